"""Regimes of motion and the energies of their collisions (thesis chapter 3).

Dissipation of single revolutions (thesis Table 3.5, Fig. 3.5), and maps of where the balls are (Figs 3.9, 3.10).
"""

import itertools
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass, replace
from operator import itemgetter
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd
from scipy.constants import hour as HOUR

from millprint.config.errors import ConfigError
from millprint.config.sweep import ball_count
from millprint.config.workflow import PartitionConfig
from millprint.dose.kinetics import MODELS, TIME, YIELD, doses
from millprint.fingerprint.descriptors import CHARGE, NOTHING, condition_of
from millprint.fingerprint.descriptors import CONDITION as WITH_CHARGE
from millprint.observables.condition import Condition, Quantity, power_scale
from millprint.observables.counted_collisions import CHANNELS
from millprint.observables.definitions import BASIC, descriptors_of, scaled_quantities
from millprint.run.hdf5 import open_hdf5
from millprint.run.tables import CASE, Number, Text, read_measured, read_printed, refuse_rows

if TYPE_CHECKING:
    from millprint.fingerprint.model import Fingerprint

# Only the chapters have these tables, and their balls are of one size.
CONDITION = [name for name in WITH_CHARGE if name != CHARGE]
CYCLE_PARTS = ("mean_J", "sd_J", "cv_percent")
# Of a density.
CYCLE_POINTS = 120


def _revolutions(summaries: list[dict]) -> Iterator[tuple[dict, dict[str, np.ndarray]]]:
    """Each condition, in order, with the energies of its revolutions [J] by channel, all seeds together."""
    groups: dict[tuple, list[dict]] = defaultdict(list)
    for run in summaries:
        condition = condition_of(run)
        groups[tuple(condition[name] for name in CONDITION)].append(run["per_revolution"])
    for key, runs in sorted(groups.items(), key=itemgetter(0)):
        energies = {name: np.concatenate([np.asarray(run[f"{name}_J"], float) for run in runs]) for name in CHANNELS}
        yield dict(zip(CONDITION, key, strict=True)), energies


def tabulate_cycles(summaries: list[dict]) -> pd.DataFrame:
    """Mean [J], standard deviation [J] and coefficient of variation [%] of the dissipation per revolution.

    A row for each condition with at least two revolutions; the columns of Table 3.5.
    """
    rows = []
    for row, cycles in _revolutions(summaries):
        row["revolutions"] = cycles["normal"].size
        if row["revolutions"] < 2:
            continue
        for channel, energies in cycles.items():
            mean, deviation = energies.mean(), energies.std(ddof=1)
            values = (mean, deviation, 100.0 * deviation / mean)
            row |= {f"{channel}_{part}": value for part, value in zip(CYCLE_PARTS, values, strict=True)}
        rows.append(row)
    columns = [*CONDITION, "revolutions", *(f"{c}_{s}" for c in CHANNELS for s in CYCLE_PARTS)]
    return pd.DataFrame(rows, columns=columns)


def tabulate_densities(summaries: list[dict], fill_ratio: float) -> pd.DataFrame:
    """Probability density [1/J] of the dissipation per revolution at one fill ratio, by a Gaussian kernel.

    For the mill as built; conditions with fewer than three revolutions have no density.
    """
    # Imported here: slow to import, and the check of the input imports this module.
    from scipy.stats import gaussian_kde

    frames = [pd.DataFrame(columns=[*CONDITION, "channel", "energy_J", "density_per_J"])]
    for condition, cycles in _revolutions(summaries):
        if not np.isclose(condition["fill_ratio"], fill_ratio) or condition["varied"] != NOTHING:
            continue
        for channel, energies in cycles.items():
            if energies.size < 3 or np.ptp(energies) == 0:
                continue
            margin = 3.0 * energies.std(ddof=1)
            grid = np.linspace(max(energies.min() - margin, 0.0), energies.max() + margin, CYCLE_POINTS)
            density = {"channel": channel, "energy_J": grid, "density_per_J": gaussian_kde(energies)(grid)}
            frames.append(pd.DataFrame(condition | density))
    return pd.concat(frames[1:] or frames, ignore_index=True)


