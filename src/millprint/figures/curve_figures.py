"""Draws a master curve in its band."""

import pandas as pd
from matplotlib.axes import Axes

from millprint.figures.style import COLOURS

FILL_LABEL = "fill ratio [-]"


def draw_curve(axis: Axes, curves: pd.DataFrame, quantity: str, label: str) -> None:
    """A master curve in its band of a new simulation. curves: fill_ratio, Q, Q_lower and Q_upper of the quantity Q."""
    fill, lower, upper = (curves[name] for name in ("fill_ratio", f"{quantity}_lower", f"{quantity}_upper"))
    axis.fill_between(fill, lower, upper, color=COLOURS[0], alpha=0.15, linewidth=0, label="band of a new simulation")
    axis.plot(fill, curves[quantity], color=COLOURS[0], label=label)
