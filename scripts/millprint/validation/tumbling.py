"""Predictions for tumbling mills, from the runs of `millprint.validation.tumbling_runs`."""

import math
from typing import Any

import numpy as np
import pandas as pd

from millprint.config.mill import MillConfig
from millprint.config.setups.tumbling import TumblingConfig
from millprint.mill.bodies import build_bodies
from millprint.quantiles import student_quantile
from millprint.validation.inputs import Inputs
from millprint.validation.power_formulas import LIFT_ANGLE_DEG, Mill, hogg_fuerstenau, morrell
from millprint.validation.predictions import CONTACT, DEM, SCATTER, prediction
from millprint.validation.tumbling_runs import FURTHER, PREDICTS, SAMPLE

PROBABILITY = 0.95
POWER, RINGS, TOE, SHOULDER = "power", "complete rings of centrifuging balls", "toe angle", "shoulder angle"
TURN_ENERGY = "energy a revolution"
BOTH = f"{SCATTER} and {CONTACT}"


def mean_interval(values: np.ndarray, probability: float = PROBABILITY) -> tuple[float, float, float]:
    """Mean of values over the seeds, and its interval by Student's t; without an interval (nan) for a single value."""
    values = np.asarray(values, dtype=float)
    mean = float(values.mean())
    if len(values) < 2:
        return mean, math.nan, math.nan
    half = float(student_quantile(0.5 + probability / 2, len(values) - 1) * values.std(ddof=1) / math.sqrt(len(values)))
    return mean, mean - half, mean + half


def without_jump(angles_deg: np.ndarray) -> np.ndarray:
    """The same angles [deg] within half a turn of their circular mean, so that 359 and 1 are two degrees apart."""
    angles = np.asarray(angles_deg, dtype=float)
    if not angles.size:
        return angles
    # Slow to import, and every set-up imports this module.
    from scipy.stats import circmean

    middle = circmean(angles, high=360)
    return middle + (angles - middle + 180) % 360 - 180


def contact_factors(runs: pd.DataFrame, column: str, probability: float = PROBABILITY) -> pd.DataFrame:
    """By what factor contact parameters change a quantity: index speed, columns lower and upper [-].

    Each run of the sample and of the further contact sets over the prediction with the same seed and speed. The ends
    are quantiles over the sample, widened to the further sets, and never leave out 1: the prediction itself.
    """
    first = runs[runs["role"] != PREDICTS]
    own = runs[(runs["role"] == PREDICTS) & (runs["number"] == runs["number"].iloc[0])]
    base = own[own["seed"] == own["seed"].iloc[0]].set_index("speed")[column]
    ratio = first[column] / first["speed"].map(base)
    tail = (1 - probability) / 2
    rows = {}
    for speed, group in first.assign(ratio=ratio).groupby("speed"):
        sampled = group.loc[group["role"] == SAMPLE, "ratio"]
        named = [1.0, *group.loc[group["role"] == FURTHER, "ratio"]]
        ends = sampled.quantile([tail, 1 - tail]) if len(sampled) else pd.Series([1.0, 1.0])
        rows[speed] = {"lower": min(ends.iloc[0], *named), "upper": max(ends.iloc[1], *named)}
    return pd.DataFrame.from_dict(rows, orient="index").sort_index()


def combined(value: float, scatter: tuple[float, float], contact: tuple[float, float]) -> tuple[float, float]:
    """Ends of two independent intervals about a value together: their distances from it, added in squares."""
    low = math.hypot(value - scatter[0], value - contact[0])
    high = math.hypot(scatter[1] - value, contact[1] - value)
    return value - low, value + high


def intervals(runs: pd.DataFrame, settings: TumblingConfig) -> pd.DataFrame:
    """Power over speed with both intervals said apart, a row for each number of balls and speed.

    Columns: number, speed, speed_rpm, power_W, scatter_lower_W, scatter_upper_W, contact_lower_W, contact_upper_W, and
    the means of toe, shoulder, rings and share of the balls that are carried round. The effect of contact parameters is
    that of the first number of balls, interpolated over the speed and constant beyond the sampled speeds.
    """
    factors = contact_factors(runs, "power_W")
    own = runs[runs["role"] == PREDICTS]
    rows = []
    for (number, speed), group in own.groupby(["number", "speed"]):
        power, low, high = mean_interval(group["power_W"].to_numpy())
        ends = [float(np.interp(speed, factors.index, factors[end])) for end in ("lower", "upper")]
        rows.append(
            {
                "number": number, "speed": speed, "speed_rpm": group["speed_rpm"].iloc[0], "seeds": len(group),
                "power_W": power, "scatter_lower_W": low, "scatter_upper_W": high,
                "contact_lower_W": power * ends[0], "contact_upper_W": power * ends[1],
                **{name: pd.Series(without_jump(group[name].dropna())).mean() for name in ("toe_deg", "shoulder_deg")},
                "rings": group["rings"].mean(), "carried_share": group["carried"].mean() / number,
            }
        )  # fmt: skip
    rank = {number: place for place, number in enumerate(settings.numbers)}
    return pd.DataFrame(sorted(rows, key=lambda row: (rank[row["number"]], row["speed"])))


def _named(quantity: str, number: int, settings: TumblingConfig) -> str:
    """The quantity, with the number of balls where it is not the first."""
    return quantity if number == settings.numbers[0] else f"{quantity}, {number} balls"


