"""The fingerprint of a mill on one page, its geometry and a strip of its motion, and several mills together."""

import textwrap
from collections.abc import Callable
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.figure import Figure, SubFigure

from millprint.config.charge import balls_in_words
from millprint.dose.spectra import BOTH
from millprint.dose.spectra_shown import ATLAS, TEMPERATURE
from millprint.dose.spectra_shown import FILL as SPECTRA_FILL
from millprint.dose.spectra_shown import NOTE as NO_SPECTRA
from millprint.dose.spectra_shown import SECTION as SPECTRA
from millprint.estimate.estimates import columns_of
from millprint.figures.dose_figures import draw_sheet_spectra
from millprint.figures.style import (
    COLOURS,
    COLUMN_WIDTH_IN,
    FILL_LABEL,
    MARKERS,
    draw_curve,
    draw_table,
    legend_below,
    no_formula,
    plt,
    write_rows,
)
from millprint.fingerprint.bands import FURTHER, ORIGINS
from millprint.fingerprint.descriptors import CHARGE, MOTIONS
from millprint.fingerprint.mill_sheet import RECORDED, SIMULATED, STATED, WHERE, by_columns, shown_speed
from millprint.observables.definitions import DESCRIPTORS, SHEET_PANELS
from millprint.run.numbers import NOT_KNOWN, plain, prefix_of, three
from millprint.view.frames import Look, MillPicture

INK, DARK, LIGHT = "#303030", 0.74, 0.96
# Walls that look round and are flat facets are yellowish, exact ones grey.
FLAT = np.array([1.0, 0.97, 0.84])


def _draw(axes: Axes, look: Look, limits: np.ndarray, linewidth: float = 0.7) -> None:
    """A mill in one view: walls that face the eye, outlines, and the inserts over them."""
    grey = np.repeat((DARK + (LIGHT - DARK) * look.wall_shade)[:, None], 3, axis=1)
    grey[look.wall_is_flat] *= FLAT
    axes.add_collection(PolyCollection(list(look.wall_mm), facecolors=grey, edgecolors=grey, linewidths=0.2))
    axes.add_collection(LineCollection(list(look.outline_mm), colors=INK, linewidths=linewidth))
    axes.add_collection(LineCollection(list(look.insert_mm), colors=COLOURS[0], linewidths=linewidth))
    axes.set(xlim=limits[:, 0], ylim=limits[:, 1], aspect="equal")


def draw_views(axes: list[Axes], picture: MillPicture) -> None:
    """The mill from above and from the side at the start of a turn."""
    for axis, view, look, limits in zip(axes, picture.views, picture.looks, picture.limits_mm, strict=True):
        _draw(axis, look, limits)
        axis.set(xlabel=f"{'xyz'[view.right]} [mm]", ylabel=f"{'xyz'[view.up]} [mm]")
        axis.set_title(view.title, loc="left", fontsize=7)


def plot_geometry(picture: MillPicture) -> Figure:
    """The mill from above and from the side: exact walls grey, facets that look round yellowish, inserts blue."""
    figure, axes = plt.subplots(2, 1, figsize=(COLUMN_WIDTH_IN, 4.6))
    draw_views(list(axes), picture)
    figure.suptitle(f"{no_formula(picture.title)}\n{picture.walls}", fontsize=8)
    return figure


def draw_strip(axes: list[Axes], picture: MillPicture) -> None:
    """Moments of a turn side by side, with the path of a marked point of the wall."""
    for number, (axis, look) in enumerate(zip(axes, picture.strip, strict=True)):
        _draw(axis, look, picture.strip_limits_mm, 0.4)
        axis.plot(*picture.path_mm.T, color=COLOURS[1], linewidth=0.5)
        axis.plot(*look.mark_mm, "o", color=COLOURS[1], markersize=2.5)
        axis.set_title(f"{number / len(picture.strip):.3g} turn", fontsize=6, pad=2)
        axis.tick_params(labelsize=5, length=2)
        if number % 4:
            axis.set_yticklabels([])
        else:
            axis.set_ylabel(f"{'xyz'[picture.strip_view.up]} [mm]", fontsize=6)
        if number < len(axes) - 4:
            axis.set_xticklabels([])
        else:
            axis.set_xlabel(f"{'xyz'[picture.strip_view.right]} [mm]", fontsize=6)


