"""Figures of any mill: its geometry, a strip of its motion, its fingerprint sheet, the collapse of several."""

import textwrap

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.figure import Figure, SubFigure
from matplotlib.transforms import Bbox

from millprint.config.mixture import balls_in_words
from millprint.dose.spectra import BOTH
from millprint.dose.spectra_shown import FILL as SPECTRA_FILL
from millprint.dose.spectra_shown import NOTE as NO_SPECTRA
from millprint.dose.spectra_shown import SECTION as SPECTRA
from millprint.figures.chapter3 import FILL_LABEL, draw_curve
from millprint.figures.spectra import draw_sheet_spectra
from millprint.figures.style import COLOURS, COLUMN_WIDTH_IN, MARKERS, legend_below, plt
from millprint.fingerprint.bands import FURTHER, SCATTER, interval_columns
from millprint.fingerprint.columns import DESCRIPTORS
from millprint.fingerprint.curves import PANELS
from millprint.fingerprint.descriptors import CHARGE
from millprint.fingerprint.mill_sheet import by_columns
from millprint.view.mill_picture import Look, MillPicture

INK, DARK, LIGHT = "#303030", 0.74, 0.96
# A4, the sheet of one page [inch].
LINE = 84  # letters of a line in one of the two columns of text
SHEET_IN = (8.27, 11.69)
# Lines of the ends of an interval in a figure, an origin of FURTHER each.
FURTHER_LINES = ("--", ":")


def _draw(axes: Axes, look: Look, limits: np.ndarray, linewidth: float = 0.7) -> None:
    """A mill in one view: walls that face the eye, outlines, and the inserts over them."""
    grey = np.repeat((DARK + (LIGHT - DARK) * look.wall_shade)[:, None], 3, axis=1)
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
    """The mill from above and from the side, inserts in blue."""
    figure, axes = plt.subplots(2, 1, figsize=(COLUMN_WIDTH_IN, 4.6))
    draw_views(list(axes), picture)
    figure.suptitle(picture.title, fontsize=8)
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
    figure.suptitle(f"{picture.title}, {picture.strip_view.title}", fontsize=7)
    return figure


def _draw_conditions(axis: Axes, quantity: str, descriptors: pd.DataFrame, curves: pd.DataFrame) -> None:
    """One master curve with its intervals, and the conditions that it was made of, a marker a speed and ball size."""
    draw_curve(axis, curves, quantity, "master curve")
    for (origin, (title, _)), style in zip(FURTHER.items(), FURTHER_LINES, strict=True):
        ends = [name for name in interval_columns(quantity, origin) if name in curves]
        for end, label in zip(ends, (f"by {title}", None), strict=False):
            axis.plot(curves["fill_ratio"], curves[end], style, color=COLOURS[0], linewidth=0.8, label=label)
    settings = descriptors.groupby([CHARGE, "ball_diameter_mm", "speed_rpm"])
    for number, ((charge, diameter, speed), line) in enumerate(settings):
        axis.plot(
            line["fill_ratio"], line[quantity], MARKERS[number % len(MARKERS)], markersize=3.5,
            color=COLOURS[1 + number % (len(COLOURS) - 1)], label=f"{balls_in_words(diameter, charge)}, {speed:g} rpm",
        )  # fmt: skip
    axis.set(xlabel=FILL_LABEL, ylabel=DESCRIPTORS[quantity].label, ylim=(0, None))
    axis.yaxis.label.set_fontsize(7)


def _unit(unit: str) -> str:
    """A unit as written after a number; a plain number has none."""
    return "" if unit == "-" else f" {unit}"


def _number(value: float) -> str:
    if value is None or np.isnan(value):
        return "-"
    return f"{value:.0f}" if 100 <= abs(value) < 1e5 else f"{value:.3g}"


def _lines_of(sheet: pd.DataFrame) -> tuple[str, str]:
    """The text of a sheet in two columns: the mill, the condition and its descriptors; exponents and validity."""
    left, right = [], []
    for row in sheet[sheet["section"].isin(["mill", "condition"])].itertuples():
        given = row.text if isinstance(row.text, str) and row.text else f"{_number(row.value)}{_unit(row.unit)}"
        if row.quantity != "name":
            left += textwrap.wrap(f"{row.quantity}: {given}", LINE, subsequent_indent="  ")
    left.append("")
    # With several intervals they are a table of their own.
    described = sheet[sheet["section"] == "descriptors"] if not _has_intervals(sheet) else sheet[:0]
    for row in described.itertuples():
        left.append(
            f"{row.quantity}: {_number(row.value)} ({_number(row.lower)} to {_number(row.upper)}){_unit(row.unit)}"
        )
    right.append("exponents (interval; of the thesis)")
    for row in sheet[sheet["section"] == "exponents"].itertuples():
        supposed = row.text.removeprefix("the thesis has ")
        interval = f"{_number(row.lower)} to {_number(row.upper)}"
        right.append(f"  {row.quantity}: {_number(row.value)} ({interval}; {supposed})")
    right += ["", "spread of power per ball, before: after the thesis's scaling: after its own"]
    for title in ("power per ball", "frequency per ball"):
        rows = sheet[(sheet["section"] == "collapse") & sheet["quantity"].str.startswith(f"{title}:")]
        values = " : ".join(_number(value) for value in rows["value"])
        right.append(f"  {title} {values}; {rows['text'].iloc[-1]}")
    right += ["", "holds from - to"]
    for row in sheet[(sheet["section"] == "validity") & sheet["lower"].notna()].itertuples():
        right.append(f"  {row.quantity}: {_number(row.lower)} to {_number(row.upper)}{_unit(row.unit)}")
    return "\n".join(left), "\n".join(right)


