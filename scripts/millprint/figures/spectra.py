"""Figures of what a chemist reads off a mill: energy spectra."""

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from millprint.figures.style import COLOURS, PAGE_WIDTH_IN, legend_below, letter_panels, plt

CHANNELS = {"normal": "normal energy [J]", "tangential": "tangential energy [J]"}
PAIRS = {"ball_ball": ("ball on ball", "-"), "ball_wall": ("ball on wall", "--")}
QUANTITIES = {
    "collisions_hz": "collisions per bin [1/s]",
    "power_W": "power per bin [W]",
    "power_above_share": "share of power above [-]",
}


def plot_spectra(spectra: pd.DataFrame, title: str) -> Figure:
    """Collisions, power and cumulative share of the power over the energy of a collision, one column a channel.

    spectra: of one charge at one speed by one rule, as `dose.spectra.shown` gives them; a colour a fill ratio, solid
    lines for ball on ball and dashed ones for ball on wall. The open bins beyond the others are not drawn.
    """
    figure, axes = plt.subplots(3, 2, figsize=(PAGE_WIDTH_IN, 6.2), sharex="col", sharey="row")
    bins = spectra.dropna(subset=["energy_low_J", "energy_high_J"])
    for column, (channel, label) in enumerate(CHANNELS.items()):
        for row, (quantity, title_y) in enumerate(QUANTITIES.items()):
            axis = axes[row, column]
            _draw(axis, bins[bins["channel"] == channel], quantity)
            axis.set_xscale("log")
            if quantity != "power_above_share":
                axis.set_yscale("log")
            if column == 0:
                axis.set_ylabel(title_y)
        axes[-1, column].set_xlabel(label)
    for row, decades in ((0, 7), (1, 7)):
        low, high = axes[row, 0].get_ylim()
        # Single contacts would stretch the axis over the whole range.
        axes[row, 0].set_ylim(max(low, high * 10.0**-decades), high)
    letter_panels(axes.flat)
    legend_below(figure, axes.flat, columns=4, fontsize=7)
    figure.suptitle(title, fontsize=8)
    return figure


def _draw(axis: Axes, bins: pd.DataFrame, quantity: str) -> None:
    fills = np.unique(bins["fill_ratio"])
    for (fill, pair), table in bins.groupby(["fill_ratio", "pair"], sort=True):
        words, line = PAIRS[str(pair)]
        low, values = table["energy_low_J"].to_numpy(), table[quantity].to_numpy()
        edges = np.append(low, table["energy_high_J"].to_numpy()[-1])
        colour = COLOURS[int(np.searchsorted(fills, fill)) % len(COLOURS)]
        label = f"fill {fill:g}, {words}"
        axis.stairs(values, edges, baseline=None, label=label, linewidth=1.0, color=colour, linestyle=line)
