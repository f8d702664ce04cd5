"""The claims of the thesis: verdicts by chapter."""

import pandas as pd
from matplotlib import pyplot as plt
from matplotlib.figure import Figure

from millprint.claims.compare import DEVIATES, ERRATUM, NOT_RUN, REPRODUCED
from millprint.figures.style import COLUMN_WIDTH_IN

VERDICT_COLOURS = {REPRODUCED: "#009E73", ERRATUM: "#56B4E9", DEVIATES: "#D55E00", NOT_RUN: "#BBBBBB"}


def plot_verdicts(counts: pd.DataFrame) -> Figure:
    """Stacked bars, one a chapter; `counts` has the column chapter and one for each verdict that occurs."""
    figure, axes = plt.subplots(figsize=(COLUMN_WIDTH_IN, 0.5 * COLUMN_WIDTH_IN))
    left = 0
    for name, colour in VERDICT_COLOURS.items():
        if name in counts:
            axes.barh(counts["chapter"], counts[name], left=left, color=colour, label=name)
            left = left + counts[name]
    axes.invert_yaxis()
    axes.set_xlabel("number of claims")
    axes.legend(loc="lower right", fontsize=7)
    return figure
