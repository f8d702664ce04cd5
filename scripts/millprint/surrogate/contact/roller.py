"""The contact surrogate in the scene of a simulation: first states from its snapshots, and roll-outs."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from tqdm import tqdm

from millprint.config.contact import ContactConfig
from millprint.config.mill import MillConfig
from millprint.dem import state
from millprint.dem.lanes import HISTORY_COLUMNS
from millprint.hdf5 import open_hdf5
from millprint.surrogate.contact.coarse import CoarseSimulation, SavedState, coarse_step
from millprint.surrogate.contact.step import Frames
from millprint.surrogate.contact.store import read_ensemble
from millprint.surrogate.rollout import RollOut
from millprint.surrogate.trajectory import read_attributes, read_rows

# Frames of one call of the kernel, between two looks at the progress.
CHUNK = 200


@dataclass(frozen=True)
class ContactState:
    """A batch of states at the times time_s (batch,) since the start of motion."""

    time_s: np.ndarray
    begins: list[SavedState]


class ContactRoller:
    """Rolls a batch of trajectories out with the first member of an ensemble, or with any other."""

    def __init__(self, weights: str | Path, run: str | Path) -> None:
        self.members, self.recipe = read_ensemble(weights)
        self.run_path = run
        attributes = read_attributes(run)
        mill, contact = MillConfig(**attributes["mill"]), ContactConfig(**attributes["contact"])
        radius = attributes["case"]["ball_diameter_mm"] / 2e3
        with open_hdf5(run) as file:
            self.times_s = file["snapshots/time_s"][:]
            self.balls = file["snapshots/position_m"].shape[1]
        self.interval_s = float(self.times_s[-1] - self.times_s[0]) / (len(self.times_s) - 1)
        coarse = self.recipe.coarse
        self.step_s = coarse_step(contact, radius, coarse.rayleigh_multiple, self.interval_s)
        speed = attributes["case"]["speed_rpm"]
        self.coarse = CoarseSimulation(mill, contact, speed, radius, self.balls, self.step_s, coarse.substeps)

    def first_state(self, starts_s: list[float]) -> ContactState:
        """The recorded states at each of `starts_s`, with springs from those just before.

        Springs are no part of a snapshot. So the states of the last coarse.warm_up_s are gone through: from each to
        the next by coarse steps, where the balls are put as recorded, while contacts and their springs stay.
        """
        begins = [self._warmed_up(start) for start in starts_s]
        # A step for nothing: no roll-out waits for the compiler.
        self.coarse.load(begins[0])
        self.coarse.record(1, 1)
        return ContactState(np.array([begin.step * self.step_s for begin in begins]), begins)

    def _warmed_up(self, start_s: float) -> SavedState:
        earlier = round(self.recipe.coarse.warm_up_s / self.interval_s)
        last = round((start_s - float(self.times_s[0])) / self.interval_s)
        rows = slice(max(0, last - earlier), last + 1)
        position, velocity, spin = read_rows(self.run_path, ("position_m", "velocity_m_s", "spin_rad_s"), rows)
        rate = np.concatenate([velocity, spin], axis=2).astype(float)
        none = np.zeros(0, dtype=np.int64)
        per_snapshot = round(self.interval_s / self.step_s)
        first = round(float(self.times_s[rows.start]) / self.interval_s) * per_snapshot
        coarse, coarse.weights = self.coarse, self.members[0]
        coarse.load(SavedState(position[0].astype(float), rate[0], none, none, np.zeros((0, HISTORY_COLUMNS)), first))
        for place in range(1, len(position)):
            coarse.run(per_snapshot)
            coarse.place(position[place], rate[place])
        return coarse.saved()

    def run(
        self, begin: ContactState, steps: int, steps_per_frame: int, bar: tqdm | None = None, member: int = 0
    ) -> RollOut:
        """Advance every trajectory by `steps` steps and keep every `steps_per_frame`-th state."""
        frames = steps // steps_per_frame
        self.coarse.weights = self.members[member]
        parts = []
        for settled in begin.begins:
            self.coarse.load(settled)
            parts.append((settled, self.coarse.record(frames, steps_per_frame, CHUNK, bar), self._trouble()))
        return self._joined(begin, parts, steps_per_frame)

    def _trouble(self) -> tuple[int, float] | None:
        """The ball that was lost and the time of it since the start of motion [s]."""
        counters = self.coarse.counters
        if counters[state.STATUS] == state.RUNNING:
            return None
        return int(counters[state.BALL]), int(counters[state.STEP]) * self.step_s

    def _joined(self, begin: ContactState, parts: list, steps_per_frame: int) -> RollOut:
        position = np.stack([_from(settled.position, kept.position) for settled, kept, _ in parts], axis=1)
        rate = np.stack([_from(settled.rate, kept.rate) for settled, kept, _ in parts], axis=1)
        normal, tangential = (np.stack([_increments(kept, k) for _, kept, _ in parts], axis=1) for k in (0, 1))
        ended = np.stack([_increments(kept, 2) for _, kept, _ in parts], axis=1)
        crossed = np.full(position.shape[1:3], np.inf)
        for number, (_, _, trouble) in enumerate(parts):
            if trouble:
                crossed[number, trouble[0]] = trouble[1] - begin.time_s[number]
        return RollOut(
            time_s=np.arange(len(position)) * steps_per_frame * self.step_s,
            position_m=position.astype(np.float32),
            velocity_m_s=rate[..., :3].astype(np.float32),
            spin_rad_s=rate[..., 3:].astype(np.float32),
            dissipated_J=normal + tangential,
            normal_J=normal,
            tangential_J=tangential,
            collisions=ended,
            crossed_s=crossed,
            start_s=begin.time_s,
        )

    def spread(self, begin: ContactState, steps: int, steps_per_frame: int, bar: tqdm | None = None) -> np.ndarray:
        """Dissipation of every member from the first start, since the frame before (frames, members) [J]."""
        first = ContactState(begin.time_s[:1], begin.begins[:1])
        members = range(len(self.members))
        return np.stack(
            [self.run(first, steps, steps_per_frame, bar, member).dissipated_J[:, 0] for member in members], axis=1
        )

    def doubt(self, begin: ContactState, steps: int, looks: int) -> np.ndarray:
        """How far the members' expectations part along the first trajectory, over the forces' own size (looks,) [-].

        sqrt(P / <S>) with P = sum |F_k - F|^2 / (members - 1) and S = sum |F|^2 over all contacts at a time, F the mean
        over the members k and <> over all times: its root mean square is that of all contacts together. Unlike the
        spread of a quantity after a long roll-out it holds nothing of the system's own chaos.
        """
        found = np.full((looks, 2), np.nan)
        if len(self.members) < 2:
            return found[:, 0]
        self.coarse.weights = self.members[0]
        self.coarse.load(begin.begins[0])
        for look in range(looks):
            if not self.coarse.run(max(1, steps // looks)):
                break
            forces = self.coarse.expected(self.members)
            mean = forces.mean(axis=0)
            found[look] = ((forces - mean) ** 2).sum() / (len(forces) - 1), (mean**2).sum()
        return np.sqrt(found[:, 0] / np.nanmean(found[:, 1]))


def _from(begin: np.ndarray, kept: np.ndarray) -> np.ndarray:
    return np.concatenate([begin[None], kept])


def _increments(kept: Frames, channel: int) -> np.ndarray:
    """Since the frame before: normal (0) and tangential (1) dissipation [J], contacts that ended (2)."""
    works = kept.works
    total = (
        works[:, state.TOTAL_NORMAL],
        # Dissipated: the work less what the springs still hold.
        works[:, state.TOTAL_TANGENTIAL] - works[:, state.ELASTIC_TANGENTIAL],
        kept.ended,
    )[channel]
    return np.concatenate([[0.0], np.diff(total, prepend=0.0)])
