"""Figures of measurements on one's own mill. They draw what is given and compute nothing."""

import numpy as np
from matplotlib.figure import Figure

from millprint.figures.style import COLOURS, COLUMN_WIDTH_IN, PAGE_WIDTH_IN, letter_panels, plt
from millprint.own_machine.estimates import Estimate
from millprint.own_machine.heard_impacts import Comparison
from millprint.own_machine.sound import Heard


def plot_impacts(
    time_s: np.ndarray, track_dB: np.ndarray, heard: Heard, floor_dB: float, comparison: Comparison
) -> Figure:
    """A second of the loudness with the impacts found in it, and impacts a second over loudness and matched energy."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(PAGE_WIDTH_IN, 2.6))
    left.plot(time_s, track_dB - floor_dB, color=COLOURS[0], linewidth=0.6)
    left.plot(heard.time_s, heard.loudness_dB - floor_dB, "v", color=COLOURS[1], label="impacts")
    left.axhline(0.0, color=COLOURS[6], linewidth=0.6, linestyle=":")
    left.set(xlabel="time [s]", ylabel="loudness over the floor [dB]", ylim=(-25, None), xlim=(time_s[0], time_s[-1]))
    left.legend(loc="lower right", frameon=True, framealpha=0.9)
    levels = comparison.levels
    ends = [levels["impacts_hz"] - levels["lower_hz"], levels["upper_hz"] - levels["impacts_hz"]]
    right.errorbar(levels["energy_J"], levels["impacts_hz"], yerr=ends, fmt="o", capsize=2)
    for row in levels.itertuples():
        right.annotate(f"{row.over_floor_dB:.1f} dB", (row.energy_J, row.impacts_hz), xytext=(4, 4),
                       textcoords="offset points", fontsize=6)  # fmt: skip
    right.set(xscale="log", yscale="log", xlabel="energy at which as many are predicted [J]")
    right.set_ylabel("measured impacts [1/s]")
    letter_panels([left, right])
    return figure


def plot_warming(
    time_s: np.ndarray, read_degC: np.ndarray, model_degC: np.ndarray, milled_s: tuple[float, float], body: str
) -> Figure:
    """Read temperatures with the heat balance that fits them; the time of milling is shaded."""
    figure, axis = plt.subplots(figsize=(COLUMN_WIDTH_IN, 2.6))
    axis.axvspan(*milled_s, color=COLOURS[5], alpha=0.2, linewidth=0, label="mill runs")
    axis.plot(time_s, read_degC, "o", markersize=2.5, color=COLOURS[0], label="read")
    axis.plot(time_s, model_degC, color=COLOURS[1], label="heat balance")
    axis.set(xlabel="time [s]", ylabel=f"temperature of the {body} [°C]")
    axis.legend(fontsize=7)
    return figure


def plot_powers(estimates: dict[str, Estimate]) -> Figure:
    """Powers with their intervals, one under the other."""
    figure, axis = plt.subplots(figsize=(COLUMN_WIDTH_IN, 0.6 + 0.4 * len(estimates)))
    for place, own in enumerate(estimates.values()):
        ends = [[own.value - own.lower], [own.upper - own.value]]
        axis.errorbar([own.value], [place], xerr=ends, fmt="o", capsize=3, color=COLOURS[place % len(COLOURS)])
    axis.set_yticks(range(len(estimates)), list(estimates))
    axis.set(xlabel="power [W]", ylim=(len(estimates) - 0.5, -0.5))
    return figure