def tabulate_published(cycles: pd.DataFrame, published: pd.DataFrame, mill: str, fill_ratio: float) -> pd.DataFrame:
    """Table 3.5 side by side: ours, the published value, and our deviation from the published one [%].

    cycles: as from `tabulate_cycles`; published: as from `published_cycles`. A row for each condition of `mill` at
    the fill ratio; conditions that the thesis does not print have empty published columns.
    """
    ours = cycles[(cycles["mill"] == mill) & np.isclose(cycles["fill_ratio"], fill_ratio)]
    ours = ours[ours["varied"] == NOTHING].drop(columns=["mill", "varied", "density_kg_m3", "amplitude_m"])
    key = ["contact", "fill_ratio", "ball_diameter_mm", "speed_rpm"]
    table = ours.merge(published, how="left", on=key, suffixes=("", "_published"))
    for channel, part in itertools.product(CHANNELS, CYCLE_PARTS):
        name = f"{channel}_{part}"
        if f"{name}_published" in table:
            table[f"{name}_deviation_percent"] = 100.0 * (table[name] / table[f"{name}_published"] - 1.0)
    return table


DATASETS = ("edges_x_m", "edges_y_m", "count", "granular_temperature")


@dataclass(frozen=True)
class OccupancyMap:
    """Maps on a grid in the frame of the jar, seen from above.

    edges_x_m (nx + 1), edges_y_m (ny + 1): edges of the cells [m]; share (nx, ny): balls in a cell over balls in the
    fullest cell [-]; temperature_m2_s2 (nx, ny): granular temperature of Eq. 3.26 [m2/s2]. Both maps are masked where
    no ball came.
    """

    title: str
    edges_x_m: np.ndarray
    edges_y_m: np.ndarray
    share: np.ma.MaskedArray
    temperature_m2_s2: np.ma.MaskedArray


def read_occupancy(path: str | Path, title: str) -> OccupancyMap:
    """The maps of a run.h5; raises ConfigError for a file without its grid, and if no ball was seen in any cell."""
    with open_hdf5(path) as run:
        group = run.get("occupancy")
        missing = [name for name in DATASETS if group is None or name not in group]
        if missing:
            raise ConfigError(f"{path}: occupancy/{missing[0]} is missing; rerun the simulation that wrote the file")
        edges_x, edges_y, count, temperature = (group[name][()] for name in DATASETS)
    if count.sum() <= 0:
        raise ConfigError(f"{title}: no ball was seen on the grid; the run recorded no window")
    empty = count == 0
    share = np.ma.masked_array(count / count.max(), mask=empty)
    temperature = np.ma.masked_array(np.where(empty, 0.0, temperature.astype(float)), mask=empty)
    return OccupancyMap(title, edges_x, edges_y, share, temperature)


WAYS_OF_RUNNING = {"speed": "constant speed", "power": "constant power"}
SLOPE_COLUMNS = [
    *("series", "title", "points", "intercept", "slope_per_pp", "slope_lower", "slope_upper"),
    *("p_value", "r2"),
]

JOULES_PER_KWH = 3.6e6
# Of a curve that is drawn.
POINTS = 80


def specific_yields(runs: pd.DataFrame) -> pd.DataFrame:
    """Yield and converted mass over power, with their gains over the reference (Table 4.4).

    runs: case, mode, fill_ratio, balls, power_W, yield_percent, borate_mass_g. The mass is that of the borate
    converted. Gains are in per cent of the unrounded reference; the printed +64 % of the mass is the ratio of two
    rounded entries (0.185 over 0.113), where the unrounded ones give 63.3 %.
    """
    table = runs[["case", "mode", "fill_ratio", "balls", "power_W"]].copy()
    table["yield_fraction"] = runs["yield_percent"] / 100.0
    table["specific_yield_per_W"] = table["yield_fraction"] / table["power_W"]
    table["borate_mass_g"] = runs["borate_mass_g"]
    table["mass_per_watt_g_W"] = table["borate_mass_g"] * table["yield_fraction"] / table["power_W"]
    reference = table[table["mode"] == "reference"].iloc[0]
    table["gain_percent"] = 100.0 * (table["specific_yield_per_W"] / reference["specific_yield_per_W"] - 1.0)
    table["mass_gain_percent"] = 100.0 * (table["mass_per_watt_g_W"] / reference["mass_per_watt_g_W"] - 1.0)
    return table


