"""Figures of chapter 6: training, roll-outs, their errors and movies."""

import itertools
from collections.abc import Sequence

import numpy as np
import pandas as pd
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import EllipseCollection, LineCollection, PolyCollection
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import MaxNLocator

from millprint.config.surrogate import EdgeConfig
from millprint.figures.animation import INK, SPEEDS, WALL_DARK, WALL_LIGHT
from millprint.figures.style import COLOURS, COLUMN_WIDTH_IN, PAGE_WIDTH_IN, PUBLISHED, LineLook, panels_for, plt
from millprint.view.frames import Movie, Picture

LABELS: dict[str, tuple[str, LineLook]] = {
    "surrogate": ("surrogate", {"color": COLOURS[1]}),
    "dem": ("DEM", {"color": COLOURS[0]}),
    "other_seed": ("DEM, other seed", {"color": COLOURS[0], "linestyle": ":"}),
    "twin": ("DEM, 1 nm away at the start", {"color": COLOURS[0]}),
    "centroid": ("all at the centre of mass", {"color": COLOURS[2], "linestyle": "--"}),
    "original": ("DEM, original jar", {"color": COLOURS[3], "linestyle": "-."}),
}
# Column of a history, its label and its look.
LOSSES: tuple[tuple[str, str, LineLook], ...] = (
    ("training_total", "training", {"color": COLOURS[0]}),
    ("validation_total", "validation", {"color": COLOURS[1]}),
    ("validation_mean_square", "validation, MSE of acceleration", {"color": COLOURS[2], "linestyle": "--"}),
)
# Height of a box of the flow chart and of the gap below it.
BOX_IN, GAP_IN = 0.44, 0.16
# What r_c bounds, by its reading.
READINGS = {"surface_gap": "gap of surfaces", "centre_distance": "distance of centres"}
TITLES = {
    "trained": "motion of the training",
    "motion1": "unseen motion 1",
    "motion2": "unseen motion 2",
    "post": "unseen: central post, motion 1",
}


def plot_distance_slices(slices: list[dict]) -> Figure:
    """Signed distance on plane sections (Fig. 6.3).

    Each slice: `title`, `axes` (names of the two axes), `first_m` (a,), `second_m` (b,), `distance_m` (b, a) with
    values that are not numbers outside the vessel.
    """
    figure, panels = plt.subplots(len(slices), 1, figsize=(COLUMN_WIDTH_IN, 2.1 * len(slices)), squeeze=False)
    lowest = min(np.nanmin(part["distance_m"]) for part in slices) * 1e3
    for panel, part in zip(panels[:, 0], slices, strict=True):
        extent = [1e3 * part[key][end] for key in ("first_m", "second_m") for end in (0, -1)]
        image = panel.imshow(
            1e3 * part["distance_m"], origin="lower", extent=extent, vmin=lowest, vmax=0, cmap="viridis", aspect="equal"
        )
        contours = np.arange(np.floor(lowest / 5) * 5, 0, 5)
        x, y = 1e3 * part["first_m"], 1e3 * part["second_m"]
        panel.contour(x, y, 1e3 * part["distance_m"], contours, colors="white", linewidths=0.4, linestyles="solid")
        panel.set(title=part["title"], xlabel=f"{part['axes'][0]} / mm", ylabel=f"{part['axes'][1]} / mm")
    figure.colorbar(image, ax=panels, label="signed distance / mm", shrink=0.8)
    return figure


def plot_wall_contacts(table: pd.DataFrame, threshold_m: float, share: float) -> Figure:
    """Signed distance of balls that touch the wall, and the threshold of the roll-out's edges (Fig. 6.4)."""
    figure, panel = plt.subplots(figsize=(COLUMN_WIDTH_IN, 2.3))
    total = table["contacts"].sum()
    widths = 1e3 * (table["high_m"] - table["low_m"])
    panel.bar(1e3 * table["low_m"], 100 * table["contacts"] / total, widths, align="edge", color=COLOURS[0])
    label = f"$\\phi_{{pw}}$ = {1e3 * threshold_m:g} mm covers {100 * share:.1f} %"
    panel.axvline(1e3 * threshold_m, color=COLOURS[1], label=label)
    met = table.loc[table["contacts"] > 0]
    low, high = min(met["low_m"].min(), threshold_m), max(met["high_m"].max(), threshold_m)
    panel.set(xlabel="signed distance of the centre / mm", ylabel="wall contacts / %", yscale="log")
    panel.set_xlim(1e3 * low - 0.05, 1e3 * high + 0.05)
    panel.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0))
    return figure


