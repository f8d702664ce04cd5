"""Power of a drum with lifters from LAMMPS, compared with ours: `make bench DRUMS=1`.

LAMMPS has the shell as a cylinder and each square lifter as a block, all turning (`fix wall/gran/region`), and the
contact law that means are compared with (`lammps.compared`). The shell is round in both.

Power of the walls: all of them turn about the y axis with w, so that it is w times their torque. Over whole turns the
balls' angular momentum does not change, so that the torque is the one against gravity, and the mean power is
-w M g <x>, of the mass M of the balls and the mean x of their centre of mass.
"""

import math
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import ClassVar

import numpy as np
import pandas as pd

from benchmarks.config import BenchConfig, TumblingConfig
from benchmarks.lammps import MEANS_FILE, SAMPLE_EVERY, Lammps, law_text, pair_lines
from millprint.config.contact_set import ContactConfig
from millprint.config.errors import ConfigError
from millprint.config.mill import LifterDrumGeometry, MillConfig
from millprint.config.motion_kinds import RotationMotion
from millprint.config.sweep import Case, DemConfig, RunUp
from millprint.dem.lammps.input import balls_text, head_lines
from millprint.dem.run import run_case
from millprint.dem.simulation import Simulation
from millprint.run.job import progress

# Steps of a row of the file of means.
ROW = 10 * SAMPLE_EVERY

# Largest balance error of our runs [-]: steps are as long as users of LAMMPS take them.
CLOSURE_MAX = 0.03

# Columns of results/bench/drums.tsv, as in config/data/other_codes.tsv; `power_W` is that of the other code.
POWER_COLUMNS = (
    *("mill", "contact", "code", "speed_rpm", "balls", "power_W", "se_W", "millprint_W", "millprint_se_W"),
    *("difference_pct", "runs", "time_step_s", "version"),
)


class DrumDem(DemConfig):
    """Settings of a drum: a turn is a multiple of ROW steps, of one length, as in LAMMPS."""

    run_up_fraction: RunUp = 0

    ledger_samples_per_revolution: ClassVar[int] = ROW


def check_drum(mill: MillConfig) -> LifterDrumGeometry:
    """The drum of a mill that LAMMPS can express; raises ConfigError for any other."""
    shape, motion = mill.geometry, mill.motion
    if (
        not isinstance(shape, LifterDrumGeometry)
        or not isinstance(motion, RotationMotion)
        or mill.inserts
        or shape.axis != "y"
        or tuple(motion.axis) != (0, 1, 0)
        or shape.lifters.face_angle_deg != 90
        or shape.smooth_ends
    ):
        raise ConfigError(
            f"config/mills/{mill.name}.yaml: the bench needs a lifter_drum with square lifters and turning ends, with "
            "its axis and its rotation along y, and no inserts"
        )
    return shape


def case_of(mill: MillConfig, contact: ContactConfig, settings: TumblingConfig, speed_rpm: float, seed: int) -> Case:
    """The case of millprint at one speed, from one start."""
    turn_s = 60 / speed_rpm
    return Case(
        mill=mill.name, contact=contact.name, ball_diameter_m=settings.ball_diameter_mm / 1e3,
        fill_ratio=settings.fill_ratio, speed_hz=speed_rpm / 60, seed=seed,
        rayleigh_fraction=settings.rayleigh_fraction, settle_s=settings.settle_s,
        discard_s=settings.discard_turns * turn_s, window_s=settings.window_turns * turn_s,
    )  # fmt: skip


def data_text(simulation: Simulation, shape: LifterDrumGeometry) -> str:
    """LAMMPS's data file: the packed balls of our simulation, in a domain around the drum."""
    reach, half = shape.radius_mm / 1e3 + simulation.diameter, shape.length_mm / 1e3
    size = [reach, half, reach]
    density = simulation.contact.density_kg_m3
    return balls_text([-end for end in size], size, simulation.balls.position, simulation.diameter, density)


