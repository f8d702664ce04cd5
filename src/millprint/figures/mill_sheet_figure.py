"""The fingerprint of a mill on one page."""

import textwrap
from collections.abc import Callable
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure, SubFigure
from matplotlib.transforms import Bbox

from millprint.config.mixture import balls_in_words
from millprint.dose.spectra import BOTH
from millprint.dose.spectra_shown import FILL as SPECTRA_FILL
from millprint.dose.spectra_shown import NOTE as NO_SPECTRA
from millprint.dose.spectra_shown import SECTION as SPECTRA
from millprint.dose.spectra_shown import TEMPERATURE
from millprint.figures.dose_figures import draw_sheet_spectra
from millprint.figures.mill_pictures import draw_strip, draw_views
from millprint.figures.style import COLOURS, FILL_LABEL, MARKERS, draw_curve, legend_below, plt
from millprint.fingerprint.bands import FURTHER, MEAN, NOT_KNOWN, SCATTER, interval_columns
from millprint.fingerprint.columns import DESCRIPTORS
from millprint.fingerprint.condition import SHEET_PANELS
from millprint.fingerprint.descriptors import CHARGE, MOTIONS
from millprint.fingerprint.mill_sheet import RECORDED, SIMULATED, STATED, by_columns, shown_speed
from millprint.run.numbers import plain, prefix_of, three
from millprint.view.mill_picture import MillPicture

# A4, the sheet of one page [inch].
SHEET_IN = (8.27, 11.69)
# Quantities whose exponents and spread are on the page; the table of the sheet has more.
SCALED_ON_PAGE = (
    *("power per ball", "weighted normal energy", "weighted tangential energy"),
    *("weighted normal frequency", "weighted tangential frequency", "specific frequency"),
)
# With more speeds and ball sizes than this, all conditions have one marker.
MOST_SETTINGS = 12
# Each of the two columns of text: characters in a line, lines that fit, and font size [pt].
LINE, ROOM, LETTERS = 94, 36, 6.0
# Line styles of the ends of intervals, one for each origin of FURTHER.
FURTHER_LINES = ("--", ":")


def _draw_conditions(
    axis: Axes, quantity: str, descriptors: pd.DataFrame, curves: pd.DataFrame, speed_unit: str
) -> None:
    """One master curve with its intervals and the simulated conditions, a marker per speed and ball size."""
    draw_curve(axis, curves, quantity, "master curve")
    for (origin, (title, _)), style in zip(FURTHER.items(), FURTHER_LINES, strict=True):
        ends = [name for name in interval_columns(quantity, origin) if name in curves]
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
    return NOT_KNOWN if value is None or np.isnan(value) else three(value)


def _quantity(row: Any, *intervals: tuple[float, float]) -> str:
    """A value with its intervals, three digits each and one SI prefix: "143 µJ (126 to 162; 140 to 146)"."""
    factor, unit = prefix_of(row.value, row.unit)
    ends = "; ".join(_between(factor * low, factor * high) for low, high in intervals)
    return f"{_number(factor * row.value)}{_unit(unit)}{f' ({ends})' if ends else ''}"


def _lines_of(sheet: pd.DataFrame) -> tuple[list[str], list[str]]:
    """The text of a sheet in two columns: the mill, the condition and its descriptors; exponents and validity."""
    left = []
    for row in sheet[sheet["section"].isin(["mill", "condition"])].itertuples():
        if row.quantity != "name":
            given = row.text if isinstance(row.text, str) and row.text else f"{plain(row.value)}{_unit(row.unit)}"
            left.append(f"{row.quantity}: {given}")
    # With several intervals the descriptors are in a separate table.
    sections = ["dose"] if _has_intervals(sheet) else ["descriptors", "dose"]
    left += ["", f"value (band of {SCATTER.title}; of {MEAN.title})"]
    for row in sheet[sheet["section"].isin(sections)].itertuples():
        left.append(f"{row.quantity}: {_quantity(row, (row.lower, row.upper), (row.mean_lower, row.mean_upper))}")
    left += ["", *_temperature_lines(sheet)]
    right = [*_exponent_lines(sheet), "", *_collapse_lines(sheet), "", "holds from - to"]
    for row in sheet[(sheet["section"] == "validity") & sheet["lower"].notna()].itertuples():
        right.append(f"  {row.quantity}: {_between(row.lower, row.upper, plain)}{_unit(row.unit)}")
    columns = _wrapped(left), _wrapped(right)
    min(columns, key=len).extend(["", *_wrapped(_precision_lines(sheet[sheet["section"] == "precision"]))])
    return columns


