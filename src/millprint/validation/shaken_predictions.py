"""Predictions for shaken boxes: energy lost a period, the fall of a swing, and the power of a plate under gravity."""

import math
from collections.abc import Iterable
from typing import Any

import numpy as np
import pandas as pd

from millprint.cases.simulate import Values
from millprint.config.contact_set import ContactConfig
from millprint.config.errors import ConfigError
from millprint.config.quantities import LOSS_EXPONENT, LOST, PLATE_MEAN, PLATE_POWER, SWING
from millprint.config.shaken_models import LeafSpringConfig, ShakenBoxConfig, ShakenPlateConfig
from millprint.dem.ledger import closure
from millprint.estimate.estimates import mean_of
from millprint.mill.gravity import GRAVITY
from millprint.validation.measured import COUNT, DEM, SCATTER, Inputs, prediction
from millprint.validation.shaken import (
    LAW_END,
    LOSSES,
    Pile,
    ShakenBox,
    law_of_loss,
    law_of_swing,
    peaks,
    pour,
    spread,
)

LAW = "collect and collide, one particle"
FITTED = f"{LAW}, thickness fitted"
POURED = "poured"
THICKNESS = "thickness of the pile over that packed by shaking"
SAME = "energy lost over that of the prediction at the same A / G"
# Places on the line of the law.
LINE = 60


def _places(inputs: Inputs, quantity: str, given: Iterable[float], what: str) -> list[float]:
    """The places of the settings and the measured ones. Raises ConfigError for a measured one that is not above 0."""
    measured = inputs.places_of(quantity)
    if (measured <= 0).any():
        raise ConfigError(f"validation.measured: quantity {quantity}: x = {measured.min():g}: {what} must be above 0")
    return sorted({*map(float, given), *measured})


def _mean_rows(table: pd.DataFrame, quantity: str, ids: dict[float, str]) -> list[dict]:
    """A row for each x of a table of runs (x, value), with the mean over the seeds and its interval."""
    rows = []
    for x, group in table.groupby("x"):
        mean, interval = mean_of(group["value"].to_numpy(), "-", least=0.0), SCATTER if len(group) > 1 else ""
        low, high = mean.ends("repeats")
        rows.append(
            prediction(quantity, "-", mean.value, id=ids.get(x, ""), x=x, lower=low, upper=high, interval=interval)
        )
    return rows


def lost_share(run: Values, settings: ShakenBoxConfig, contact: ContactConfig) -> Values:
    """What a run of set-up 21 loses a period over 4 m (A w)^2 [-], and the thickness of the pile.

    run: amplitude over the free gap `x`, `seed`, `balls`, `speed_m_s`, `restitution`, `static_friction`. The gap is the
    inner length less the thickness of the pile as shaking packs it, at A / G = x or more, in a first box that the
    poured pile fills as far.
    `layers`: that thickness over the diameter; `poured`: that of the poured pile over it [-].
    """
    own = contact.model_copy(update={key: run[key] for key in ("restitution", "static_friction")})
    radius, fraction = settings.ball_diameter_mm / 2e3, settings.rayleigh_fraction

    def box_of(pile: Pile, amplitude_over_gap: float) -> ShakenBox:
        length = pile.thickness / settings.fill_share
        amplitude = amplitude_over_gap * (length - pile.thickness)
        frequency_hz = run["speed_m_s"] / (2 * math.pi * amplitude)
        return ShakenBox(pile, own, length, amplitude, frequency_hz, fraction)

    poured = pour(own, radius, settings.side_m, run["balls"], run["seed"], fraction)
    pile = box_of(poured, max(run["x"], settings.packing_amplitude)).packed(settings.packing_periods)
    box = box_of(pile, run["x"])
    box.shake(settings.discard_periods, 1.0)
    series = box.shake(settings.window_periods, settings.closure_max)
    lost = float(series[LOSSES].iloc[-1].sum()) / settings.window_periods
    return {
        "value": lost / (4 * box.mass * run["speed_m_s"] ** 2),
        "layers": pile.thickness / (2 * radius),
        "poured": poured.thickness / pile.thickness,
        "closure": closure(series),
    }


def design_of_box(settings: ShakenBoxConfig, contact: ContactConfig, places: Iterable[float]) -> pd.DataFrame:
    """A row for each run of set-up 21: its `model`, and the values that `lost_share` takes."""
    own = {
        "balls": settings.balls, "speed_m_s": settings.speed_m_s, "restitution": contact.restitution,
        "static_friction": contact.static_friction,
    }  # fmt: skip
    rows = [{"model": DEM, "x": x, "seed": seed, **own} for seed in settings.seeds for x in places]
    words = {
        "speed_m_s": "{:g} m/s", "restitution": "restitution {:g}", "static_friction": "friction {:g}",
        "balls": "{} balls",
    }  # fmt: skip
    rows += [
        {"model": f"{DEM}, {words[key].format(value)}", "x": x, "seed": settings.seeds[0], **own, key: value}
        for key, values in settings.changes.items()
        for value in values
        for x in settings.varied_amplitudes
    ]
    return pd.DataFrame(rows)


