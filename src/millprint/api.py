"""Fingerprints from Python, without Snakemake: a mill, its simulations, its fingerprint, and a comparison of mills.

    import millprint

    mill = millprint.load_mill("planetary")
    fingerprint = millprint.take_fingerprint(mill, folder="my_planetary")
    condition = fingerprint.condition(speed_hz=400 / 60, ball_diameter_m=0.010, fill_ratio=0.2)
    fingerprint.predict(condition).wall_power_W

Lengths, energies and powers are in m, J and W; rpm, mm and mL where a name says so. Faults of the input raise
`ConfigError`, with a line for each.
"""

import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from millprint.card.experiment_checks import check_cases
from millprint.cases.of_mill import mill_cases, sweep_of
from millprint.cases.simulate import simulate_cases
from millprint.cases.table import own_cases
from millprint.config.card import Experiment
from millprint.config.checks import with_own_fills
from millprint.config.contact_set import ContactConfig
from millprint.config.errors import ConfigError
from millprint.config.included import SOURCES, load_contact, load_mill
from millprint.config.load import check_model
from millprint.config.mill import MillConfig
from millprint.config.mill_sweep import MillSweepConfig
from millprint.config.sweep import Case, overridden
from millprint.config.wording import close_to
from millprint.config.workflow import WorkflowConfig
from millprint.dem.compilation import compile_kernels
from millprint.fingerprint.descriptors import tabulate_descriptors
from millprint.fingerprint.model import Fingerprint
from millprint.fingerprint.predicted_values import COLUMNS, Prediction, conditions_of
from millprint.fingerprint.readers import charges_of, find_fingerprint, read_summaries
from millprint.observables.condition import Condition
from millprint.observables.definitions import CURVES, DESCRIPTORS
from millprint.run.files import write_table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# What a plot of a fingerprint shows, and the points of a curve.
PLOTTED, POINTS = ("Pn", "Pt", "En_star", "Et_star"), 50
EXAMPLE = '{"speed_rpm": 400, "ball_diameter_mm": 10, "fill_ratio": 0.2}'
# The conditions of a mill: its sweep, or the keys of a sweep.
Sweep = MillSweepConfig | Mapping[str, Any]


def take_fingerprint(
    mill: MillConfig | str,
    contact: ContactConfig | str | None = None,
    *,
    folder: str | Path,
    sweep: Sweep | None = None,
    cores: int = 1,
) -> Fingerprint:
    """The fingerprint of a mill: simulates its sweep and fits its curves, as the workflow's target `fingerprint` does.

    contact: the contact set of balls and walls, "calibrated" if left out. sweep: speeds, balls, fill ratios and seeds
    in place of the mill's own (keys as in its file). cores: simulations at a time; a script that asks for several must
    begin with `if __name__ == "__main__":`, because each runs in a separate process.
    `folder` keeps the simulations (run.h5, summary.json), descriptors.tsv and fingerprint.json. A stopped call can be
    repeated and continues there; once everything is simulated, a call only fits the curves.
    Raises ConfigError, a line for each fault of the input, and SimulationError for a simulation that fails.
    """
    mill, contact, settings = _given(mill, contact)
    if sweep is not None:
        mill = mill.model_copy(update={"sweep": _checked(sweep)})
    mill = with_own_fills(mill, contact.density_kg_m3, "sweep")
    mill = mill.model_copy(update={"sweep": sweep_of(mill)})
    folder = Path(folder)
    cases = mill_cases(mill, settings.mills.model_copy(update={"contact": contact.name}))
    summaries = _simulated(cases, mill, contact, folder, cores)
    rule = settings.fingerprint
    descriptors = tabulate_descriptors(summaries, rule.counting_rule)
    fingerprint = Fingerprint.fit(descriptors, mill.volume_ml * 1e-6, rule.interval, charges_of(summaries))
    write_table(descriptors, folder / "descriptors.tsv")
    fingerprint.write(folder / "fingerprint.json")
    return fingerprint


def simulate(
    mill: MillConfig | str,
    contact: ContactConfig | str | None = None,
    *,
    folder: str | Path,
    cores: int = 1,
    **condition: Any,
) -> pd.Series:
    """The descriptors of one condition, the mean over its seeds; workflow/descriptors.md explains each.

    condition: keys of an experiment (config/keys.md), such as `speed_rpm=400` or `speed_hz=17.5`,
    `balls={"diameter_mm": 10, "fill_ratio": 0.2}` and `seeds=[0, 1, 2]`. The rest as of `take_fingerprint`.
    """
    mill, contact, settings = _given(mill, contact)
    content = {"name": "condition", "mill": mill.name, "contact": contact.name, **condition}
    experiment = check_model(content, Experiment, "simulate")
    cases = own_cases(experiment, mill, contact, settings.mills, "simulate")
    summaries = _simulated(cases, mill, contact, Path(folder), cores)
    return tabulate_descriptors(summaries, settings.fingerprint.counting_rule).iloc[0]


