"""Small worlds for the physics tests: a few balls in a plain vessel, driven from Python."""

import numpy as np
import pandas as pd

from millprint.config.contact import ContactConfig
from millprint.dem import state
from millprint.dem.advance import SAMPLE_COLUMNS, advance
from millprint.dem.collisions import collision_table
from millprint.dem.ledger import ledger_series
from millprint.dem.recording import make_recorder, make_table
from millprint.mill.motion import HARMONIC, REST, Motion
from millprint.mill.vessel import Facet, Vessel
from millprint.mill.walls import build_walls

CALIBRATED = ContactConfig(
    name="calibrated",
    source="thesis Table 3.2",
    restitution=0.30,
    static_friction=0.30,
    rolling_friction=0.045,
    density_kg_m3=7700,
    young_modulus_gpa=2.05,
    poisson_ratio=0.235,
)
AT_REST = Motion(REST, np.zeros((1, 7)), 0.0)


def uniform(velocity: np.ndarray) -> Motion:
    """Motion at constant velocity (3,) [m/s], as the first moments of a very slow and wide swing."""
    slow = 1e-6
    return Motion(HARMONIC, np.array([[slow, 0, 0, 0, *(velocity / slow)]]), slow)


def prism(outline: np.ndarray, height: float, turn: np.ndarray | None = None) -> Vessel:
    """The upright prism over a counter-clockwise outline (k, 2) [m], from z = 0 to `height` [m].

    turn: rotation (3, 3) of the whole about the origin.
    """
    low = np.column_stack([outline, np.zeros(len(outline))])
    high = low + np.array([0.0, 0.0, height])
    if turn is not None:
        low, high = low @ turn.T, high @ turn.T
    sides = [[np.array([high[k], high[k - 1], low[k - 1], low[k]])[::-1]] for k in range(len(outline))]
    return Vessel([Facet.from_loops(loops) for loops in [*sides, [low], [high[::-1]]]])


def box(width: float = 0.2, depth: float = 0.2, height: float = 0.2, turn: np.ndarray | None = None) -> Vessel:
    """A box centred on the origin in plan, floor at z = 0 [m]; turn: rotation (3, 3) of the whole about the origin."""
    x, y = width / 2, depth / 2
    return prism(np.array([[-x, -y], [x, -y], [x, y], [-x, y]]), height, turn)


class World:
    """Balls of given radii in a vessel; positions, velocities, spins are (n, 3), in SI.

    Options: vessel, step [s], skin [m], gravity (downwards, or a vector (3,)) [m/s2], motion, pitch [m].
    """

    def __init__(self, position, velocity=None, spin=None, radius=5e-3, contact=CALIBRATED, **options) -> None:
        position = np.atleast_2d(np.asarray(position, dtype=float))
        radii = np.unique(np.broadcast_to(radius, len(position)))
        species = np.searchsorted(radii, np.broadcast_to(radius, len(position)))
        self.vessel = options.get("vessel") or box()
        self.step, skin = options.get("step", 1e-6), options.get("skin", 6e-4)
        self.balls = state.make_balls(position, species, radii, contact.density_kg_m3)
        for columns, value in ((slice(0, 3), velocity), (slice(3, 6), spin)):
            if value is not None:
                self.balls.rate[:, columns] = self.balls.rate_now[:, columns] = value
        self.candidates = state.make_candidates(len(position), per_ball=40)
        self.open_contacts = state.make_contacts(self.candidates.partner.size)
        self.laws = state.make_laws(self.balls, contact, self.step, 0.2)
        self.walls = build_walls([self.vessel], radii.max(), skin / 2, 0.2 * radii.max(), options.get("pitch", 0.01))
        motion = options.get("motion", AT_REST)
        self.clock = state.make_clock(self.balls, [motion], self.step, skin, options.get("gravity", 0.0))
        self.totals = np.zeros(state.TOTALS)
        self.counters = state.make_counters()

    @property
    def contacts(self) -> pd.DataFrame:
        """The contacts that ended in the last run (millprint.dem.collisions.COLUMNS)."""
        return collision_table(*self.collisions)

    def run(self, seconds: float, sample_every: int = 0):
        """Advance by a time [s]; returns the table of collisions, and the ledger if samples are asked for."""
        steps = round(seconds / self.step)
        begin = int(self.counters[state.STEP])
        rows = steps // sample_every + 2 if sample_every else 0
        table = make_table(100_000)
        recorder = make_recorder(np.zeros((2, 2)), 1.0, 0, 0, begin, (sample_every, 0, 0), 0)
        recorder = recorder._replace(sample=np.zeros((rows, len(SAMPLE_COLUMNS))))
        advance(
            self.balls, self.candidates, self.open_contacts, self.laws, self.walls, self.clock, self.totals,
            self.counters, table, recorder, begin + steps - 1 + (1 if sample_every else 0),
        )  # fmt: skip
        assert self.counters[state.STATUS] == state.RUNNING
        rows = int(self.counters[state.RECORDS])
        self.counters[state.RECORDS] = 0
        self.collisions = [column[:rows] for column in table]
        samples = int(self.counters[state.SAMPLES])
        self.counters[state.SAMPLES] = 0
        return ledger_series(recorder.sample[:samples]) if sample_every else None
