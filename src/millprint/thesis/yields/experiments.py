"""Experiments that can be done on a mill: their settings and descriptors, what the jar holds, and the table of them.

The tables of the yield stage: screening runs, their split, and runs of other groups and mills.
"""

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
import pandas as pd
from scipy.constants import bar, gas_constant

from millprint.config.doe import ChemistryConfig, DoeConfig, Factor
from millprint.config.errors import ConfigError
from millprint.config.rows import read_cells
from millprint.config.sweep import ball_count
from millprint.config.yields import OtherSourcesConfig, RegionConfig, YieldConfig
from millprint.fingerprint.predicted_values import conditions_of
from millprint.observables.condition import Condition
from millprint.observables.definitions import BASIC, descriptors_of, scaled_quantities
from millprint.run.tables import CASE, Number, Text, read_measured, refuse_copies, refuse_rows, refuse_shares
from millprint.thesis.doe.chemistry import hydrogen_released, molar_mass, reactant_masses
from millprint.thesis.doe.factorial_designs import PERCENT_YIELD, YIELD, read_runs
from millprint.thesis.yields.features import CHEMICAL, CONDITIONS, FREQUENCY, NORMAL, TANGENTIAL

ROLES = ("train", "test")


def read_split(path: str) -> pd.DataFrame:
    """Read the locked split: columns case (text) and role (train or test), in the order in which models see the rows.

    Raises ConfigError, in one line, for a missing column, a case that appears twice, another role, or an empty part.
    """
    split = read_measured(path, [Text("case", unique=True), Text("role", choices=ROLES)])
    for role in ROLES:
        if (split["role"] == role).sum() < 2:
            raise ConfigError(f"{path}: column role: at least two cases must have the role {role}")
    return split


def read_parts(screening: str, split: str, factors: Sequence[Factor]) -> tuple[pd.DataFrame, pd.DataFrame]:
    """The training rows and the test rows of the screening table, each in the order of the split.

    Columns: case, the six conditions, yield_percent. Raises ConfigError, in one line, for a table that read_runs
    refuses, a run without a role and a role without a run.
    """
    runs = read_runs(screening, factors, positive=list(CONDITIONS)).set_index("case")
    roles = read_split(split).set_index("case")["role"]
    for case in runs.index.difference(roles.index):
        raise ConfigError(f"{split}: column case: case {case} of {screening} has no role; must be train or test")
    for case in roles.index.difference(runs.index):
        raise ConfigError(f"{split}: column case = {case}: there is no such case in {screening}")
    rows = runs.loc[roles.index, [*CONDITIONS, YIELD]].reset_index()
    train, test = ((roles == role).to_numpy() for role in ROLES)
    return rows[train].reset_index(drop=True), rows[test].reset_index(drop=True)


def read_rows(path: str, yields: bool = True, asked: bool = False) -> pd.DataFrame:
    """Read case (text), the six conditions, and yield_percent unless `yields` is false.

    asked: whether yields of which none is above 1 are refused; not for a part of the runs, which the program wrote.

    Raises ConfigError, in one line, as `read_measured`: for no rows, a case that is missing or appears twice, a
    condition that is not above 0 and a yield outside 0 to 100.
    """
    columns = [Number(name, 0, above=True) for name in CONDITIONS]
    columns += [replace(PERCENT_YIELD, asked=asked)] if yields else []
    return read_measured(path, [Text("case", unique=True), *columns])


def check_yield_tables(settings: YieldConfig, screening: str, split: str, design: DoeConfig, source: str) -> None:
    """Raise ConfigError, in one line, for the first setting or table entry with which a job would fail."""
    train, test = read_parts(screening, split, design.factors)
    read_rows(settings.out_of_domain, asked=True)
    runs = len(train) + len(test)
    evaluation = settings.evaluation
    smallest = min(len(train), runs - int(np.ceil(runs / evaluation.outer_folds)))
    limits = {
        "search.folds": (settings.search.folds, len(train), "the rows to train on"),
        "evaluation.outer_folds": (evaluation.outer_folds, runs, "the runs"),
        "evaluation.folds": (evaluation.folds, smallest, "the rows that an outer fold trains on"),
        "evaluation.conformal_folds": (evaluation.conformal_folds, smallest, "the rows that an outer fold trains on"),
    }
    for key, (value, limit, rows) in limits.items():
        if value > limit:
            raise ConfigError(f"{source}: yields.{key} = {value}: at most {limit}, {rows}")
    read_rows(settings.prediction.conditions, yields=False)


