"""Coefficients over the speed of the hit in files: what is refused, what drops give, what is sampled and told."""

import logging
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from scripts import calibrate_restitution

from millprint.card.build import _contact_set
from millprint.card.card_files import coefficient_in_words, cohesion_in_words
from millprint.config.calibration import DropTestConfig
from millprint.config.contact_set import ContactConfig
from millprint.config.load import check_model
from millprint.run.files import read_table, write_table
from millprint.thesis.drop import restitution_over_speed, table_in_words
from millprint.uncertainty.samples import _with, contact_values
from tests.unit.test_contact_laws import COMMON, KEYS

CONTENT = {**COMMON, "kind": "hertz", **KEYS["hertz"]}
TABLE = {"speeds_m_s": [0.1, 0.5, 2.0], "values": [0.2, 0.4, 0.8]}


def contact_set(**changes) -> ContactConfig:
    return check_model({**CONTENT, **changes}, ContactConfig, "soft.yaml")


def test_a_set_is_the_same_after_it_was_written_and_read():
    contact = contact_set(restitution=TABLE, wall_restitution={"form": "plastic", "value": 0.6})
    assert ContactConfig(**contact.model_dump(mode="json")) == contact
    assert set(contact.speed_tables) == {"restitution", "wall_restitution"}
    assert contact.at_speed(2.0).restitution == 0.8 and contact.value_of("restitution", 50) == 0.8
    assert contact_set().speed_tables == {} and contact_set().at_speed(2.0) == contact_set()


def test_a_sample_scales_the_whole_table_and_stays_within_1():
    contact = contact_set(restitution=TABLE, static_friction=TABLE)
    assert contact_values(contact)["restitution"] == pytest.approx(0.4)
    changed = _with(contact, {"restitution": 0.6, "wall_static_friction": 0.2, "rolling_friction": 0.02})
    np.testing.assert_allclose(changed.restitution.values, [0.3, 0.6, 1.0])
    np.testing.assert_allclose(changed.wall_static_friction.values, [0.1, 0.2, 0.4])
    assert changed.static_friction == contact.static_friction and changed.rolling_friction == 0.02
    assert _with(contact_set(), {"restitution": 0.6}).restitution == 0.6


def test_drops_from_three_heights_give_a_table_with_intervals(tmp_path, caplog):
    """Heights of hits at 0.2, 0.5 and 1 m/s; the script writes the table and tells the key."""
    heights = [1e3 * speed**2 / (2 * 9.81) for speed in (0.2, 0.5, 1.0)]
    values = {heights[0]: (0.2, 0.22), heights[1]: (0.4, 0.42, 0.44), heights[2]: (0.6, 0.6)}
    rows = [(height, value**2 * height) for height, own in values.items() for value in own]
    write_table(pd.DataFrame(rows, columns=["drop_height_mm", "bounce_height_mm"]), tmp_path / "drops.tsv")
    output = SimpleNamespace(**{name: str(tmp_path / name) for name in ("drops", "restitution", "over_speed")})
    settings = DropTestConfig.model_construct(measured=str(tmp_path / "drops.tsv"))
    with caplog.at_level(logging.INFO, "millprint"), pytest.MonkeyPatch.context() as patched:
        patched.setattr(calibrate_restitution, "simulate_drops", lambda *_: pd.DataFrame())
        calibrate_restitution.main(output, [], 1e-6, 0.2, settings, 0.95)
    found = read_table(output.over_speed)
    np.testing.assert_allclose(found["speed_m_s"], [0.2, 0.5, 1.0], rtol=1e-6)
    np.testing.assert_allclose(found["mean"], [0.21, 0.42, 0.6], rtol=1e-6)
    # t(0.975; 2) = 4.303 times the standard error 0.02 / sqrt(3).
    assert found["upper"][1] - 0.42 == pytest.approx(4.3027 * 0.02 / 3**0.5, rel=1e-3)
    assert "restitution: {speeds_m_s: [0.2, 0.5, 1], values: [0.21, 0.42, 0.6]}" in caplog.text
    assert "is that at 0.5 m/s: lower: 0.37, upper: 0.47" in caplog.text


@pytest.mark.parametrize("heights", [[10, 10, 20, 20], [10, 20, 30]])
def test_too_few_drops_give_no_table(heights):
    drops = pd.DataFrame({"drop_height_mm": heights, "restitution": 0.5})
    assert table_in_words(restitution_over_speed(drops, 0.95)) == [
        "a restitution over speed needs drops from 3 heights, two or more from each"
    ]


def test_a_card_keeps_the_tables():
    card = _contact_set(contact_set(restitution=TABLE))
    assert card.restitution == pytest.approx(0.4)
    assert coefficient_in_words(card, "restitution") == "0.4 at hits of 0.5 m/s (0.2 at 0.1 m/s and 0.8 at 2 m/s)"
    assert coefficient_in_words(card, "static_friction") == "0.3"
    assert card.over_speed[0].values[-1] == pytest.approx(0.8) and card.wall_restitution is None
    sticky = _contact_set(contact_set(cohesion={"ball_ball_J_m2": 0.5, "ball_wall_N": 0.1}))
    words = ", cohesion by Derjaguin, Muller and Toporov: ball on ball 0.5 J/m2, ball on wall 0.1 N"
    assert cohesion_in_words(sticky) == words and cohesion_in_words(card) == ""
    assert _contact_set(contact_set(wall_restitution=0.7)).wall_restitution == 0.7
