"""Figures of chapter 2: Pareto plot, interaction plots, residuals, the literature, and the wear of the balls."""

import textwrap

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import NullLocator, StrMethodFormatter

from millprint.config.doe import Factor
from millprint.figures.style import (
    COLOURS,
    COLUMN_WIDTH_IN,
    MARKERS,
    PAGE_WIDTH_IN,
    PUBLISHED,
    letter_panels,
    no_formula,
    plt,
)

GREY = "#999999"
SHAPES = "os^Dv"


def pareto(effects: pd.DataFrame, names: dict[str, str]) -> Figure:
    """F of each term, largest first, with the F that would be significant (thesis Fig. 2.3).

    Columns source, F, critical_F, F_type_two, stands_after_holm, and F_published (empty where no table prints one);
    `names` the label of each factor's letter. Terms that do not stand after Holm's correction are pale.
    """
    figure, axes = plt.subplots(figsize=(COLUMN_WIDTH_IN, 0.85 * COLUMN_WIDTH_IN))
    ranked = effects.sort_values("F")
    place = np.arange(len(ranked))
    stands = (ranked["stands_after_holm"] == "yes").to_numpy()
    for shown, alpha, name in ((stands, 1.0, "type I"), (~stands, 0.35, "does not stand after Holm")):
        if shown.any():
            axes.barh(place[shown], ranked["F"][shown], height=0.62, color=COLOURS[5], alpha=alpha, label=name)
    axes.plot(ranked["F_type_two"], place, "|", color=COLOURS[0], markersize=9, markeredgewidth=2, label="type II")
    if ranked["F_published"].notna().any():
        axes.plot(ranked["F_published"], place, **PUBLISHED, label="from the printed p")
    for row, critical in zip(place, ranked["critical_F"], strict=True):
        label = "significant at 0.05" if row == 0 else None
        axes.plot([critical, critical], [row - 0.45, row + 0.45], color=COLOURS[1], label=label)
    ticks = [
        textwrap.fill(f"{no_formula(names[source]).rsplit(' (', 1)[0]} ({source})", 18) if source in names else source
        for source in ranked["source"]
    ]
    axes.set_yticks(place, ticks, fontsize=7)
    axes.tick_params(axis="y", length=0)
    axes.set_xlabel("F (-)")
    axes.legend(loc="lower right", fontsize=7)
    return figure


def _interaction_panel(axes: Axes, means: pd.DataFrame, factors: dict[str, Factor]) -> None:
    axis, curve = (factors[means[side].iloc[0]] for side in ("axis", "curve"))
    places = np.asarray(axis.levels if axis.numeric else range(len(axis.levels)), dtype=float)
    # Curves are shifted a little, so that their ranges do not hide each other.
    shift = 0.03 * np.min(np.diff(places))
    count = len(curve.levels)
    for code, group in means.groupby("curve_code"):
        group = group.sort_values("axis_code")
        where = places[group["axis_code"]] + shift * (code - (count - 1) / 2)
        colour = COLOURS[code % len(COLOURS)]
        lowest, highest = group["lowest_yield_percent"], group["highest_yield_percent"]
        axes.vlines(where, lowest, highest, color=colour, alpha=0.35, linewidth=2.5)
        marker = SHAPES[code % len(SHAPES)]
        axes.plot(where, group["mean_yield_percent"], marker=marker, color=colour, label=no_formula(curve.text(code)))
    axes.set_xticks(places, [no_formula(axis.text(code)) for code in range(len(places))])
    margin = 0.12 * np.ptp(places)
    axes.set(xlim=(places[0] - margin, places[-1] + margin), xlabel=no_formula(axis.label), ylim=(0, 100))
    axes.legend(
        title=no_formula(curve.label),
        fontsize=7,
        title_fontsize=7,
        ncols=count,
        loc="lower center",
        bbox_to_anchor=(0.5, 1.0),
    )