SOURCE, GIVEN = "source", "given"
ENERGIES = (NORMAL, TANGENTIAL, FREQUENCY)
# Bounds of the columns: a value outside has another unit. Collisions of ball mills have from some nanojoules (beads
# of a millimetre) to some joules (large balls in a planetary mill).
BOUNDS = {
    "bpr": (0, 1000),
    "molar_ratio": (0, 1000),
    "time_h": (0, 1000),
    NORMAL: (1e-3, 1e7),
    TANGENTIAL: (1e-3, 1e7),
    FREQUENCY: (0.1, 1e5),
}
# What a fingerprint needs, as columns: the variable of a condition, and the factor from the column to its unit.
MILL_COLUMNS = {
    "fill_ratio": ("fill_ratio", 1.0),
    "speed_rpm": ("speed_hz", 1 / 60),
    "ball_diameter_mm": ("ball_diameter_m", 1e-3),
}
# With fewer training runs a model of six conditions says nothing.
FEWEST_TRAINED = 10


def read_other_runs(settings: OtherSourcesConfig, taken: Mapping[str, Collection[str]], config: str) -> pd.DataFrame:
    """The runs of others: case, source, the six conditions, yield_percent, and where the energies come from.

    taken: cases of other tables by the table's path; no run may have the name of one of them. config: the file with
    the settings, for messages. The table has case, source, bpr, molar_ratio, time_h and yield_percent, and either the
    three descriptors or, in rows where these are empty, fill_ratio, speed_rpm and ball_diameter_mm, from which the
    fingerprint of the source calculates them. Column `descriptors` is `given` or the counting rule of the fingerprint.
    Without a table there are no rows. Raises ConfigError, in one line, for the first fault.
    """
    if settings.runs is None:
        return pd.DataFrame(columns=[CASE, SOURCE, *CONDITIONS, YIELD, "descriptors"])
    path = settings.runs
    frame = read_measured(
        path,
        [
            Text(CASE, unique=True),
            Text(SOURCE),
            *(Number(name, *BOUNDS[name], above=True) for name in CHEMICAL),
            *(Number(name, *BOUNDS[name], may_be_blank=True) for name in ENERGIES),
            *(Number(name, 0, above=True, optional=True, may_be_blank=True) for name in MILL_COLUMNS),
            replace(PERCENT_YIELD, asked=False),
        ],
    )
    _check_names(frame, path, settings, taken, config)
    _check_units(frame, path)
    refuse_copies(
        frame.fillna(0.0), path, [SOURCE, *(name for name in (*CONDITIONS, *MILL_COLUMNS) if name in frame)], YIELD
    )
    table = frame[[CASE, SOURCE, *CONDITIONS, YIELD]].assign(descriptors=GIVEN)
    for source in settings.sources:
        calculated = (frame[SOURCE] == source.name) & frame[NORMAL].isna()
        if not calculated.any():
            continue
        if source.fingerprint is None:
            why = (
                f"source {source.name} has no fingerprint: give the descriptors here, or its `fingerprint` in {config}"
            )
            refuse_rows(frame, path, NORMAL, calculated, why)
        else:
            found, rule = _calculated(frame[calculated], path, source.fingerprint)
            table.loc[calculated, list(ENERGIES)] = found
            table.loc[calculated, "descriptors"] = rule
    return table