def plot_motion(picture: MillPicture) -> Figure:
    """Eight moments of one turn of the mill, in the view that shows most of its motion."""
    size = np.ptp(picture.strip_limits_mm, axis=0)
    height = min(6.5, 0.8 + 2 * (COLUMN_WIDTH_IN - 0.6) / 4 * size[1] / size[0])
    figure, axes = plt.subplots(2, 4, figsize=(COLUMN_WIDTH_IN, max(height, 1.6)))
    draw_strip(list(axes.flat), picture)
    figure.suptitle(f"{no_formula(picture.title)}, {picture.strip_view.title}", fontsize=7)
    return figure


def plot_collapse(collapse: pd.DataFrame, largest: float) -> Figure:
    """Spread of the power per ball of several mills: before scaling, by the thesis's exponents, by their own.

    collapse: power_spread_before, power_spread_thesis, power_spread_own of each mill; largest: largest spread that
    counts as a collapse.
    """
    figure, axis = plt.subplots(figsize=(COLUMN_WIDTH_IN, 0.9 + 0.3 * len(collapse)))
    places = np.arange(len(collapse))
    for number, (name, label) in enumerate(
        {"before": "before scaling", "thesis": "by the scaling law", "own": "exponents of its own"}.items()
    ):
        axis.plot(collapse[f"power_spread_{name}"], places, MARKERS[number], color=COLOURS[number], label=label)
    axis.axvline(largest, color="0.5", linestyle="--", linewidth=0.8)
    axis.set(xlabel="spread of log power per ball [-]", xscale="log")
    axis.set_yticks(places, collapse["mill"])
    axis.set_ylabel("mill")
    axis.invert_yaxis()
    figure.legend(loc="outside lower center", ncols=2, fontsize=7)
    return figure


def plot_scale_up(sheet: pd.DataFrame) -> Figure:
    """Ratios of the large mill to the small one, for each way to run it: what stays the same and what changes."""
    quantities = {
        "weighted_normal_energy_ratio": "weighted normal\nenergy E*n",
        "weighted_normal_frequency_ratio": "weighted normal\nfrequency f*n",
        "specific_power_ratio": "power over mass\nof balls",
    }
    figure, axes = plt.subplots(len(quantities), 1, figsize=(COLUMN_WIDTH_IN, 4.4), sharex=True)
    places = np.arange(len(sheet))
    for axis, (quantity, label) in zip(axes, quantities.items(), strict=True):
        axis.axhline(1.0, color="0.5", linewidth=0.8)
        axis.plot(places, sheet[quantity], "o", color=COLOURS[0])
        axis.set(ylabel=f"{label} [-]", yscale="log")
        axis.yaxis.label.set_fontsize(7)
    axes[-1].set_xticks(places, [name.replace(", ", ",\n") for name in sheet["keeps"]], fontsize=6)
    axes[-1].set_xlabel("what is kept")
    return figure


# A4, the sheet of one page [inch].
SHEET_IN = (8.27, 11.69)
# Quantities whose exponents and spread are on the page; the table of the sheet has more.
SCALED_ON_PAGE = (
    *("wall power per ball", "weighted normal energy", "weighted tangential energy"),
    *("weighted normal frequency", "weighted tangential frequency", "specific frequency"),
)
# With more speeds and ball sizes than this, all conditions have one marker.
MOST_SETTINGS = 12
# Each of the two columns of text: characters in a line of names and texts, size [pt], lines of it.
WIDTHS, LETTERS, ROOM = (34, 62), 5.8, 38
# What a row of text says about what; None in its place makes a heading.
Said = tuple[str, str | None]
# Columns of a sheet for the two bands.
SHEET_ENDS = {"scatter": ["lower", "upper"], "mean": ["mean_lower", "mean_upper"]}
# Line styles of the ends of intervals, one for each origin of FURTHER.
FURTHER_LINES = ("--", ":")


