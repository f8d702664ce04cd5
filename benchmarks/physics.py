"""Means of the same motion from both codes: an independent check of the physics, in a box that both express exactly.

Trajectories of two codes part within tenths of a second, so only means can agree. Each code runs from the same starts,
which are independent of each other: the intervals of the means are Student's over the starts.
"""

import math
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pandas as pd

from benchmarks.cases import SAMPLES, Setup, box_jar, make_setup, settle
from benchmarks.config import BenchConfig, PhysicsConfig, PhysicsLaw
from benchmarks.lammps import MEANS, Lammps
from millprint.config.contact_set import ContactConfig
from millprint.config.mill import MillConfig
from millprint.dem.run import run_case
from millprint.estimate.quantiles import student_exceeded
from millprint.run.files import read_json
from millprint.run.hdf5 import open_hdf5
from millprint.run.job import progress

# Columns of results/bench/physics.tsv. Quantities are MEANS, with their unit in the name; contacts are those of a ball.
# NAME_95 is the half-width of the 95 % interval of NAME, in its unit; empty with fewer than FEWEST_RUNS runs.
PHYSICS_COLUMNS = (
    "law",
    "quantity",
    "millprint",
    "millprint_95",
    "lammps",
    "lammps_95",
    "difference_pct",
    "difference_pct_95",
    "runs",
    "differs",
)
# With fewer, Student's intervals are so wide that they say nothing.
FEWEST_RUNS = 4


def our_means(setup: Setup, physics: PhysicsConfig, seed: int, place: Path) -> dict[str, float]:
    """The means of MEANS from a run of millprint, written to the folder `place`."""
    times = {"settle_s": setup.settle_s, "discard_s": physics.discard_s, "window_s": physics.window_s}
    revolution = 60 / setup.speed_rpm
    case = setup.case(seed, **times, snapshot_interval_s=revolution / SAMPLES)
    run_case(case, setup.mill, setup.contact, setup.settings(), place / "run.h5", place / "summary.json")
    return read_means(place / "run.h5", place / "summary.json", setup)


def read_means(run: Path, summary: Path, setup: Setup) -> dict[str, float]:
    """The means of MEANS from the files of a run with snapshots; the last, a revolution's first, is left out."""
    with open_hdf5(run) as file:
        ledger = {name: file["ledger"][name][:-1] for name in ("kinetic_translation_J", "kinetic_spin_J")}
        snapshots = file["snapshots"]
        time_s, velocity = snapshots["time_s"][:-1], snapshots["velocity_m_s"][:-1]
        contacts = snapshots["contact_second"][: snapshots["contact_offset"][len(time_s)]]
    counted = read_json(summary)
    w = setup.angular_frequency
    direction = np.stack([np.cos(w * time_s), np.sin(w * time_s)], axis=1)
    along = (velocity[:, :, :2].sum(axis=1) * direction).sum(axis=1).mean()
    per_ball = 1 / (len(time_s) * setup.balls)
    return {
        "kinetic_translation_J": float(ledger["kinetic_translation_J"].mean()),
        "kinetic_spin_J": float(ledger["kinetic_spin_J"].mean()),
        "wall_power_W": counted["power_W"]["wall"],
        "identity_power_W": float(counted["ball_mass_kg"] * setup.amplitude_m * w**2 * along),
        "ball_contacts": float(2 * per_ball * (contacts >= 0).sum()),
        "wall_contacts": float(per_ball * (contacts < 0).sum()),
    }


def driven_steps(setup: Setup, physics: PhysicsConfig) -> tuple[list[int], float]:
    """Steps to discard and to average over, whole revolutions of each, and the step [s]."""
    times = {"discard_s": physics.discard_s, "window_s": physics.window_s}
    simulation = setup.simulation(setup.case(0, settle_s=setup.settle_s, **times))
    revolution = SAMPLES * simulation.sample_every
    return [math.ceil(length * setup.speed_rpm / 60) * revolution for length in times.values()], simulation.step