def _check_names(
    frame: pd.DataFrame, path: str, settings: OtherSourcesConfig, taken: Mapping[str, Collection[str]], config: str
) -> None:
    known = [source.name for source in settings.sources]
    why = f"not in yields.other_sources.sources of {config}; known: {', '.join(known)}"
    refuse_rows(frame.fillna({SOURCE: ""}), path, SOURCE, ~frame[SOURCE].isin(known), why)
    for name in known:
        if name not in set(frame[SOURCE]):
            raise ConfigError(f"{config}: yields.other_sources.sources: {name!r}: {path} has no run of it")
    for table, cases in taken.items():
        why = f"{table} has a run of that name; must be another"
        refuse_rows(frame, path, CASE, frame[CASE].isin(list(cases)), why)


def _check_units(frame: pd.DataFrame, path: str) -> None:
    """Refuse rows with some of the three descriptors, and sources whose yields must be fractions."""
    blank = frame[list(ENERGIES)].isna()
    for name in ENERGIES:
        partly = blank[name] & ~blank.all(axis=1)
        refuse_rows(frame, path, name, partly, "must be a number, or all three descriptors of the row empty")
    signed = ["%" in cell for cell in read_cells(path).column(YIELD)]
    for _, own in frame[~np.array(signed)].groupby(SOURCE, sort=False):
        refuse_shares(own, path, YIELD)


def _calculated(frame: pd.DataFrame, path: str, fingerprint_path: str) -> tuple[np.ndarray, str]:
    """The descriptors (rows, 3) of rows by a fingerprint, and its counting rule; refuses what it does not know."""
    # Imported here, since few tables need it: it takes a second.
    from millprint.fingerprint.model import Fingerprint

    for column in MILL_COLUMNS:
        if column not in frame:
            raise ConfigError(f"{path}: column {column} is missing: rows without descriptors need it")
        refuse_rows(frame, path, column, frame[column].isna(), "must be a number, since the row has no descriptors")
    fingerprint = Fingerprint.read(fingerprint_path)
    for column, (name, unit) in MILL_COLUMNS.items():
        low, high = (end / unit for end in fingerprint.about["ranges"][name])
        why = f"outside what {fingerprint_path} was simulated for; must be from {low:.4g} to {high:.4g}"
        refuse_rows(frame, path, column, ~frame[column].between(low * (1 - 1e-9), high * (1 + 1e-9)), why)
    found = fingerprint.descriptors(conditions_of(frame[[*MILL_COLUMNS]], fingerprint.about))
    energies = [1e6 * found["normal_energy_J"], 1e6 * found["tangential_energy_J"], found["specific_frequency_hz"]]
    return np.column_stack(energies), str(fingerprint.about["counting_rule"])


def with_other_runs(own: pd.DataFrame, others: pd.DataFrame, name: str) -> pd.DataFrame:
    """The runs of all sources: case, source, the six conditions, yield_percent; `name` is the source of `own`."""
    columns = [CASE, SOURCE, *CONDITIONS, YIELD]
    ours = own.assign(source=name)[columns]
    return pd.concat([ours, others[columns]], ignore_index=True) if len(others) else ours


def check_folds(rows: pd.DataFrame, folds: int, config: str) -> None:
    """Refuse more inner folds than a source that is held out leaves runs. Raises ConfigError, in one line."""
    runs = rows[SOURCE].value_counts(sort=False)
    for name, own in runs.items():
        kept = len(rows) - own
        if len(runs) > 1 and FEWEST_TRAINED <= kept < folds:
            raise ConfigError(
                f"{config}: yields.evaluation.folds = {folds}: at most {kept}, the runs without source {name}"
            )


SETTINGS = ("bpr", "molar_ratio", "time_h", "speed_rpm", "fill_ratio", "ball_diameter_mm")
GRAM = 1e-3


@dataclass(frozen=True)
class Mill:
    """What the descriptors need of a mill: ball density [kg/m3], amplitude [m] and volume of the jar [m3]."""

    density: float
    amplitude: float
    volume: float


