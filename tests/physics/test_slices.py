"""A slice of a drum with ends without friction, against statics."""

import math

import numpy as np
import pytest

from millprint.config.contact_set import ContactConfig
from millprint.config.mill import MillConfig
from millprint.config.sweep import Case, DemConfig
from millprint.dem.layout import SNAPSHOT
from millprint.dem.simulation import Simulation
from millprint.mill.kernel_columns import span_of
from millprint.validation.drums import fit_surface

RADIUS, LENGTH, DIAMETER, FILL = 0.05, 0.03, 0.006, 0.3
DRUM = MillConfig(
    name="slice", title="a slice", source="none", volume_ml=1e6 * math.pi * RADIUS**2 * LENGTH,
    geometry={
        "kind": "cylinder", "axis": "y", "radius_mm": 1e3 * RADIUS, "height_mm": 1e3 * LENGTH, "facets": 48,
        "fillet_ends": "none", "smooth_ends": True,
    },
    motion={"kind": "rotation", "axis": [0, 1, 0]},
)  # fmt: skip
BEADS = ContactConfig(
    name="beads", source="none", restitution=0.3, static_friction=0.5, rolling_friction=0.05, density_kg_m3=2500,
    young_modulus_gpa=0.01, poisson_ratio=0.25,
)  # fmt: skip


@pytest.fixture(scope="module")
def at_rest() -> tuple[Simulation, np.ndarray]:
    """A bed that has settled in a drum at rest, and what the snapshots of its balls hold (t, n, columns)."""
    case = Case(
        mill="slice", contact="beads", ball_diameter_m=DIAMETER, fill_ratio=FILL, speed_hz=0.0, seed=0,
        rayleigh_fraction=0.1, settle_s=2.0, discard_s=0.0, window_s=0.1, snapshot_interval_s=0.01,
    )  # fmt: skip
    simulation = Simulation(case, DRUM, BEADS, DemConfig())
    recording = simulation.run()
    return simulation, np.concatenate(recording.snapshots)


@pytest.mark.slow
def test_the_walls_carry_the_weight_of_a_bed_at_rest(at_rest):
    """Forces of balls on balls cancel, so the sum of all contact forces is what the walls give: m g, upwards."""
    simulation, balls = at_rest
    force = balls[..., span_of(SNAPSHOT.contact_force_N)].sum(axis=1).mean(axis=0)
    weight = simulation.count * BEADS.density_kg_m3 * math.pi / 6 * DIAMETER**3 * 9.81
    assert force[2] == pytest.approx(weight, rel=0.01)
    assert np.abs(force[:2]).max() < 0.01 * weight


def test_a_bed_at_rest_stays_level_and_still(at_rest):
    _, balls = at_rest
    places = balls[..., span_of(SNAPSHOT.position_m)][..., [0, 2]]
    assert fit_surface(places.reshape(-1, 2), 0.6 * RADIUS, DIAMETER).angle_deg < 5
    moved = np.abs(places[-1] - places[0]).max()
    # In free fall a ball would move eight diameters.
    assert moved < 0.05 * DIAMETER
