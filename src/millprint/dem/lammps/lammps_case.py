"""One case by LAMMPS, from its description to its files."""

import ctypes
import hashlib
import json
import logging
import math
import os
import shlex
import signal
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from millprint.config.contact_set import ContactConfig
from millprint.config.dem_engine import EngineConfig
from millprint.config.errors import SimulationError
from millprint.config.mill import MillConfig
from millprint.config.sweep import Case, DemConfig
from millprint.dem.lammps.cost import rank_step_s
from millprint.dem.lammps.input import (
    BALLS,
    INPUT,
    LOG,
    RESTARTS,
    SNAPSHOTS,
    STATES,
    TOUCHES,
    SampledDem,
    Schedule,
    data_text,
    input_text,
    tracks_contacts,
)
from millprint.dem.lammps.output import (
    LammpsLog,
    ledger_of,
    read_contacts,
    read_log,
    read_snapshots,
    read_states,
    read_text,
)
from millprint.dem.lammps.support import check_case, program
from millprint.dem.simulation import Simulation
from millprint.dem.store import put, put_geometry
from millprint.dem.summary import described, finite
from millprint.dem.turns import mean_of_turns, relative_error
from millprint.run.files import write_json
from millprint.run.hdf5 import whole_hdf5

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
    simulation: Simulation,
    series: pd.DataFrame,
    contacts: pd.DataFrame | None,
    log: LammpsLog,
    schedule: Schedule,
) -> dict:
    """The summary of a run in the columns of `dem.summary`; `absent` names what LAMMPS does not give."""
    window, frequency = simulation.window_s, simulation.frequency_hz
    first, last = series.iloc[0], series.iloc[-1]
    samples = simulation.dem.ledger_samples_per_revolution
    turns = {name: np.diff(series[f"{name}_J"].to_numpy()[::samples]).tolist() if frequency else [] for name in
             ("wall_work", "lost")}  # fmt: skip
    known = mean_of_turns(turns["wall_work"])
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
        "power_W": {"wall": float(last["wall_work_J"]) / window, "lost": float(last["lost_J"]) / window},
        "power_standard_error_W": {"wall": known and known.error * frequency},
        "power_relative_error": {"wall": finite(relative_error(turns["wall_work"]))},
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
    config = {name: getattr(simulation, name).model_dump(mode="json") for name in ("case", "mill", "contact", "dem")}
    with whole_hdf5(path) as file:
        file.attrs["config"] = json.dumps(config, sort_keys=True)
        file.attrs["seed"] = simulation.case.seed
        file.attrs["versions"] = json.dumps({"LAMMPS": version})
        file.attrs["engine"] = "lammps"
        file.attrs["ball_radius_m"] = simulation.radius
        put(file.create_group("balls"), "radius_m", np.full(simulation.count, simulation.radius))
        put_geometry(file.create_group("geometry"), simulation.vessel)
        ledger = file.create_group("ledger")
        for name in series.columns:
            put(ledger, name, series[name].to_numpy())
        if contacts is not None:
            group = file.create_group("ball_contacts")
            group.attrs["begin_s"], group.attrs["window_s"] = simulation.begin_s, simulation.window_s
            for name in contacts.columns:
                put(group, name, contacts[name].to_numpy(), narrow=True)
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