def curve_point(curves: pd.DataFrame, fill_ratio: float) -> dict[str, float]:
    """The master curves of BASIC at a fill ratio, interpolated between logarithms; NaN outside the curves.

    curves: fill_ratio, Pn, Pt, f; rows of equal fill ratio count once.
    """
    table = curves.drop_duplicates("fill_ratio").sort_values("fill_ratio")
    fills = np.log(table["fill_ratio"].to_numpy(float))
    place = np.log(fill_ratio)
    inside = fills[0] - 1e-9 <= place <= fills[-1] + 1e-9
    found = {name: float(np.exp(np.interp(place, fills, np.log(table[name].to_numpy(float))))) for name in BASIC}
    return found if inside else dict.fromkeys(BASIC, float("nan"))


def check_region(region: RegionConfig, curves: pd.DataFrame, source: str) -> None:
    """Raise ConfigError, in one line, for a fill ratio outside the master curves."""
    low, high = curves["fill_ratio"].min(), curves["fill_ratio"].max()
    for fill in region.fill_ratio:
        if np.isnan(curve_point(curves, fill)["Pn"]):
            raise ConfigError(
                f"{source}: yields.proposals.region.fill_ratio = {fill:g}: the master curves cover {low:g} to {high:g}"
            )


def described_settings(settings: pd.DataFrame, curves: pd.DataFrame, mill: Mill) -> pd.DataFrame:
    """Settings with balls, powder and the descriptors of Eqs 3.22, 3.28 and 3.29.

    settings: a row for each condition with the columns SETTINGS, and any others. Columns added: balls, powder_mass_g,
    normal_energy_uJ, tangential_energy_uJ, specific_frequency_hz; NaN for a fill ratio outside the curves.
    """
    scaled = {fill: scaled_quantities(curve_point(curves, fill)) for fill in settings["fill_ratio"].unique()}
    found = []
    for row in settings.itertuples():
        diameter = row.ball_diameter_mm * 1e-3
        condition = Condition(row.fill_ratio, row.speed_rpm / 60, diameter, mill.density, mill.amplitude)
        at = descriptors_of(condition, scaled[row.fill_ratio])
        balls = ball_count(row.fill_ratio, mill.volume, diameter)
        found.append(
            {
                "balls": balls,
                "powder_mass_g": balls * mill.density * np.pi / 6 * diameter**3 / row.bpr / GRAM,
                "normal_energy_uJ": 1e6 * at["normal_energy_J"],
                "tangential_energy_uJ": 1e6 * at["tangential_energy_J"],
                "specific_frequency_hz": at["specific_frequency_hz"],
            }
        )
    return pd.concat([settings, pd.DataFrame(found, index=settings.index)], axis=1)


def region_conditions(region: RegionConfig, curves: pd.DataFrame, mill: Mill) -> pd.DataFrame:
    """Every combination of the settings, with case and the columns of `described_settings`."""
    table = pd.DataFrame(list(product(*(getattr(region, name) for name in SETTINGS))), columns=list(SETTINGS))
    cases = [f"r{number}" for number in range(1, len(table) + 1)]
    return described_settings(table, curves, mill).assign(case=cases)


POWDER, HYDROGEN, PRESSURE = "powder_mass_g", "hydrogen_mmol", "hydrogen_pressure_bar"
PLACE = "yields.proposals.region"


def with_hydrogen(rows: pd.DataFrame, region: RegionConfig, reaction: ChemistryConfig, volume: float) -> pd.DataFrame:
    """The rows with hydrogen_mmol, what the reaction gives off at full conversion, and hydrogen_pressure_bar.

    rows: molar_ratio, balls, ball_diameter_mm and powder_mass_g; volume: of the jar [m3]. The amount is
    `hydrogen_released` times the limiting reactant in the powder. Its pressure is that of an ideal gas in what balls
    and powder leave of the jar, n R T / (V - V_balls - m / rho), added to the pressure of the gas at closing; NaN where
    they leave nothing. rho and T are keys of the region. Excess hydride, which gives off its hydrogen from about 300
    degC only, is not counted.
    """
    powder = rows[POWDER].to_numpy(float) * 1e-3
    limiting, _ = reactant_masses(powder, rows["molar_ratio"].to_numpy(float), reaction)
    moles = hydrogen_released(reaction) * limiting * reaction.limiting_purity / molar_mass(reaction.limiting)
    balls = rows["balls"] * np.pi / 6 * (rows["ball_diameter_mm"] * 1e-3) ** 3
    free = volume - balls.to_numpy(float) - powder / region.powder_density_kg_m3
    pressure = np.full(len(rows), np.nan)
    np.divide(moles * gas_constant * region.gas_temperature_k, free * bar, out=pressure, where=free > 0)
    return rows.assign(**{HYDROGEN: 1e3 * np.asarray(moles), PRESSURE: pressure})


