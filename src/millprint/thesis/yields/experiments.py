"""Experiments that can be done on a mill: their settings and descriptors, what the jar holds, and the table of them."""

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import product

import numpy as np
import pandas as pd
from scipy.constants import bar, gas_constant

from millprint.config.doe import ChemistryConfig
from millprint.config.errors import ConfigError
from millprint.config.sweep import ball_count
from millprint.config.yields import RegionConfig
from millprint.observables.condition import Condition
from millprint.observables.definitions import BASIC, descriptors_of, scaled_quantities
from millprint.run.tables import CASE, Number, Text, read_measured, refuse_rows
from millprint.thesis.doe.chemistry import hydrogen_released, molar_mass, reactant_masses
from millprint.thesis.doe.runs import YIELD
from millprint.thesis.yields.features import CONDITIONS

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