def gap_ratio(thickness: float, fill_share: float) -> float:
    """The free gap of a pile that is thicker than packed, over that of the packed one [-].

    thickness: over the packed one; fill_share: packed thickness over the inner length [-].
    """
    return (1 - fill_share * thickness) / (1 - fill_share)


def fitted_thickness(table: pd.DataFrame, fill_share: float) -> float:
    """The thickness over the packed one [-] with which the law fits runs (x, value) best, by least squares.

    Runs at less than 1.1 of the amplitude at which the law ends are left out.
    """
    # Slow to import, and every set-up imports this module.
    from scipy.optimize import minimize_scalar

    own = table[table["x"] > 1.1 * LAW_END]

    def misfit(thickness: float) -> float:
        places = own["x"] / gap_ratio(thickness, fill_share)
        return float(((places.clip(lower=LAW_END).map(law_of_loss) - own["value"]) ** 2).sum())

    return float(minimize_scalar(misfit, bounds=(0.9, 1.4), method="bounded").x)


def predict_shaken_box(inputs: Inputs) -> pd.DataFrame:
    """Set-up 21: energy lost a period over the amplitude, by the DEM, with one thing changed, and by the law."""
    settings: ShakenBoxConfig = inputs.settings
    places = _places(inputs, LOST, settings.amplitudes, "the amplitude over the free gap")
    table = design_of_box(settings, inputs.contact, places)
    runs = {f"{row['model']}, A/G {row['x']:g}, seed {row['seed']}": row for row in table.to_dict("records")}
    found = inputs.simulated(runs, lambda run: lost_share(run, settings, inputs.contact), "shaken box")
    table = table.join(pd.DataFrame(found))
    own = table[table["model"] == DEM]
    rows = _mean_rows(own, LOST, inputs.ids_of(LOST))
    means = own.groupby("x")["value"].mean()
    for row in table[table["model"] != DEM].to_dict("records"):
        about: dict[str, Any] = {"x": row["x"], "model": row["model"]}
        rows.append(prediction(LOST, "-", row["value"], **about))
        if row["x"] in means:
            rows.append(prediction(SAME, "-", row["value"] / means[row["x"]], **about))
    thickness = fitted_thickness(own, settings.fill_share)
    rows.append(prediction(THICKNESS, "-", thickness, model=FITTED))
    rows.append(prediction(THICKNESS, "-", float(own["poured"].mean()), model=POURED))
    gap = gap_ratio(thickness, settings.fill_share)
    for x in np.geomspace(LAW_END, max(*places, 2 * LAW_END), LINE).tolist():
        rows.append(prediction(LOST, "-", law_of_loss(x), x=x, model=LAW))
        rows.append(prediction(LOST, "-", law_of_loss(x / gap), x=x, model=FITTED))
    return pd.DataFrame(rows)


def swing_down(run: Values, settings: LeafSpringConfig, contact: ContactConfig, seconds: float) -> Values:
    """Times [s] at which the box of set-up 22 turns, and its amplitude there over the ball diameter [-].

    run: `seed` and `balls`; the box has `mass_ratio` times their mass.
    """
    diameter, fraction = settings.ball_diameter_mm / 1e3, settings.rayleigh_fraction
    length, amplitude = settings.length_diameters * diameter, settings.amplitude_diameters * diameter
    start = spread(diameter / 2, settings.side_m, length, run["balls"], run["seed"])
    box = ShakenBox(start, contact, length, amplitude, settings.frequency_hz, fraction)
    turns = peaks(box.swing(settings.mass_ratio * box.mass, seconds * settings.frequency_hz))
    return {
        "time_s": [0.0, *turns["time_s"]],
        "amplitude": [settings.amplitude_diameters, *turns["amplitude_m"] / diameter],
    }


def swing_by_law(settings: LeafSpringConfig, contact: ContactConfig) -> pd.DataFrame:
    """The same by the law, with the packed thickness: columns time_s and amplitude (over the ball diameter)."""
    diameter = settings.ball_diameter_mm / 1e3
    pile = pour(contact, diameter / 2, settings.side_m, settings.balls, settings.seeds[0], settings.rayleigh_fraction)
    gap = settings.length_diameters - pile.thickness / diameter
    amplitudes = np.linspace(settings.amplitude_diameters, LAW_END * gap, LINE)
    periods = law_of_swing(amplitudes / gap, settings.mass_ratio)
    return pd.DataFrame({"time_s": periods / settings.frequency_hz, "amplitude": amplitudes})


