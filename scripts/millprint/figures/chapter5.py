"""Figures of thesis chapter 5. They draw tables and compute nothing."""

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.collections import PathCollection
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure

from millprint.figures.style import COLOURS, COLUMN_WIDTH_IN, PAGE_WIDTH_IN, PUBLISHED

TITLES = {
    "linear": "linear",
    "gpr": "GPR",
    "rf": "random forest",
    "svr": "SVR",
    "xgb": "XGBoost",
    "averaged_gpr": "averaged GPR",
}
STRATEGIES = {"primary": ("primary", COLOURS[0], "o"), "two_step": ("two-step", COLOURS[1], "s")}
FEATURE_LABELS = {
    "bpr": "BPR",
    "molar_ratio": "molar ratio",
    "time_h": "time",
    "normal_energy_uJ": r"$\bar{E}_n$",
    "tangential_energy_uJ": r"$\bar{E}_t$",
    "specific_frequency_hz": r"$f_{col}/n$",
    "molar_ratio_squared": "molar ratio (squared)",
    "bpr_molar_ratio": "BPR · molar ratio",
    "time_sigmoid": "time (sigmoid)",
    "bpr_sigmoid": "BPR (sigmoid)",
}
LOW_TO_HIGH = LinearSegmentedColormap.from_list("low_to_high", [COLOURS[0], "#BBBBBB", COLOURS[1]])


def plot_test_predictions(predictions: pd.DataFrame) -> Figure:
    """Fig. 5.2: predicted against measured yield of the test rows, a panel an algorithm.

    predictions: model, strategy, role, yield_percent, predicted_percent.
    """
    test = predictions[predictions["role"] == "test"]
    panels = [name for name in TITLES if name != "linear" and name in set(test["model"])]
    figure, axes = plt.subplots(2, 2, figsize=(COLUMN_WIDTH_IN, 3.5), sharex=True, sharey=True)
    for axis, model in zip(axes.flat, panels, strict=False):
        axis.plot([0, 100], [0, 100], color="#999999", linewidth=0.8)
        for strategy, (title, colour, marker) in STRATEGIES.items():
            rows = test[(test["model"] == model) & (test["strategy"] == strategy)]
            filled = colour if strategy == "primary" else "none"  # one does not hide the other
            axis.plot(
                rows["yield_percent"],
                rows["predicted_percent"],
                marker,
                color=colour,
                markerfacecolor=filled,
                label=title,
            )
        axis.set_title(TITLES[model], fontsize=8)
        axis.set(xlim=(0, 100), ylim=(0, 100))
    figure.supxlabel("measured yield [%]", fontsize=8)
    figure.supylabel("predicted yield [%]", fontsize=8)
    axes.flat[0].legend(fontsize=6, handletextpad=0.2, borderpad=0)
    return figure


def plot_intervals(predictions: pd.DataFrame) -> Figure:
    """Fig. 5.3: measured yields and the predictive intervals of the two-step GPR for every run.

    predictions: model, strategy, case, role, yield_percent, predicted_percent, lower_percent, upper_percent.
    """
    rows = predictions[(predictions["model"] == "gpr") & (predictions["strategy"] == "two_step")]
    rows = rows.assign(number=rows["case"].astype(str)).sort_values("yield_percent", kind="stable")
    figure, axis = plt.subplots(figsize=(PAGE_WIDTH_IN, 2.6))
    place = np.arange(len(rows))
    for role, title, colour in (("train", "training rows", COLOURS[0]), ("test", "test rows", COLOURS[1])):
        part = (rows["role"] == role).to_numpy()
        shown = rows[part]
        errors = [
            shown["predicted_percent"] - shown["lower_percent"],
            shown["upper_percent"] - shown["predicted_percent"],
        ]
        axis.errorbar(
            place[part],
            shown["predicted_percent"],
            errors,
            fmt="o",
            color=colour,
            capsize=2,
            label=f"predicted, {title}",
        )
    axis.plot(place, rows["yield_percent"], label="measured", **PUBLISHED)
    axis.set_xticks(place, rows["number"], fontsize=6)
    axis.set(xlabel="case, by measured yield", ylabel="yield [%]")
    axis.legend(fontsize=7)
    return figure


def _attribution_panel(axis: plt.Axes, rows: pd.DataFrame) -> PathCollection:
    """One summary plot: a point a row, features by mean |SHAP|, the largest on top."""
    size = rows.assign(size=rows["shap_pp"].abs()).groupby("feature")["size"].mean().sort_values()
    for height, feature in enumerate(size.index):
        points = rows[rows["feature"] == feature].sort_values("shap_pp")
        value = points["feature_value"]
        span = value.max() - value.min()
        colour = (value - value.min()) / span if span > 0 else value * 0 + 0.5
        # Neighbours in value are set apart in height, so that points do not hide each other.
        shift = 0.12 * (np.arange(len(points)) % 5 - 2)
        marks = axis.scatter(
            points["shap_pp"], height + shift, c=colour, cmap=LOW_TO_HIGH, vmin=0, vmax=1, s=6, linewidths=0
        )
    axis.axvline(0, color="#999999", linewidth=0.8, zorder=0)
    axis.set_yticks(range(len(size)), [FEATURE_LABELS.get(name, name) for name in size.index])
    axis.set_xlabel("SHAP value [percentage points]")
    return marks


def plot_attributions(values: pd.DataFrame) -> Figure:
    """Fig. 5.4: SHAP values of the two-step tree models.

    values: model, strategy, feature, feature_value, shap_pp.
    """
    figure, axes = plt.subplots(1, 2, figsize=(PAGE_WIDTH_IN, 2.8))
    for axis, model in zip(axes, ("xgb", "rf"), strict=True):
        marks = _attribution_panel(axis, values[(values["model"] == model) & (values["strategy"] == "two_step")])
        axis.set_title(f"two-step {TITLES[model]}", fontsize=8)
    bar = figure.colorbar(marks, ax=axes, ticks=[0, 1], aspect=30)
    bar.set_ticklabels(["low", "high"])
    bar.set_label("feature value")
    return figure
