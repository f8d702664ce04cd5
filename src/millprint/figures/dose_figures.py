"""Figures of wear, and of the heat balance over a programme. They draw tables and compute nothing."""

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from matplotlib.ticker import NullLocator, StrMethodFormatter

from millprint.figures.style import COLOURS, MARKERS, PAGE_WIDTH_IN, legend_below, letter_panels, plt

ROLES = {"fitted": COLOURS[0], "held back": COLOURS[1]}


def _bars_of_weighings(wear: pd.DataFrame) -> list[pd.Series]:
    """Lengths of the bars below and above the wear over powder [%] that span the coefficients of single weighings.

    The coefficient may equal that of the largest or smallest weighing up to rounding, so bars are cut off at 0.
    """
    value = wear["powder_percent"]
    ends = value - wear["seen_lower_powder_percent"], wear["seen_upper_powder_percent"] - value
    return [end.clip(lower=0) for end in ends]


def plot_wear(weighings: pd.DataFrame, wear: pd.DataFrame, material: str, verdict: str) -> Figure:
    """Measured and predicted wear of the weighings, and wear against the fill ratio for every mill, ball and speed.

    weighings: as from fit_wear; wear: as from predict_wear; only rows of `material` and the first charge are drawn;
    verdict: written over the figure.
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
    shown = wear[wear["material"] == material]
    if len(shown):
        first = shown.iloc[0]
        shown = shown[(shown["bpr"] == first["bpr"]) & (shown["time_h"] == first["time_h"])]
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
    figure.suptitle(verdict, fontsize=7)
    return figure


def plot_mill_wear(wear: pd.DataFrame, material: str) -> Figure:
    """Wear over powder at every simulated condition of several mills: a line per mill, a marker per ball and speed.

    wear: as from predict_wear; only rows of `material` and the first charge are drawn; bars span the coefficients of
    single weighings.
    """
    shown = wear[wear["material"] == material]
    first = shown.iloc[0]
    shown = shown[(shown["bpr"] == first["bpr"]) & (shown["time_h"] == first["time_h"])]
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


BODY_NAMES = {"balls": "balls", "powder": "powder", "jar": "jar"}
# As in the explorer.
BODY_COLOURS = {"balls": COLOURS[0], "powder": COLOURS[1], "jar": COLOURS[-1]}


def plot_heat(temperatures: pd.DataFrame, limits: pd.DataFrame, comparison: pd.DataFrame, title: str) -> Figure:
    """Temperatures of the condition of the largest power over time, and of every condition after long milling.

    temperatures, limits, comparison: as of `millprint.dose.heat_table.heat_tables`.
    """
    figure, (left, right) = plt.subplots(1, 2, figsize=(PAGE_WIDTH_IN, 2.9))
    strongest = limits.loc[limits["total_W"].idxmax()]
    for number, (body, name) in enumerate(BODY_NAMES.items()):
        colour = BODY_COLOURS[body]
        rows = temperatures[(temperatures["condition"] == strongest["condition"]) & (temperatures["body"] == body)]
        left.fill_between(rows["time_h"], rows["lower_degC"], rows["upper_degC"], color=colour, alpha=0.18, linewidth=0)
        left.plot(rows["time_h"], rows["median_degC"], color=colour, label=name)
        lower, median, upper = (limits[f"{body}_steady_degC_{end}"].to_numpy() for end in ("lower", "median", "upper"))
        # Side by side, to distinguish bars at the same power.
        power = limits["total_W"].to_numpy() + 0.012 * strongest["total_W"] * (number - 1)
        right.errorbar(
            power, median, yerr=np.array([median - lower, upper - median]), linestyle="none", capsize=2,
            marker=MARKERS[number], color=colour, linewidth=0.8,
        )  # fmt: skip
    left.axhline(
        strongest["limit_degC"],
        color="black",
        linestyle="--",
        linewidth=0.8,
        label=f"limit ({strongest['limit_body']})",
    )
    for _, row in comparison.drop_duplicates("id").iterrows():
        bound = float(str(row["measured"]).split()[-1])
        right.axhline(bound, color="0.6", linewidth=0.8)
        right.text(
            0.02, bound, f"balls, measured: {row['measured']} {row['unit']}", transform=right.get_yaxis_transform(),
            fontsize=6, va="bottom", color="0.4",
        )  # fmt: skip
    left.set(xlabel="time [h]", ylabel="temperature [degC]")
    said = "{ball_diameter_mm:.3g} mm, fill {fill_ratio:g}, {speed_rpm:g} rpm: {total_W:.3g} W".format(**strongest)
    left.set_title(said, fontsize=7, loc="right")
    right.set(
        xlabel="dissipated power [W]",
        ylabel="temperature after\nlong milling [degC]",
        xlim=(0, 1.1 * strongest["total_W"]),
    )
    letter_panels([left, right])
    legend_below(figure, [left], columns=4, fontsize=7)
    figure.suptitle(title, fontsize=8)
    return figure