def energy_leverage(runs: pd.DataFrame, settings: PartitionConfig) -> pd.DataFrame:
    """Share of the milling energy found again as chemical energy (Eq. 4.7, Table 4.5), plug energy and cost.

    runs: as for `specific_yields`, with time_h. Mechanical energy P t [J]; leverage on enthalpy, Gibbs energy and
    lower heating value [%]; energy from the plug E / (eta m) [kWh/kg] (Eq. 4.8) and its cost [EUR/kg] (Eq. 4.9), m the
    mass of borohydride, one mole for one of borate (Eq. 4.2).

    The printed digits are ours, rounded or truncated: the column dG comes out by rounding if it is 1.23 times the
    unrounded column dH, as the text of Sec. 4.3.2 says, and the column LHV by truncation of 2908 / 1226 times it.
    """
    table = runs[["case", "mode", "fill_ratio", "power_W"]].copy()
    molar_mass = settings.borate_molar_mass_g_mol * 1e-3
    moles = runs["borate_mass_g"] * 1e-3 / molar_mass * runs["yield_percent"] / 100.0
    table["mechanical_energy_J"] = runs["power_W"] * runs["time_h"] * HOUR
    table["borohydride_mol"] = moles
    table["borohydride_mass_g"] = moles * (settings.borohydride_molar_mass_g_mol * 1e-3) * 1e3
    energies_kJ = settings.enthalpy_kJ_mol, settings.gibbs_kJ_mol, settings.lower_heating_value_kJ_mol
    for name, energy in zip(("dH", "dG", "LHV"), energies_kJ, strict=True):
        table[f"leverage_{name}_percent"] = 100.0 * moles * (energy * 1e3) / table["mechanical_energy_J"]
    mass = table["borohydride_mass_g"] * 1e-3
    table["plug_energy_kWh_kg"] = table["mechanical_energy_J"] / JOULES_PER_KWH / (settings.plug_efficiency * mass)
    table["cost_EUR_kg"] = table["plug_energy_kWh_kg"] * settings.electricity_price_EUR_kWh
    return table


def compare_with_prior(best: dict[str, float], prior: dict[str, float]) -> pd.DataFrame:
    """Comparison of the best case with earlier work (Table 4.3): both hold yield_percent, time_h, bpr and speed_hz.

    The change is relative, in per cent; only the change of the yield is in percentage points.
    """
    rows = []
    for metric, earlier in prior.items():
        change = best[metric] - earlier if metric == "yield_percent" else 100.0 * (best[metric] / earlier - 1.0)
        rows.append({"metric": metric, "prior": earlier, "this_work": best[metric], "change": change})
    return pd.DataFrame(rows)


def fit_slopes(runs: pd.DataFrame, probability: float) -> pd.DataFrame:
    """Ordinary least squares of the yield [-] on the fill ratio [percentage points], for each way of running.

    runs: mode, fill_ratio, yield_percent; the reference belongs to both lines. `slope_per_pp` is what one percentage
    point of fill ratio changes, with its confidence interval; three points leave one degree of freedom, so the
    interval is wide however high R2 is.
    """
    from statsmodels.regression.linear_model import OLS
    from statsmodels.tools import add_constant

    rows = []
    for mode, title in WAYS_OF_RUNNING.items():
        line = runs[runs["mode"].isin(["reference", mode])]
        if line["fill_ratio"].nunique() < 3:
            continue
        yields, fills = (line[name].to_numpy() for name in ("yield_percent", "fill_ratio"))
        fit = OLS(yields / 100.0, add_constant(fills * 100.0)).fit()
        values = (*fit.params, *fit.conf_int(alpha=1.0 - probability)[1], fit.pvalues[1], fit.rsquared)
        rows.append((mode, title, len(line), *values))
    return pd.DataFrame(rows, columns=SLOPE_COLUMNS)