def interactions(means: pd.DataFrame, factors: dict[str, Factor]) -> Figure:
    """Mean yield for each pair of levels, bars from the lowest to the highest run (thesis Figs 2.4, 2.5).

    `means` is one figure's part of the interaction table; `factors` those of the design by their letters.
    """
    panels = [panel for _, panel in means.groupby(["axis", "curve"], sort=False)]
    width = COLUMN_WIDTH_IN if len(panels) == 1 else PAGE_WIDTH_IN
    figure, grid = plt.subplots(1, len(panels), figsize=(width, 0.9 * COLUMN_WIDTH_IN), squeeze=False, sharey=True)
    for letter, axes, panel in zip("abc", grid[0], panels, strict=False):
        _interaction_panel(axes, panel, factors)
        if len(panels) > 1:
            _letter(axes, letter)
    grid[0, 0].set_ylabel("Yield (%)")
    return figure


def _letter(axes: Axes, letter: str) -> None:
    axes.annotate(f"({letter})", (0, 1), (4, -9), xycoords="axes fraction", textcoords="offset points")


def residuals(table: pd.DataFrame) -> Figure:
    """Residuals against normal quantiles and fitted yield, and studentised against leverage, of the residual table."""
    figure, (left, middle, right) = plt.subplots(1, 3, figsize=(PAGE_WIDTH_IN, 0.72 * COLUMN_WIDTH_IN))
    left.plot(table["normal_quantile"], table["residual_percent"], "o")
    spread = table["residual_percent"].std()
    ends = np.array([table["normal_quantile"].min(), table["normal_quantile"].max()])
    left.plot(ends, spread * ends, color=COLOURS[1], label="normal, same spread")
    left.set(xlabel="Normal quantile (-)", ylabel="Residual yield (%)")
    left.legend(loc="lower right", fontsize=7, handlelength=1)
    middle.plot(table["fitted_percent"], table["residual_percent"], "o")
    middle.set(xlabel="Fitted yield (%)", ylabel="Residual yield (%)")
    right.plot(table["leverage"], table["studentised"], "o")
    right.set(xlabel="Leverage (-)", ylabel="Studentised residual (-)")
    for axes, column, across in ((middle, "residual_percent", "fitted_percent"), (right, "studentised", "leverage")):
        axes.axhline(0, color=GREY, linewidth=0.6, zorder=0)
        axes.margins(x=0.12, y=0.12)
        largest = table.iloc[table[column].abs().fillna(0).argsort()[-3:]].sort_values(across)
        for place, (_, run) in enumerate(largest.iterrows()):
            # The last marked run has its name on the right, the others on the left, so that neighbours stay readable.
            offset, side = ((4, 2), "left") if place == len(largest) - 1 else ((-4, 2), "right")
            point = (run[across], run[column])
            axes.annotate(run["case"], point, offset, textcoords="offset points", ha=side, fontsize=7)
    for letter, axes in zip("abc", (left, middle, right), strict=True):
        _letter(axes, letter)
    return figure


