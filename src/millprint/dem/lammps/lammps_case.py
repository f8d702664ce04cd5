"""One case by LAMMPS, from its description through what LAMMPS writes to its files."""

import ctypes
import hashlib
import json
import logging
import math
import os
import re
import shlex
import signal
import subprocess
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from millprint.config.contact_set import ContactConfig
from millprint.config.errors import SimulationError
from millprint.config.mill import MillConfig
from millprint.config.sweep import Case, DemConfig
from millprint.config.workflow import EngineConfig
from millprint.dem.lammps.cost import rank_step_s
from millprint.dem.lammps.input import (
    BALLS,
    CONTACT_NAMES,
    INPUT,
    LOG,
    RESTARTS,
    SNAPSHOT_NAMES,
    SNAPSHOTS,
    STATE_NAMES,
    STATES,
    TOUCHES,
    SampledDem,
    Schedule,
    data_text,
    input_text,
    tracks_contacts,
)
from millprint.dem.lammps.support import check_case, program
from millprint.dem.recording import settings_of
from millprint.dem.run import described, finite
from millprint.dem.simulation import Simulation
from millprint.dem.store import put, put_frame, put_geometry
from millprint.dem.turns import mean_of_turns, relative_error
from millprint.mill.gravity import GRAVITY
from millprint.mill.motion import Motion
from millprint.run.files import write_json
from millprint.run.hdf5 import whole_hdf5

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


logger = logging.getLogger("millprint")

# The folder of a run next to run.h5, and what tells a run that was stopped from one with other settings.
FOLDER, IDENTITY = "lammps", "identity"
# What a run of millprint's own kernel has and this one has not, for its summary.
ABSENT = (
    "power by channel (normal, tangential, rolling)",
    "closure of the energy balance",
    "collisions with walls",
    "energy of a collision",
    "occupancy",
    "mean height of the balls",
)


def environment(program: Path) -> dict[str, str]:
    """The environment of a program: with the libraries of its wheel, in a folder `lib` above it, if it has any."""
    folders = (above / "lib" for above in program.parents)
    libraries = next((folder for folder in folders if list(folder.glob("libmpi*.so*"))), None)
    known = {"LD_LIBRARY_PATH": str(libraries)} if libraries else {}
    return {**os.environ, **known, "OMP_NUM_THREADS": "1"}


def _end_with_parent() -> None:
    """On Linux: kill this process when the one that started it ends, even by kill -9; `mpirun` then ends its ranks."""
    if sys.platform == "linux":
        set_death_signal = 1
        ctypes.CDLL(None).prctl(set_death_signal, signal.SIGKILL)


def start(words: Sequence[str], place: Path, begin: Path | None, extra: Sequence[str] = ()) -> LammpsLog:
    """Run LAMMPS in the folder of its input. Raises SimulationError where it does not start, or fails.

    words: the command; begin: a restart file, in place of the packing.
    """
    further = ["-var", "begin", begin.name] if begin else []
    command = [*words, "-in", INPUT, "-log", LOG, "-screen", "none", *further, *extra]
    (place / LOG).unlink(missing_ok=True)
    first = next(Path(word) for word in words if "/" in word)
    done = subprocess.run(
        command,
        cwd=place,
        env=environment(first),
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        check=False,
        preexec_fn=_end_with_parent,
    )
    if not (place / LOG).is_file():
        lines = (done.stderr or done.stdout).strip().splitlines()
        raise SimulationError(f"LAMMPS does not start: {lines[-1] if lines else f'exit code {done.returncode}'}")
    return read_log((place / LOG).read_text())


