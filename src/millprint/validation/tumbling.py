"""Predictions for tumbling mills, from the runs of `millprint.validation.tumbling_runs`."""

import math
from typing import Any

import numpy as np
import pandas as pd

from millprint.config.mill import MillConfig
from millprint.config.setups.tumbling_setups import TumblingConfig
from millprint.mill.bodies import build_bodies
from millprint.validation.inputs import Inputs
from millprint.validation.power_formulas import LIFT_ANGLE_DEG, Mill, hogg_fuerstenau, morrell
from millprint.validation.predictions import DEM, prediction
from millprint.validation.tumbling_intervals import ANGLES, POWER_W, intervals, whole_interval
from millprint.validation.tumbling_runs import FURTHER, PREDICTS

POWER, RINGS, TOE, SHOULDER = "power", "complete rings of centrifuging balls", "toe angle", "shoulder angle"
TURN_ENERGY = "energy a revolution"
OTHER_CONTACT = f"{DEM}, contact set"


def _named(quantity: str, number: int, settings: TumblingConfig) -> str:
    """The quantity, with the number of balls unless it is the first."""
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
        low, high, by = whole_interval(row, POWER_W)
        if single:
            turn_s = 60 / row["speed_rpm"]
            rows += _rows(inputs, TURN_ENERGY, "J/rev", x, row["power_W"] * turn_s, low * turn_s, high * turn_s, by)
            continue
        rows += _rows(inputs, _named(POWER, row["number"], settings), "W", x, row["power_W"], low, high, by)
        group = runs[(runs["role"] == PREDICTS) & (runs["number"] == row["number"]) & (runs["speed"] == row["speed"])]
        rings = float(np.median(group["rings"]))
        rows += _rows(inputs, _named(RINGS, row["number"], settings), "rings", x, rings, math.nan, math.nan, "")
        for name, quantity in ((TOE, ANGLES["toe_deg"]), (SHOULDER, ANGLES["shoulder_deg"])):
            if group[quantity.column].notna().all():
                ends = whole_interval(row, quantity)
                rows += _rows(inputs, _named(name, row["number"], settings), "deg", x, row[quantity.column], *ends)
    return rows


def charge_of(settings: TumblingConfig, mill: MillConfig, density: float, number: int) -> Mill:
    """The charge for the power formulas, for a number of balls."""
    low, high = build_bodies(mill, settings.speed_rpm(settings.speeds[0]))[0].vessel.bounds
    across = "xyz".index(getattr(mill.geometry, "axis", "y"))
    mass = number * density * math.pi / 6 * (settings.diameter_mm / 1e3) ** 3
    filling = settings.fillings[settings.numbers.index(number)]
    return Mill(float(high[2]), float(high[across] - low[across]), filling, mass)


def formula_powers(
    settings: TumblingConfig, mill: MillConfig, density: float, number: int, speed_rpm: float
) -> dict[str, float]:
    """Net power by each formula [W], without formulas that do not hold at this speed."""
    charge = charge_of(settings, mill, density, number)
    share = speed_rpm / 60 * 2 * math.pi / math.sqrt(9.81 / charge.radius_m)
    powers = {}
    if share < 1:
        powers[f"Hogg and Fuerstenau, {LIFT_ANGLE_DEG:g} deg"] = hogg_fuerstenau(charge, speed_rpm / 60)
        powers["Morrell, C-model"] = morrell(charge, share)
    return powers


def predict_tumbling(inputs: Inputs) -> pd.DataFrame:
    """Power, toe, shoulder and rings over the speed, or the energy of a revolution at one speed; also by formulas."""
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
        model = f"{OTHER_CONTACT} {row['contact']}"
        if single:
            rows.append(prediction(TURN_ENERGY, "J/rev", row["power_W"] * 60 / row["speed_rpm"], model=model))
        else:
            rows.append(prediction(POWER, "W", row["power_W"], x=row["speed"], model=model))
    return pd.DataFrame([*rows, *powers_of_other_codes(inputs, single)])


def powers_of_other_codes(inputs: Inputs, single: bool) -> list[dict[str, Any]]:
    """Predictions by other codes for the same mill, contact set and numbers of balls.

    single: whether the set-up has one speed, and therefore the energy of a revolution in place of the power.
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