def input_text(simulation: Simulation, shape: LifterDrumGeometry, bench: BenchConfig, settings: TumblingConfig) -> str:
    """LAMMPS's input: balls settle in the drum at rest, which then turns; the power of each turn of the window."""
    radius = simulation.radius
    law = bench.lammps.compared
    pair = law_text(simulation.contact, radius, law, 2.0)
    wall = law_text(simulation.contact.at_wall, radius, law, 1.0)
    inner, half, lifters = shape.radius_mm / 1e3, shape.length_mm / 2e3, shape.lifters
    height, width = lifters.height_mm / 1e3, lifters.width_mm / 2e3
    settle, discard, window = steps_of(simulation, settings)
    lines = [
        *head_lines(pair_lines(pair), bench.lammps.skin_m, simulation.step),
        f"variable w equal {2 * math.pi * simulation.frequency_hz!r}",
        f"variable turned equal v_w*dt*(step>{settle})*(step-{settle})",
        "fix gravity all gravity 9.81 vector 0 0 -1",
        "fix motion all nve/sphere",
        f"region shell cylinder y 0 0 {inner!r} {-half!r} {half!r} side in rotate v_turned 0 0 0 0 1 0 units box",
        f"fix shell all wall/gran/region granular {wall} region shell",
    ]
    for number in range(lifters.number):
        # Each block reaches through the shell and the ends, where no ball is.
        lines += [
            f"variable angle{number} equal v_turned+{2 * math.pi * number / lifters.number!r}",
            f"region lifter{number} block {-width!r} {width!r} {-2 * half!r} {2 * half!r} {inner - height!r} "
            f"{inner + height!r} side out rotate v_angle{number} 0 0 0 0 1 0 units box",
            f"fix lifter{number} all wall/gran/region granular {wall} region lifter{number}",
        ]
    return "\n".join(
        [
            *lines,
            "thermo_style custom step cpu",
            f"thermo {window}",
            f"run {settle}",
            f"run {discard}",
            "variable power equal -v_w*mass(all)*9.81*xcm(all,x)",
            f"fix means all ave/time {SAMPLE_EVERY} {ROW // SAMPLE_EVERY} {ROW} v_power file {MEANS_FILE}",
            f"run {window}\n",
        ]
    )


def steps_of(simulation: Simulation, settings: TumblingConfig) -> tuple[int, int, int]:
    """Steps to settle, to discard and to average over: multiples of ROW, the last two of whole turns as well."""
    turn = simulation.sample_every * simulation.dem.ledger_samples_per_revolution
    settle = math.ceil(simulation.settle_steps / ROW) * ROW
    return settle, settings.discard_turns * turn, settings.window_turns * turn


def lammps_power(
    lammps: Lammps, place: Path, simulation: Simulation, bench: BenchConfig, settings: TumblingConfig
) -> tuple[float, str]:
    """Mean power [W] from LAMMPS over the window, from the packing of our simulation, and its version."""
    shape = check_drum(simulation.mill)
    log = lammps.run(place, input_text(simulation, shape, bench, settings), data_text(simulation, shape))
    if log.balls != simulation.count:
        raise ConfigError(f"{place}: LAMMPS has lost {simulation.count - log.balls} balls")
    return float(np.loadtxt(place / MEANS_FILE)[:, 1].mean()), log.version


def compare_power(
    bench: BenchConfig,
    settings: TumblingConfig,
    mill: MillConfig,
    contact: ContactConfig,
    lammps: Lammps,
    place: Path,
    cores: int,
) -> pd.DataFrame:
    """Rows of POWER_COLUMNS, one for each speed, with standard errors over the starts. LAMMPS runs on `cores` cores."""
    check_drum(mill)
    dem = DrumDem(closure_max=CLOSURE_MAX)
    wanted = [(speed, seed) for speed in settings.speeds_rpm for seed in range(settings.seeds)]
    cases = [case_of(mill, contact, settings, speed, seed) for speed, seed in wanted]
    simulations = [Simulation(case, mill, contact, dem) for case in cases]
    with ThreadPoolExecutor(cores) as pool, progress(len(cases), f"power of {mill.name}", "run") as bar:
        folders = [place / f"{case.name}_lammps" for case in cases]
        theirs = [
            pool.submit(lammps_power, lammps, folder, simulation, bench, settings)
            for folder, simulation in zip(folders, simulations, strict=True)
        ]
        rows = []
        for case, simulation, future in zip(cases, simulations, theirs, strict=True):
            folder = place / case.name
            ours = run_case(case, mill, contact, dem, folder / "run.h5", folder / "summary.json")
            power, version = future.result()
            rows.append(
                (60 * case.speed_hz, simulation.count, ours["power_W"]["wall"], power, simulation.step, version)
            )
            bar.update(1)
    return tabulate_power(rows, mill.name, contact.name)


def tabulate_power(rows: list[tuple[float, int, float, float, float, str]], mill: str, contact: str) -> pd.DataFrame:
    """Rows of POWER_COLUMNS from runs (speed, balls, our power, theirs, step, version), in the order of the speeds."""
    runs = pd.DataFrame(rows, columns=["speed_rpm", "balls", "ours", "theirs", "step", "version"])
    table = []
    for speed, group in runs.groupby("speed_rpm"):
        ours, theirs = group["ours"], group["theirs"]
        values = (
            *(mill, contact, "LAMMPS", speed, group["balls"].iloc[0]),
            *(theirs.mean(), theirs.sem(), ours.mean(), ours.sem()),
            100 * (theirs.mean() / ours.mean() - 1), len(group), group["step"].iloc[0], group["version"].iloc[0],
        )  # fmt: skip
        table.append(dict(zip(POWER_COLUMNS, values, strict=True)))
    return pd.DataFrame(table)
