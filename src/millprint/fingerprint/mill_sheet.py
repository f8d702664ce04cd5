"""The fingerprint sheet of a mill as a table: the mill, descriptors, exponents, and range of validity."""

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import pandas as pd

from millprint.config.charge import balls_in_words
from millprint.config.contact_set import ASSUMED
from millprint.config.included import shipped
from millprint.config.mill import MillConfig
from millprint.estimate.estimates import ENDS, columns_of
from millprint.fingerprint.bands import FURTHER, ORIGINS
from millprint.fingerprint.descriptors import CHARGE, MOTIONS, as_built, said_of, with_impacts
from millprint.fingerprint.readers import TABLE, WALL
from millprint.observables.condition import Condition
from millprint.observables.definitions import DESCRIPTORS, POWER, PREDICTED
from millprint.run.files import read_table
from millprint.run.numbers import three

if TYPE_CHECKING:
    # Only for types: it imports scikit-learn, which takes a second, and the figures of a sheet only read tables.
    from millprint.fingerprint.model import Fingerprint
    from millprint.fingerprint.predicted_values import Prediction


class Row(NamedTuple):
    """A row of a fingerprint sheet. For a descriptor, lower and upper are of a new simulation, mean_ of the mean."""

    section: str
    quantity: str
    value: float | None = None
    lower: float | None = None
    upper: float | None = None
    unit: str = ""
    text: str = ""
    mean_lower: float | None = None
    mean_upper: float | None = None


SHEET = list(Row._fields)
# Mass of the balls over that of the powder, for the dose of a sheet; people take 10 to 50 [-].
RATIO = 10
# Fill ratios at which the width of an interval is evaluated.
FILLS_WITHIN = 40
# Fill ratios that are listed one by one.
LISTED = 6
DESCRIBED = tuple(name for name in PREDICTED if name in DESCRIPTORS)
# The section `precision`: time and seeds of a condition, and the intervals of some quantities of CURVES.
RECORDED, SIMULATED = "recorded time of a simulation", "simulations of a condition"
STATED = {
    "Pw": "power",
    "Pn": "normal power",
    "Pt": "tangential power",
    "Pr": "rolling power",
    "En_star": "weighted normal energy",
    "Et_star": "weighted tangential energy",
    "f": "collisions",
}
WIDTH = "half of the band of a new simulation: the median, and from the smallest to the largest"
WHERE = {"where simulated": "at the simulated conditions", "between": "over the fill ratios, at each speed and size"}
MORE = (
    "millprint fingerprint {name} --config 'mills={{precision: fine}}' (a run that has a file: its name in place of "
    "{name}); or more seeds and conditions in the sweep"
)
RANGES = {
    "fill_ratio": ("fill ratio", "-", 1.0),
    "speed_hz": ("speed", "rpm", 60.0),
    "ball_diameter_m": ("ball diameter", "mm", 1e3),
    "density_kg_m3": ("ball density", "kg/m3", 1.0),
    "amplitude_m": ("amplitude A", "mm", 1e3),
}


def sheet_condition(fingerprint: "Fingerprint", simulated: pd.DataFrame) -> tuple[Condition[float], str]:
    """The simulated condition that a sheet describes, and its charge.

    The slowest speed of the largest balls, at the fill ratio nearest to the middle of the simulated ones in logarithm.
    simulated: conditions of the mill as built, with charge, ball_diameter_mm, speed_rpm and fill_ratio.
    """
    speed, diameter, charge = min(fingerprint.settings, key=lambda setting: (-setting[1], setting[0]))
    # A table has fewer digits than a fingerprint.
    near = np.isclose(simulated["ball_diameter_mm"], 1e3 * diameter, rtol=1e-5)
    near &= np.isclose(simulated["speed_rpm"], 60 * speed, rtol=1e-5)
    fills = simulated.loc[near & (simulated[CHARGE] == charge), "fill_ratio"].to_numpy(dtype=float)
    low, high = fingerprint.fill_range
    fill = float(fills[np.argmin(np.abs(np.log(fills**2 / (low * high))))])
    return fingerprint.condition(speed_hz=speed, ball_diameter_m=diameter, fill_ratio=fill), charge


def _row_of(condition: Condition[float], charge: str, simulated: pd.DataFrame) -> pd.Series:
    """The row of a simulated condition in a table of them, which has fewer digits than a fingerprint."""
    near = simulated[CHARGE] == charge
    for name in ("fill_ratio", "speed_hz", "ball_diameter_m"):
        near &= np.isclose(simulated[name], getattr(condition, name), rtol=1e-5)
    return simulated[near].iloc[0]


def _balls_row(condition: Condition[float], charge: str) -> Row:
    diameter_mm = 1e3 * condition.ball_diameter_m
    text = f"{balls_in_words(diameter_mm, charge)}, the ball of mean volume" if charge else ""
    return Row("condition", "ball diameter", diameter_mm, unit="mm", text=text)


