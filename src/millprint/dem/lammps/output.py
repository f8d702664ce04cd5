"""What LAMMPS writes: its log, the states of all balls together, contacts between balls, snapshots."""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from millprint.config.errors import SimulationError
from millprint.dem.lammps.input import CONTACT_NAMES, SNAPSHOT_NAMES, STATE_NAMES
from millprint.mill.gravity import GRAVITY
from millprint.mill.motion import Motion

LOOP = re.compile(r"^Loop time of (\S+) on (\d+) procs for (\d+) steps with (\d+) atoms", re.MULTILINE)
SHARE = re.compile(r"^(\S+)% CPU use", re.MULTILINE)
VERSION = re.compile(r"^LAMMPS \((.+)\)", re.MULTILINE)
UP = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True)
class LammpsLog:
    """The last loop in the log of a run, and the time of all its loops."""

    version: str
    loop_s: float
    steps: int
    balls: int
    ranks: int
    processor_share: float  # of the loop's wall time [-]
    loops_s: float  # wall time of all loops of the log [s]
    loops_steps: int


def read_log(text: str) -> LammpsLog:
    """Read a log; raises SimulationError with LAMMPS's own error where no loop came to its end."""
    loops, shares, version = LOOP.findall(text), SHARE.findall(text), VERSION.search(text)
    if "ERROR" in text or not loops or not shares or not version:
        errors = [line for line in text.splitlines() if line.startswith("ERROR")]
        raise SimulationError(f"LAMMPS: {errors[0] if errors else 'the log ends before the run does'}")
    loop_s, ranks, steps, balls = loops[-1]
    return LammpsLog(
        version[1], float(loop_s), int(steps), int(balls), int(ranks), float(shares[-1]) / 100,
        sum(float(loop[0]) for loop in loops), sum(int(loop[2]) for loop in loops),
    )  # fmt: skip


def read_states(text: str, begin: int, end: int, every: int) -> pd.DataFrame:
    """States in columns STATE_NAMES, a row for each step from `begin` to `end`; of a step written twice, the last.

    A run that was stopped writes some steps again. Raises SimulationError where a step is missing or not a number.
    """
    rows = [line.split() for line in text.splitlines()]
    numbers = [row for row in rows if len(row) == len(STATE_NAMES) and not row[0].startswith("#")]
    table = pd.DataFrame(numbers, columns=list(STATE_NAMES), dtype=float).drop_duplicates("step", keep="last")
    table = table.set_index("step").reindex(np.arange(begin, end + 1, every, dtype=float))
    if not np.isfinite(table.to_numpy()).all():
        at = int(table.index[~np.isfinite(table.to_numpy()).all(axis=1)][0])
        raise SimulationError(f"LAMMPS: the state of step {at} is missing or not a finite number")
    return table.reset_index()


def _frames(text: str, columns: int) -> Iterator[tuple[int, np.ndarray]]:
    """The step and the rows (m, columns) of each frame of a dump; an unfinished last one is left out."""
    for piece in text.split("ITEM: TIMESTEP\n")[1:]:
        lines = piece.split("\n")
        count = int(lines[2]) if len(lines) > 2 and lines[2] else -1
        # Step, two titles, number, title and three bounds, title of the columns.
        values = np.array(" ".join(lines[8 : 8 + count]).split(), dtype=float) if count >= 0 else np.empty(0)
        if count >= 0 and values.size == count * columns:
            yield int(lines[0]), values.reshape(count, columns)


def read_contacts(text: str, begin: int, step_s: float, radius: float) -> pd.DataFrame:
    """Contacts between balls that end in the window: first, second, start_s, duration_s, peak_overlap_m.

    begin: step of the window; start_s counts from it. LAMMPS with several ranks, or stopped, writes some twice.
    """
    pieces = [rows for _, rows in _frames(text, len(CONTACT_NAMES))]
    table = pd.DataFrame(np.concatenate([np.empty((0, len(CONTACT_NAMES))), *pieces]), columns=list(CONTACT_NAMES))
    pair = np.sort(table[["first", "second"]].to_numpy(), axis=1) - 1
    table = table.assign(first=pair[:, 0].astype(int), second=pair[:, 1].astype(int))
    table = table.drop_duplicates(["first", "second", "created"])
    table = table[table["created"] + table["steps"] >= begin]
    return pd.DataFrame(
        {
            "first": table["first"],
            "second": table["second"],
            "start_s": (table["created"] - begin) * step_s,
            "duration_s": table["steps"] * step_s,
            "peak_overlap_m": 2 * radius - table["closest_m"],
        }
    ).sort_values(["start_s", "first", "second"], ignore_index=True)