def run_lammps(
    case: Case,
    mill: MillConfig,
    contact: ContactConfig,
    dem: EngineConfig,
    run_path: str | Path,
    summary_path: str | Path,
    launcher: str = "mpirun",
) -> dict:
    """Simulate a case by LAMMPS, write run.h5 and summary.json, and return the summary.

    launcher: the program that starts several ranks, with further words if it needs any. A run that was stopped goes on
    from its newest restart file. Raises ConfigError for a case that LAMMPS cannot simulate, and SimulationError where
    it fails; nothing is written then.
    """
    check_case(case, mill, contact)
    ranks = dem.lammps.ranks
    words = [program(dem.lammps, case.path), *shlex.split(dem.lammps.command)[1:]]
    if ranks > 1:
        words = [*shlex.split(launcher), "-n", str(ranks), *words]
    own = SampledDem(**{key: getattr(dem, key) for key in DemConfig.model_fields} | {"run_up_fraction": 0})
    simulation = Simulation(case, mill, contact, own)
    schedule = Schedule.of(simulation)
    every = max(1, math.ceil(dem.restart_interval_s / rank_step_s(simulation.count, ranks, mill)))
    text, data = input_text(simulation, every, ranks), data_text(simulation)
    place = Path(run_path).with_name(FOLDER)
    begins = _prepared(place, text, data)
    for begin in [*begins, None]:
        if begin is None:
            _forget(place)
        else:
            logger.info("going on from %s", begin.name)
        try:
            log = start(words, place, begin)
            break
        except SimulationError as error:
            # A restart file that was being written when the run was stopped cannot be read.
            if begin is None or "restart" not in str(error):
                raise
            logger.warning("%s: %s", begin.name, error)
    if log.balls != simulation.count:
        raise SimulationError(f"LAMMPS has lost {simulation.count - log.balls} balls")
    summary = _written(simulation, schedule, place, log, run_path)
    write_json(summary, summary_path)
    for name in (*RESTARTS, TOUCHES, SNAPSHOTS, BALLS):
        (place / name).unlink(missing_ok=True)
    return summary


def _prepared(place: Path, text: str, data: str) -> list[Path]:
    """Write the input; the restart files of the same run, the newest first."""
    place.mkdir(parents=True, exist_ok=True)
    # How often restart files are written, and by how many ranks, is nothing of the run itself.
    own = [line for line in text.splitlines() if not line.startswith(("restart ", "fix shared ", "comm_style "))]
    identity = hashlib.sha256("\n".join([*own, data]).encode()).hexdigest()
    known = read_text(place / IDENTITY) == identity
    (place / INPUT).write_text(text)
    (place / BALLS).write_text(data)
    (place / IDENTITY).write_text(identity)
    files = [place / name for name in RESTARTS if (place / name).is_file()]
    return sorted(files, key=lambda path: path.stat().st_mtime, reverse=True) if known else []


def _forget(place: Path) -> None:
    """Remove what an earlier run has left; LAMMPS appends to these files."""
    for name in (*RESTARTS, STATES, TOUCHES, SNAPSHOTS):
        (place / name).unlink(missing_ok=True)


def _written(simulation: Simulation, schedule: Schedule, place: Path, log: LammpsLog, run_path: str | Path) -> dict:
    """Write run.h5; the summary."""
    states = read_states(read_text(place / STATES), schedule.begin, schedule.end, schedule.states)
    time_s = (states["step"].to_numpy() - schedule.start) * simulation.step
    mass = simulation.count * float(simulation.balls.mass[0])
    series = ledger_of(states, simulation.motion, time_s, mass)
    contacts = None
    if tracks_contacts(simulation):
        contacts = read_contacts(read_text(place / TOUCHES), schedule.begin, simulation.step, simulation.radius)
        contacts["start_s"] += simulation.begin_s
    snapshots = None
    if schedule.snapshots:
        text = read_text(place / SNAPSHOTS)
        snapshots = read_snapshots(text, schedule.begin, schedule.end, schedule.snapshots)
    summary = summarise(simulation, series, contacts, log, schedule)
    write_run(run_path, simulation, schedule, series, contacts, snapshots, log.version)
    return summary