def _draw_conditions(
    axis: Axes, quantity: str, descriptors: pd.DataFrame, curves: pd.DataFrame, speed_unit: str
) -> None:
    """One master curve with its intervals and the simulated conditions, a marker per speed and ball size."""
    draw_curve(axis, curves, quantity, "master curve")
    for (origin, (title, _)), style in zip(FURTHER.items(), FURTHER_LINES, strict=True):
        ends = [name for name in columns_of(quantity, origin) if name in curves]
        for end, label in zip(ends, (f"by {title}", None), strict=False):
            axis.plot(curves["fill_ratio"], curves[end], style, color=COLOURS[0], linewidth=0.8, label=label)
    settings = descriptors.groupby([CHARGE, "ball_diameter_mm", "speed_rpm"])
    if settings.ngroups > MOST_SETTINGS:
        label = f"{len(descriptors)} simulated conditions"
        axis.plot(descriptors["fill_ratio"], descriptors[quantity], ".", markersize=3, color=COLOURS[1], label=label)
        settings = []
    for number, ((charge, diameter, speed), line) in enumerate(settings):
        axis.plot(
            line["fill_ratio"], line[quantity], MARKERS[number % len(MARKERS)], markersize=3.5,
            color=COLOURS[1 + number % (len(COLOURS) - 1)],
            label=f"{balls_in_words(diameter, charge)}, {shown_speed(speed_unit, speed / 60)}",
        )  # fmt: skip
    axis.set(xlabel=FILL_LABEL, ylabel=DESCRIPTORS[quantity].label, ylim=(0, None))
    axis.yaxis.label.set_fontsize(7)


def _unit(unit: str) -> str:
    """A unit as written after a number; a plain number has none."""
    return "" if unit == "-" else f" {unit}"


def _number(value: float) -> str:
    return NOT_KNOWN if value is None else three(value)


def _quantity(row: Any, *intervals: tuple[float, float]) -> str:
    """A value with its intervals, three digits each and one SI prefix: "143 µJ (126 to 162; 140 to 146)"."""
    factor, unit = prefix_of(row.value, row.unit)
    ends = "; ".join(_between(factor * low, factor * high) for low, high in intervals)
    return f"{_number(factor * row.value)}{_unit(unit)}{f' ({ends})' if ends else ''}"


def _columns_of(sheet: pd.DataFrame) -> tuple[list[Said], list[Said]]:
    """The text of a sheet in two columns: the mill, the condition and its descriptors; exponents and validity."""
    left: list[Said] = [("The mill", None)]
    for section, title in (("mill", ""), ("condition", "Condition, one that was simulated")):
        left += [(title, None)] if title else []
        for row in sheet[sheet["section"] == section].itertuples():
            if row.quantity != "name":
                given = row.text if isinstance(row.text, str) and row.text else f"{plain(row.value)}{_unit(row.unit)}"
                left.append((row.quantity, given))
    # With several intervals the descriptors are in a separate table.
    sections = ["dose"] if _has_intervals(sheet) else ["descriptors", "dose"]
    left.append((f"Value (band of {ORIGINS['scatter'].title}; of {ORIGINS['mean'].title})", None))
    for row in sheet[sheet["section"].isin(sections)].itertuples():
        said = [row.text] if isinstance(row.text, str) and row.text else []
        if row.value is not None and not np.isnan(row.value):
            said = [_quantity(row, (row.lower, row.upper), (row.mean_lower, row.mean_upper)), *said]
        left.append((row.quantity, ", ".join(said) or NOT_KNOWN))
    left += _temperatures(sheet)
    right = [*_exponents(sheet), *_collapse(sheet), ("Holds from - to", None)]
    for row in sheet[(sheet["section"] == "validity") & sheet["lower"].notna()].itertuples():
        right.append((row.quantity, f"{_between(row.lower, row.upper, plain)}{_unit(row.unit)}"))
    for further in (_precision(sheet[sheet["section"] == "precision"]), _atlas(sheet)):
        min(left, right, key=len).extend(further)
    return left, right


def _temperatures(sheet: pd.DataFrame) -> list[Said]:
    """Temperatures after long milling, if the sheet has them."""
    rows = list(sheet[sheet["section"] == TEMPERATURE].itertuples())
    if not rows:
        return []
    words = [(row.quantity, row.text if row.text == row.text and row.text else _degrees(row)) for row in rows]
    return [("After long milling without a pause", None), *words]


