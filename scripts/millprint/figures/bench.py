"""The figure of the benchmark: how many times faster than LAMMPS, run by run."""

import pandas as pd
from matplotlib.figure import Figure

from millprint.bench.history import faster_than_lammps
from millprint.figures.style import COLOURS, COLUMN_WIDTH_IN, MARKERS, legend_below, plt


def plot_history(history: pd.DataFrame) -> Figure:
    """The ratio of each case over the runs, in their order; bars are the half range of the repetitions."""
    table = faster_than_lammps(history)
    runs = table[["date", "commit", "processor"]].drop_duplicates().reset_index(drop=True)
    places = {tuple(run): place for place, run in enumerate(runs.itertuples(index=False))}
    figure, axes = plt.subplots(figsize=(COLUMN_WIDTH_IN, 2.8))
    for number, (case, rows) in enumerate(table.groupby("case", sort=False)):
        at = [places[row.date, row.commit, row.processor] for row in rows.itertuples()]
        colour, marker, error = (
            COLOURS[number % len(COLOURS)],
            MARKERS[number % len(MARKERS)],
            rows["ratio"] * rows["spread"],
        )
        axes.errorbar(at, rows["ratio"], yerr=error, capsize=2, label=str(case), color=colour, marker=marker)
    axes.axhline(1, color="#808080", linewidth=0.6)
    # A commit with its changes is one that others do not have.
    names = [f"{run.date}\n{run.commit[:7]}{'+' if ' ' in run.commit else ''}" for run in runs.itertuples()]
    instructions = table.drop_duplicates(["date", "commit", "processor"])["instructions"]
    axes.set_xticks(range(len(runs)), [f"{name}\n{own}" for name, own in zip(names, instructions, strict=True)])
    axes.set(ylabel="LAMMPS over millprint,\ntime of a ball-step [-]", ylim=(0, None))
    legend_below(figure, [axes], 3, fontsize=7)
    return figure