def predict_leaf_spring(inputs: Inputs) -> pd.DataFrame:
    """Set-up 22: amplitude of a box on a leaf spring over the time; the interval spans seeds and numbers of balls."""
    settings: LeafSpringConfig = inputs.settings
    times = _places(inputs, SWING, settings.times_s, "the time")
    numbers = [settings.balls] * len(settings.seeds) + settings.further_balls
    seeds = settings.seeds + [settings.seeds[0]] * len(settings.further_balls)
    runs = {
        f"{balls} balls, seed {seed}": {"balls": balls, "seed": seed}
        for balls, seed in zip(numbers, seeds, strict=True)
    }
    seconds = max(times) + 1 / settings.frequency_hz
    found = inputs.simulated(runs, lambda run: swing_down(run, settings, inputs.contact, seconds), "leaf spring")
    courses = np.array([np.interp(times, each["time_s"], each["amplitude"]) for each in found])
    own, ids, rows = courses[: len(settings.seeds)], inputs.ids_of(SWING), []
    for x, values, every in zip(times, own.T, courses.T, strict=True):
        mean = mean_of(values, "-", least=0.0)
        low, high = mean.ends("repeats")
        ends = (float(np.nanmin([low, *every])), float(np.nanmax([high, *every]))) if len(every) > 1 else (low, high)
        interval = f"{SCATTER} and {COUNT}" if len(every) > 1 else ""
        rows.append(
            prediction(SWING, "-", mean.value, id=ids.get(x, ""), x=x, lower=ends[0], upper=ends[1], interval=interval)
        )
    line = swing_by_law(settings, inputs.contact)
    rows += [prediction(SWING, "-", row.amplitude, x=row.time_s, model=LAW) for row in line.itertuples()]
    return pd.DataFrame(rows)


def plate_power(run: Values, settings: ShakenPlateConfig, contact: ContactConfig) -> Values:
    """Power over m g V of a run of set-up 23 [-], V the peak speed of the plate.

    run: acceleration `x` [g] and `seed`.
    """
    radius, fraction = settings.ball_diameter_mm / 2e3, settings.rayleigh_fraction
    pile = pour(contact, radius, settings.side_m, settings.balls, run["seed"], fraction)
    w = 2 * math.pi * settings.frequency_hz
    speed = run["x"] * GRAVITY / w
    # Twice the speed of the plate does not reach the lid.
    height = pile.thickness + (2 * speed) ** 2 / (2 * GRAVITY)
    plate = ShakenBox(pile, contact, height, speed / w, settings.frequency_hz, fraction, GRAVITY)
    plate.shake(settings.discard_periods, 1.0)
    series = plate.shake(settings.window_periods, settings.closure_max)
    power = float(series[LOSSES].iloc[-1].sum()) * settings.frequency_hz / settings.window_periods
    return {"value": power / (plate.mass * GRAVITY * speed)}


def predict_shaken_plate(inputs: Inputs) -> pd.DataFrame:
    """Set-up 23: power over m g V at each acceleration, its mean, and the exponent of the loss factor."""
    settings: ShakenPlateConfig = inputs.settings
    places = _places(inputs, PLATE_POWER, settings.accelerations, "the acceleration")
    table = pd.DataFrame([{"x": x, "seed": seed} for seed in settings.seeds for x in places])
    runs = {f"{row['x']:g} g, seed {row['seed']}": row for row in table.to_dict("records")}
    found = inputs.simulated(runs, lambda run: plate_power(run, settings, inputs.contact), "shaken plate")
    table = table.join(pd.DataFrame(found))
    own = table[table["x"].isin(settings.accelerations)]
    means, exponents = zip(
        *(
            # Energy lost a cycle over m V^2 / 2 goes with the power over m g V, over the acceleration.
            (group["value"].mean(), np.polyfit(np.log(group["x"]), np.log(group["value"] / group["x"]), 1)[0])
            for _, group in own.groupby("seed")
        ),
        strict=True,
    )
    rows = _mean_rows(table, PLATE_POWER, inputs.ids_of(PLATE_POWER))
    for quantity, values in ((PLATE_MEAN, means), (LOSS_EXPONENT, exponents)):
        mean = mean_of(values, "-")
        bounds: dict[str, Any] = {**vars(mean.repeats), "interval": SCATTER} if mean.repeats else {}
        rows.append(prediction(quantity, "-", mean.value, id=inputs.ids_of_single(quantity), **bounds))
    return pd.DataFrame(rows)