def plot_recursion(window: int, edges: EdgeConfig, snap_back_m: float | None, step_s: float) -> Figure:
    """The recursive stage of a variant as a flow chart, whose last step leads to the first (Fig. 6.5)."""
    reach = READINGS[edges.ball_threshold_reading]
    back = "balls stay where they are"
    if snap_back_m is not None:
        back = f"balls with φ ≥ {1e3 * snap_back_m:g} mm back to there"
    start = f"window of {window} snapshots from DEM"
    steps = [
        "graph of the newest snapshot,\nfeatures of the whole window",
        "network: acceleration of each ball,\ndissipation of the step",
        f"Euler step of {step_s:g} s\n(Eqs 6.31, 6.32)",
        "place of the jar from its motion,\nsigned distance φ of every ball",
        f"edges: wall where φ ≥ {1e3 * edges.wall_threshold_m:g} mm,\n"
        f"balls where the {reach} ≤ {1e3 * edges.ball_threshold_m:g} mm",
        f"snap-back: {back}",
        "newest snapshot in, oldest out",
    ]
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


# Curves of roll-outs after further trainings of the same surrogate.
OTHER_TRAININGS: LineLook = {"color": COLOURS[1], "linewidth": 0.6, "linestyle": ":"}


def plot_loss(history: pd.DataFrame) -> Figure:
    """Loss on training and validation snapshots over the epochs, and its terms (Fig. 6.6).

    Columns: epoch, training_TERM and validation_TERM of `total` and of its terms, and validation_mean_square.
    """
    figure, panels = plt.subplots(1, 2, figsize=(PAGE_WIDTH_IN, 2.5))
    terms = [name.removeprefix("training_") for name in history.columns if name.startswith("training_")]
    terms.remove("total")
    for column, title, look in LOSSES:
        panels[0].plot(history["epoch"], history[column], label=title, **look)
    for term, colour in zip(terms, itertools.cycle(COLOURS), strict=False):
        panels[1].plot(history["epoch"], history[f"training_{term}"], color=colour, label=term.replace("_", " "))
        panels[1].plot(history["epoch"], history[f"validation_{term}"], color=colour, linestyle="--")
    panels[0].set(title="total loss, Eq. 6.28")
    panels[1].set(title="its terms (dashed: validation)")
    for panel in panels:
        panel.set(xlabel="epoch", ylabel="standardised loss / 1", yscale="log")
        panel.xaxis.set_major_locator(MaxNLocator(integer=True))
        panel.legend(loc="upper center", bbox_to_anchor=(0.5, -0.25), ncols=3, handlelength=1.2, columnspacing=1)
    return figure


def _grid(tests: list[str]) -> tuple[Figure, dict[str, Axes]]:
    columns, width = (2, PAGE_WIDTH_IN) if len(tests) > 1 else (1, COLUMN_WIDTH_IN)
    figure, panels = panels_for(len(tests), columns, (width, 2.1))
    for test, panel in zip(tests, panels, strict=True):
        panel.set_title(TITLES.get(test, test))
    return figure, dict(zip(tests, panels, strict=True))


def _draw_curves(panel: Axes, part: pd.DataFrame, names: tuple[str, ...], unit: str) -> None:
    """Curves over time of the columns NAME_UNIT that the table has."""
    for name in names:
        column = f"{name}_{unit}"
        if column in part and part[column].notna().any():
            label, look = LABELS[name]
            panel.plot(part["time_s"], part[column], label=label, **look)


def plot_error_growth(errors: pd.DataFrame) -> Figure:
    """Position error over time next to the errors of two other DEM runs and of the centre of mass (Figs 6.7, 6.11)."""
    figure, panels = _grid(list(errors["test"].unique()))
    for test, panel in panels.items():
        part = errors[(errors["test"] == test) & (errors["time_s"] > 0)]
        _draw_curves(panel, part, ("surrogate", "twin", "other_seed", "centroid"), "m2")
        if test == "trained":
            panel.axhline(2e-4, color="black", linewidth=0.8, label="thesis, plateau")
        panel.set(xlabel="time since the start of the roll-out / s", ylabel="MSE / m$^2$", yscale="log", xscale="log")
        # The axis leaves out the first errors after a disturbance of 1e-9 m, and the last ones of escaped balls.
        panel.set_ylim(1e-13, 30 * part["other_seed_m2"].max())
    handles, labels = next(iter(panels.values())).get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=3)
    return figure


