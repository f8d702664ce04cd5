"""Balls in a mill, advanced by coarse steps from Python: state, lists and scratch arrays."""

from dataclasses import dataclass

import numpy as np
from tqdm import tqdm

from millprint.columns import span_of
from millprint.config.contact import ContactConfig
from millprint.config.mill import MillConfig
from millprint.dem import state
from millprint.dem.layout import COUNTER, LANES, STATUS, TOTAL_WIDTH
from millprint.dem.neighbours import put_aside
from millprint.dem.recording import Table, make_table
from millprint.dem.timestep import aligned_step, rayleigh_time
from millprint.mill.bodies import build_bodies
from millprint.mill.wall_arrays import build_walls
from millprint.mill.walls import Walls
from millprint.surrogate.contact.pair import PAIR, PAIR_WIDTH
from millprint.surrogate.contact.samples import forget
from millprint.surrogate.contact.scratch import Scratch, Weights, make_scratch, no_weights
from millprint.surrogate.contact.step import Frames, gather_all, make_frames, predict, run_frames, run_steps

# A roll-out ends at this overlap, as a fraction of the ball's radius: the network has lost the ball [-].
OVERLAP_MAX = 0.5
# Candidates are listed up to this distance from contact, in radii [-], because coarse steps are long.
SKIN = 0.6
CANDIDATES_PER_BALL = 40

# State in the order in which the kernels take it.
Groups = tuple[state.Balls, state.Candidates, state.Contacts, state.Laws, Walls, state.Clock, np.ndarray, np.ndarray]


@dataclass(frozen=True)
class SavedState:
    """One state: positions (n, 3) [m], rates (n, 6) [m/s, rad/s], open contacts with their histories, and the step."""

    position: np.ndarray
    rate: np.ndarray
    first: np.ndarray
    second: np.ndarray
    history: np.ndarray
    step: int


def coarse_step(contact: ContactConfig, radius: float, rayleigh_multiple: float, interval_s: float) -> float:
    """The longest step of at most `rayleigh_multiple` Rayleigh times of which a whole number makes `interval_s` [s].

    In Rayleigh times, so that a contact takes as many steps whatever the balls are made of and however large.
    """
    rayleigh = rayleigh_time(radius, contact.density_kg_m3, contact.young_modulus_gpa * 1e9, contact.poisson_ratio)
    return aligned_step(rayleigh_multiple * rayleigh, interval_s)[0]


class CoarseSimulation:
    """Balls of one size in a mill at a speed; `weights` may be exchanged at any time."""

    def __init__(
        self, mill: MillConfig, contact: ContactConfig, speed_rpm: float, radius: float, balls: int, step: float,
        substeps: int,
    ):  # fmt: skip
        self.bodies = build_bodies(mill, speed_rpm)
        self.radius, self.step, self.substeps = radius, step, substeps
        skin = SKIN * radius
        self.balls = state.make_balls(
            np.zeros((balls, 3)), np.zeros(balls, dtype=np.int64), np.array([radius]), contact.density_kg_m3
        )
        self.clock = state.make_clock(self.balls, [body.motion for body in self.bodies], step, skin)
        vessels = [body.vessel for body in self.bodies]
        self.walls = build_walls(vessels, radius, skin / 2, OVERLAP_MAX * radius, pitch=max(0.4 * radius, 1e-3))
        self.laws = state.make_laws(self.balls, contact, step / substeps, OVERLAP_MAX, self.walls.surface)
        self._make_lists(CANDIDATES_PER_BALL)
        self.weights = no_weights()

    def _make_lists(self, per_ball: int) -> None:
        self.candidates = state.make_candidates(len(self.balls.position), len(self.bodies), per_ball)
        self.contacts = state.make_contacts(self.candidates.partner.size)
        self.totals, self.counters = np.zeros(TOTAL_WIDTH), state.make_counters()
        blocks = len(self.contacts.lanes)
        self._scratch = make_scratch(len(self.balls.position), len(self.bodies), blocks, self.step, self.substeps)

    @property
    def scratch(self) -> Scratch:
        """Scratch with the present weights."""
        return self._scratch._replace(weights=self.weights)

    @property
    def groups(self) -> tuple[*Groups, Table]:
        """State as the kernels take it."""
        return (
            self.balls, self.candidates, self.contacts, self.laws, self.walls, self.clock, self.totals, self.counters,
            make_table(0),
        )  # fmt: skip

    def load(self, begin: SavedState) -> None:
        """Load a state; works and ended contacts are counted from here."""
        forget(self.candidates, self.contacts, self.counters)
        self.totals[:], self._scratch.ended[:] = 0.0, 0.0
        self.counters[:] = 0
        kept = len(begin.first)
        self.contacts.kept_ball[:kept], self.contacts.kept_partner[:kept] = begin.first, begin.second
        self.contacts.kept_history[:kept] = begin.history
        self.counters[COUNTER.aside] = kept
        self.counters[COUNTER.step] = begin.step
        self.place(begin.position, begin.rate)

    def place(self, position: np.ndarray, rate: np.ndarray) -> None:
        """Set the positions of the balls; open contacts and their springs stay."""
        self.balls.position[:] = position
        self.balls.rate[:] = self.balls.rate_now[:] = rate

    def run(self, steps: int) -> bool:
        """Advance; False if a ball was lost."""
        groups = self.groups
        run_steps(*groups[:6], self.scratch, *groups[6:], self.counters[COUNTER.step] + steps - 1)
        return self.counters[COUNTER.status] == STATUS.running

    def record(self, frames: int, per_frame: int, chunk: int = 0, bar: tqdm | None = None) -> Frames:
        """Advance and keep `frames` states, `per_frame` steps apart; those after a ball was lost stay not a number."""
        kept, at = make_frames(frames, len(self.balls.position)), 0
        chunk = chunk or frames
        while at < frames:
            part = Frames(*(array[: min(at + chunk, frames)] for array in kept))
            missing = len(part.position) - at
            written = run_frames(*self.groups, self.scratch, per_frame, part, at)
            if bar is not None:
                bar.update(missing * per_frame)
            if written < missing:
                break
            at += written
        return kept

    def expected(self, members: list[Weights]) -> np.ndarray:
        """Mean forces that each network predicts for the next step (members, contacts, 3) [N]."""
        found, before = [], self.weights
        for weights in members:
            self.weights = weights
            groups = self.groups
            gather_all(*groups[:6], self.scratch, *groups[6:], self.counters[COUNTER.step] * self.step)
            predict(self.balls, self.contacts, self.walls, self.clock, self.scratch, self.counters)
            used = np.flatnonzero(self.contacts.slot >= 0)
            rows = self._scratch.work.reshape(-1, PAIR_WIDTH, LANES)
            found.append(rows[used // LANES, span_of(PAIR.expected_force), used % LANES])
        self.weights = before
        return np.array(found)

    def saved(self) -> SavedState:
        """The present state, to load again."""
        put_aside(self.candidates, self.contacts, self.counters)
        kept = int(self.counters[COUNTER.aside])
        self.counters[COUNTER.rebuilds] = 0
        history = self.contacts.kept_history[:kept].copy()
        return SavedState(
            self.balls.position.copy(),
            self.balls.rate.copy(),
            self.contacts.kept_ball[:kept].copy(),
            self.contacts.kept_partner[:kept].copy(),
            history,
            int(self.counters[COUNTER.step]),
        )