def read_snapshots(text: str, begin: int, end: int, every: int) -> np.ndarray:
    """Snapshots (t, balls, columns of SNAPSHOT_NAMES) of the window; of a step that was written twice, the last."""
    found = {step: rows[np.argsort(rows[:, 0])] for step, rows in _frames(text, len(SNAPSHOT_NAMES))}
    wanted = range(begin, end + 1, every)
    if missing := [step for step in wanted if step not in found]:
        raise SimulationError(f"LAMMPS: the snapshot of step {missing[0]} is missing")
    return np.array([found[step] for step in wanted])


def _rates(motion: Motion, time_s: np.ndarray) -> tuple[np.ndarray, ...]:
    """Velocity field of the walls: u at the laboratory's origin and angular velocity (t, 3), and their derivatives."""

    def wave(rows: np.ndarray, size: int, order: int) -> np.ndarray:
        w, phase = rows[:, :1], rows[:, :1] * time_s[:, None, None]
        cosine, sine = rows[:, 1 : 1 + size], rows[:, 1 + size : 1 + 2 * size]
        turned = phase + order * np.pi / 2
        return (w**order * (cosine * np.cos(turned) + sine * np.sin(turned))).sum(axis=1)

    moved, velocity, acceleration = (wave(motion.harmonics, 3, order) for order in range(3))
    spin, gain = (wave(motion.swing, 1, order) * motion.axis for order in (1, 2))
    spin = spin + motion.rate * motion.axis
    pivot = moved + motion.pivot
    return (
        velocity - np.cross(spin, pivot),
        spin,
        acceleration - np.cross(gain, pivot) - np.cross(spin, velocity),
        gain,
    )


def ledger_of(states: pd.DataFrame, motion: Motion, time_s: np.ndarray, mass: float) -> pd.DataFrame:
    """Energies over the window [J]: time_s, wall_work_J, gravity_work_J, kinetic_J and its parts, lost_J.

    time_s: of each state since the mill has started (t,) [s]; mass: of all balls [kg].

    Wall work, from momentum P and angular momentum L about the origin. The walls move as one rigid body, its velocity
    u + w x r, so that their power is F . u + T . w of force and torque on the balls. With F = dP/dt - M g and
    T = dL/dt - r x M g, their work is P . u + L . w at the ends, less the integrals of P . du/dt + L . dw/dt and of the
    power of gravity M g . (u + w x r). No contact force is sampled, and the integrands are as smooth as the motion.

    lost_J is dissipated, or stored in springs: walls' and gravity's work less the gain of kinetic energy.
    """
    place, velocity, own, spin = (states[[f"{n}{axis}" for axis in "xyz"]].to_numpy() for n in ("x", "v", "l", "s"))
    momentum = mass * velocity
    angular = np.cross(place, momentum) + own + spin
    u, w, u_rate, w_rate = _rates(motion, time_s)
    held = (momentum * u + angular * w).sum(axis=1)
    weight = -mass * GRAVITY * UP
    power = (momentum * u_rate + angular * w_rate).sum(axis=1) + (u + np.cross(w, place)) @ weight
    gained = np.concatenate([[0.0], np.cumsum(np.diff(time_s) * (power[1:] + power[:-1]) / 2)])
    work, fallen = held - held[0] - gained, -mass * GRAVITY * (place[:, 2] - place[0, 2])
    kinetic = (states["translation_J"] + states["spin_J"]).to_numpy()
    return pd.DataFrame(
        {
            "time_s": time_s,
            "wall_work_J": work,
            "gravity_work_J": fallen,
            "kinetic_translation_J": states["translation_J"].to_numpy(),
            "kinetic_spin_J": states["spin_J"].to_numpy(),
            "kinetic_J": kinetic,
            "lost_J": work + fallen - (kinetic - kinetic[0]),
        }
    )


def read_text(path: Path) -> str:
    """The content of a file of a run; empty where LAMMPS has written none."""
    return path.read_text() if path.is_file() else ""
