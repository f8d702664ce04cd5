"""One simulation as an object that is driven from Python: buffers, chunks, progress, and errors in words."""

import math
import time
from dataclasses import dataclass, field

import numpy as np

from millprint.config.contact import ContactConfig
from millprint.config.mill import MillConfig
from millprint.config.override import overridden
from millprint.config.sweep import Case, DemConfig, ball_count
from millprint.dem import state
from millprint.dem.advance import SAMPLE_COLUMNS, Recorder, Table, advance, begin_window, end_window
from millprint.dem.packing import pack
from millprint.dem.timestep import aligned_step, largest_fraction, rayleigh_time, wanted_step
from millprint.errors import SimulationError
from millprint.job import progress
from millprint.mill.motion import build_motion
from millprint.mill.vessel import Vessel, build_vessel
from millprint.mill.walls import Walls, build_walls

# Wall time that one call of the kernel should take [s]: short enough for a lively progress bar.
CHUNK_S = 0.25
ASSUMED_NS = 30

# Rows of the table of collisions before it is emptied.
TABLE_ROWS = 1 << 16


@dataclass
class Recording:
    """What a window has recorded, in pieces."""

    samples: list[np.ndarray] = field(default_factory=list)
    contacts: list[tuple[np.ndarray, ...]] = field(default_factory=list)
    snapshots: list[np.ndarray] = field(default_factory=list)
    snapshot_bodies: list[np.ndarray] = field(default_factory=list)
    snapshot_contacts: list[np.ndarray] = field(default_factory=list)
    occupancy: np.ndarray | None = None
    edges: tuple[np.ndarray, np.ndarray] | None = None
    height_m: float = math.nan