def _rows(
    inputs: Inputs, quantity: str, unit: str, x: float, value: float, low: float, high: float, interval: str
) -> list[dict]:
    """A row for each measured row of the quantity at x, or one without an id."""
    places = inputs.places[inputs.places["quantity"] == quantity]
    same = places["x"].isna() if x != x else np.isclose(places["x"].astype(float), x)
    ids = list(places.loc[same, "id"]) or [""]
    named = interval if low == low else ""
    return [prediction(quantity, unit, value, id=id, x=x, lower=low, upper=high, interval=named) for id in ids]


def _dem_rows(inputs: Inputs, curve: pd.DataFrame, runs: pd.DataFrame, settings: TumblingConfig) -> list[dict]:
    rows = []
    single = len(curve["speed"].unique()) == 1
    for row in curve.to_dict("records"):
        x = math.nan if single else row["speed"]
        power = row["power_W"]
        low, high = combined(
            power,
            (row["scatter_lower_W"], row["scatter_upper_W"]),
            (row["contact_lower_W"], row["contact_upper_W"]),
        )
        if single:
            turn_s = 60 / row["speed_rpm"]
            rows += _rows(inputs, TURN_ENERGY, "J/rev", x, power * turn_s, low * turn_s, high * turn_s, BOTH)
            continue
        rows += _rows(inputs, _named(POWER, row["number"], settings), "W", x, power, low, high, BOTH)
        group = runs[(runs["role"] == PREDICTS) & (runs["number"] == row["number"]) & (runs["speed"] == row["speed"])]
        rings = float(np.median(group["rings"]))
        rows += _rows(inputs, _named(RINGS, row["number"], settings), "rings", x, rings, math.nan, math.nan, "")
        for quantity, column in ((TOE, "toe_deg"), (SHOULDER, "shoulder_deg")):
            if group[column].notna().all():
                mean, lower, upper = mean_interval(without_jump(group[column].to_numpy()))
                name = _named(quantity, row["number"], settings)
                rows += _rows(inputs, name, "deg", x, mean, lower, upper, SCATTER)
    return rows


def charge_of(settings: TumblingConfig, mill: MillConfig, density: float, number: int) -> Mill:
    """What the power formulas take for a number of balls."""
    low, high = build_bodies(mill, settings.speed_rpm(settings.speeds[0]))[0].vessel.bounds
    across = "xyz".index(getattr(mill.geometry, "axis", "y"))
    mass = number * density * math.pi / 6 * (settings.diameter_mm / 1e3) ** 3
    filling = settings.fillings[settings.numbers.index(number)]
    return Mill(float(high[2]), float(high[across] - low[across]), filling, mass)


def formula_powers(
    settings: TumblingConfig, mill: MillConfig, density: float, number: int, speed_rpm: float
) -> dict[str, float]:
    """Net power by each formula [W]; one that says nothing at this speed is left out."""
    charge = charge_of(settings, mill, density, number)
    share = speed_rpm / 60 * 2 * math.pi / math.sqrt(9.81 / charge.radius_m)
    powers = {}
    if share < 1:
        powers[f"Hogg and Fuerstenau, {LIFT_ANGLE_DEG:g} deg"] = hogg_fuerstenau(charge, speed_rpm / 60)
        powers["Morrell, C-model"] = morrell(charge, share)
    return powers


def predict_tumbling(inputs: Inputs) -> pd.DataFrame:
    """Power, toe, shoulder and rings over the speed, or the energy of a revolution at one speed; formulas beside."""
    settings: TumblingConfig = inputs.settings
    mill = inputs.mill
    assert mill is not None, "a tumbling mill is in a file of config/mills"
    runs = inputs.table("runs.tsv")
    curve = intervals(runs, settings)
    rows = _dem_rows(inputs, curve, runs, settings)
    single = len(curve["speed"].unique()) == 1
    further = runs[runs["role"] == FURTHER]
    for row in curve.to_dict("records"):
        number, speed = row["number"], row["speed"]
        for model, power in formula_powers(
            settings, mill, inputs.contact.density_kg_m3, number, row["speed_rpm"]
        ).items():
            if single:
                rows.append(prediction(TURN_ENERGY, "J/rev", power * 60 / row["speed_rpm"], model=model))
            else:
                rows.append(prediction(_named(POWER, number, settings), "W", power, x=speed, model=model))
    for row in further.to_dict("records"):
        model = f"{DEM}, contact set {row['contact']}"
        if single:
            rows.append(prediction(TURN_ENERGY, "J/rev", row["power_W"] * 60 / row["speed_rpm"], model=model))
        else:
            rows.append(prediction(POWER, "W", row["power_W"], x=row["speed"], model=model))
    return pd.DataFrame([*rows, *powers_of_other_codes(inputs, single)])


def powers_of_other_codes(inputs: Inputs, single: bool) -> list[dict[str, Any]]:
    """Predictions by other codes for the same mill, contact set and numbers of balls.

    single: whether the set-up is of one speed, so that it has the energy of a revolution for the power.
    """
    settings: TumblingConfig = inputs.settings
    codes = inputs.other_codes
    same = (codes["mill"] == settings.mill) & (codes["contact"] == settings.contact)
    rows = []
    for row in codes[same & codes["balls"].isin(settings.numbers)].to_dict("records"):
        power, model = row["power_W"], str(row["code"])
        if single:
            rows.append(prediction(TURN_ENERGY, "J/rev", power * 60 / row["speed_rpm"], model=model))
        else:
            name = _named(POWER, int(row["balls"]), settings)
            rows.append(prediction(name, "W", power, x=settings.speed_of(row["speed_rpm"]), model=model))
    return rows
