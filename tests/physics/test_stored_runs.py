"""Short runs against the numbers of an earlier version, to 1e-10.

The closed forms bound the error of the physics; these numbers tell whether a change of the kernels has changed what
they compute. The runs are too short for differences in rounding to grow. After a change of the physics that is meant,
write them again: `python -m tests.physics.test_stored_runs`.
"""

import numpy as np
import pandas as pd
import pytest

from millprint.mill.motion import Motion
from tests.conftest import ROOT
from tests.physics.setups import FewBalls, box

STORED = ROOT / "tests/data/stored_runs.tsv"
RADIUS = 5e-3  # [m]
STEP_S = 2e-6
# 17 mm along x and y, 10 times a second: angular frequency [rad/s], cosine and sine amplitudes [m].
SWING = Motion(np.array([[20 * np.pi, 0.0, 0.0, 0.0, 0.017, 0.017, 0.0]]), 10.0)


def oblique_pair() -> FewBalls:
    """A spinning ball that meets another one at an angle."""
    position = [[0.0, 0.0, 0.1], [2.001 * RADIUS, 0.002, 0.1]]
    return FewBalls(position, [[1.5, 0.4, 0.0], [0.0, 0.0, 0.0]], [[0.0, 30.0, 80.0], [0.0, 0.0, 0.0]], step=STEP_S)


def unequal_balls_that_drop() -> FewBalls:
    """Four balls of two sizes that fall on the floor and on each other."""
    position = [[0.0, 0.0, 0.0051], [0.0065, 0.001, 0.0135], [-0.004, 0.006, 0.014], [0.001, -0.0055, 0.0132]]
    radius = np.array([5e-3, 4e-3, 5e-3, 4e-3])
    return FewBalls(position, [[0.0, 0.0, -0.5]] * 4, radius=radius, gravity=9.81, step=STEP_S)


def balls_in_a_moving_box() -> FewBalls:
    """Three balls on the floor of a box that swings along its diagonal, two of them near its walls."""
    position = [[-0.0249, 0.0, 0.005], [0.0, 0.0, 0.005], [0.0, -0.0249, 0.0051]]
    return FewBalls(position, vessel=box(0.06, 0.06, 0.06), motion=SWING, gravity=9.81, step=STEP_S)


RUNS = {run.__name__: run for run in (oblique_pair, unequal_balls_that_drop, balls_in_a_moving_box)}
DURATION_S = {"oblique_pair": 2e-3, "unequal_balls_that_drop": 8e-3, "balls_in_a_moving_box": 8e-3}


def numbers_of(name: str) -> pd.Series:
    """Where the balls are [m], their velocities and angular velocities, and the ledger [J] at the end of a run."""
    world = RUNS[name]()
    ledger = world.run(DURATION_S[name], sample_every=100)
    values = {}
    for quantity in ("position", "velocity", "angular_velocity"):
        for (ball, axis), value in np.ndenumerate(getattr(world.balls, quantity)):
            values[f"{quantity}_{'xyz'[axis]}_{ball}"] = value
    values |= ledger.iloc[-1].drop("imbalance_J").to_dict()
    return pd.Series(values, name="value")


@pytest.mark.parametrize("name", RUNS)
def test_a_short_run_ends_as_it_did_before(name):
    stored = pd.read_csv(STORED, sep="\t").set_index(["run", "quantity"])["value"].loc[name]
    found = numbers_of(name)
    assert list(found.index) == list(stored.index)
    for kind in ("position", "velocity", "angular_velocity", "_J"):
        rows = [row for row in stored.index if row.startswith(kind) or (kind == "_J" and row.endswith(kind))]
        # Numbers near zero are held to the largest of their kind.
        np.testing.assert_allclose(found[rows], stored[rows], rtol=1e-10, atol=1e-10 * stored[rows].abs().max())


def test_the_runs_have_contacts_that_open_and_end():
    for name, run in RUNS.items():
        world = run()
        world.run(DURATION_S[name])
        assert len(world.contacts) > 0, name


if __name__ == "__main__":
    table = pd.concat({name: numbers_of(name) for name in RUNS}, names=["run", "quantity"]).reset_index()
    table.to_csv(STORED, sep="\t", index=False, float_format="%.17g")