def powder_of_ball(bpr: pd.Series, ball_diameter_m: float, density_kg_m3: float) -> pd.Series:
    """Powder [g] that one ball has at a ball-to-powder mass ratio [-]."""
    return 1e3 * density_kg_m3 * np.pi / 6 * ball_diameter_m**3 / bpr


def screening_doses(path: str | Path, ball_diameter_m: float, density_kg_m3: float) -> pd.DataFrame:
    """Case, bpr, molar_ratio, time_h, doses and yield_percent of the screening runs, from their printed descriptors."""
    energies = ("normal_energy_uJ", "tangential_energy_uJ", "specific_frequency_hz")
    numbers = [Number(name, 0, above=True) for name in ("bpr", "molar_ratio", TIME, *energies)]
    table = read_measured(path, [Text(CASE, unique=True), *numbers, Number(YIELD, 0, 100)])
    powder = powder_of_ball(table["bpr"], ball_diameter_m, density_kg_m3)
    normal, tangential, frequency = (table[name] for name in energies)
    found = doses(1e-6 * normal, 1e-6 * tangential, frequency, table[TIME], powder)
    return pd.concat([table[[CASE, "bpr", "molar_ratio", TIME]], found, table[[YIELD]]], axis=1)


def regime_doses(
    measured: pd.DataFrame, cases: pd.DataFrame, ball_diameter_m: float, density_kg_m3: float
) -> pd.DataFrame:
    """The columns of `screening_doses` for the five cases of chapter 4.

    measured: as of `fingerprint.regimes.read_regimes`; cases: those rows of Table 4.2, with energies and frequency.
    """
    joined = measured[[CASE, "bpr", "molar_ratio", TIME, YIELD]].merge(cases, on=CASE, suffixes=("", "_designed"))
    powder = powder_of_ball(joined["bpr"], ball_diameter_m, density_kg_m3)
    columns = ("normal_energy_J", "tangential_energy_J", "specific_frequency_hz")
    normal, tangential, frequency = (joined[name] for name in columns)
    found = doses(normal, tangential, frequency, joined[TIME], powder)
    return pd.concat([joined[[CASE, "bpr", "molar_ratio", TIME]], found, joined[[YIELD]]], axis=1)


def curve_of(row: pd.Series, largest: float) -> pd.DataFrame:
    """The yield [%] of a fitted law from 0 to the largest x: columns x and yield_percent."""
    x = np.linspace(0.0, largest, POINTS)
    values = {name: row[name] for name in MODELS[row["model"]].names}
    if "x0" in values:
        values["x0"] /= largest
    return pd.DataFrame({"x": x, YIELD: MODELS[row["model"]].law(x, **values)})


def read_published(path: str | Path, claims_path: str | Path) -> pd.DataFrame:
    """The published values: quantity, contact, fill_ratio, ball_diameter_mm, speed_rpm, value, unit, locus.

    path: their table, which may have a column `claim`: the id of a claim whose value is in the table `claims_path`.
    Raises ConfigError for a missing column, for a claim that is unknown, and for a value that is not a number.
    """
    blank = [Number(name, may_be_blank=True) for name in ("ball_diameter_mm", "speed_rpm", "value")]
    text = [Text(name) for name in ("quantity", "contact", "unit", "locus")]
    table = read_measured(path, [*text, Number("fill_ratio"), *blank, Text("claim", optional=True)])
    if "claim" in table:
        claims = read_printed(claims_path)
        refuse_rows(table, path, "claim", table["claim"].notna() & ~table["claim"].isin(claims.index), "no known claim")
        printed = pd.to_numeric(table["claim"].map(claims), errors="coerce")
        table["value"] = table["value"].fillna(printed)
    missing = table["value"].isna()
    refuse_rows(table, path, "value", missing, "must be a number, or that of the row's claim in claims.tsv")
    return table


