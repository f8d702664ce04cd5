"""The figure of growth: planning, fingerprint, pages and simulations over their size."""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.ticker import FormatStrFormatter, LogLocator, NullFormatter
from matplotlib.typing import FillStyleType, LineStyleType

from millprint.figures.style import COLOURS, MARKERS, PAGE_WIDTH_IN, letter_panels, save
from millprint.plan.costs import BALL_MB, BALL_STEP_S, CASE_MB

# The cost model of simulations is drawn up to so many balls [-].
MODEL_TO = 1_000_000
# Line and markers of the type of processor on which most was measured, and of all others.
Look = tuple[LineStyleType, FillStyleType]
MOST_MEASURED: Look = ("-", "full")
OTHERS: Look = (":", "none")
PANELS = {
    "planning": ("Simulations in the run (-)", "Processor time (s)", "processor_s"),
    "fingerprint": ("Conditions (-)", "Processor time (s)", "processor_s"),
    "pages": ("Size of the page (MB)", "Processor time\nto open it (s)", "processor_s"),
    "simulation": ("Balls (-)", "Processor time of\na ball and a step (ns)", "value"),
}


def draw_growth(table: pd.DataFrame, svg: str | Path, png: str | Path) -> None:
    """A panel a part, and one of the memory of simulations with the cost model beyond what was measured."""
    figure, axes = plt.subplots(2, 3, figsize=(PAGE_WIDTH_IN, 0.6 * PAGE_WIDTH_IN))
    panels, looks = axes.ravel(), _looks(table)
    for axis, (part, (size, value, column)) in zip(panels, PANELS.items(), strict=False):
        _draw(axis, table[table["part"] == part], column, looks)
        axis.set(xlabel=size, ylabel=value)
    simulations = table[table["part"] == "simulation"]
    _draw(panels[4], simulations, "memory_MB", looks)
    panels[4].set(xlabel="Balls (-)", ylabel="Memory (MB)")
    if len(simulations):
        balls = np.geomspace(simulations["size"].min(), MODEL_TO, 50)
        look = {"color": "0.5", "linestyle": "--", "label": "cost model"}
        panels[3].axhline(BALL_STEP_S * 1e9, **look)
        panels[4].plot(balls, CASE_MB + BALL_MB * balls, **look)
    for axis in panels[:5]:
        if axis.get_legend_handles_labels()[0]:
            _add_legend(axis)
            _number(axis)
    _name_machines(panels[5], looks)
    letter_panels(panels[:5])
    save(figure, svg, png)


def _looks(table: pd.DataFrame) -> dict[str, Look]:
    """The types of processor, the one on which most was measured first, and the look of each."""
    names = table["processor"].value_counts().index
    return {name: OTHERS if at else MOST_MEASURED for at, name in enumerate(names)}


def _draw(axis: Axes, table: pd.DataFrame, column: str, looks: dict[str, Look]) -> None:
    """A line for each thing measured on each type of processor; a colour says what, a style where."""
    known = table.assign(**{column: pd.to_numeric(table[column], errors="coerce")}).dropna(subset=[column])
    for number, what in enumerate(known["what"].unique()):
        own = known[known["what"] == what]
        marker, colour = MARKERS[number % len(MARKERS)], COLOURS[number % len(COLOURS)]
        for machine, (line, fill) in looks.items():
            there = own[own["processor"] == machine].sort_values("size")
            if there.empty:
                continue
            label = what if machine == own["processor"].iloc[0] else None
            axis.loglog(
                there["size"], there[column], marker=marker, color=colour, label=label, linestyle=line, fillstyle=fill
            )


def _add_legend(axis: Axes) -> None:
    """A legend above the lines, for which the axis is made longer by two thirds."""
    low, high = axis.get_ylim()
    axis.set_ylim(low, high * (high / low) ** 0.7)
    axis.legend(fontsize=6, loc="upper left")


def _number(axis: Axes) -> None:
    """Powers of ten along a size, and along what it takes, which may span less than one, their 2 and 5 times too."""
    axis.xaxis.set_minor_formatter(NullFormatter())
    low, high = axis.get_ylim()
    axis.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if high < 500 * low else (1.0,)))
    axis.yaxis.set_major_formatter(FormatStrFormatter("%g"))
    axis.yaxis.set_minor_formatter(NullFormatter())


def _name_machines(axis: Axes, looks: dict[str, Look]) -> None:
    """Which look is which type of processor."""
    axis.set_axis_off()
    lines = [
        Line2D([], [], color="0.3", marker="o", linestyle=line, fillstyle=fill, label=name)
        for name, (line, fill) in looks.items()
    ]
    if lines:
        axis.legend(handles=lines, loc="center", fontsize=6, title="Processor", title_fontsize=7)