def plot_dissipation(dissipation: pd.DataFrame, metrics: pd.DataFrame, trainings: Sequence[pd.DataFrame]) -> Figure:
    """Cumulative dissipation of the roll-out and of DEM (Figs 6.8, 6.14, 6.15, 6.17).

    metrics: as `millprint.thesis.surrogate.measures.with_spread`; trainings: the same table of each further
    training.
    """
    figure, panels = _grid(list(dissipation["test"].unique()))
    errors = metrics[metrics["measure"] == "dissipation_error_percent"].set_index("test")
    for test, panel in panels.items():
        part = dissipation[dissipation["test"] == test]
        _draw_curves(panel, part, ("dem", "other_seed", "original", "surrogate"), "J")
        for number, other in enumerate(trainings):
            own, label = other[other["test"] == test], "other trainings" if number == 0 else None
            panel.plot(own["time_s"], own["surrogate_J"], label=label, **OTHER_TRAININGS)
        note = f"error after {errors['length_s'][test]:g} s: {errors['value'][test]:.3g} %"
        if trainings:
            ends = f"{errors['lowest'][test]:.3g} to {errors['highest'][test]:.3g} %"
            note += f"\n{len(trainings) + 1} trainings {ends}"
        if pd.notna(errors["thesis"][test]):
            note += f"\nthesis {errors['thesis'][test]:g} %"
        # The curve of a roll-out that loses half of the energy crosses the note.
        paper = {"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 1}
        panel.text(0.97, 0.05, note, transform=panel.transAxes, ha="right", va="bottom", bbox=paper)
        panel.set(xlabel="time since the start of the roll-out / s", ylabel="cumulative dissipation / J")
        # A roll-out that runs away leaves the picture.
        panel.set_ylim(0, 1.8 * part["dem_J"].max())
        panel.legend(loc="upper left")
    return figure


# Quantity of a distribution: label of its axis, unit of its density, and the factor to both.
DISTRIBUTIONS = {
    "speed_m_s": ("speed / m s$^{-1}$", "s m$^{-1}$", 1),
    "wall_distance_m": ("wall distance / mm", "mm$^{-1}$", 1e3),
    "contacts": ("contacts of a ball", "1", 1),
    "increment_5ms_J": ("energy in 5 ms / mJ", "mJ$^{-1}$", 1e3),
}


def plot_distributions(distributions: pd.DataFrame, metrics: pd.DataFrame) -> Figure:
    """Densities of speed, wall distance, contacts a ball and dissipation increments, a row a test.

    metrics: as `millprint.thesis.surrogate.measures.with_spread`, of which the length of each roll-out is taken.
    """
    lengths_s = metrics.groupby("test")["length_s"].max()
    tests = list(distributions["test"].unique())
    figure, panels = plt.subplots(
        len(tests), len(DISTRIBUTIONS), figsize=(PAGE_WIDTH_IN, 1.6 * len(tests) + 0.3), squeeze=False
    )
    for row, test in zip(panels, tests, strict=True):
        for panel, (quantity, (label, unit, scale)) in zip(row, DISTRIBUTIONS.items(), strict=True):
            part = distributions[(distributions["test"] == test) & (distributions["quantity"] == quantity)]
            middle = scale * (part["low"] + part["high"]) / 2
            for name in ("dem", "other_seed", "surrogate"):
                panel.plot(middle, part[name].where(part[name] > 0) / scale, label=LABELS[name][0], **LABELS[name][1])
            panel.set(xlabel=label, ylabel=f"density / {unit}", yscale="log")
            panel.xaxis.set_major_locator(MaxNLocator(4, integer=True))
        row[0].set_title(f"{TITLES.get(test, test)}, {lengths_s[test]:g} s", loc="left")
    handles, labels = panels[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=3)
    return figure


def plot_ablations(ablations: pd.DataFrame, scatter: str) -> Figure:
    """Dissipation error and position error of each ablation next to the baseline and the thesis (appendix A).

    lower_percent and upper_percent, where they are known, are drawn as error bars; scatter: a sentence on them.
    """
    figure, panels = plt.subplots(1, 2, figsize=(PAGE_WIDTH_IN, 3.0), sharey=True)
    # Roll-outs that run away leave the picture.
    lengths = " or ".join(f"{length:g} s" for length in sorted(ablations["rollout_s"].unique()))
    shown = {
        "dissipation_error_percent": (f"error of the dissipation after {lengths} / %", 1e4),
        "position_mse_plateau_m2": ("plateau of the position error / m$^2$", 0.1),
    }
    places = range(len(ablations))
    colours = [COLOURS[0] if stable else COLOURS[1] for stable in ablations["stable"]]
    for panel, (measure, (label, most)) in zip(panels, shown.items(), strict=True):
        finite = ablations[measure].where(np.isfinite(ablations[measure]))
        panel.barh(places, finite, color=colours)
        for place in np.flatnonzero(finite.isna()):
            panel.text(0.02, place, "not finite", transform=panel.get_yaxis_transform(), va="center")
        panel.set(xlabel=label, xscale="log" if (finite > 0).any() else "linear")
        if finite.max() > most:
            panel.set_xlim(right=most)
    # A bar beyond the picture ends at its edge.
    ends = ablations[["lower_percent", "upper_percent"]].clip(upper=shown["dissipation_error_percent"][1])
    panels[0].hlines(places, ends["lower_percent"], ends["upper_percent"], color="black", linewidth=0.8)
    if scatter:
        figure.supxlabel(scatter, fontsize=7, wrap=True)
    panels[0].plot(ablations["thesis_percent"], places, **PUBLISHED)
    panels[0].set_yticks(places, ablations["variant"])
    panels[0].invert_yaxis()
    handles: list[Artist] = [Patch(color=COLOURS[0], label="stable"), Patch(color=COLOURS[1], label="unstable")]
    handles.append(Line2D([], [], label="thesis", **PUBLISHED))
    figure.legend(handles=handles, loc="outside upper center", ncols=3)
    return figure


def plot_motion(movie: Movie, moments: list[int]) -> Figure:
    """Frames of a movie, a column a moment and a row a panel; colours are speeds relative to the jar."""
    start_s = movie.frames[0].time_s
    sizes = [panel.limits_mm[1] - panel.limits_mm[0] for panel in movie.panels]
    shares = [size[1] / sizes[0][0] for size in sizes]
    width = (PAGE_WIDTH_IN - 1.5) / len(moments)
    figure, panels = plt.subplots(
        len(sizes),
        len(moments),
        figsize=(PAGE_WIDTH_IN, width * sum(shares) + 0.25 * len(sizes) + 0.5),
        height_ratios=shares,
        squeeze=False,
    )
    speeds = Normalize(0, movie.speed_max_m_s)
    for column, moment in enumerate(moments):
        frame = movie.frames[moment]
        panels[0, column].set_title(f"{1e3 * (frame.time_s - start_s):.0f} ms", fontsize=8)
        for axes, panel, picture in zip(panels[:, column], movie.panels, frame.pictures, strict=True):
            _draw(axes, picture, speeds)
            axes.set(xlim=panel.limits_mm[:, 0], ylim=panel.limits_mm[:, 1], aspect="equal")
            axes.tick_params(labelsize=6, length=2, labelbottom=axes in panels[-1], labelleft=column == 0)
    for axes, panel in zip(panels[:, 0], movie.panels, strict=True):
        who, view = panel.title.split(", ")[:2]
        axes.set_ylabel(f"{who}\n{view}\n{panel.labels[1]}", fontsize=7)
    for axes in panels[-1]:
        axes.set_xlabel(movie.panels[-1].labels[0], fontsize=7)
    figure.colorbar(
        ScalarMappable(speeds, SPEEDS), ax=panels, label="speed relative to the jar / m s$^{-1}$", shrink=0.5
    )
    return figure


def _draw(axes: Axes, picture: Picture, speeds: Normalize) -> None:
    grey = WALL_DARK + (WALL_LIGHT - WALL_DARK) * picture.wall_shade
    shades = np.repeat(grey[:, None], 3, axis=1)
    # Hundreds of triangles in shades of grey: as pixels also in a drawing of lines.
    walls = PolyCollection(list(picture.wall_mm), facecolors=shades, edgecolors=shades, linewidths=0.3, rasterized=True)
    axes.add_collection(walls)
    axes.add_collection(LineCollection(list(picture.outline_mm), colors=INK, linewidths=0.5))
    size = 2 * picture.radius_mm
    axes.add_collection(
        EllipseCollection(
            size,
            size,
            np.zeros(len(size)),
            units="xy",
            offsets=picture.centre_mm,
            offset_transform=axes.transData,
            facecolors=SPEEDS(speeds(picture.speed_m_s)),
            edgecolors=INK,
            linewidths=0.3,
        )
    )