def published_curves(published: pd.DataFrame, contact: str) -> pd.DataFrame:
    """Published master curves of a contact set: fill_ratio and a column for each of Pn, Pt, f and ratio."""
    curves = published[published["quantity"].isin(["Pn", "Pt", "f", "ratio"]) & (published["contact"] == contact)]
    return curves.pivot_table(index="fill_ratio", columns="quantity", values="value").reset_index()


def published_point(published: pd.DataFrame, contact: str, fill_ratio: float) -> dict[str, float] | None:
    """The published Pn, Pt and f at a fill ratio, or None where the thesis gives no values there."""
    curves = published_curves(published, contact)
    row = curves[(curves["fill_ratio"] - fill_ratio).abs() < 1e-9]
    if row.empty:
        return None
    return {name: float(row[name].iloc[0]) for name in BASIC}


def published_cycles(published: pd.DataFrame) -> pd.DataFrame:
    """Table 3.5 with the means that it implies: standard deviation over coefficient of variation [J]."""
    quantities = [f"{channel}_{part}" for channel in CHANNELS for part in ("sd_J", "cv_percent")]
    rows = published[published["quantity"].isin(quantities)]
    index = ["contact", "fill_ratio", "ball_diameter_mm", "speed_rpm"]
    table = rows.pivot_table(index=index, columns="quantity", values="value").reset_index()
    for channel in CHANNELS:
        if f"{channel}_sd_J" in table:
            table[f"{channel}_mean_J"] = 100.0 * table[f"{channel}_sd_J"] / table[f"{channel}_cv_percent"]
    return table


MODES = ("reference", "speed", "power")
MEASURED_CURVES = {"Pn": "normal_curve", "Pt": "tangential_curve", "f": "frequency_curve"}


def read_regimes(path: str) -> pd.DataFrame:
    """The measured cases; raises ConfigError for a missing column, an unknown mode or no single reference case."""
    positive = ["fill_ratio", "balls", *MEASURED_CURVES.values(), "bpr", "molar_ratio", "time_h", "borate_mass_g"]
    table = read_measured(
        path,
        [
            Text("case", unique=True),
            Text("mode", choices=MODES),
            *(Number(name, 0, above=True) for name in positive),
            Number("yield_percent", 0, 100, above=True),
        ],
    )
    if (table["mode"] == "reference").sum() != 1:
        raise ConfigError(f"{path}: column mode: exactly one row must be the reference")
    return table.rename(columns={column: name for name, column in MEASURED_CURVES.items()})


def reference_condition(
    cases: pd.DataFrame, *, speed_hz: float, ball_diameter_m: float, density_kg_m3: float, amplitude_m: float
) -> Condition[float]:
    """How the reference case is run: at its own fill ratio, and with what is given."""
    reference = cases[cases["mode"] == "reference"].iloc[0]
    return Condition(
        fill_ratio=float(reference["fill_ratio"]),
        speed_hz=speed_hz,
        ball_diameter_m=ball_diameter_m,
        density_kg_m3=density_kg_m3,
        amplitude_m=amplitude_m,
    )


def equal_power_speed(
    reference_speed: float, reference_balls: float, reference_power: float, balls: Quantity, power: Quantity
) -> Quantity:
    """Speed that keeps the total power, Eq. 4.6: omega_ref (n_ref P_ref / (n P))^(1/3), in the unit of omega_ref.

    reference_power, power: specific powers Pn + Pt [-]; balls: numbers of balls.
    """
    return reference_speed * np.cbrt(reference_balls * reference_power / (balls * power))