def literature(studies: pd.DataFrame, yields: pd.DataFrame) -> Figure:
    """Best reported yield against speed; studies that do not report their speed stand at the side (thesis Fig. 1.4).

    `studies` is Table 2.2; of `yields`, Table 2.1, what differs from it is drawn open.
    """
    figure, (axes, side) = plt.subplots(
        1, 2, figsize=(COLUMN_WIDTH_IN, 0.75 * COLUMN_WIDTH_IN), sharey=True, width_ratios=(4, 1)
    )
    speeds = studies.set_index("reference")["speed_rpm"]
    unknown = studies["yield_percent"][studies["speed_rpm"].isna()]
    axes.plot(*studies[["speed_rpm", "yield_percent"]].dropna().to_numpy().T, "o", label="Table 2.2")
    side.plot(np.zeros(len(unknown)), unknown, "s", color=COLOURS[1])
    printed = set(zip(studies["reference"], studies["yield_percent"], strict=True))
    other = [
        (speeds.get(row.reference, np.nan), row.yield_percent)
        for row in yields.itertuples()
        if (row.reference, row.yield_percent) not in printed
    ]
    if other:
        axes.plot(*zip(*other, strict=True), **PUBLISHED, label="Table 2.1, where it differs")
    for _, study in studies.iterrows():
        place, where = (side, 0.0) if np.isnan(study["speed_rpm"]) else (axes, study["speed_rpm"])
        place.annotate(f"[{study['reference']}]", (where, study["yield_percent"]), (5, 2), textcoords="offset points")
    axes.set(xlabel="Rotational speed (rpm)", ylabel="Reported yield (%)")
    axes.margins(x=0.12, y=0.1)
    axes.legend(loc="lower center", bbox_to_anchor=(0.6, 1.0), ncols=2, fontsize=7, columnspacing=1, handletextpad=0.2)
    side.set_xticks([0], ["not\nreported"])
    side.set_xlim(-1, 1.6)
    return figure


PARAMETER_NAMES = {
    "ball_diameter_mm": "ball diameter",
    "balls": "number of balls",
    "vessel": "vessel material",
    "jar_volume_ml": "jar volume",
    "ball_volume_percent": "ball volume in jar",
    "borate_mass_g": "mass of borate",
    "reductant_mass_g": "mass of reductant",
    "powder_mass_g": "total mass",
    "speed_rpm": "speed",
    "molar_ratio": "molar ratio",
    "time_h": "milling time",
    "bpr": "ball-to-powder ratio",
    "mill": "mill",
}


def missingness(table: pd.DataFrame) -> Figure:
    """Which study (across) reports which parameter (down), of the missingness table: filled where it does."""
    columns = [name for name in table if name.startswith("reference_")]
    reported = (table[columns] == "yes").to_numpy()
    figure, axes = plt.subplots(figsize=(COLUMN_WIDTH_IN, 0.95 * COLUMN_WIDTH_IN))
    rows, places = np.indices(reported.shape)
    axes.scatter(places[reported], rows[reported], marker="s", s=48, color=COLOURS[0], label="reported")
    left_out = places[~reported], rows[~reported]
    axes.scatter(*left_out, marker="s", s=44, facecolors="none", edgecolors=COLOURS[1], label="not reported")
    axes.set_xticks(range(len(columns)), [f"[{name.removeprefix('reference_')}]" for name in columns])
    axes.set_yticks(range(len(table)), [PARAMETER_NAMES.get(name, name) for name in table["parameter"]], fontsize=7)
    axes.invert_yaxis()
    axes.set_xlabel("Study (reference)")
    axes.tick_params(length=0)
    axes.spines[:].set_visible(False)
    axes.legend(ncols=2, loc="lower center", bbox_to_anchor=(0.4, 1.0), fontsize=7, handletextpad=0.1)
    return figure


ROLES = {"fitted": COLOURS[0], "held back": COLOURS[1]}


def _bars_of_weighings(wear: pd.DataFrame) -> list[pd.Series]:
    """Lengths of the bars below and above the wear over powder [%] that span the coefficients of single weighings.

    The coefficient may equal that of the largest or smallest weighing up to rounding, so bars are cut off at 0.
    """
    value = wear["powder_percent"]
    ends = value - wear["seen_lower_powder_percent"], wear["seen_upper_powder_percent"] - value
    return [end.clip(lower=0) for end in ends]


def _first_charge(wear: pd.DataFrame, material: str) -> pd.DataFrame:
    """The rows of a material with the ball-to-powder ratio and the time of its first row."""
    own = wear[wear["material"] == material]
    return own.merge(own[["bpr", "time_h"]].head(1))