def read_fingerprint(path: str | Path) -> Fingerprint:
    """Read a stored fingerprint: a fingerprint.json, or that of an included mill by its name, such as "planetary"."""
    return Fingerprint.read(find_fingerprint(str(path), sources=SOURCES))


def predict(
    fingerprint: Fingerprint | str | Path, conditions: pd.DataFrame | Mapping[str, float] | pd.Series
) -> pd.DataFrame | Prediction:
    """What a fingerprint predicts: of a table of conditions a table, of one condition a `Prediction`.

    fingerprint: or its file, or the name of an included mill. conditions: columns or keys as a sweep has them, such as
    `speed_rpm`, `ball_diameter_mm`, and `fill_ratio`, `number` or `mass_g`; a row of such a table is one condition.
    Raises ConfigError, in one line.
    """
    known = _read(fingerprint)
    if isinstance(conditions, pd.DataFrame):
        return known.predict(conditions)
    if not isinstance(conditions, Mapping | pd.Series):
        raise ConfigError(f"conditions = {conditions!r}: must be a table, or a mapping such as {EXAMPLE}")
    for name in set(conditions.keys()) - set(COLUMNS):
        raise ConfigError(f"conditions: {name} is none of them{close_to(str(name), COLUMNS)}")
    (row,) = conditions_of(pd.DataFrame([dict(conditions)]), known.about).rows().tolist()
    return known.predict(Condition(*row))


def plot(fingerprint: Fingerprint | str | Path, quantities: Sequence[str] = PLOTTED) -> "Figure":
    """The master curves of scaled quantities over the fill ratio, each with the band of a new simulation.

    fingerprint: or its file, or the name of an included mill. quantities: such as "Pn" and "Pt", the normal and
    tangential power of a ball. Raises ConfigError, in one line, for one that is unknown.
    """
    from matplotlib import pyplot as plt

    for name in quantities:
        if name not in CURVES:
            raise ConfigError(f"quantities: {name} is none of them{close_to(name, CURVES)}")
    known = _read(fingerprint)
    curve = known.curve(np.linspace(*known.fill_range, POINTS))
    figure, axes = plt.subplots(
        1, len(quantities), figsize=(3.2 * len(quantities), 2.8), squeeze=False, layout="constrained"
    )
    for axis, quantity in zip(axes[0], quantities, strict=True):
        axis.fill_between(curve["fill_ratio"], curve[f"{quantity}_lower"], curve[f"{quantity}_upper"], alpha=0.2)
        axis.plot(curve["fill_ratio"], curve[quantity])
        axis.set(xlabel="fill ratio [-]", ylabel=DESCRIPTORS[quantity].label, ylim=(0, None))
    return figure


def _read(fingerprint: Fingerprint | str | Path) -> Fingerprint:
    return fingerprint if isinstance(fingerprint, Fingerprint) else read_fingerprint(fingerprint)


def _given(
    mill: MillConfig | str, contact: ContactConfig | str | None
) -> tuple[MillConfig, ContactConfig, WorkflowConfig]:
    """Mill, contact set and settings with every default."""
    mill = load_mill(mill) if isinstance(mill, str) else mill
    settings = WorkflowConfig(mill=mill.name)
    contact = settings.mills.contact_set if contact is None else contact
    return mill, load_contact(contact) if isinstance(contact, str) else contact, settings


def _checked(sweep: Sweep) -> MillSweepConfig:
    return sweep if isinstance(sweep, MillSweepConfig) else check_model(dict(sweep), MillSweepConfig, "sweep")


def _simulated(cases: list[Case], mill: MillConfig, contact: ContactConfig, folder: Path, cores: int) -> list[dict]:
    """The summaries of cases, simulated into FOLDER/runs unless they are there."""
    if cores < 1:
        raise ConfigError(f"cores = {cores}: must be 1 or more")
    settings = WorkflowConfig(mill=mill.name)
    changed = overridden(cases[0], mill, contact)[1]
    warnings, _ = check_cases(cases, mill, changed, settings, f"mill {mill.name}")
    for line in warnings:
        print(f"warning: {line}", file=sys.stderr)
    compile_kernels(cores)
    runs = {case.name: case for case in cases}
    simulate_cases(runs, mill, contact, settings.dem, folder / "runs", cores)
    return read_summaries(folder / "runs" / name / "summary.json" for name in runs)