def design_cases(cases: pd.DataFrame, condition: Condition[float]) -> pd.DataFrame:
    """Speed, frequency, energies and power of every case: Table 4.2 from its curve values.

    cases: case, mode, fill_ratio, balls, Pn, Pt, f; condition: of the reference case. Speeds follow from the mode
    (Eq. 4.6 for `power`), frequency and energies from Eqs 4.3 and 4.4, the power from Eq. 4.5. Nothing is rounded, but
    `power_as_printed_W`, which Tables 4.4 and 4.5 go on with: Eq. 4.5 with energies to two decimals of 1e-4 J and whole
    collisions a second, rounded to 0.1 W. That gives 3.0 W for the 3.053 W of the tangential case.

    The digits of Table 4.2 are ours, rounded or truncated. All its energies and powers come out by plain rounding if
    600 rpm is taken as 62.8 rad/s, and the ratio as that of the rounded energies (a test holds this).
    """
    table = cases[["case", "mode", "fill_ratio", "balls", "Pn", "Pt", "f"]].copy()
    reference = table[table["mode"] == "reference"].iloc[0]
    total = table["Pn"] + table["Pt"]
    even = equal_power_speed(
        condition.speed_hz, reference["balls"], reference["Pn"] + reference["Pt"], table["balls"], total
    )
    table["speed_hz"] = even.where(table["mode"] == "power", condition.speed_hz)
    as_run = replace(condition, fill_ratio=table["fill_ratio"], speed_hz=table["speed_hz"])
    found = descriptors_of(as_run, scaled_quantities(table))
    for name in ("specific_frequency_hz", "normal_energy_J", "tangential_energy_J"):
        table[name] = found[name]
    both = table["normal_energy_J"] + table["tangential_energy_J"]
    table["power_W"] = table["balls"] * table["specific_frequency_hz"] * both
    for end in ("lower", "upper"):
        # Printed values have no interval.
        table[f"power_{end}_W"] = table["power_W"] * cases.get(f"power_{end}_share", np.nan)
    energies = table["normal_energy_J"].round(6) + table["tangential_energy_J"].round(6)
    table["power_as_printed_W"] = (table["balls"] * table["specific_frequency_hz"].round(0) * energies).round(1)
    table["ratio"] = table["tangential_energy_J"] / table["normal_energy_J"]
    return table


def with_curves(cases: pd.DataFrame, fingerprint: "Fingerprint") -> pd.DataFrame:
    """The cases with our Pn, Pt and f at their fill ratios, and the interval of the power over its value.

    Columns power_lower_share and power_upper_share: the ends of the interval of Pn + Pt over Pn + Pt [-]. Raises
    ConfigError for a fill ratio outside the curves.
    """
    curve = fingerprint.curve(cases["fill_ratio"].to_numpy()).set_index(cases.index)
    shares = {f"power_{end}_share": curve[f"P_{end}"] / curve["P"] for end in ("lower", "upper")}
    return cases.assign(**{name: curve[name] for name in MEASURED_CURVES}, **shares)


def cases_at(fill_ratios: list[float], reference: Condition[float], volume_m3: float) -> pd.DataFrame:
    """Cases at any fill ratios, without curve values: the reference, then each fill at its speed and at its power.

    volume_m3: of the jar.
    """
    rows = [("reference", "reference", reference.fill_ratio)]
    rows += [(f"{mode}.{fill:g}", mode, fill) for mode in MODES[1:] for fill in sorted(set(fill_ratios))]
    table = pd.DataFrame(rows, columns=["case", "mode", "fill_ratio"])
    return table.assign(balls=[ball_count(fill, volume_m3, reference.ball_diameter_m) for fill in table["fill_ratio"]])


def with_published(cases: pd.DataFrame, measured: pd.DataFrame) -> pd.DataFrame:
    """The cases at fill ratios at which the thesis prints curve values, with them; `measured` as of `read_regimes`."""
    printed = measured.drop_duplicates("fill_ratio")[["fill_ratio", *MEASURED_CURVES]]
    return cases.merge(printed, on="fill_ratio", how="inner")


def power_as_run(cases: pd.DataFrame, speed: pd.Series, condition: Condition[float]) -> pd.Series:
    """Total power n (Pn + Pt) rho omega^3 A^2 d^3 [W] of the cases (Eqs 4.3, 4.5) at the speeds [Hz] that were run.

    condition: of the reference case.
    """
    as_run = replace(condition, fill_ratio=cases["fill_ratio"], speed_hz=speed)
    return cases["balls"] * (cases["Pn"] + cases["Pt"]) * power_scale(as_run)