def _wrapped(lines: list[str]) -> list[str]:
    """Lines of text, broken where they are too long for a column."""
    return [part for line in lines for part in textwrap.wrap(line, LINE, subsequent_indent="  ") or [""]]


def _temperature_lines(sheet: pd.DataFrame) -> list[str]:
    """Temperatures after long milling, if the sheet has them."""
    rows = list(sheet[sheet["section"] == TEMPERATURE].itertuples())
    if not rows:
        return []
    words = [row.text if row.text == row.text and row.text else f"{row.quantity} {_degrees(row)}" for row in rows]
    return [f"after long milling without a pause: {', '.join(words)}"]


def _degrees(row: Any) -> str:
    return f"{row.value:.0f} °C ({row.lower:.0f} to {row.upper:.0f})"


def _exponent_lines(sheet: pd.DataFrame) -> list[str]:
    """The exponents of each quantity that the sweep can tell, with the interval and the exponent of the scaling law."""
    exponents = sheet[sheet["section"] == "exponents"]
    if exponents["value"].isna().all():
        return ["exponents: not known; no fill ratio has two speeds or two ball sizes"]
    lines = ["exponents (interval; of the scaling law)"]
    for title in SCALED_ON_PAGE:
        words = []
        for row in exponents[exponents["quantity"].str.startswith(f"{title}:")].dropna(subset="value").itertuples():
            variable, supposed = row.quantity.removeprefix(f"{title}: "), row.text.removeprefix("scaling law: ")
            words.append(f"{variable} {_number(row.value)} ({_between(row.lower, row.upper)}; {supposed})")
        lines.append(f"  {title}: {', '.join(words)}")
    return lines


def _collapse_lines(sheet: pd.DataFrame) -> list[str]:
    """By which factor the conditions at a fill ratio differ, before and after scaling."""
    rows = sheet[sheet["section"] == "collapse"]
    if rows["value"].isna().all():
        return [f"curves: {rows['text'].iloc[-1]}"]
    lines = ["curves differ by a factor of: before scaling, after the scaling law, after their own exponents"]
    for title in SCALED_ON_PAGE:
        own = rows[rows["quantity"].str.startswith(f"{title}:")]
        factors = ", ".join(map(_number, np.exp(own["value"].astype(float))))
        lines.append(f"  {title}: {factors}; {own['text'].iloc[-1]}")
    return lines


def _between(lower: float, upper: float, number: Callable[[float], str] = three) -> str:
    """A range, or a number if both ends are equal; `not known` if an end is not."""
    if np.isnan(lower + upper):
        return NOT_KNOWN
    return " to ".join(dict.fromkeys((number(lower), number(upper))))


def _precision_lines(section: pd.DataFrame) -> list[str]:
    """Time and seeds of a condition, the resulting intervals, and the key that narrows them."""
    said = section.set_index("quantity")
    recorded, seeds = (
        _between(said.at[name, "lower"], said.at[name, "upper"], plain) for name in (RECORDED, SIMULATED)
    )
    columns = ["value", "lower", "upper"]
    widths = ", ".join(f"{name} {_width(*said.loc[name, columns])}" for name in STATED.values())
    return [
        f"precision: {recorded} s recorded, simulations of a condition: {seeds}",
        f"a new simulation within these ranges is known to within: {widths}",
        *(f"{motion.word}: {said.at[motion.word, 'text']}" for motion in MOTIONS.values() if motion.word in said.index),
        f"for more: {said.at['for more', 'text']}",
    ]