def safety_warnings(rows: pd.DataFrame, region: RegionConfig) -> list[str]:
    """For each row the limits of the region that it breaks, empty if none; rows as `with_hydrogen` returns them."""
    limits = {
        POWDER: ("powder_max_g", region.powder_max_g),
        HYDROGEN: ("hydrogen_max_mmol", region.hydrogen_max_mmol),
        PRESSURE: ("pressure_max_bar", region.pressure_max_bar),
    }
    texts = []
    for row in rows[list(limits)].to_dict("records"):
        broken = [
            f"{name} = {row[name]:.3g} is above {limit:g} ({PLACE}.{key})"
            for name, (key, limit) in limits.items()
            if limit is not None and row[name] > limit
        ]
        if np.isnan(row[PRESSURE]):
            broken.append(f"{PRESSURE} = nothing: balls and powder fill the jar")
        texts.append("; ".join(broken))
    return texts


STATUS, PROPOSED, RUNNING, DONE = "status", "proposed", "running", "done"


def read_experiments(path: str, curves: pd.DataFrame | None = None, taken: Iterable[str] = ()) -> pd.DataFrame:
    """Read the experiments: case, status, the settings of the mill, yield_percent where the status is done.

    Rows of next_experiments.tsv can be copied into it as they are; further columns are not changed. curves: master
    curves that must cover the fill ratios, or None; taken: cases of other tables. Raises ConfigError, in one line, as
    `read_measured`, for a status other than proposed, running or done, for a done experiment without a yield and for a
    yield of one that is not done, for a fill ratio outside the curves, and for a case that another table has.
    """
    table = read_measured(
        path,
        [
            Text(CASE, unique=True),
            Text(STATUS, choices=(PROPOSED, RUNNING, DONE)),
            *(Number(name, 0, above=True) for name in SETTINGS),
            Number(YIELD, 0, 100, may_be_blank=True),
        ],
        fewest_rows=0,
    )
    done, told = (table[STATUS] == DONE).to_numpy(), table[YIELD].notna().to_numpy()
    refuse_rows(table, path, YIELD, done & ~told, "a done experiment has a yield [%]")
    refuse_rows(table, path, YIELD, ~done & told, "only an experiment with the status done has a yield")
    refuse_rows(table, path, CASE, table[CASE].isin(set(taken)), "another table of runs has this case; choose another")
    if curves is not None:
        outside = np.array([np.isnan(curve_point(curves, fill)["Pn"]) for fill in table["fill_ratio"]], dtype=bool)
        low, high = curves["fill_ratio"].min(), curves["fill_ratio"].max()
        refuse_rows(table, path, "fill_ratio", outside, f"the master curves cover {low:g} to {high:g}")
    return table


def experiment_rows(table: pd.DataFrame, status: str, curves: pd.DataFrame, mill: Mill) -> pd.DataFrame:
    """The experiments of one status as rows of a yield model: case, the settings, the six conditions, yield_percent."""
    own = table.loc[table[STATUS] == status, [CASE, *SETTINGS, YIELD]].reset_index(drop=True)
    columns = list(dict.fromkeys([CASE, *SETTINGS, *CONDITIONS, YIELD]))
    return described_settings(own, curves, mill)[columns] if len(own) else pd.DataFrame(columns=columns, dtype=float)


def next_cases(count: int, taken: Iterable[str]) -> list[str]:
    """Names next_1, next_2, ... for new experiments that no case of `taken` has."""
    names: list[str] = []
    known, number = set(taken), 0
    while len(names) < count:
        number += 1
        if f"next_{number}" not in known:
            names.append(f"next_{number}")
    return names