def summarise(
    simulation: Simulation, series: pd.DataFrame, contacts: pd.DataFrame | None, log: LammpsLog, schedule: Schedule
) -> dict:
    """The summary of a run in the columns of `dem.run`; `absent` names what LAMMPS does not give."""
    window, frequency = simulation.window_s, simulation.frequency_hz
    first, last = series.iloc[0], series.iloc[-1]
    samples = simulation.dem.ledger_samples_per_revolution
    turns = {name: np.diff(series[f"{name}_J"].to_numpy()[::samples]).tolist() if frequency else [] for name in
             ("wall_work", "lost")}  # fmt: skip
    known = mean_of_turns(turns["lost"])
    mass = simulation.count * float(simulation.balls.mass[0])
    steps = schedule.end
    balls = {}
    if contacts is not None:
        begun = contacts[contacts["start_s"] >= simulation.begin_s]
        balls = {
            "ball_contacts": {
                "count": len(begun),
                "frequency_hz": len(begun) / window,
                "median_duration_s": float(begun["duration_s"].median()) if len(begun) else None,
                "max_overlap_fraction": float(contacts["peak_overlap_m"].max() / simulation.radius)
                if len(contacts)
                else 0,
            }
        }
    return described(simulation) | {
        "engine": {"name": "LAMMPS", "version": log.version, "ranks": log.ranks},
        "absent": [*ABSENT, *([] if contacts is not None else ["contacts between balls: too many"])],
        "ledger_J": {
            "wall_work": float(last["wall_work_J"]),
            "gravity_work": float(last["gravity_work_J"]),
            "lost": float(last["lost_J"]),
            "kinetic_change": float(last["kinetic_J"] - first["kinetic_J"]),
        },
        # As in a run of ours, less what the balls stored of it; what the contacts store is not known.
        "power_W": {"wall": float(last["lost_J"]) / window},
        "power_standard_error_W": {"wall": known and known.error * frequency},
        "power_relative_error": {"wall": finite(relative_error(turns["lost"]))},
        "per_revolution": {"wall_J": turns["wall_work"], "lost_J": turns["lost"]},
        **balls,
        "rms_speed_m_s": math.sqrt(2 * float(series["kinetic_translation_J"].mean()) / mass),
        "wall_clock_s": log.loops_s,
        "processor_s": log.loops_s * log.ranks,
        "steps": steps,
        "ns_per_ball_step": log.loops_s * log.ranks / log.loops_steps / simulation.count * 1e9,
    }


def write_run(
    path: str | Path,
    simulation: Simulation,
    schedule: Schedule,
    series: pd.DataFrame,
    contacts: pd.DataFrame | None,
    snapshots: np.ndarray | None,
    version: str,
) -> None:
    """Write run.h5 in the groups of `dem.store`, as far as LAMMPS gives them."""
    with whole_hdf5(path) as file:
        file.attrs["config"] = json.dumps(settings_of(simulation), sort_keys=True)
        file.attrs["seed"] = simulation.case.seed
        file.attrs["versions"] = json.dumps({"LAMMPS": version})
        file.attrs["engine"] = "lammps"
        file.attrs["ball_radius_m"] = simulation.radius
        put(file.create_group("balls"), "radius_m", np.full(simulation.count, simulation.radius))
        put_geometry(file.create_group("geometry"), simulation.vessel)
        put_frame(file.create_group("ledger"), series)
        if contacts is not None:
            group = file.create_group("ball_contacts")
            group.attrs["begin_s"], group.attrs["window_s"] = simulation.begin_s, simulation.window_s
            put_frame(group, contacts, narrow=True)
        if snapshots is not None:
            group = file.create_group("snapshots")
            time_s = (
                schedule.begin - schedule.start + schedule.snapshots * np.arange(len(snapshots))
            ) * simulation.step
            put(group, "time_s", time_s)
            put(group, "body_position_m", simulation.motion.position(time_s))
            put(group, "body_rotation", simulation.motion.rotation(time_s))
            for number, name in enumerate(("position_m", "velocity_m_s", "spin_rad_s")):
                put(group, name, snapshots[:, :, 1 + 3 * number : 4 + 3 * number], narrow=True)