def _width(median: float, smallest: float, largest: float) -> str:
    """Half the width of a band [%], the median and the range."""
    known = [NOT_KNOWN if np.isnan(width) else f"{width:.0f}" for width in (smallest, largest)]
    return NOT_KNOWN if np.isnan(median) else f"{median:.0f} % ({' to '.join(known)})"


def _has_intervals(sheet: pd.DataFrame) -> bool:
    """Whether a sheet has intervals by origin."""
    return bool((sheet["section"] == "intervals").any())


def draw_table(axis: Axes, cells: list[list[str]], titles: list[str], place: Bbox) -> None:
    """A table of values with four intervals each."""
    table = axis.table(
        cells, colLabels=titles, colWidths=[0.25, 0.11, 0.16, 0.16, 0.16, 0.16], cellLoc="left", edges="horizontal",
        bbox=place,
    )  # fmt: skip
    table.auto_set_font_size(False)
    table.set_fontsize(6.5)


def _draw_intervals(axis: Axes, sheet: pd.DataFrame) -> None:
    """Descriptors with a column for each origin of intervals, and a line that explains each."""
    axis.axis("off")

    def between(row: pd.Series, lower: str, upper: str) -> str:
        factor, _ = prefix_of(row["value"], row["unit"])
        return _between(factor * row[lower], factor * row[upper])

    columns = {SCATTER.title: ["lower", "upper"], MEAN.title: ["mean_lower", "mean_upper"]}
    columns |= {title: by_columns(origin) for origin, (title, _) in FURTHER.items()}
    cells = [
        [row["quantity"], _quantity(row), *(between(row, *ends) for ends in columns.values())]
        for _, row in sheet[sheet["section"] == "descriptors"].iterrows()
    ]
    draw_table(axis, cells, ["at this condition", "value", *columns], Bbox.from_bounds(0, 0.34, 1, 0.66))
    said = sheet[sheet["section"] == "intervals"]
    lines = [f"{row.quantity}: {row.text}" for row in said.itertuples()]
    lines.append("the intervals are not added up: each is for one origin, all else as simulated")
    axis.text(0, 0.28, "\n".join(lines), va="top", fontsize=6.5, transform=axis.transAxes, linespacing=1.35)


def _draw_spectra(part: SubFigure, sheet: pd.DataFrame, spectra: pd.DataFrame, read_off: pd.DataFrame) -> None:
    """Energy spectra of the simulated condition nearest to the sheet's, or the reason why there are none."""
    told = sheet[sheet["section"] == SPECTRA].set_index("quantity")
    if not len(spectra):
        axis = part.subplots()
        axis.axis("off")
        axis.text(0.5, 0.5, textwrap.fill(f"No energy spectra: {told.at[NO_SPECTRA, 'text']}", LINE), ha="center")
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
    figure.suptitle(f"Mechanical fingerprint: {picture.title}", fontsize=12)
    heights = [0.7, 1.08, 0.78, 0.55, 1.08] if _has_intervals(sheet) else [0.75, 1.3, 0.66, 1.2]
    top, middle, *between, energies, bottom = figure.subfigures(
        len(heights), 1, squeeze=False, height_ratios=heights
    ).flat
    for part in between:
        _draw_intervals(part.subplots(), sheet)
    views, strip = top.subfigures(1, 2, width_ratios=[1.0, 1.25])
    draw_views(list(views.subplots(1, 2)), picture)
    draw_strip(list(strip.subplots(2, 4).flat), picture)
    columns = _lines_of(sheet)
    size = LETTERS * min(1.0, ROOM / max(map(len, columns)))
    for axis, column in zip(middle.subplots(1, 2), columns, strict=True):
        axis.axis("off")
        axis.text(0, 1, "\n".join(column), va="top", fontsize=size, transform=axis.transAxes, linespacing=1.25)
    _draw_spectra(energies, sheet, spectra, read_off)
    axes = bottom.subplots(2, 2)
    for axis, quantity in zip(axes.flat, SHEET_PANELS, strict=True):
        _draw_conditions(axis, quantity, descriptors, curves, picture.speed_unit)
    legend_below(bottom, axes.flat[:1], 4, fontsize=7)
    return figure