def _atlas(sheet: pd.DataFrame) -> list[Said]:
    """What the atlas says at the condition, if the sheet has it, with the verdict on the simulation."""
    rows = list(sheet[sheet["section"] == ATLAS].itertuples())
    if not rows:
        return []
    said = [(row.quantity, f"{_quantity(row, (row.lower, row.upper))}; {row.text}") for row in rows]
    return [("The atlas, which simulates nothing (interval of 90 %); verdict on the simulation", None), *said]


def _degrees(row: Any) -> str:
    return f"{row.value:.0f} °C ({row.lower:.0f} to {row.upper:.0f})"


def _exponents(sheet: pd.DataFrame) -> list[Said]:
    """The exponents of each quantity that the sweep can tell, with the interval and the exponent of the scaling law."""
    exponents = sheet[sheet["section"] == "exponents"]
    if exponents["value"].isna().all():
        return [("Exponents", None), ("not known", "no fill ratio has two speeds or two ball sizes")]
    found: list[Said] = [("Exponents (interval; of the scaling law)", None)]
    for title in SCALED_ON_PAGE:
        words = []
        for row in exponents[exponents["quantity"].str.startswith(f"{title}:")].dropna(subset="value").itertuples():
            variable, supposed = row.quantity.removeprefix(f"{title}: "), row.text.removeprefix("scaling law: ")
            words.append(f"{variable} {_number(row.value)} ({_between(row.lower, row.upper)}; {supposed})")
        found.append((title, ", ".join(words) or NOT_KNOWN))
    return found


def _collapse(sheet: pd.DataFrame) -> list[Said]:
    """By which factor the conditions at a fill ratio differ, before and after scaling."""
    rows = sheet[sheet["section"] == "collapse"]
    if rows["value"].isna().all():
        return [("Curves", None), ("collapse", rows["text"].iloc[-1])]
    found: list[Said] = [("Curves differ by a factor of: unscaled, by the scaling law, by their own exponents", None)]
    for title in SCALED_ON_PAGE:
        own = rows[rows["quantity"].str.startswith(f"{title}:")]
        factors = ", ".join(map(_number, np.exp(own["value"].astype(float))))
        found.append((title, f"{factors}; {own['text'].iloc[-1]}"))
    return found


def _between(lower: float, upper: float, number: Callable[[float], str] = three) -> str:
    """A range, or a number if both ends are equal; `not known` if an end is not."""
    if np.isnan(lower + upper):
        return NOT_KNOWN
    return " to ".join(dict.fromkeys((number(lower), number(upper))))


def _precision(section: pd.DataFrame) -> list[Said]:
    """Time and seeds of a condition, the resulting intervals, and the key that narrows them."""
    said = section.set_index("quantity")
    recorded, seeds = (
        _between(said.at[name, "lower"], said.at[name, "upper"], plain) for name in (RECORDED, SIMULATED)
    )
    columns = ["value", "lower", "upper"]
    widths = {
        place: ", ".join(f"{name} {_width(*said.loc[f'{name}, {place}', columns])}" for name in STATED.values())
        for place in WHERE
    }
    return [
        ("Precision: a new simulation is known to within", None),
        *widths.items(),
        ("recorded", f"{recorded} s"),
        ("simulations of a condition", seeds),
        *((motion.word, said.at[motion.word, "text"]) for motion in MOTIONS.values() if motion.word in said.index),
        *((name, said.at[name, "text"]) for name in said.index if name.startswith("no curve")),
        ("for more, and for what is not known", said.at["for more", "text"]),
    ]


def _width(median: float, smallest: float, largest: float) -> str:
    """Half the width of a band [%], the median and the range."""
    known = [NOT_KNOWN if np.isnan(width) else f"{width:.0f}" for width in (smallest, largest)]
    return NOT_KNOWN if np.isnan(median) else f"{median:.0f} % ({' to '.join(known)})"


def _has_intervals(sheet: pd.DataFrame) -> bool:
    """Whether a sheet has intervals by origin."""
    return bool((sheet["section"] == "intervals").any())