def _has_intervals(sheet: pd.DataFrame) -> bool:
    """Whether a sheet tells intervals by origin."""
    return bool((sheet["section"] == "intervals").any())


def _draw_intervals(axis: Axes, sheet: pd.DataFrame) -> None:
    """Descriptors with a column for each origin of intervals, and a line that explains each."""
    axis.axis("off")

    def between(row: pd.Series, lower: str, upper: str) -> str:
        return "-" if np.isnan(row[lower]) else f"{_number(row[lower])} to {_number(row[upper])}"

    columns = {SCATTER.title: ["lower", "upper"]}
    columns |= {title: by_columns(origin) for origin, (title, _) in FURTHER.items()}
    cells = [
        [row["quantity"], f"{_number(row['value'])}{_unit(row['unit'])}", *(between(row, *c) for c in columns.values())]
        for _, row in sheet[sheet["section"] == "descriptors"].iterrows()
    ]
    table = axis.table(
        cells, colLabels=["at this condition", "value", *columns], colWidths=[0.28, 0.15, 0.19, 0.19, 0.19],
        cellLoc="left", edges="horizontal", bbox=Bbox.from_bounds(0, 0.45, 1, 0.55),
    )  # fmt: skip
    table.auto_set_font_size(False)
    table.set_fontsize(6.5)
    said = sheet[sheet["section"] == "intervals"]
    lines = [f"{row.quantity}: {row.text}" for row in said.itertuples()]
    lines.append("the intervals are not added up: each is that of its own origin, all else as simulated")
    axis.text(0, 0.36, "\n".join(lines), va="top", fontsize=6.5, transform=axis.transAxes, linespacing=1.35)


def _draw_spectra(part: SubFigure, sheet: pd.DataFrame, spectra: pd.DataFrame, read_off: pd.DataFrame) -> None:
    """Energy spectra of the simulated condition next to that of the sheet, or the line that says why there are none."""
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

    sheet: as of tabulate_sheet; descriptors: those of the mill as built; curves: fill_ratio, Q, Q_lower, Q_upper, and
    the columns of further intervals if there are any; spectra, read_off: those of the sheet's condition, as of
    `dose.spectra_shown.of_sheet`.
    """
    figure = plt.figure(figsize=SHEET_IN)
    figure.suptitle(f"Mechanical fingerprint: {picture.title}", fontsize=12)
    heights = [0.8, 0.95, 0.52, 0.62, 1.3] if _has_intervals(sheet) else [0.85, 1.0, 0.68, 1.35]
    top, middle, *between, energies, bottom = figure.subfigures(
        len(heights), 1, squeeze=False, height_ratios=heights
    ).flat
    for part in between:
        _draw_intervals(part.subplots(), sheet)
    views, strip = top.subfigures(1, 2, width_ratios=[1.0, 1.25])
    draw_views(list(views.subplots(1, 2)), picture)
    draw_strip(list(strip.subplots(2, 4).flat), picture)
    left, right = _lines_of(sheet)
    text = middle.subplots(1, 2)
    for axis, column in zip(text, (left, right), strict=True):
        axis.axis("off")
        axis.text(0, 1, column, va="top", fontsize=6.5, transform=axis.transAxes, linespacing=1.35)
    _draw_spectra(energies, sheet, spectra, read_off)
    axes = bottom.subplots(2, 2)
    for axis, quantity in zip(axes.flat, PANELS, strict=True):
        _draw_conditions(axis, quantity, descriptors, curves)
    legend_below(bottom, axes.flat[:1], 4, fontsize=7)
    return figure


def plot_collapse(collapse: pd.DataFrame, largest: float) -> Figure:
    """Spread of the power per ball of several mills: before scaling, by the thesis's exponents, by their own.

    collapse: a row a mill, power_spread_before, power_spread_thesis, power_spread_own; largest: spread of a collapse.
    """
    figure, axis = plt.subplots(figsize=(COLUMN_WIDTH_IN, 0.9 + 0.3 * len(collapse)))
    places = np.arange(len(collapse))
    for number, (name, label) in enumerate(
        {"before": "before scaling", "thesis": "exponents of the thesis", "own": "exponents of its own"}.items()
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
    """Ratios of the large mill over the small one, for each way to run it: what is kept and what changes."""
    quantities = {
        "normal_energy_ratio": "normal energy\nof a collision",
        "frequency_per_ball_ratio": "collisions\nof one ball",
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
