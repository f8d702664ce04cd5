"""The recursive stage as a flow chart (Fig. 6.5)."""

from matplotlib.figure import Figure

from millprint.figures.style import COLOURS, COLUMN_WIDTH_IN, plt

BOX_IN, GAP_IN = 0.44, 0.16


def plot_loop(start: str, steps: list[str]) -> Figure:
    """A box for what the recursion starts from, and one for each of its steps, the last of which leads to the first."""
    height = (len(steps) + 1) * (BOX_IN + GAP_IN) + GAP_IN
    figure, axes = plt.subplots(figsize=(COLUMN_WIDTH_IN, height))
    axes.set(xlim=(0, COLUMN_WIDTH_IN), ylim=(0, height), aspect="equal")
    axes.axis("off")
    middle, right = 0.47 * COLUMN_WIDTH_IN, 0.93 * COLUMN_WIDTH_IN
    tops = [height - GAP_IN - number * (BOX_IN + GAP_IN) for number in range(len(steps) + 1)]
    arrow = {"arrowstyle": "-|>", "color": "black", "linewidth": 0.8, "shrinkA": 0, "shrinkB": 0}
    for number, (text, top) in enumerate(zip([start, *steps], tops, strict=True)):
        colour = COLOURS[1] if number == 0 else COLOURS[0]
        corner = 0.02 * COLUMN_WIDTH_IN, top - BOX_IN
        axes.add_patch(plt.Rectangle(corner, 0.9 * COLUMN_WIDTH_IN, BOX_IN, facecolor="white", edgecolor=colour))
        axes.text(middle, top - BOX_IN / 2, text, ha="center", va="center", fontsize=7)
        if number:
            axes.annotate("", (middle, top), (middle, top + GAP_IN), arrowprops=arrow)
    # Back from the last step to the first, along the right.
    low, high = tops[-1] - BOX_IN / 2, tops[1] - BOX_IN / 2
    edge = 0.92 * COLUMN_WIDTH_IN
    axes.plot([edge, right + 0.1, right + 0.1], [low, low, high], color="black", linewidth=0.8)
    axes.annotate("", (edge, high), (right + 0.1, high), arrowprops=arrow)
    return figure
