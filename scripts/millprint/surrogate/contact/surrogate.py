"""The contact surrogate in the scene of a simulation: first states from its snapshots, and roll-outs."""

import logging
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
from tqdm import tqdm

from millprint.config.contact import ContactConfig
from millprint.config.mill import MillConfig
from millprint.dem.layout import COUNTER, HISTORY_WIDTH, STATUS, TOTAL
from millprint.errors import ConfigError
from millprint.hdf5 import open_hdf5
from millprint.progress import progress
from millprint.surrogate.contact.coarse import CoarseSimulation, SavedState, coarse_step
from millprint.surrogate.contact.ensemble import read_ensemble
from millprint.surrogate.contact.step import Frames
from millprint.surrogate.protocol import Run
from millprint.surrogate.rollout import RollOut
from millprint.surrogate.trajectory import read_attributes, read_rows

logger = logging.getLogger("millprint")

# Frames that the kernel advances in one call, between two updates of the progress bar.
FRAMES_PER_CALL = 200
# Moments of a roll-out at which the forces that the members expect are compared.
COMPARED_MOMENTS = 100


class ContactSurrogate:
    """An ensemble that advances a batch of trajectories one after the other, with one member or with another.

    member: the one that leads, 0 for the first. Raises ConfigError where the ensemble has none of that number.
    """

    def __init__(self, weights: str | Path, run: str | Path, member: int = 0) -> None:
        self.members, self.recipe = read_ensemble(weights)
        if member >= len(self.members):
            raise ConfigError(f"{weights}: has {len(self.members)} member(s), and none of number {member}")
        self.leading = member
        self.run_path = run
        attributes = read_attributes(run)
        mill, contact = MillConfig(**attributes["mill"]), ContactConfig(**attributes["contact"])
        radius = attributes["case"]["ball_diameter_mm"] / 2e3
        with open_hdf5(run) as file:
            self.times_s = file["snapshots/time_s"][:]
            self.balls = file["snapshots/position_m"].shape[1]
        self.interval_s = float(self.times_s[-1] - self.times_s[0]) / (len(self.times_s) - 1)
        settings = self.recipe.coarse
        self.step_s = coarse_step(contact, radius, settings.rayleigh_multiple, self.interval_s)
        speed = attributes["case"]["speed_rpm"]
        self.coarse = CoarseSimulation(mill, contact, speed, radius, self.balls, self.step_s, settings.substeps)

    def first_states(self, starts_s: list[float]) -> list[SavedState]:
        """The recorded states at each of `starts_s` [s], with springs from the states just before.

        Springs are no part of a snapshot. So the surrogate goes through the states of the last coarse.warm_up_s: from
        each to the next by coarse steps, where the balls are put as recorded, while contacts and their springs stay.
        """
        states = [self._warmed_up(start) for start in starts_s]
        # A step whose result is not used, so that no roll-out waits for the compiler.
        self.coarse.load(states[0])
        self.coarse.record(1, 1)
        return states

    def _warmed_up(self, start_s: float) -> SavedState:
        earlier = round(self.recipe.coarse.warm_up_s / self.interval_s)
        last = round((start_s - float(self.times_s[0])) / self.interval_s)
        rows = slice(max(0, last - earlier), last + 1)
        position, velocity, omega = read_rows(self.run_path, ("position_m", "velocity_m_s", "spin_rad_s"), rows)
        rate = np.concatenate([velocity, omega], axis=2).astype(float)
        none = np.zeros(0, dtype=np.int64)
        per_snapshot = round(self.interval_s / self.step_s)
        first = round(float(self.times_s[rows.start]) / self.interval_s) * per_snapshot
        coarse, coarse.weights = self.coarse, self.members[self.leading]
        coarse.load(SavedState(position[0].astype(float), rate[0], none, none, np.zeros((0, HISTORY_WIDTH)), first))
        for place in range(1, len(position)):
            coarse.run(per_snapshot)
            coarse.place(position[place], rate[place])
        return coarse.saved()

    def begin(self, starts_s: list[float]) -> Run:
        """Take the first states from the simulation, one a start [s], for roll-outs by the leading member."""
        return partial(self.run, self.first_states(starts_s))

    def roll_out(self, starts_s: list[float], steps: int, steps_per_frame: int) -> RollOut:
        """A roll-out by the leading member; from the first start also by every member, and how far they differ.

        The members are compared where the first leads; a further training is rolled out alone.
        """
        states = self.first_states(starts_s)
        if self.leading:
            with progress(steps * len(states), None, "step") as bar:
                return self.run(states, steps, steps_per_frame, bar)
        with progress(steps * (len(states) + len(self.members)), None, "step") as bar:
            rollout = self.run(states, steps, steps_per_frame, bar)
            members = range(len(self.members))
            alone = [self.run(states[:1], steps, steps_per_frame, bar, member).dissipated_J for member in members]
        disagreement = self.force_disagreement(states[0], steps)
        member_dissipated_J = np.concatenate(alone, axis=1)
        logger.info("dissipation of the members: %s J", member_dissipated_J.sum(axis=0))
        pooled = np.sqrt(np.nanmean(disagreement**2))
        logger.info("the forces that they expect differ by %.3g of the forces", pooled)
        return replace(rollout, member_dissipated_J=member_dissipated_J, force_disagreement=disagreement)

    def run(
        self, states: list[SavedState], steps: int, steps_per_frame: int, bar: tqdm | None = None,
        member: int | None = None,
    ) -> RollOut:  # fmt: skip
        """Advance every trajectory by `steps` steps with a member, the leading one if none is named.

        Every `steps_per_frame`-th state is kept.
        """
        self.coarse.weights = self.members[self.leading if member is None else member]
        start_s = np.array([saved.step * self.step_s for saved in states])
        crossed = np.full((len(states), self.balls), np.inf)
        kept: list[Frames] = []
        for number, saved in enumerate(states):
            self.coarse.load(saved)
            kept.append(self.coarse.record(steps // steps_per_frame, steps_per_frame, FRAMES_PER_CALL, bar))
            counters = self.coarse.counters
            if counters[COUNTER.status] != STATUS.running:
                lost_s = int(counters[COUNTER.step]) * self.step_s
                crossed[number, int(counters[COUNTER.ball])] = lost_s - start_s[number]
        pairs = list(zip(states, kept, strict=True))
        position = np.stack([np.concatenate([saved.position[None], part.position]) for saved, part in pairs], axis=1)
        rate = np.stack([np.concatenate([saved.rate[None], part.rate]) for saved, part in pairs], axis=1)
        works = np.stack([part.works for part in kept], axis=1)
        normal = _increments(works[..., TOTAL.normal_damping_J])
        # Dissipated: the work less what the springs still hold.
        tangential = _increments(works[..., TOTAL.tangential_work_J] - works[..., TOTAL.elastic_tangential_J])
        return RollOut(
            time_s=np.arange(len(position)) * steps_per_frame * self.step_s,
            position_m=position.astype(np.float32),
            velocity_m_s=rate[..., :3].astype(np.float32),
            angular_velocity_rad_s=rate[..., 3:].astype(np.float32),
            dissipated_J=normal + tangential,
            normal_J=normal,
            tangential_J=tangential,
            collisions=_increments(np.stack([part.ended for part in kept], axis=1)),
            crossed_s=crossed,
            start_s=start_s,
        )

    def force_disagreement(self, begin: SavedState, steps: int) -> np.ndarray:
        """How far the forces that the members expect differ along a trajectory, over the forces, (moments,) [-].

        sqrt(P / <S>) with P = sum |F_k - F|^2 / (members - 1) and S = sum |F|^2 over all contacts at a moment, F the
        mean over the members k and <> over all moments: its root mean square is that of all contacts together. Unlike
        the spread of a quantity after a long roll-out it holds nothing of the system's own chaos. Not a number for a
        single member, and after a ball was lost.
        """
        squares = np.full((COMPARED_MOMENTS, 2), np.nan)
        if len(self.members) < 2:
            return squares[:, 0]
        self.coarse.weights = self.members[0]
        self.coarse.load(begin)
        for moment in range(COMPARED_MOMENTS):
            if not self.coarse.run(max(1, steps // COMPARED_MOMENTS)):
                break
            forces = self.coarse.expected(self.members)
            mean = forces.mean(axis=0)
            squares[moment] = ((forces - mean) ** 2).sum() / (len(forces) - 1), (mean**2).sum()
        return np.sqrt(squares[:, 0] / np.nanmean(squares[:, 1]))


def _increments(totals: np.ndarray) -> np.ndarray:
    """Totals (frames, batch) since the frame before, after a first frame without any (frames + 1, batch)."""
    return np.concatenate([np.zeros((1, totals.shape[1])), np.diff(totals, axis=0, prepend=0.0)])
