"""Figures of several mills: the collapse of each, and the scale-up of one."""

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from millprint.figures.style import COLOURS, COLUMN_WIDTH_IN, MARKERS, plt


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
