"""Figures of measurements on one's own mill. They draw what is given and compute nothing."""

import numpy as np
from matplotlib.figure import Figure

from millprint.estimate.estimates import Estimate
from millprint.figures.style import COLOURS, COLUMN_WIDTH_IN, plt


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
        hull = own.hull()
        ends = [[own.value - hull.lower], [hull.upper - own.value]]
        axis.errorbar([own.value], [place], xerr=ends, fmt="o", capsize=3, color=COLOURS[place % len(COLOURS)])
    axis.set_yticks(range(len(estimates)), list(estimates))
    axis.set(xlabel="power [W]", ylim=(len(estimates) - 0.5, -0.5))
    return figure