def shown_speed(unit: str, speed_hz: float) -> str:
    """A speed as text, in the unit of a mill, rpm or hz."""
    return f"{speed_hz:.3g} Hz" if unit == "hz" else f"{60 * speed_hz:.4g} rpm"


def tabulate_sheet(
    mill: MillConfig, fingerprint: "Fingerprint", collapse: pd.DataFrame, zones: pd.DataFrame, descriptors: pd.DataFrame
) -> pd.DataFrame:
    """Rows of SHEET: the mill, descriptors of one condition with intervals, exponents, collapse, zones, validity.

    collapse: as of tabulate_mill_collapse; zones: as of find_zones; descriptors: of the mill's sweep. A fingerprint
    with further origins of intervals also has their columns, and a line that explains each.
    """
    # Imported here: they take long, and what only reads sheets does not need them.
    from millprint.mill.bodies import build_bodies
    from millprint.mill.wall_words import walls_in_words

    about, built = fingerprint.about, as_built(descriptors)
    condition, charge = sheet_condition(fingerprint, with_impacts(built))
    simulated = _row_of(condition, charge, built)
    words = [MOTIONS["few_turns"].word] if MOTIONS["few_turns"].word in simulated["motion"].split(", ") else []
    prediction, speed = fingerprint.predict(condition, charge=charge), condition.speed_hz
    at_wall = [f"{DESCRIPTORS[of].title} {about[name]:g}" for name, of in WALL.items() if name in about]
    rows = [
        Row("mill", "name", text=f"{mill.name}: {mill.title}"),
        Row("mill", "nominal volume", mill.volume_ml, unit="mL"),
        Row("mill", "amplitude A, half of the longest way of a wall", 1e3 * about["amplitude_m"], unit="mm"),
        Row("mill", "wall", text=walls_in_words(build_bodies(mill))),
        Row("mill", "contact set", text=f"{about['contact']}, {about['density_kg_m3']:g} kg/m3; {ASSUMED}"),
        *([Row("mill", "at the wall", text=", ".join(at_wall))] if at_wall else []),
        Row("mill", "collisions counted by", text=about["counting_rule"]),
        Row("condition", "speed", 60 * speed, unit="rpm", text=shown_speed(mill.speed_unit, speed)),
        _balls_row(condition, charge),
        Row("condition", "fill ratio", condition.fill_ratio, unit="-"),
        Row("condition", "balls", prediction.balls, unit="-"),
    ]
    if lasting := simulated["lasting_motions"]:
        rows.append(Row("condition", "several motions last", text=lasting))
    if charge:
        rows.append(Row("condition", "charge", text=fingerprint.charges[charge].in_words(prediction.balls)))
    for name in DESCRIBED:
        band, column = getattr(prediction, name), DESCRIPTORS[name]
        reason = about.get("no_curve", {}).get(column.curve)
        value = float(simulated[name]) if reason and math.isnan(band.value) else band.value
        said = ", ".join([*words, *([f"no curve: {reason}"] if reason else [])])
        ends = (band.lower, band.upper, column.unit, said, *band.ends("mean"))
        rows.append(Row("descriptors", column.title, value, *ends))
    rows += _dose_rows(prediction, condition, ", ".join(words))
    for own in collapse.itertuples():
        title = own.quantity.removesuffix("_W").removesuffix("_hz").removesuffix("_J").replace("_", " ")
        rows += [
            Row("exponents", f"{title}: of speed", own.omega, own.omega_lower, own.omega_upper, "-",
                 f"scaling law: {own.omega_supposed:g}"),
            Row("exponents", f"{title}: of ball size", own.d, own.d_lower, own.d_upper, "-",
                 f"scaling law: {own.d_supposed:g}"),
            Row("collapse", f"{title}: spread before scaling", own.spread_before, unit="-"),
            Row("collapse", f"{title}: by the scaling law", own.spread_thesis, unit="-"),
            Row("collapse", f"{title}: by its own exponents", own.spread_own, None, None, "-",
                 f"{own.collapse}: {own.reason}"),
        ]  # fmt: skip
    for zone in zones.itertuples():
        rows.append(Row("zones", zone.zone.replace("_", " "), zone.value, zone.lower, zone.upper, "-"))
    for name, (title, unit, factor) in RANGES.items():
        low, high = about["ranges"][name]
        if name == "speed_hz" and mill.speed_unit == "hz":
            unit, factor = "Hz", 1.0
        rows.append(Row("validity", title, None, low * factor, high * factor, unit))
    rows.append(Row("validity", "largest error of an energy balance", descriptors["closure"].max(), unit="-"))
    rows += _precision_rows(mill.name, fingerprint, built)
    table = pd.DataFrame(rows, columns=SHEET)
    return _with_intervals(table, fingerprint, prediction) if fingerprint.further else table


