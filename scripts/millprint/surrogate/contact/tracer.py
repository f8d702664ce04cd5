"""Our DEM, advanced by coarse steps: first states, and what every contact does next."""

import numpy as np

from millprint.columns import span_of, width_of
from millprint.config.contact import ContactConfig
from millprint.config.mill import MillConfig
from millprint.config.sweep import Case, DemConfig
from millprint.dem.advance import advance
from millprint.dem.layout import COUNTER, HISTORY, LANE, LANES, STATUS, TOTAL_WIDTH
from millprint.dem.neighbours import check_lists
from millprint.dem.recording import all_works, make_table, silent_recorder
from millprint.dem.simulation import Simulation
from millprint.dem.trace import make_trace
from millprint.errors import SimulationError
from millprint.surrogate.contact import samples
from millprint.surrogate.contact.coarse import CoarseSimulation, Groups, SavedState
from millprint.surrogate.contact.pair import LAST_FORCE
from millprint.surrogate.contact.scratch import Weights, no_weights

# Recorded contacts at a time, per ball.
ROWS_PER_BALL = 40


class Tracer(Simulation):
    """A simulation beside a coarse simulation, in which the same balls are seen by coarse steps."""

    def __init__(
        self, case: Case, mill: MillConfig, contact: ContactConfig, dem: DemConfig, coarse_step: float, substeps: int
    ) -> None:
        # A whole number of fine steps makes a coarse one.
        super().__init__(case.model_copy(update={"snapshot_interval_s": coarse_step}), mill, contact, dem)
        self.fine_steps = self.snapshot_every
        self.coarse = CoarseSimulation(
            self.mill, self.contact, case.speed_rpm, self.radius, self.count, self.fine_steps * self.step, substeps
        )
        self.followed = make_trace(self.count, len(self.walls.body), ROWS_PER_BALL * self.count)
        self.counters[COUNTER.step] = -self.settle_steps
        self.to_step(0)
        # The walls start suddenly, so the planned rebuild of the lists may be too late.
        self.counters[COUNTER.check_in] = 0

    def to_step(self, step: int, check: bool = True) -> None:
        """Advance until `step` is the next one; raises SimulationError."""
        table, recorder = make_table(0), silent_recorder()
        while self.counters[COUNTER.step] < step and self.counters[COUNTER.status] == STATUS.running:
            advance(*self._groups, table, recorder, step - 1, None, None, None)
            if self.counters[COUNTER.status] == STATUS.candidates_full:
                self._lengthen_lists()
        if check:
            self._check()

    def to_time(self, time_s: float) -> None:
        """Advance to the coarse step at `time_s` [s] or the next one."""
        self.to_step(int(np.ceil(time_s / self.coarse.step - 1e-6)) * self.fine_steps)

    @property
    def _groups(self) -> Groups:
        return (
            self.balls, self.candidates, self.contacts, self.laws, self.walls, self.clock, self.totals, self.counters,
        )  # fmt: skip

    def _check(self) -> None:
        if self.counters[COUNTER.status] != STATUS.running:
            raise SimulationError(self._trouble())

    @property
    def coarse_number(self) -> int:
        """Number of the coarse step that comes next."""
        return int(self.counters[COUNTER.step]) // self.fine_steps

    def works(self) -> np.ndarray:
        """Works so far by channel, as in layout.TotalColumns [J]."""
        out = np.zeros(TOTAL_WIDTH)
        all_works(self.contacts, self.counters, self.totals, out)
        return out

    def saved(self) -> SavedState:
        """The present state, for the coarse simulation."""
        samples.put_contacts_aside(self.contacts, self.counters, self.coarse.contacts, self.coarse.counters)
        kept = int(self.coarse.counters[COUNTER.aside])
        aside = self.coarse.contacts
        self.coarse.counters[COUNTER.aside] = -1
        return SavedState(
            self.balls.position.copy(), self.balls.rate_now.copy(), aside.kept_ball[:kept].copy(),
            aside.kept_partner[:kept].copy(), aside.kept_history[:kept].copy(), self.coarse_number,
        )  # fmt: skip

    def load(self, begin: SavedState) -> bool:
        """Put the DEM into a state of the coarse simulation; False where the DEM cannot go on from it.

        Rates of the DEM are those of half a fine step ago: by the forces that act now.
        """
        self.balls.position[:] = begin.position
        self.balls.rate_now[:] = self.balls.rate[:] = begin.rate
        force = np.zeros((self.count, 3))
        pulls = begin.history[:, span_of(LAST_FORCE)]
        np.add.at(force, begin.first, pulls)
        pairs = begin.second >= 0
        np.subtract.at(force, begin.second[pairs], pulls[pairs])
        change = force / self.balls.mass[0] + self.clock.gravity
        self.balls.rate[:, :3] -= 0.5 * self.step * change
        open_now = np.flatnonzero(np.abs(pulls).sum(axis=1) > 0)
        for _ in range(1 + len(open_now)):
            self._set_aside(begin, open_now)
            self.to_step(begin.step * self.fine_steps, check=False)
            if self.counters[COUNTER.status] != STATUS.contact_lost:
                break
            # A contact that has separated in the meantime, so that the DEM does not list it.
            open_now = open_now[begin.first[open_now] != self.counters[COUNTER.ball]]
        self._put_forces(begin)
        return self.counters[COUNTER.status] == STATUS.running

    def _put_forces(self, begin: SavedState) -> None:
        """Put present forces into the lanes of open contacts: the DEM has not computed them yet."""
        partners = zip(begin.first.tolist(), begin.second.tolist(), strict=True)
        forces = dict(zip(partners, begin.history[:, span_of(LAST_FORCE)], strict=True))
        for lane in range(self.counters[COUNTER.used]):
            if self.contacts.slot[lane] >= 0:
                block, m = divmod(lane, LANES)
                force = forces[int(self.contacts.ball[lane]), int(self.contacts.partner[lane])]
                self.contacts.lanes.reshape(-1, width_of(LANE), LANES)[block, span_of(LANE.force), m] = force

    def _set_aside(self, begin: SavedState, chosen: np.ndarray) -> None:
        """Set contacts of a state aside, for the next check of the lists to open again."""
        samples.forget(self.candidates, self.contacts, self.counters)
        kept = len(chosen)
        self.contacts.kept_ball[:kept], self.contacts.kept_partner[:kept] = begin.first[chosen], begin.second[chosen]
        self.contacts.kept_history[:kept] = 0.0
        springs = span_of(HISTORY.spring)
        self.contacts.kept_history[:kept, springs] = begin.history[chosen][:, springs]
        self.counters[COUNTER.aside], self.counters[COUNTER.check_in] = kept, 0
        self.counters[COUNTER.status], self.counters[COUNTER.step] = STATUS.running, begin.step * self.fine_steps
        check_lists(*self._groups[:6], self.counters)

    def push_forward(
        self, weights: Weights, own_steps: int, between: int, states: int
    ) -> tuple[np.ndarray, np.ndarray]:
        """Samples of states that the surrogate has reached by `own_steps` of its own from one of the DEM.

        The DEM goes on from each such state for `between` coarse steps, and the next one begins there.
        """
        parts, sizes = [], []
        rows = np.zeros((ROWS_PER_BALL * self.count, samples.SAMPLE_COLUMNS))
        self.coarse.weights = weights
        for _ in range(states):
            begin = self.saved()
            self.coarse.load(begin)
            if not self.coarse.run(own_steps) or not self.load(self.coarse.saved()):
                # The surrogate has lost a ball: this state is not used.
                self.load(begin)
                self.to_step(int(self.counters[COUNTER.step]) + between * self.fine_steps)
                continue
            self.coarse.weights, kept = no_weights(), self.coarse.weights
            written = self._sample_once(rows)
            self.coarse.weights = kept
            parts.append(rows[:written].astype(np.float32))
            sizes.append(written)
            self.to_step(int(self.counters[COUNTER.step]) + (between - 1) * self.fine_steps)
        return np.concatenate(parts), np.array(sizes)

    def sample(self, every: int, until_s: float) -> tuple[np.ndarray, np.ndarray]:
        """Samples of the contacts in every `every`-th coarse step until `until_s`: rows, and how many a state has."""
        parts, sizes = [], []
        rows = np.zeros((ROWS_PER_BALL * self.count, samples.SAMPLE_COLUMNS))
        while self.coarse_number * self.coarse.step < until_s:
            written = self._sample_once(rows)
            parts.append(rows[:written].astype(np.float32))
            sizes.append(written)
            self.to_step(int(self.counters[COUNTER.step]) + (every - 1) * self.fine_steps)
        return np.concatenate(parts), np.array(sizes)

    def _sample_once(self, rows: np.ndarray) -> int:
        """Write the contacts of the present state and what they do in the next coarse step; returns how many."""
        coarse = self.coarse
        written = samples.sample_step(
            (*self._groups, make_table(0), silent_recorder()),
            coarse.groups,
            coarse.scratch,
            self.followed,
            rows,
            0,
            self.fine_steps,
        )
        self._check()
        return written