def _draw_intervals(axis: Axes, sheet: pd.DataFrame) -> None:
    """Descriptors with a column for each origin of intervals, and a line that explains each."""

    def between(row: pd.Series, lower: str, upper: str) -> str:
        factor, _ = prefix_of(row["value"], row["unit"])
        return _between(factor * row[lower], factor * row[upper])

    rows = sheet[sheet["section"] == "descriptors"]
    columns = {ORIGINS[name].title: ends for name, ends in SHEET_ENDS.items()}
    # A column for each origin that is known of at least one descriptor.
    further = {title: by_columns(origin) for origin, (title, _) in FURTHER.items()}
    columns |= {title: ends for title, ends in further.items() if rows[ends].notna().any(axis=None)}
    cells = [
        [row["quantity"], _quantity(row), *(between(row, *ends) for ends in columns.values())]
        for _, row in rows.iterrows()
    ]
    draw_table(axis, ["At this condition", "value", *columns], cells, LETTERS, room=0.66)
    said = sheet[sheet["section"] == "intervals"]
    lines = [f"{row.quantity}: {row.text}" for row in said.itertuples()]
    lines.append("the intervals are not added up: each is for one origin, all else as simulated")
    axis.text(0, 0.28, "\n".join(lines), va="top", fontsize=LETTERS, transform=axis.transAxes, linespacing=1.35)


def _draw_spectra(part: SubFigure, sheet: pd.DataFrame, spectra: pd.DataFrame, read_off: pd.DataFrame) -> None:
    """Energy spectra of the simulated condition nearest to the sheet's, or the reason why there are none."""
    told = sheet[sheet["section"] == SPECTRA].set_index("quantity")
    if not len(spectra):
        axis = part.subplots()
        axis.axis("off")
        reason = f"No energy spectra: {told.at[NO_SPECTRA, 'text']}"
        axis.text(0.5, 0.5, textwrap.fill(reason, sum(WIDTHS)), ha="center")
        return
    draw_sheet_spectra(axes := list(part.subplots(1, 2)), spectra, read_off[read_off["pair"] == BOTH])
    axes[0].set_title(f"Energy spectra at fill {told.at[SPECTRA_FILL, 'value']:g}", loc="left", fontsize=7)
    axes[1].set_title("dotted: half of the power is above this energy", loc="left", fontsize=7)
    legend_below(part, axes[:1], 4, fontsize=7)


def plot_sheet(
    picture: MillPicture,
    sheet: pd.DataFrame,
    descriptors: pd.DataFrame,
    curves: pd.DataFrame,
    spectra: pd.DataFrame,
    read_off: pd.DataFrame,
) -> Figure:
    """The fingerprint of a mill on one page: picture, motion, descriptors, spectra, master curves, exponents, range.

    sheet: as of tabulate_sheet; descriptors: of the mill as built; curves: fill_ratio, Q, Q_lower, Q_upper, and the
    columns of further intervals if there are any; spectra, read_off: for the sheet's condition, as of
    `dose.spectra_shown.of_sheet`.
    """
    figure = plt.figure(figsize=SHEET_IN)
    figure.suptitle(
        f"Mechanical fingerprint: {no_formula(picture.title)}", fontsize=13, fontweight="bold", x=0.01, ha="left"
    )
    heights = [0.65, 1.28, 0.72, 0.55, 1.0] if _has_intervals(sheet) else [0.72, 1.44, 0.63, 1.14]
    top, middle, *between, energies, bottom = figure.subfigures(
        len(heights), 1, squeeze=False, height_ratios=heights
    ).flat
    for part in between:
        _draw_intervals(part.subplots(), sheet)
    views, strip = top.subfigures(1, 2, width_ratios=[1.0, 1.25])
    draw_views(list(views.subplots(1, 2)), picture)
    draw_strip(list(strip.subplots(2, 4).flat), picture)
    for axis, column in zip(middle.subplots(1, 2), _columns_of(sheet), strict=True):
        write_rows(axis, column, WIDTHS, LETTERS, ROOM if len(heights) == 4 else ROOM - 6)
    _draw_spectra(energies, sheet, spectra, read_off)
    axes = bottom.subplots(2, 2)
    for axis, quantity in zip(axes.flat, SHEET_PANELS, strict=True):
        _draw_conditions(axis, quantity, descriptors, curves, picture.speed_unit)
    legend_below(bottom, axes.flat[:1], 4, fontsize=7)
    return figure
