"""The claims of the thesis: verdicts by chapter."""

import pandas as pd
from matplotlib import pyplot as plt
from matplotlib.figure import Figure

from millprint.claims.compare import DEVIATES, ERRATUM, NOT_RUN, REPRODUCED
from millprint.figures.style import COLUMN_WIDTH_IN

VERDICT_COLOURS = {REPRODUCED: "#009E73", ERRATUM: "#56B4E9", DEVIATES: "#D55E00", NOT_RUN: "#BBBBBB"}


def plot_verdicts(counts: pd.DataFrame) -> Figure:
    """Stacked bars, one a chapter; `counts` has the columns chapter and claims and one for each verdict."""
    figure, axes = plt.subplots(figsize=(COLUMN_WIDTH_IN, 0.55 * COLUMN_WIDTH_IN))
    left, narrow = 0, 0.05 * counts["claims"].max()
    for name, colour in VERDICT_COLOURS.items():
        bars = axes.barh(counts["chapter"], counts[name], left=left, color=colour, label=name)
        axes.bar_label(bars, [n if n > narrow else "" for n in counts[name]], label_type="center", fontsize=6)
        left = left + counts[name]
    axes.invert_yaxis()
    axes.set_xlabel("number of claims")
    figure.legend(loc="outside upper center", ncols=len(VERDICT_COLOURS), fontsize=7, columnspacing=1, handlelength=1)
    return figure
