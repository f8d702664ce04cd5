"""The virtual drop test gives the restitution of the contact set."""

from pathlib import Path

import numpy as np
import pytest

from millprint.config.contact_set import ContactConfig
from millprint.config.errors import ConfigError
from millprint.config.load import load_named
from millprint.thesis.drop import bounce_height, simulate_drops

CONTACTS = Path(__file__).parents[2] / "config/contacts"
STEP_S, RAYLEIGH_FRACTION_MAX = 2e-6, 0.2


@pytest.mark.parametrize("restitution", [0.30, 0.68])
def test_the_bounce_gives_the_restitution_back_at_every_height(restitution):
    contact = load_named(CONTACTS, "calibrated", ContactConfig, "contact set")
    contact = contact.model_copy(update={"restitution": restitution})
    table = simulate_drops(contact, STEP_S, RAYLEIGH_FRACTION_MAX, 0.010, [0.010, 0.030])
    np.testing.assert_allclose(table["restitution"], restitution, atol=5e-3)
    np.testing.assert_allclose(table["bounce_height_mm"], restitution**2 * table["drop_height_mm"], rtol=0.03)


def test_the_first_bounce_is_found_among_several():
    time = np.linspace(0, 0.3, 3001)
    fall = np.sqrt(2 * 0.02 / 9.81)
    track = np.where(time < fall, 0.02 - 9.81 / 2 * time**2, 0.0)
    start = fall
    for speed in (0.3, 0.1):
        flight = time - start
        track = np.where((flight > 0) & (flight < 2 * speed / 9.81), speed * flight - 9.81 / 2 * flight**2, track)
        start += 2 * speed / 9.81
    assert bounce_height(track) == pytest.approx(0.3**2 / 2 / 9.81, rel=1e-4)


def test_a_track_without_a_bounce_is_refused():
    with pytest.raises(ConfigError, match="no bounce"):
        bounce_height(np.linspace(0.02, 0.0, 50))
    with pytest.raises(ConfigError, match="before the top"):
        bounce_height(np.concatenate([np.linspace(0.02, 0.0, 50), np.linspace(0, 0.01, 50)]))
