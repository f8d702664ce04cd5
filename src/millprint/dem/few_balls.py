"""A few balls in a vessel, placed and advanced from Python, for the calibration and the tests of the physics."""

from collections.abc import Iterator

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from millprint.config.contact_set import ContactConfig
from millprint.config.errors import SimulationError
from millprint.config.sweep import OVERLAP_LIMIT
from millprint.dem import state
from millprint.dem.advance import advance
from millprint.dem.collisions import by_surface, collision_table
from millprint.dem.laws.registry import mark_of
from millprint.dem.layout import COUNTER, LAW, RATE, SAMPLE, STATUS, TOTAL_WIDTH
from millprint.dem.ledger import ledger_series
from millprint.dem.recording import Recorder, Table, make_recorder, make_table
from millprint.mill.kernel_columns import span_of, width_of
from millprint.mill.motion import AT_REST, Motion
from millprint.mill.vessel import Vessel
from millprint.mill.wall_arrays import build_walls
from millprint.mill.walls import SURFACE, Walls

COLLISION_ROWS = 100_000  # contacts that one call of `run` can record

TROUBLE = {
    STATUS.overlap: f"overlaps something by more than {100 * OVERLAP_LIMIT:g} % of its radius",
    STATUS.escaped: "has left the vessel",
    STATUS.not_finite: "has no finite position",
    STATUS.contact_lost: "has lost an open contact",
}


def walls_for(vessel: Vessel, radius: float, skin: float = 6e-4, pitch: float = 0.01) -> Walls:
    """Walls of a vessel at rest or in motion, for balls of at most `radius`; skin and pitch of the cells, all in m."""
    return build_walls([vessel], radius, skin / 2, pitch)


