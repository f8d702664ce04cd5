"""The heat balance of a mill's conditions: samples of unknown parameters, temperatures with bands, limits, pauses."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pandas as pd

from millprint.config.dose import COEFFICIENT, PARAMETERS, TEMPERATURE, HeatConfig, RangeSection
from millprint.dose.heat_balance import BODIES, Balance, Course, pause_needed, programme_phases, solve, time_to_limit
from millprint.dose.heat_sources import HeatSource

RUNNING, RESTING, ROOM = "running_W_m2K", "resting_W_m2K", "surroundings_degC"
# Bounds of a band, by the columns that hold them.
BAND = ("lower", "median", "upper")
# Times in a table of temperatures, from the start to the end of the programme.
TIMES = 61
# What cools a jar while the mill stands, by what cools it while the mill runs.
AT_REST: dict[str, str] = {"still_air": "still_air", "moving_air": "still_air", "water": "water"}


def ranges_of(settings: HeatConfig, mill: str) -> dict[str, tuple[RangeSection, str, str]]:
    """Every sampled number by name, with its range, title and unit: parameters, and the surroundings of the mill."""
    cooling = getattr(settings.surroundings, settings.jar_of(mill).cooling)
    resting = getattr(settings.surroundings, AT_REST[settings.jar_of(mill).cooling])
    own = {name: (given, PARAMETERS[name].title, PARAMETERS[name].unit) for name, given in settings.parameters.items()}
    return {
        **own,
        RUNNING: (cooling.coefficient_W_m2K, f"{COEFFICIENT.title} while the mill runs", COEFFICIENT.unit),
        RESTING: (resting.coefficient_W_m2K, f"{COEFFICIENT.title} in a pause", COEFFICIENT.unit),
        ROOM: (cooling.temperature_degC, f"{TEMPERATURE.title}, and all bodies at the start", TEMPERATURE.unit),
    }


def sample(settings: HeatConfig, mill: str) -> pd.DataFrame:
    """A Latin hypercube over the ranges (McKay, Beckman and Conover, Technometrics 21 (1979) 239): a row a sample.

    A range that spans a factor of ten is uniform in the logarithm. If a pause is cooled like milling, both have the
    same sampled number.
    """
    # Slow to import, and the check of the input imports this module.
    from scipy.stats import qmc

    ranges = ranges_of(settings, mill)
    cube = qmc.LatinHypercube(len(ranges), rng=np.random.default_rng(settings.seed)).random(settings.samples)
    columns = {}
    for share, (name, (given, _, _)) in zip(cube.T, ranges.items(), strict=True):
        columns[name] = (
            given.low * (given.high / given.low) ** share
            if given.logarithmic
            else given.low + (given.high - given.low) * share
        )
    cooling = settings.jar_of(mill).cooling
    if AT_REST[cooling] == cooling:
        columns[RESTING] = columns[RUNNING]
    return pd.DataFrame(columns)


def jar_of_samples(
    settings: HeatConfig, mill: str, source: HeatSource, drawn: pd.DataFrame
) -> tuple[np.ndarray, np.ndarray]:
    """Mass [kg] and outside [m2] of the jar of each sample (n,).

    If the outside is not given, it is the inside (volume V, surface S) enlarged by the thickness t, by the factor
    1 + t S / (3 V) in length. This is exact for a sphere, a cube and a cylinder as deep as wide.
    """
    known = settings.jar_of(mill)
    factor = 1 + 1e-3 * drawn["wall_thickness_mm"].to_numpy() * source.inside_m2 / (3 * source.inside_m3)
    mass = drawn["jar_density_kg_m3"].to_numpy() * source.inside_m3 * (factor**3 - 1)
    outside = source.inside_m2 * factor**2
    if known.mass_kg is not None:
        mass = np.full(len(drawn), known.mass_kg)
    if known.surface_cm2 is not None:
        outside = np.full(len(drawn), 1e-4 * known.surface_cm2)
    return mass, outside


def heat_by_body(source: HeatSource, drawn: pd.DataFrame) -> np.ndarray:
    """Heat released in balls, powder and jar [W] (n, 3); the sum is heat_share of the dissipation.

    The powder takes its share of every contact. The rest heats the balls in contacts of ball on ball; in contacts of
    ball on wall, `wall_share` of the rest heats the jar and the remainder the balls.
    """
    shares = drawn[["powder_share_normal", "powder_share_shear", "powder_share_shear"]].to_numpy()
    power = source.power_W[None] * drawn["heat_share"].to_numpy()[:, None, None]
    powder = (power * shares[:, None, :]).sum(axis=(1, 2))
    between, wall = np.moveaxis((power * (1 - shares[:, None, :])).sum(axis=2), 1, 0)
    jar = wall * drawn["wall_share"].to_numpy()
    return np.column_stack([between + wall - jar, powder, jar])


def balance_of(settings: HeatConfig, mill: str, source: HeatSource, drawn: pd.DataFrame) -> Balance:
    """The balances of a condition, one for each sample."""
    mass, outside = jar_of_samples(settings, mill, source, drawn)
    powder = source.balls_kg / drawn["ball_to_powder_ratio"].to_numpy()
    if settings.powder_mass_g is not None:
        powder = np.full(len(drawn), 1e-3 * settings.powder_mass_g)
    masses = {"ball": source.balls_kg, "powder": powder, "jar": mass}
    areas = {"ball_powder": source.balls_m2, "ball_wall": source.inside_m2, "powder_wall": source.inside_m2}
    return Balance(
        capacity_J_K=np.column_stack([own * drawn[f"{of}_heat_capacity_J_kgK"] for of, own in masses.items()]),
        between_W_K=np.column_stack([own * drawn[f"{of}_W_m2K"] for of, own in areas.items()]),
        running_W_K=outside * drawn[RUNNING].to_numpy(),
        resting_W_K=outside * drawn[RESTING].to_numpy(),
        source_W=heat_by_body(source, drawn),
        surroundings_degC=drawn[ROOM].to_numpy(),
    )


def band(values: np.ndarray, probability: float) -> np.ndarray:
    """Lower end, median and upper end over the first axis (3, ...); an infinite value is larger than any other."""
    ends = [(1 - probability) / 2, 0.5, (1 + probability) / 2]
    # Not interpolated, because there is no value between a finite and an infinite one.
    return np.quantile(values, ends, axis=0, method="inverted_cdf")


def _columns(name: str, values: np.ndarray, probability: float) -> dict[str, float]:
    return {f"{name}_{end}": value for end, value in zip(BAND, band(values, probability), strict=True)}


@dataclass(frozen=True)
class HeatTables:
    """The tables of a mill."""

    parameters: pd.DataFrame
    """a row for each sampled number, with its range and source"""
    temperatures: pd.DataFrame
    """a row for each condition, body and time"""
    limits: pd.DataFrame
    """a row for each condition: temperatures, time to the limit, pauses"""


def parameter_table(settings: HeatConfig, mill: str) -> pd.DataFrame:
    """A row for each sampled number: range, unit and source."""
    columns = ["parameter", "title", "unit", "low", "high", "source"]
    ranges = ranges_of(settings, mill).items()
    rows = [(name, title, unit, given.low, given.high, given.source) for name, (given, title, unit) in ranges]
    return pd.DataFrame(rows, columns=columns)


def limit_row(settings: HeatConfig, source: HeatSource, balance: Balance, course: Course) -> dict[str, object]:
    """The results of a condition: temperatures, time to the limit, and the pauses that keep below it.

    no_pause_share: share of samples that need no pause; interval_too_long_share: share of samples that get too hot in a
    single interval of milling, so that no pause is enough.
    """
    limit, programme, level = settings.limit, settings.programme, settings.probability
    body = BODIES.index(limit.body)
    reach = time_to_limit(balance, body, limit.temperature_degC) / 3600
    pause = pause_needed(balance, body, limit.temperature_degC, 60 * programme.milling_min) / 60
    steady = balance.steady_degC()
    row: dict[str, object] = {"condition": source.condition, **source.about, "total_W": source.power_W.sum()}
    for index, name in enumerate(BODIES):
        row |= _columns(f"{name}_steady_degC", steady[:, index], level)
    for index, name in enumerate(BODIES):
        row |= _columns(f"{name}_peak_degC", course.peak_degC[:, index], level)
    return {
        **row,
        "limit_body": limit.body,
        "limit_degC": limit.temperature_degC,
        "over_limit_share": float(np.mean(course.peak_degC[:, body] > limit.temperature_degC)),
        **_columns("time_to_limit_h", reach, level),
        "milling_min": programme.milling_min,
        **_columns("pause_needed_min", pause, level),
        "no_pause_share": float(np.mean(pause == 0)),
        "interval_too_long_share": float(np.mean(np.isinf(pause))),
        "balance_error": course.balance_error,
    }


def temperature_rows(settings: HeatConfig, source: HeatSource, course: Course) -> pd.DataFrame:
    """Bands of the temperatures of a condition over time, a row for each body and time."""
    tables, about = [], {"condition": source.condition, "time_h": course.times_s / 3600}
    for index, name in enumerate(BODIES):
        ends = band(np.moveaxis(course.temperature_degC[:, :, index], 1, 0), settings.probability)
        columns = {f"{end}_degC": values for end, values in zip(BAND, ends, strict=True)}
        tables.append(pd.DataFrame(about | {"body": name} | columns))
    order = ["condition", "body", "time_h", *(f"{end}_degC" for end in BAND)]
    return pd.concat(tables, ignore_index=True)[order]


def heat_tables(
    settings: HeatConfig,
    mill: str,
    sources: list[HeatSource],
    step: Callable[[], object] = lambda: None,
    times: int = TIMES,
) -> HeatTables:
    """Every table of a mill; step: called after each condition; times: number of times of the temperatures."""
    drawn = sample(settings, mill)
    programme = settings.programme
    duration = 3600 * programme.duration_h
    phases = programme_phases(duration, 60 * programme.milling_min, 60 * programme.pause_min)
    if not programme.pause_min:
        phases = programme_phases(duration, duration, 0.0)
    times_s = np.linspace(0.0, duration, times)
    limits, temperatures = [], []
    for source in sources:
        balance = balance_of(settings, mill, source, drawn)
        course = solve(balance, phases, times_s)
        limits.append(limit_row(settings, source, balance, course))
        temperatures.append(temperature_rows(settings, source, course))
        step()
    return HeatTables(parameter_table(settings, mill), pd.concat(temperatures, ignore_index=True), pd.DataFrame(limits))
