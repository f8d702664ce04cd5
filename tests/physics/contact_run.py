"""Runs a contact case in a FewBalls and measures what the closed forms give."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import pandas as pd
from scipy.spatial.transform import Rotation

from tests.physics.closed_forms import CLOSED_FORMS, approach_of, momenta, pair_of
from tests.physics.contact_cases import ContactCase
from tests.physics.setups import FewBalls, box

# A rotation about no axis of symmetry: every case must have the same result in the rotated frame.
TURNED = Rotation.from_euler("zyx", [0.61, -1.13, 0.37]).as_matrix()
UPRIGHT = np.eye(3)

# Samples of the ledger in one run, about.
SAMPLES = 4000


@dataclass(frozen=True)
class Outcome:
    """What one run has left: arrays in the case's own frame, ended contacts, ledger samples."""

    position: np.ndarray
    velocity: np.ndarray
    spin: np.ndarray
    ledger: pd.DataFrame
    world: FewBalls

    @cached_property
    def contacts(self) -> pd.DataFrame:
        """The contacts that have ended; few tests look at them, and joining their rows takes as long as the run."""
        return self.world.contacts


def run_case(case: ContactCase, frame: np.ndarray = UPRIGHT) -> Outcome:
    """Run a case, set up whole in a frame turned by a rotation (3, 3)."""
    largest = float(case.radius.max())
    position = case.position.copy()
    if case.seated:
        position[0, 2] -= CLOSED_FORMS["static_stack"](case)["overlap_m"][0]
    width = 60 * largest + 4 * float(np.abs(position).max())
    if not case.wall:
        # Amid the box, far from every wall.
        position[:, 2] += width / 2
    world = FewBalls(
        position @ frame.T, case.velocity @ frame.T, case.spin @ frame.T, radius=case.radius, contact=case.material,
        vessel=box(width, width, width, frame), step=case.step_s, skin=0.1 * largest, pitch=width / 20,
        gravity=-case.gravity_m_s2 * frame[:, 2],
    )  # fmt: skip
    # A run with samples makes one step more, for the last sample.
    every = max(1, round(case.duration_s / case.step_s / SAMPLES))
    ledger = world.run(case.duration_s - case.step_s, sample_every=every)
    balls = world.balls
    position, velocity, spin = (array @ frame for array in (balls.position, balls.velocity, balls.angular_velocity))
    if not case.wall:
        position[:, 2] -= width / 2
    return Outcome(position, velocity, spin, ledger, world)


def overlaps(case: ContactCase, outcome: Outcome) -> np.ndarray:
    """Overlap of each ball of a stack with the one below, the first with the wall [m]."""
    centres, radii = np.append(0.0, outcome.position[:, 2]), np.append(0.0, case.radius)
    return radii[:-1] + radii[1:] - np.diff(centres)


def drifts(case: ContactCase, outcome: Outcome) -> tuple[np.ndarray, np.ndarray]:
    """Change of momentum over sum |p|, and of angular momentum over sum (|x x p| + |I w| + R |p|) at the start (3,)."""
    start = momenta(case, case.position, case.velocity, case.spin)
    end = momenta(case, outcome.position, outcome.velocity, outcome.spin)
    linear, angular = ((after - before).sum(axis=0) for before, after in zip(start, end, strict=True))
    sizes = [np.linalg.norm(array, axis=1) for array in start]
    return linear / sizes[0].sum(), angular / (sizes[1] + case.radius * sizes[0]).sum()


def slip_energy(case: ContactCase) -> float:
    """The work that ends the slip of first touch, m* u^2 / 7 [J]."""
    return pair_of(case).reduced_mass * approach_of(case)[1] ** 2 / 7


def measure(case: ContactCase, outcome: Outcome, quantity: str) -> np.ndarray:
    """A quantity of the closed forms, as measured in a run."""
    contacts, work = outcome.contacts, outcome.ledger.iloc[-1]
    if quantity in ("peak_force_N", "peak_overlap_m", "duration_s"):
        assert len(contacts) == 1, f"{len(contacts)} contacts have ended; one was expected"
        return contacts[quantity].to_numpy()
    if quantity.endswith("_J"):
        return np.array(work[quantity])
    return {
        "position_m": lambda: outcome.position,
        "velocity_m_s": lambda: outcome.velocity,
        "spin_rad_s": lambda: outcome.spin,
        "overlap_m": lambda: overlaps(case, outcome),
        "rim_over_slip": lambda: case.radius[:, None] * outcome.spin / abs(approach_of(case)[1]),
        "tangential_damping_share": lambda: np.array(work["tangential_damping_J"] / slip_energy(case)),
        "sliding_share": lambda: np.array(work["sliding_J"] / slip_energy(case)),
        "momentum_drift": lambda: drifts(case, outcome)[0],
        "angular_momentum_drift": lambda: drifts(case, outcome)[1],
    }[quantity]()


def balance_error(outcome: Outcome) -> float:
    """The largest error of the energy balance at any time, over the energy at the start or set free by gravity [-]."""
    ledger = outcome.ledger
    energy = ledger["kinetic_J"].iloc[0] + ledger["elastic_J"].iloc[0] + ledger["gravity_work_J"].abs().max()
    return float(ledger["imbalance_J"].abs().max() / energy)