class FewBalls:
    """Balls of given radii [m] in a vessel; positions, velocities, angular velocities are (n, 3), in SI.

    Further: step [s], skin [m], gravity (downwards, or a vector (3,)) [m/s2], motion, pitch [m], walls, where many
    worlds share those of one vessel, and by_facet, see recording.make_table.

    friction: static and rolling friction (n, 2) [-] of each ball at the walls, in place of the contact set's. The balls
    are then as many experiments side by side: they do not touch each other. Raises ValueError for several balls of a
    contact set with coefficients that depend on the speed of the hit, since these are the same for all.
    """

    def __init__(
        self,
        vessel: Vessel,
        contact: ContactConfig,
        position: ArrayLike,
        velocity: ArrayLike | None = None,
        angular_velocity: ArrayLike | None = None,
        radius: ArrayLike = 5e-3,
        *,
        step: float = 1e-6,
        skin: float = 6e-4,
        gravity: float | np.ndarray = 0.0,
        motion: Motion = AT_REST,
        pitch: float = 0.01,
        walls: Walls | None = None,
        by_facet: bool = False,
        friction: ArrayLike | None = None,
    ) -> None:
        position = np.atleast_2d(np.asarray(position, dtype=float))
        radii, species = np.unique(np.broadcast_to(radius, len(position)), return_inverse=True)
        if friction is not None:
            if len(position) > 1 and contact.speed_tables:
                raise ValueError("friction: one ball at a time where coefficients depend on the speed of the hit")
            radii, species = radii[species], np.arange(len(position))
        self.vessel = vessel
        self.by_facet = by_facet
        self.step = step
        self.balls = state.make_balls(position, species, radii, contact.density_kg_m3)
        for columns, value in ((RATE.velocity, velocity), (RATE.angular_velocity, angular_velocity)):
            if value is not None:
                self.balls.rate[:, span_of(columns)] = self.balls.rate_now[:, span_of(columns)] = value
        self.candidates = state.make_candidates(len(position))
        self.open_contacts = state.make_contacts(self.candidates.partner.size)
        self.walls = walls or walls_for(vessel, radii.max(), skin, pitch)
        self.mark = mark_of(contact)
        self.laws = state.make_laws(self.balls, contact, self.step, OVERLAP_LIMIT, self.walls.surface)
        if friction is not None:
            self.laws.wall[SURFACE.rough][:, [LAW.friction, LAW.rolling_friction]] = friction
            # Less than nothing within the skin.
            self.laws.pair[..., LAW.reach] = -skin
        self.clock = state.make_clock(self.balls, [motion], self.step, skin, gravity)
        self.totals = np.zeros(TOTAL_WIDTH)
        self.counters = state.make_counters()

    @property
    def contacts(self) -> pd.DataFrame:
        """The contacts that ended in the last run (collisions.COLLISION_NAMES)."""
        return by_surface(collision_table(self.collisions))

    def run(self, seconds: float, sample_every: int = 0, rows: int = COLLISION_ROWS) -> pd.DataFrame | None:
        """Advance by a time [s]; returns the ledger if samples are asked for. Raises SimulationError.

        rows: room for the contacts that end; with none they are not recorded.
        """
        steps = round(seconds / self.step)
        begin = int(self.counters[COUNTER.step])
        recorder = _recorder(begin, sample_every, steps // sample_every + 2 if sample_every else 0)
        table = make_table(rows, self.by_facet)
        self._advance(begin + steps - 1 + (1 if sample_every else 0), table, recorder)
        recorded = int(self.counters[COUNTER.records])
        self.counters[COUNTER.records] = 0
        self.collisions = Table(*(column[:recorded] for column in table))
        samples = int(self.counters[COUNTER.samples])
        self.counters[COUNTER.samples] = 0
        return ledger_series(recorder.sample[:samples]) if sample_every else None

    def track(self, seconds: float, every: int) -> tuple[np.ndarray, np.ndarray]:
        """Advance by a time [s] and record the balls at regular steps: times (m,) [s] and positions (m, n, 3) [m].

        Raises SimulationError.
        """
        looks = int(np.floor(seconds / self.step / every + 1e-9)) + 1
        begin = int(self.counters[COUNTER.step])
        table, recorder = make_table(0), _recorder(begin, 0, 0)
        positions = np.empty((looks, *self.balls.position.shape))
        for look in range(looks):
            self._advance(begin + look * every - 1, table, recorder)
            positions[look] = self.balls.position
        return (begin + every * np.arange(looks)) * self.step, positions

    def chunks(self, seconds: float, every: int) -> Iterator[float]:
        """Advance by a time [s], `every` steps after another; yields the time of each [s]. Raises SimulationError."""
        table, recorder = make_table(0), _recorder(0, 0, 0)
        begin = int(self.counters[COUNTER.step])
        for step in range(begin + every, begin + round(seconds / self.step) + 1, every):
            self._advance(step - 1, table, recorder)
            yield step * self.step

    def _advance(self, last_step: int, table: Table, recorder: Recorder) -> None:
        counters = self.counters
        while True:
            advance(
                self.balls, self.candidates, self.open_contacts, self.laws, self.mark, self.walls, self.clock,
                self.totals, counters, table, recorder, last_step, None,
            )  # fmt: skip
            if counters[COUNTER.status] != STATUS.candidates_full:
                break
            self.candidates, self.open_contacts = state.lengthened(self.candidates, self.open_contacts, counters)
        if counters[COUNTER.status] != STATUS.running:
            trouble = TROUBLE[int(counters[COUNTER.status])]
            when = counters[COUNTER.step] * self.step
            raise SimulationError(f"ball {counters[COUNTER.ball]} {trouble} at {when:.6f} s")
        if counters[COUNTER.step] <= last_step:
            raise SimulationError(f"more than {len(table.value)} contacts ended in one run")


def _recorder(begin: int, sample_every: int, rows: int) -> Recorder:
    """Buffers for `rows` samples of the ledger and for nothing else."""
    recorder = make_recorder(np.zeros((2, 2)), 1.0, 0, 0, begin, (sample_every, 0, 0), 0)
    return recorder._replace(sample=np.zeros((rows, width_of(SAMPLE))))
