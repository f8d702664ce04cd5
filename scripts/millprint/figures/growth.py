"""The figure of growth: planning, fingerprint, pages and simulations over their size."""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.ticker import NullFormatter

from millprint.figures.style import MARKERS, PAGE_WIDTH_IN, letter_panels, save
from millprint.plan.costs import BALL_MB, BALL_STEP_S, CASE_MB

# The cost model of simulations is drawn up to so many balls [-].
MODEL_TO = 1_000_000
PANELS = {
    "planning": ("Simulations in the run (-)", "Processor time (s)", "processor_s"),
    "fingerprint": ("Conditions (-)", "Processor time (s)", "processor_s"),
    "pages": ("Size of the page (MB)", "Processor time to open it (s)", "processor_s"),
    "simulation": ("Balls (-)", "Processor time of a ball and a step (ns)", "value"),
}


def draw_growth(table: pd.DataFrame, svg: str | Path, png: str | Path) -> None:
    """A panel a part, and one of the memory of simulations with the cost model beyond what was measured."""
    figure, axes = plt.subplots(2, 3, figsize=(PAGE_WIDTH_IN, 0.6 * PAGE_WIDTH_IN))
    panels = axes.ravel()
    for axis, (part, (size, value, column)) in zip(panels, PANELS.items(), strict=False):
        _draw(axis, table[table["part"] == part], column)
        axis.set(xlabel=size, ylabel=value)
    simulations = table[table["part"] == "simulation"]
    _draw(panels[4], simulations, "memory_MB")
    panels[4].set(xlabel="Balls (-)", ylabel="Memory (MB)")
    if len(simulations):
        balls = np.geomspace(simulations["size"].min(), MODEL_TO, 50)
        look = {"color": "0.5", "linestyle": "--", "label": "cost model"}
        panels[3].axhline(BALL_STEP_S * 1e9, **look)
        panels[4].plot(balls, CASE_MB + BALL_MB * balls, **look)
    panels[5].set_axis_off()
    for axis in panels[:5]:
        if axis.get_legend_handles_labels()[0]:
            axis.legend(fontsize=6)
        # Numbers between the powers of ten would lie on each other.
        axis.xaxis.set_minor_formatter(NullFormatter())
    letter_panels(panels[:5])
    save(figure, svg, png)


def _draw(axis: Axes, table: pd.DataFrame, column: str) -> None:
    known = table.assign(**{column: pd.to_numeric(table[column], errors="coerce")}).dropna(subset=[column])
    for marker, (what, own) in zip(MARKERS, known.groupby("what", sort=False), strict=False):
        axis.loglog(own["size"], own[column], marker=marker, label=what)