class Simulation:
    """Balls in a moving vessel. Step 0 is where the mill starts; before it the vessel is at rest."""

    def __init__(self, case: Case, mill: MillConfig, contact: ContactConfig, dem: DemConfig) -> None:
        mill, contact = overridden(case, mill, contact)
        self.case, self.mill, self.contact, self.dem = case, mill, contact, dem
        self.diameter = case.ball_diameter_mm / 1e3
        self.radius = self.diameter / 2
        volume = mill.volume_ml / 1e6
        self.count = ball_count(case.fill_ratio, volume, self.diameter)
        if self.count < 1:
            raise SimulationError(
                f"fill ratio {case.fill_ratio:g} is less than one ball of {case.ball_diameter_mm:g} mm"
            )
        self.motion = build_motion(mill, case.speed_rpm)
        self.vessel: Vessel = build_vessel(mill)
        self._choose_steps()
        start = pack(self.vessel, self.diameter, self.count, case.seed, volume) + self.motion.position(0.0)
        self.balls = state.make_balls(
            start, np.zeros(self.count, dtype=np.int64), np.array([self.radius]), contact.density_kg_m3
        )
        self.candidates = state.make_candidates(self.count)
        self.contacts = state.make_contacts(self.candidates.partner.size)
        self.laws = state.make_laws(self.balls, contact, self.step, dem.overlap_max)
        self.clock = state.make_clock(self.balls, [self.motion], self.step, dem.skin_m)
        self.walls: Walls = build_walls(
            [self.vessel],
            self.radius,
            dem.skin_m / 2,
            dem.overlap_max * self.radius,
            pitch=max(0.4 * self.radius, 1e-3),
        )
        self.totals = np.zeros(state.TOTALS)
        self.counters = state.make_counters()
        self.wall_clock_s = 0.0
        self.processor_s = 0.0

    def _choose_steps(self) -> None:
        """The step: a whole number of them makes a snapshot interval or else an energy sample."""
        case, dem, contact = self.case, self.dem, self.contact
        self.rayleigh_s = rayleigh_time(
            self.radius, contact.density_kg_m3, contact.young_modulus_gpa * 1e9, contact.poisson_ratio
        )
        longest, allowed = wanted_step(case, dem, self.rayleigh_s), largest_fraction(case, dem)
        if longest > allowed * self.rayleigh_s:
            raise SimulationError(
                f"the time step of {longest:g} s is {longest / self.rayleigh_s:.3g} of the Rayleigh time; "
                f"at most {allowed:g} ({allowed * self.rayleigh_s:.3g} s) is allowed"
            )
        revolution = 1 / self.motion.frequency_hz if self.motion.frequency_hz else case.window_s
        sample = revolution / dem.ledger_samples_per_revolution
        self.snapshot_every = 0
        if case.snapshot_interval_s:
            self.step, self.snapshot_every = aligned_step(longest, case.snapshot_interval_s)
            self.sample_every = max(1, round(sample / self.step))
        else:
            self.step, self.sample_every = aligned_step(longest, sample)
        self.settle_steps = math.ceil(case.settle_s / self.step)
        self.discard_steps = round(case.discard_s / self.step / self.sample_every) * self.sample_every
        samples = max(1, round(case.window_s / self.step / self.sample_every))
        self.window_steps = samples * self.sample_every
        self.window_s = self.window_steps * self.step
        self.begin_s = self.discard_steps * self.step

    def run(self, title: str) -> Recording:
        """Settle, drive, discard, record. Raises SimulationError where the state stops making sense."""
        total = self.settle_steps + self.discard_steps + self.window_steps + 1
        recording = Recording()
        self.counters[state.STEP] = -self.settle_steps
        with progress(total, title, "s", unit_scale=self.step, bar_format=BAR) as bar:
            self._advance(-1, self._recorder(None), no_table(), None, bar)
            self.counters[state.CHECK_IN] = 0
            self._advance(self.discard_steps - 1, self._recorder(None), no_table(), None, bar)
            begin_window(self.contacts, self.totals, self.counters)
            recorder, table = self._recorder(recording), make_table(max(TABLE_ROWS, 2 * self.contacts.slot.size))
            self._advance(self.discard_steps + self.window_steps, recorder, table, recording, bar)
        end_window(self.candidates, self.contacts, self.begin_s + self.window_s, self.counters, table)
        self._drain(table, recorder, recording)
        recording.occupancy = recorder.occupancy
        recording.height_m = float(recorder.height[0] / recorder.height[1]) if recorder.height[1] else math.nan
        return recording

    def _recorder(self, recording: Recording | None) -> Recorder:
        """Buffers for a window, or for none."""
        n = self.count
        active = recording is not None
        low, high = self.vessel.bounds[:, :2]
        cell = self.dem.occupancy_cell_m
        shape = np.ceil((high - low) / cell).astype(int)
        if active:
            recording.edges = tuple(low[axis] + cell * np.arange(shape[axis] + 1) for axis in range(2))
        snapshots = 256 if active and self.snapshot_every else 0
        samples = 512 if active else 0
        return Recorder(
            origin=self.discard_steps if active else np.iinfo(np.int64).max,
            sample_every=self.sample_every if active else 0,
            snapshot_every=self.snapshot_every if active else 0,
            occupancy_every=max(1, round(self.dem.occupancy_interval_s / self.step)) if active else 0,
            sample=np.zeros((samples, len(SAMPLE_COLUMNS))),
            snapshot=np.zeros((snapshots, n, 12)),
            snapshot_body=np.zeros((snapshots, 10)),
            snapshot_contact=np.zeros(
                (max(snapshots, 1) * (8 * n + 16) + self.candidates.partner.size, 2), dtype=np.int64
            ),
            grid=np.array([*low, 1 / cell]),
            occupancy=np.zeros((*shape, 5)),
            work=np.zeros((2, state.TOTALS)),
            height=np.zeros(2),
        )

    def _advance(self, last_step: int, recorder: Recorder, table: Table, recording, bar) -> None:
        """Call the kernel in chunks up to and including `last_step`."""
        chunk = max(64, int(CHUNK_S / (ASSUMED_NS * 1e-9 * self.count)))
        counters = self.counters
        while counters[state.STEP] <= last_step:
            before = int(counters[state.STEP])
            begin = time.perf_counter(), time.process_time()
            advance(
                self.balls, self.candidates, self.contacts, self.laws, self.walls, self.clock, self.totals, counters,
                table, recorder, min(before + chunk, last_step),
            )  # fmt: skip
            self.wall_clock_s += time.perf_counter() - begin[0]
            self.processor_s += time.process_time() - begin[1]
            if counters[state.STATUS] == state.CANDIDATES_FULL:
                self._lengthen_lists()
            elif counters[state.STATUS] != state.RUNNING:
                raise SimulationError(self._trouble())
            if recording is not None:
                self._drain(table, recorder, recording)
            bar.update(int(counters[state.STEP]) - before)

    def _lengthen_lists(self) -> None:
        """Twice the room for candidates and contacts; those that are open have been set aside and stay there."""
        per_ball = 2 * self.candidates.partner.size // self.count
        aside, kept = int(self.counters[state.ASIDE]), self.contacts
        self.candidates = state.make_candidates(self.count, len(self.clock.load), per_ball)
        self.contacts = state.make_contacts(self.candidates.partner.size)
        self.contacts.kept_ball[:aside] = kept.kept_ball[:aside]
        self.contacts.kept_partner[:aside] = kept.kept_partner[:aside]
        self.contacts.kept_history[:aside] = kept.kept_history[:aside]
        self.counters[state.STATUS] = state.RUNNING
        self.counters[state.CHECK_IN] = 0

    def _drain(self, table: Table, recorder: Recorder, recording: Recording) -> None:
        """Take what the buffers hold and empty them."""
        counters = self.counters
        rows, samples = counters[state.RECORDS], counters[state.SAMPLES]
        snapshots, contacts = counters[state.SNAPSHOTS], counters[state.SNAPSHOT_CONTACTS]
        if rows:
            recording.contacts.append(tuple(column[:rows].copy() for column in table))
        if samples:
            recording.samples.append(recorder.sample[:samples].copy())
        if snapshots:
            recording.snapshots.append(recorder.snapshot[:snapshots].copy())
            recording.snapshot_bodies.append(recorder.snapshot_body[:snapshots].copy())
            recording.snapshot_contacts.append(recorder.snapshot_contact[:contacts].copy())
        counters[[state.RECORDS, state.SAMPLES, state.SNAPSHOTS, state.SNAPSHOT_CONTACTS]] = 0

    def _trouble(self) -> str:
        """What went wrong, in words."""
        ball, partner = int(self.counters[state.BALL]), int(self.counters[state.PARTNER])
        when = f"at {self.counters[state.STEP] * self.step:.6f} s"
        other = f"ball {partner}" if partner >= 0 else f"wall feature {-1 - partner}"
        return {
            state.OVERLAP: (
                f"ball {ball} overlaps {other} by more than {100 * self.dem.overlap_max:g} % of its radius {when}: "
                "the speed is too high for this Young's modulus, or the step too large"
            ),
            state.ESCAPED: f"ball {ball} has left the vessel {when}",
            state.NOT_FINITE: f"the position of ball {ball} is not a finite number {when}",
            state.CONTACT_LOST: f"an open contact of ball {ball} was lost when the candidates were listed anew {when}",
        }[int(self.counters[state.STATUS])]


# Progress in simulated seconds, with the time to go.
BAR = "{desc}: {percentage:3.0f}%|{bar}| {n_fmt}/{total_fmt} s simulated [{elapsed}<{remaining}]"


def no_table() -> Table:
    """A table of collisions that records nothing."""
    return make_table(0)


def make_table(rows: int) -> Table:
    """An empty table of collisions with room for `rows`."""
    whole = np.zeros(rows, dtype=np.int64)
    return Table(whole, whole.copy(), np.zeros(rows, dtype=np.uint8), np.zeros((rows, 9)))
