"""One simulation as an object for Python: chunks, progress, restart, errors; and a few balls, placed and advanced."""

import math
import time
from collections.abc import Callable, Iterator
from contextlib import nullcontext
from pathlib import Path
from typing import Literal

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike
from tqdm import tqdm

from millprint.config.contact_set import ContactConfig
from millprint.config.errors import SimulationError
from millprint.config.mill import MillConfig
from millprint.config.sweep import OVERLAP_LIMIT, Case, DemConfig, ball_count, overridden, threads_of
from millprint.dem import state
from millprint.dem.advance import Shares, advance, make_shares, use_threads
from millprint.dem.collisions import by_surface, collision_table
from millprint.dem.laws.registry import law_of, mark_of, step_scale
from millprint.dem.layout import COUNTER, HISTORY, LAW, SAMPLE, STATUS, TOTAL_WIDTH
from millprint.dem.ledger import ledger_series
from millprint.dem.neighbours import list_again, restore_rows, sort_if_due
from millprint.dem.overlap import overlap_in_words
from millprint.dem.packing import pack, pack_mixture
from millprint.dem.recording import (
    TABLE_ROWS,
    Recorder,
    Recording,
    Table,
    begin_window,
    end_window,
    grid_edges,
    make_recorder,
    make_table,
    read_restart,
    silent_recorder,
    write_restart,
)
from millprint.dem.resources import (
    OCCUPANCY_CELL_M,
    OCCUPANCY_INTERVAL_S,
    aligned_step,
    check_cohesion,
    largest_fraction,
    requested_step,
    run_up_step,
    skin_of,
)
from millprint.mill.bodies import Body, build_bodies, inserts_in_vessel
from millprint.mill.kernel_columns import width_of
from millprint.mill.motion import AT_REST, Motion
from millprint.mill.vessel import Vessel
from millprint.mill.wall_arrays import build_walls
from millprint.mill.walls import SURFACE, Walls
from millprint.run.job import progress

# Wall time of one call of the kernel [s]: short enough for a smooth progress bar.
CHUNK_S = 0.25
ASSUMED_NS = 30
# How a window goes on: it is over, it is made longer, or it begins anew, since something was not steady yet.
GoesOn = Literal["end", "longer", "anew"]


