"""Timings of both codes, interleaved: each repetition runs every code of a case once, so that all see the same machine.

The measure is the same for both: wall time of the loop over the steps, set-up, compilation and output left out.
"""

import logging
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from millprint.bench.cases import (
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
from millprint.bench.lammps import Lammps
from millprint.config.bench import BenchCase, BenchConfig
from millprint.config.contact import ContactConfig
from millprint.config.mill import MillConfig
from millprint.job import progress

logger = logging.getLogger("millprint")

OURS, LAMMPS = "millprint", "LAMMPS"

# Columns of results/bench/dem.tsv.
COLUMNS = ("case", "balls", "code", "wall", "steps_per_s", "ns_per_ball_step", "ratio_to_us")

# Rough cost of a ball's step [ns], for the time to go alone.
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
        """What the wall is in this code."""
        return f"facets ({len(self.setup.jar.vessel.facets)})" if self.code == OURS else "moving region"

    @property
    def cost(self) -> float:
        """Seconds that a repetition may take."""
        return self.steps * self.setup.balls * ASSUMED_NS[self.code] * 1e-9

    def time(self, lammps: Lammps, place: Path) -> Timing:
        """Run it once."""
        if self.code == OURS:
            return time_millprint(self.setup, self.start, self.driven_s)
        log = lammps.time(place / self.setup.name, self.setup, self.start, self.steps, self.step_s)
        return log.timing()


def entries_of(config: BenchConfig, contact: ContactConfig, case: BenchCase, jars: list[Jar]) -> list[Entry]:
    """Every code on every jar of a case; LAMMPS only where it can express the jar. Settles the balls first."""
    made = []
    for jar in jars:
        setup = make_setup(config, contact, jar, case.balls, case.ball_diameter_mm)
        start = settle(setup, seed=0)
        simulation = start_from(setup, start, case.driven_s)
        steps = count_steps(simulation)
        codes = [OURS, LAMMPS] if jar.region else [OURS]
        made += [Entry(setup, code, start, case.driven_s, steps, simulation.step) for code in codes]
    return made


def time_case(entries: list[Entry], repetitions: int, lammps: Lammps, place: Path, bar) -> pd.DataFrame:
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
                }
            )
            logger.info(
                "%s, %s, repetition %d: %.1f ns a ball-step",
                entry.setup.name, entry.code, repetition + 1, timing.ns_per_ball_step,
            )  # fmt: skip
            bar.update(entry.cost)
    return pd.DataFrame(rows)


def time_all(config: BenchConfig, mill: MillConfig, contact: ContactConfig, lammps: Lammps, place: Path):
    """Repetitions of every case of the bench, as one frame."""
    jars = [emax_jar(mill), cylinder_jar(config, mill)]
    cases = [entries_of(config, contact, case, jars) for case in config.cases]
    total = config.repetitions * sum(entry.cost for entries in cases for entry in entries)
    with progress(total, "timings", "s", bar_format="{desc}: {percentage:3.0f}%|{bar}| [{elapsed}<{remaining}]") as bar:
        frames = [time_case(entries, config.repetitions, lammps, place, bar) for entries in cases]
    return pd.concat(frames, ignore_index=True)


def summarise(repetitions: pd.DataFrame) -> pd.DataFrame:
    """Medians over the repetitions, a row for each code and case, in COLUMNS.

    ratio_to_us: ns a ball-step of the code over that of millprint on the same case (same jar, same start).
    """
    keys = ["case", "balls", "code", "wall"]
    medians = repetitions.groupby(keys, sort=False)["ns_per_ball_step"].median().reset_index()
    medians["steps_per_s"] = 1e9 / (medians["ns_per_ball_step"] * medians["balls"])
    ours = medians[medians["code"] == OURS].set_index("case")["ns_per_ball_step"]
    medians["ratio_to_us"] = medians["ns_per_ball_step"] / medians["case"].map(ours)
    return medians[list(COLUMNS)]


def spread(repetitions: pd.DataFrame) -> pd.DataFrame:
    """Least and largest ns a ball-step of each code and case, and the median of processor time in its place.

    Processor time well below wall time says that something else ran on the machine and that wall times are too long.
    """
    processor = repetitions["ns_per_ball_step"] * repetitions["processor_s"] / repetitions["wall_s"]
    groups = repetitions.assign(processor_ns=processor).groupby(["case", "code"], sort=False)
    columns = {"least_ns": ("ns_per_ball_step", "min"), "largest_ns": ("ns_per_ball_step", "max")}
    return groups.agg(**columns, processor_ns=("processor_ns", "median")).reset_index()