def half_width(errors: Sequence[float], runs: int) -> float:
    """Half-width of the 95 % interval of a mean, or of a difference of means by Welch, in the unit of the errors.

    errors: the standard error of each independent mean, of `runs` runs each; the degrees of freedom are
    (sum e_i^2)^2 / sum (e_i^4 / (runs - 1)). NaN with fewer than FEWEST_RUNS runs.
    """
    if runs < FEWEST_RUNS:
        return math.nan
    squares = np.square(errors)
    freedom = (runs - 1) * squares.sum() ** 2 / np.square(squares).sum() if squares.any() else runs - 1
    return float(student_exceeded(0.025, freedom) * math.sqrt(squares.sum()))


def compare_law(law: PhysicsLaw, ours: pd.DataFrame, theirs: pd.DataFrame) -> pd.DataFrame:
    """Rows of PHYSICS_COLUMNS for one law, from the means (runs, quantities) of either code."""
    rows = []
    for name in MEANS:
        a, b, runs = ours[name], theirs[name], len(ours)
        ratio = b.mean() / a.mean()
        values = (
            law.name, name, a.mean(), half_width([a.sem()], runs), b.mean(), half_width([b.sem()], runs),
            100 * (ratio - 1), 100 * half_width([b.sem() / a.mean(), ratio * a.sem() / a.mean()], runs),
            runs, law.differs,
        )  # fmt: skip
        rows.append(dict(zip(PHYSICS_COLUMNS, values, strict=True)))
    return pd.DataFrame(rows)


def compare_physics(
    config: BenchConfig, mill: MillConfig, contact: ContactConfig, lammps: Lammps, place: Path, cores: int
) -> pd.DataFrame:
    """Means of both codes under every law; LAMMPS runs on `cores` cores, and millprint at the same time."""
    physics, jar = config.physics, box_jar(config, mill)
    seeds = range(physics.seeds)
    tables = []
    with ThreadPoolExecutor(cores) as pool, progress(len(physics.laws) * physics.seeds, "physics", "run") as bar:
        waiting = []
        for law in physics.laws:
            setup = make_setup(config, law.contact(contact), jar, physics.balls, physics.ball_diameter_mm)
            runs, step_s = driven_steps(setup, physics)
            starts = [settle(setup, seed) for seed in seeds]
            folders = [place / f"{law.name}_lammps_{seed}" for seed in seeds]
            theirs = [pool.submit(lammps.means, folders[k], setup, starts[k], runs, step_s) for k in seeds]
            waiting.append((law, setup, theirs))
        for law, setup, futures in waiting:
            ours = [our_means(setup, physics, seed, place / f"{law.name}_millprint_{seed}") for seed in seeds]
            measured = []
            for future in futures:
                measured.append(future.result())
                bar.update(1)
            tables.append(compare_law(law, pd.DataFrame(ours), pd.DataFrame(measured)))
    return pd.concat(tables, ignore_index=True)


def physics_text(table: pd.DataFrame) -> str:
    """The means of both codes for each law with their 95 % intervals, and the remaining differences of the laws."""

    def shown(rows: pd.DataFrame, name: str, form: str) -> list[str]:
        pairs = zip(rows[name], rows[f"{name}_95"], strict=True)
        return [f"{value:{form}}" + ("" if pd.isna(half) else f" +- {half:.2g}") for value, half in pairs]

    parts = []
    for (law, differs), rows in table.groupby(["law", "differs"], sort=False):
        columns = {
            "quantity": rows["quantity"],
            "millprint": shown(rows, "millprint", ".4g"),
            "LAMMPS": shown(rows, "lammps", ".4g"),
            "difference %": shown(rows, "difference_pct", "+.1f"),
        }
        runs = rows["runs"].iloc[0]
        what = "95 % intervals" if rows["difference_pct_95"].notna().all() else "too few for an interval"
        parts.append(
            f"law {law}: differs {differs}; {runs} runs, {what}\n{pd.DataFrame(columns).to_string(index=False)}"
        )
    return "\n\n".join(parts)