class Simulation:
    """Balls in a moving vessel and between its inserts. Step 0 is where the mill starts; before it all is at rest.

    Until the window begins, steps are `run_up_step` long, and settle_steps and discard_steps are counted in these; then
    they are `step` long. The first of the window has the number begin_step, which grows where the window begins anew.

    start: centres (n, 3) [m] in the vessel's frame to begin from, of balls of one size, in place of the seed's packing.
    Raises SimulationError for balls that do not fit, a step that is too long, and a start of another number of balls.
    """

    def __init__(
        self, case: Case, mill: MillConfig, contact: ContactConfig, dem: DemConfig, start: np.ndarray | None = None
    ) -> None:
        mill, contact = overridden(case, mill, contact)
        self.case, self.mill, self.contact, self.dem = case, mill, contact, dem
        # With several sizes, those of the ball of mean volume.
        self.diameter = case.ball_diameter_m
        self.radius = self.diameter / 2
        self.radii = np.array(case.sizes_m) / 2
        largest = float(self.radii.max())
        volume = mill.volume_ml / 1e6
        self.count = ball_count(case.fill_ratio, volume, self.diameter)
        if self.count < 1:
            raise SimulationError(
                f"fill ratio {case.fill_ratio:g} is less than one ball of {1e3 * case.ball_diameter_m:g} mm"
            )
        check_cohesion(contact, self.radii.tolist(), dem.overlap_max)
        self.bodies: list[Body] = build_bodies(mill, case.speed_hz)
        self._choose_steps()
        start, species = self._start(volume) if start is None else self._given(start)
        self.balls = state.make_balls(
            self.bodies[0].to_laboratory(start, 0.0), species, self.radii, contact.density_kg_m3
        )
        self.candidates = state.make_candidates(self.count, len(self.bodies))
        self.contacts = state.make_contacts(self.candidates.partner.size)
        skin = skin_of(float(self.radii.min()), self.step / self.step_scale_s)
        self.walls: Walls = build_walls(
            [body.vessel for body in self.bodies], largest, skin / 2, pitch=max(0.4 * largest, 1e-3)
        )
        self._take_step(self.run_up_step, skin)
        self.threads = threads_of(case, dem)
        self.shares = self._make_shares()
        self.totals = np.zeros(TOTAL_WIDTH)
        self.counters = state.make_counters()
        self.numbers = np.arange(self.count)
        self.wall_clock_s = 0.0
        self.processor_s = 0.0

    @property
    def vessel(self) -> Vessel:
        """The vessel's walls."""
        return self.bodies[0].vessel

    @property
    def motion(self) -> Motion:
        """The vessel's motion."""
        return self.bodies[0].motion

    @property
    def ball_counts(self) -> list[int]:
        """The number of balls of each size, in the order of the case's sizes."""
        return np.bincount(self.balls.species, minlength=len(self.radii)).tolist()

    @property
    def frequency_hz(self) -> float:
        """Turns of the mill in a second: of the vessel, or of what turns in it; 0 for a mill at rest."""
        return max(body.motion.frequency_hz for body in self.bodies)

    def _start(self, volume_m3: float) -> tuple[np.ndarray, np.ndarray]:
        """Centres (n, 3) [m] in the vessel's frame, packed by the seed, and the size (n,) of each."""
        inserts = inserts_in_vessel(self.bodies)
        if self.case.mixture:
            counts = self.case.mixture.counts(self.count)
            return pack_mixture(self.vessel, 2 * self.radii, counts, self.case.seed, inserts)
        start = pack(self.vessel, self.diameter, self.count, self.case.seed, volume_m3, inserts=inserts)
        return start, np.zeros(self.count, dtype=np.int64)

    def _given(self, start: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """A given start (n, 3) [m], and the size (n,) of each ball."""
        if self.case.mixture or start.shape != (self.count, 3):
            raise SimulationError(
                f"a start of shape {start.shape}: it must have {self.count} rows and 3 columns, for balls of one size"
            )
        return start, np.zeros(self.count, dtype=np.int64)

    def _choose_steps(self) -> None:
        """The step: a whole number of them makes a snapshot interval or else an energy sample."""
        case, dem, contact = self.case, self.dem, self.contact
        self.step_scale_s = step_scale(contact, self.radii.min())
        longest, allowed = requested_step(case, dem, self.step_scale_s), largest_fraction(case, dem)
        if longest > allowed * self.step_scale_s:
            raise SimulationError(
                f"the time step of {longest:g} s is {longest / self.step_scale_s:.3g} of "
                f"{law_of(contact).scale_title}; at most {allowed:g} ({allowed * self.step_scale_s:.3g} s) is allowed"
            )
        revolution = 1 / self.frequency_hz if self.frequency_hz else case.window_s
        sample = revolution / dem.ledger_samples_per_revolution
        self.snapshot_every = 0
        if case.snapshot_interval_s:
            self.step, self.snapshot_every = aligned_step(longest, case.snapshot_interval_s)
            self.sample_every = max(1, round(sample / self.step))
        else:
            self.step, self.sample_every = aligned_step(longest, sample)
        sample = self.sample_every * self.step
        self.run_up_step, each = aligned_step(max(self.step, run_up_step(case, dem, self.step_scale_s)), sample)
        if each == self.sample_every:
            self.run_up_step = self.step
        self.settle_steps = math.ceil(case.settle_s / self.run_up_step)
        before = round(case.discard_s / sample)
        self.discard_steps, self.begin_step = before * each, before * self.sample_every
        self.window_steps = max(1, round(case.window_s / sample)) * self.sample_every
        self.first_begin_step = self.begin_step

    def _take_step(self, step: float, skin: float) -> None:
        """Take steps of another length [s]: the clock, and the coefficients that depend on it."""
        self.clock = state.make_clock(self.balls, [body.motion for body in self.bodies], step, skin)
        self.laws = state.make_laws(self.balls, self.contact, step, self.dem.overlap_max, self.walls.surface)

    @property
    def begin_s(self) -> float:
        """Time at which the recorded window begins [s]."""
        return self.begin_step * self.step

    @property
    def window_s(self) -> float:
        """Length of the recorded window [s]."""
        return self.window_steps * self.step

    def run(
        self,
        title: str | None = None,
        restart: str | Path | None = None,
        goes_on: Callable[[Recording], GoesOn] | None = None,
    ) -> Recording:
        """Settle, drive, discard, record. Raises SimulationError where the state stops making sense.

        title: of the progress bar, without which there is none; restart: a file that the state is written to from
        time to time, and that a run which was stopped goes on from; goes_on: says how a window that is over goes on.
        It is made longer by its own length while it ends within case.window_max_s of its first beginning, and begins
        anew in the first half of that.
        """
        recorder, table = self._recorder(), self._table()
        recording = Recording(
            edges=grid_edges(self.vessel.bounds[:, :2], recorder), occupancy=recorder.occupancy, height=recorder.height
        )
        self.counters[COUNTER.step] = 0
        if not (restart and read_restart(restart, self, recording)):
            self.counters[COUNTER.step] = -self.settle_steps
        self._take_step(self.step if self._is_recording else self.run_up_step, self.clock.skin)
        self._restart, self._written = restart, time.monotonic()
        first_window = self.window_steps
        with progress(self._steps_in_all, title or "", "step", bar_format=BAR, disable=title is None) as bar:
            bar.update(self.steps_taken)
            self._drive_in(recording, bar)
            # A restarted run may be in a window that had been made longer.
            while self.counters[COUNTER.step] > self.begin_step + self.window_steps + 1:
                self.window_steps += first_window
            while True:
                if self.counters[COUNTER.step] <= self.begin_step:
                    self._advance(self.begin_step - 1, silent_recorder(), make_table(0), recording, bar)
                    begin_window(self.contacts, self.totals, self.counters)
                recorder = recorder._replace(origin=self.begin_step)
                self._advance(self.begin_step + self.window_steps, recorder, table, recording, bar)
                if not goes_on or not self._prolonged(goes_on, recording, first_window):
                    break
                bar.total = self._steps_in_all
        end_window(self.candidates, self.contacts, self.walls, self.begin_s + self.window_s, self.counters, table)
        recording.drain(table, recorder, self.counters, self.numbers)
        restore_rows(self)
        return recording

    def _prolonged(self, goes_on: Callable[[Recording], GoesOn], recording: Recording, first_window: int) -> bool:
        """Make a window that is over longer, or begin it anew, by what is told; returns whether it goes on."""
        end = self.begin_step + self.window_steps
        taken, longest_s = end - self.first_begin_step, self.case.window_max_s or 0.0
        told = goes_on(recording) if (taken + first_window) * self.step <= longest_s else "end"
        if told == "anew" and 2 * taken * self.step <= longest_s * (1 + 1e-9):
            recording.clear()
            # The last sample of the old window and the first of the new one are two.
            self.begin_step, self.window_steps = end + self.sample_every, first_window
        else:
            self.window_steps += first_window if told != "end" else 0
        return told != "end"

    @property
    def time_s(self) -> float:
        """The present time [s]; 0 is where the mill starts."""
        return float(self.counters[COUNTER.step]) * self.clock.step

    @property
    def _is_recording(self) -> bool:
        """Whether the window has begun: then a step has a number above all before."""
        return bool(self.counters[COUNTER.step] > self.discard_steps)

    @property
    def steps_taken(self) -> int:
        """Steps since the balls were placed."""
        skipped = self.first_begin_step - self.discard_steps if self._is_recording else 0
        return int(self.counters[COUNTER.step]) + self.settle_steps - skipped

    @property
    def _steps_in_all(self) -> int:
        before = self.settle_steps + self.discard_steps + self.begin_step - self.first_begin_step
        return before + self.window_steps + 1

    def _drive_in(self, recording: Recording, bar: tqdm) -> None:
        """Settle, start the mill, and run up to where the window begins; a restarted run may be past any of it."""
        silent, none = silent_recorder(), make_table(0)
        if self.counters[COUNTER.step] <= 0:
            self._advance(-1, silent, none, recording, bar)
            # The walls start suddenly, so the planned rebuild of the lists may be too late.
            self.counters[COUNTER.check_in] = 0
        if not self._is_recording:
            self._advance(self.discard_steps - 1, silent, none, recording, bar)
            begin_window(self.contacts, self.totals, self.counters)
            self._shorten_step()
            self._disturb()

    def _shorten_step(self) -> None:
        """Go on with the step of the window.

        Rates are those of half a step ago, v(t - h/2) = v(t) - a h/2, and v(t) stays. A tangential spring is still to
        go from the last evaluation, a long step H ago, by H (u + u')/2 of the slips now and then, of which the short
        step h takes h (u + u')/2: with u' (2 H/h - 1) in place of u' it is the same for u = u'. The lists are made
        again, since open contacts have coefficients that depend on the step.
        """
        ratio = self.step / self.run_up_step
        self.counters[COUNTER.step] = self.begin_step
        if ratio == 1:
            return
        balls = self.balls
        for half_a_step_ago, now in (
            (balls.velocity, balls.velocity_now),
            (balls.angular_velocity, balls.angular_velocity_now),
        ):
            half_a_step_ago[:] = now + ratio * (half_a_step_ago - now)
        self._take_step(self.step, self.clock.skin)
        list_again(self)
        self.contacts.kept_history[:, HISTORY.last_slip] *= 2 / ratio - 1

    def _disturb(self) -> None:
        """Displace every ball by the case's disturbance, each in a direction of its own."""
        if self.case.disturbance_m:
            direction = np.random.default_rng(self.case.seed).normal(size=(self.count, 3))
            direction /= np.linalg.norm(direction, axis=1, keepdims=True)
            self.balls.position[:] += self.case.disturbance_m * direction[self.numbers]

    def _recorder(self) -> Recorder:
        """Buffers for the window."""
        occupancy_every = max(1, round(OCCUPANCY_INTERVAL_S / self.step))
        return make_recorder(
            self.vessel.bounds[:, :2], OCCUPANCY_CELL_M, self.count, len(self.bodies), self.begin_step,
            (self.sample_every, self.snapshot_every, occupancy_every), self.candidates.partner.size,
        )  # fmt: skip

    def _table(self) -> Table:
        """The buffer for contacts."""
        return make_table(max(TABLE_ROWS, 2 * self.contacts.slot.size), self.dem.counts_by_facet)

    def _advance(self, last_step: int, recorder: Recorder, table: Table, recording: Recording, bar: tqdm) -> None:
        """Call the kernel in chunks up to and including `last_step`."""
        chunk = max(64, int(CHUNK_S / (ASSUMED_NS * 1e-9 * self.count)))
        counters = self.counters
        while counters[COUNTER.step] <= last_step:
            before = int(counters[COUNTER.step])
            begin = time.perf_counter(), time.process_time()
            sort_if_due(self)
            self._call_kernel(table, recorder, min(before + chunk, last_step))
            self.wall_clock_s += time.perf_counter() - begin[0]
            self.processor_s += time.process_time() - begin[1]
            if counters[COUNTER.status] == STATUS.candidates_full:
                self.candidates, self.contacts = state.lengthened(self.candidates, self.contacts, counters)
                self.shares = self._make_shares()
            elif counters[COUNTER.status] != STATUS.running:
                restore_rows(self)
                raise SimulationError(self._trouble())
            recording.drain(table, recorder, counters, self.numbers)
            self._write_restart_if_due(recording)
            bar.update(int(counters[COUNTER.step]) - before)

    def _make_shares(self) -> Shares | None:
        """What the threads write to, where there are several; again whenever the lists are made."""
        if self.threads == 1:
            return None
        return make_shares(self.threads, self.count, len(self.bodies), self.candidates, self.contacts)

    def _call_kernel(self, table: Table, recorder: Recorder, last_step: int) -> None:
        """One call of the step loop; that with threads is compiled only where there are several."""
        with use_threads(self.threads) if self.threads > 1 else nullcontext():
            advance(
                self.balls, self.candidates, self.contacts, self.laws, mark_of(self.contact), self.walls, self.clock,
                self.totals, self.counters, table, recorder, last_step, self.shares,
            )  # fmt: skip

    def _write_restart_if_due(self, recording: Recording) -> None:
        """Write the restart file if the last one is old enough."""
        if self._restart and time.monotonic() - self._written >= self.dem.restart_interval_s:
            write_restart(self._restart, self, recording)
            self._written = time.monotonic()

    def _trouble(self) -> str:
        """The message for the status of the run."""
        if self.counters[COUNTER.status] == STATUS.overlap:
            return overlap_in_words(self)
        return f"{trouble_of(self.counters)} at {self.time_s:.6f} s"


# Progress in steps, which take alike, with the remaining time.
BAR = "{desc}: {percentage:3.0f}%|{bar}| {n_fmt}/{total_fmt} steps [{elapsed}<{remaining}]"


COLLISION_ROWS = 100_000  # contacts that one call of `run` can record


def trouble_of(counters: np.ndarray) -> str:
    """What a status says about a ball."""
    ball = counters[COUNTER.ball]
    return {
        STATUS.overlap: f"ball {ball} overlaps something by more than {100 * OVERLAP_LIMIT:g} % of its radius",
        STATUS.escaped: f"ball {ball} has left the vessel",
        STATUS.not_finite: f"the position of ball {ball} is not a finite number",
        STATUS.contact_lost: f"an open contact of ball {ball} was lost when the lists were rebuilt",
    }[int(counters[COUNTER.status])]


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
        if velocity is not None:
            self.balls.velocity[:] = self.balls.velocity_now[:] = velocity
        if angular_velocity is not None:
            self.balls.angular_velocity[:] = self.balls.angular_velocity_now[:] = angular_velocity
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
            raise SimulationError(f"{trouble_of(counters)} at {counters[COUNTER.step] * self.step:.6f} s")
        if counters[COUNTER.step] <= last_step:
            raise SimulationError(f"more than {len(table.value)} contacts ended in one run")


def _recorder(begin: int, sample_every: int, rows: int) -> Recorder:
    """Buffers for `rows` samples of the ledger and for nothing else."""
    recorder = make_recorder(np.zeros((2, 2)), 1.0, 0, 0, begin, (sample_every, 0, 0), 0)
    return recorder._replace(sample=np.zeros((rows, width_of(SAMPLE))))
