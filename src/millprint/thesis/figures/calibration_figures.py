"""Figures of the calibration. They draw tables and compute nothing."""

import matplotlib.pyplot as plt
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from millprint.figures.style import (
    COLOURS,
    COLUMN_WIDTH_IN,
    MARKERS,
    PAGE_WIDTH_IN,
    LineLook,
    legend_below,
    letter_panels,
)

NAMES = {"static_friction": "static friction $\\mu$ [-]", "rolling_friction": "rolling friction $\\mu_r$ [-]"}
PLACES = {"across_mm": "across the jar [mm]", "height_mm": "height [mm]"}


def plot_drops(drops: pd.DataFrame, means: pd.DataFrame) -> Figure:
    """Restitution of every drop against its height; lines are means, bands their confidence intervals.

    drops: contact, drop_height_mm, restitution; means: contact, mean, lower, upper.
    """
    figure, axis = plt.subplots(figsize=(COLUMN_WIDTH_IN, 2.5))
    for index, row in enumerate(means.itertuples()):
        line, colour = drops[drops["contact"] == row.contact], COLOURS[index % len(COLOURS)]
        label = f"{row.contact}: {row.mean:.3f}"
        marker = MARKERS[index % len(MARKERS)]
        axis.plot(line["drop_height_mm"], line["restitution"], marker, color=colour, label=label)
        axis.axhline(row.mean, color=colour, linewidth=0.8)
        axis.axhspan(row.lower, row.upper, color=colour, alpha=0.15, linewidth=0)
    axis.set(xlabel="drop height [mm]", ylabel="restitution [-]", ylim=(0, 1))
    axis.set_xlim(0, 1.08 * drops["drop_height_mm"].max())
    axis.legend()
    return figure


def _plot_path(axis: Axes, track: pd.DataFrame, paths: pd.DataFrame, place: str) -> None:
    for index, (pair, line) in enumerate(paths.groupby(["static_friction", "rolling_friction"], sort=False)):
        is_fit = line["path"].iloc[0] == "fit"
        label = f"{'fit: ' if is_fit else ''}$\\mu$ {pair[0]:.3g}, $\\mu_r$ {pair[1]:.3g}"
        look: LineLook = {"color": COLOURS[0], "zorder": 3} if is_fit else {"color": COLOURS[index], "linewidth": 0.7}
        axis.plot(line["time_s"], line[place], label=label, **look)
    if place in track:
        axis.plot(
            track["time_s"], track[place], "o", color=COLOURS[6], markersize=2, markerfacecolor="none",
            markeredgewidth=0.5, label="track", zorder=2,
        )  # fmt: skip
    axis.set(xlabel="time [s]", ylabel=PLACES[place])
    axis.margins(x=0)


def _plot_profile(axis: Axes, profile: pd.DataFrame, row: pd.Series) -> None:
    axis.axvspan(row["lower"], row["upper"], color="0.9", linewidth=0)
    axis.plot(profile["value"], profile["excess"], "o-", color=COLOURS[0], markersize=3)
    axis.axhline(profile["threshold"].iloc[0], color=COLOURS[1], linestyle="--", linewidth=1)
    if pd.notna(row["given"]):
        axis.axvline(row["given"], color=COLOURS[2], linestyle="-.", linewidth=1)
    axis.locator_params(axis="x", nbins=5)
    axis.set(xlabel=NAMES[row["parameter"]], ylabel="excess over the best fit [-]")


def plot_friction_fit(track: pd.DataFrame, paths: pd.DataFrame, fit: pd.DataFrame, profile: pd.DataFrame) -> Figure:
    """Fig. 3.3: the track of the ball with fitted and varied pairs, and the profile of each coefficient.

    track: time_s and places; paths: path, both coefficients, time_s, places; fit: parameter, given, lower, upper;
    profile: parameter, value, excess, threshold. Grey is the interval, dashed its threshold,
    dash-dotted what was put in.
    """
    figure, axes = plt.subplot_mosaic(
        [["across", "across"], ["height", "height"], ["first", "second"]], figsize=(PAGE_WIDTH_IN, 5.6)
    )
    for name, place in (("across", "across_mm"), ("height", "height_mm")):
        _plot_path(axes[name], track, paths, place)
    axes["across"].set_xlabel("")
    for name, (_, row) in zip(("first", "second"), fit.iterrows(), strict=True):
        _plot_profile(axes[name], profile[profile["parameter"] == row["parameter"]], row)
    letter_panels(axes.values())
    legend_below(figure, axes.values(), 3)
    return figure