def _dose_rows(prediction: "Prediction", condition: Condition[float], said: str) -> list[Row]:
    """Power of all balls and of a kilogram of them, and what it means for the powder; said: a word with each."""
    power = prediction.known[POWER]
    mass_kg = prediction.balls * condition.density_kg_m3 * math.pi / 6 * condition.ball_diameter_m**3
    rows = []
    for title, factor, unit in (
        ("power of a kilogram of balls", 1 / mass_kg, "W/kg"),
        (f"dose of an hour at a ball-to-powder ratio of {RATIO}", 3.6e-3 * RATIO / mass_kg, "kJ/g"),
    ):
        band = power * factor
        rows.append(Row("dose", title, band.value, band.lower, band.upper, unit, said, *band.ends("mean")))
    return [*rows, *_box_rows()]


def _box_rows() -> list[Row]:
    """What is weak and what is strong: the power of a kilogram of balls in the mills that come with millprint."""
    if not (made := shipped(TABLE)):
        return []
    weakest_first = read_table(made).sort_values("lowest_W_kg")
    spans = [f"{own.mill} {three(own.lowest_W_kg)} to {three(own.highest_W_kg)}" for own in weakest_first.itertuples()]
    return [Row("dose", "power of other mills, W/kg", text=", ".join(spans))]


def _precision_rows(mill: str, fingerprint: "Fingerprint", descriptors: pd.DataFrame) -> list[Row]:
    """How much the sweep simulated for a condition, and how wide the resulting intervals are."""
    seeds, recorded = descriptors["seeds"], descriptors["window_s"]
    rows = [
        Row("precision", RECORDED, None, recorded.min(), recorded.max(), "s"),
        Row("precision", SIMULATED, None, seeds.min(), seeds.max(), "-"),
    ]
    between = fingerprint.at_settings(np.geomspace(*fingerprint.fill_range, FILLS_WITHIN))
    for (place, meaning), inputs in zip(WHERE.items(), (fingerprint.inputs, between), strict=True):
        widths = _half_widths(fingerprint, inputs)
        for name, title in STATED.items():
            median, smallest, largest = 100 * widths[name]
            rows.append(Row("precision", f"{title}, {place}", median, smallest, largest, "%", f"{WIDTH}, {meaning}"))
    for name, motion in MOTIONS.items():
        held = said_of(descriptors, name)
        if held.any():
            text = f"{held.sum()} of {held.size} conditions, {_fills(descriptors[held])}: {motion.meaning}"
            rows.append(Row("precision", motion.word, float(held.sum()), unit="-", text=text))
    for name, reason in fingerprint.about.get("no_curve", {}).items():
        rows.append(Row("precision", f"no curve of {DESCRIPTORS[name].title}", text=reason))
    return [*rows, Row("precision", "for more", text=MORE.format(name=mill))]


def _half_widths(fingerprint: "Fingerprint", inputs: np.ndarray) -> dict[str, np.ndarray]:
    """Half the width of the band of a new simulation over its value [-], for each quantity: median, smallest, largest.

    inputs: conditions (m, 5 or 6). Bands that are not known are wider than all others; NaN where one of the three is
    not known.
    """
    table, found = fingerprint.told(inputs), {}
    for name in STATED:
        lower, upper = (table[column] for column in columns_of(name, "scatter"))
        widths = np.sort(np.sqrt(upper / lower).fillna(np.inf)) - 1
        three = np.array([widths[(len(widths) - 1) // 2], widths[0], widths[-1]])
        found[name] = np.where(np.isfinite(three), three, np.nan)
    return found


def _fills(descriptors: pd.DataFrame) -> str:
    """The fill ratios of conditions: "at fill 0.06, 0.08"; of many only their range."""
    fills = sorted(descriptors["fill_ratio"].unique())
    listed = ", ".join(f"{fill:g}" for fill in fills)
    return f"at fill {listed if len(fills) <= LISTED else f'{fills[0]:.3g} to {fills[-1]:.3g}'}"


def by_columns(origin: str) -> list[str]:
    """The columns of a sheet for the interval by an origin of FURTHER."""
    return [f"by_{origin}_{end}" for end in ENDS]


def _with_intervals(sheet: pd.DataFrame, fingerprint: "Fingerprint", prediction: "Prediction") -> pd.DataFrame:
    """The sheet with `by_columns` of every origin, empty where it is not known, and the section `intervals`."""
    bands = [getattr(prediction, name) for name in DESCRIBED]
    places = sheet.index[sheet["section"] == "descriptors"]
    probability = 100 * fingerprint.about["probability"]
    lines = []
    for origin, (title, meaning) in ORIGINS.items():
        if origin not in FURTHER:
            lines.append(Row("intervals", title, text=f"{meaning} ({probability:g} %)"))
            continue
        sheet.loc[places, by_columns(origin)] = [band.ends(origin) for band in bands]
        factors = fingerprint.further.get(origin)
        said = f"{meaning} ({100 * factors.probability:g} %)" if factors else ""
        lines.append(Row("intervals", title, text=prediction.missing.get(origin, said)))
    return pd.concat([sheet, pd.DataFrame(lines, columns=SHEET)], ignore_index=True)