def plot_wear(weighings: pd.DataFrame, wear: pd.DataFrame, material: str, said: str) -> Figure:
    """Measured and predicted wear of the weighings, and wear against the fill ratio for every mill, ball and speed.

    weighings: as from fit_wear; wear: as from predict_wear; only rows of `material` and the first charge are drawn;
    said: written over the figure.
    """
    figure, (left, right) = plt.subplots(1, 2, figsize=(PAGE_WIDTH_IN, 3.2))
    for role, colour in ROLES.items():
        rows = weighings[weighings["role"] == role]
        left.errorbar(
            rows["speed_rpm"],
            rows["measured_g"],
            yerr=rows["reading_error_g"],
            fmt="o",
            color=colour,
            capsize=2,
            label=f"measured, {role}",
        )
        left.plot(
            rows["speed_rpm"], rows["predicted_g"], "D", color=colour, fillstyle="none", label=f"predicted, {role}"
        )
        for row in rows.itertuples():
            left.plot([row.speed_rpm] * 2, [row.measured_g, row.predicted_g], ":", color=colour, linewidth=0.8)
    left.set(xlabel="rotational speed [rpm]", ylabel="wear of the balls [g]")
    left.set_ylim(bottom=0)
    left.margins(x=0.3)
    left.legend(fontsize=7, loc="upper left")
    shown = _first_charge(wear, material)
    if len(shown):
        first = shown.iloc[0]
        groups = shown.sort_values("fill_ratio").groupby(["mill", "ball_diameter_mm", "speed_rpm"], sort=True)
        for index, ((mill, diameter, speed), rows) in enumerate(groups):
            right.errorbar(
                rows["fill_ratio"],
                rows["powder_percent"],
                yerr=_bars_of_weighings(rows),
                marker=MARKERS[index % len(MARKERS)],
                color=COLOURS[index % len(COLOURS)],
                capsize=1.5,
                linewidth=0.8,
                label=f"{mill}, {diameter:g} mm, {speed:g} rpm",
            )
        right.set(xscale="log", yscale="log", title=f"BPR {first['bpr']:g}, {first['time_h']:g} h")
        right.title.set_fontsize(8)
        figure.legend(*right.get_legend_handles_labels(), loc="outside right center", fontsize=6)
        fills = sorted(shown["fill_ratio"].unique())
        right.set_xticks(fills, [f"{fill:g}" for fill in fills], fontsize=6, rotation=90)
        right.xaxis.set_minor_locator(NullLocator())
        right.yaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
    right.set(xlabel="fill ratio [-]", ylabel="wear over powder [%]")
    letter_panels([left, right])
    figure.suptitle(said, fontsize=7)
    return figure


def plot_mill_wear(wear: pd.DataFrame, material: str) -> Figure:
    """Wear over powder at every simulated condition of several mills: a line per mill, a marker per ball and speed.

    wear: as from predict_wear; only rows of `material` and the first charge are drawn; bars span the coefficients of
    single weighings.
    """
    shown = _first_charge(wear, material)
    first = shown.iloc[0]
    mills = list(dict.fromkeys(shown["mill"]))
    figure, axis = plt.subplots(figsize=(PAGE_WIDTH_IN, 0.9 + 0.45 * len(mills)))
    for place, mill in enumerate(mills):
        own = shown[shown["mill"] == mill].sort_values("powder_percent")
        # Side by side, to distinguish the bars.
        heights = place + (pd.Series(range(len(own))) - (len(own) - 1) / 2) * 0.7 / max(len(own), 1)
        value = own["powder_percent"]
        axis.errorbar(
            value,
            heights,
            xerr=_bars_of_weighings(own),
            fmt="o",
            markersize=2.5,
            linewidth=0.8,
            color=COLOURS[place % len(COLOURS)],
        )
    axis.set(xscale="log", xlabel="wear over powder [%]", ylabel="mill")
    axis.set_yticks(range(len(mills)), mills)
    axis.invert_yaxis()
    axis.set_title(f"{material.replace('_', ' ')}, BPR {first['bpr']:g}, {first['time_h']:g} h", fontsize=8)
    return figure
