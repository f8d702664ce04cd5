"""Figures of thesis chapter 5. They draw tables and compute nothing."""

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.collections import PathCollection
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure

from millprint.figures.style import COLOURS, COLUMN_WIDTH_IN, PAGE_WIDTH_IN, PUBLISHED
from millprint.thesis.yields.regressors import TITLES

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


def interval_errors(rows: pd.DataFrame, centre: str, scale: float = 1.0) -> list[pd.Series]:
    """Distances from `centre` to the columns lower and upper of the same kind, as error bars take them."""
    suffix = "_percent" if centre.endswith("_percent") else ""
    return [scale * (rows[centre] - rows[f"lower{suffix}"]), scale * (rows[f"upper{suffix}"] - rows[centre])]


def plot_test_predictions(predictions: pd.DataFrame) -> Figure:
    """Fig. 5.2: predicted against measured yield of the test rows, a panel for each model but the linear one.

    predictions: model, strategy, role, yield_percent, predicted_percent.
    """
    test = predictions[predictions["role"] == "test"]
    panels = [name for name in TITLES if name != "linear" and name in set(test["model"])]
    lines = (len(panels) + 1) // 2
    figure, axes = plt.subplots(
        lines, 2, figsize=(COLUMN_WIDTH_IN, 1.75 * lines), sharex=True, sharey=True, squeeze=False
    )
    if len(panels) % 2:
        axes[-1, 1].remove()
        axes[max(lines - 2, 0), 1].tick_params(labelbottom=True)
    for axis, model in zip(axes.flat[: len(panels)], panels, strict=True):
        axis.plot([0, 100], [0, 100], color="#999999", linewidth=0.8)
        for strategy, (title, colour, marker) in STRATEGIES.items():
            rows = test[(test["model"] == model) & (test["strategy"] == strategy)]
            # Open markers do not hide the filled ones.
            face = colour if strategy == "primary" else "none"
            points = rows["yield_percent"], rows["predicted_percent"]
            axis.plot(*points, marker, color=colour, markerfacecolor=face, label=title)
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
    for role, colour in (("train", COLOURS[0]), ("test", COLOURS[1])):
        part = (rows["role"] == role).to_numpy()
        centre, errors = rows.loc[part, "predicted_percent"], interval_errors(rows[part], "predicted_percent")
        title = f"predicted, {'training' if role == 'train' else role} rows"
        axis.errorbar(place[part], centre, errors, fmt="o", color=colour, capsize=2, label=title)
    axis.plot(place, rows["yield_percent"], label="measured", **PUBLISHED)
    axis.set_xticks(place, rows["number"], fontsize=6)
    axis.set(xlabel="case, by measured yield", ylabel="yield [%]")
    axis.legend(fontsize=7)
    return figure


def _attribution_panel(axis: plt.Axes, rows: pd.DataFrame) -> PathCollection:
    """One summary plot with a point for each row; features are sorted by mean |SHAP|, the largest on top."""
    size = rows.assign(size=rows["shap_pp"].abs()).groupby("feature")["size"].mean().sort_values()
    for height, feature in enumerate(size.index):
        points = rows[rows["feature"] == feature].sort_values("shap_pp")
        value = points["feature_value"]
        span = value.max() - value.min()
        colour = (value - value.min()) / span if span > 0 else value * 0 + 0.5
        # Points of similar value are drawn at different heights, so that they do not hide each other.
        shift = 0.12 * (np.arange(len(points)) % 5 - 2)
        marks = axis.scatter(
            points["shap_pp"], height + shift, c=colour, cmap=LOW_TO_HIGH, vmin=0, vmax=1, s=6, linewidths=0
        )
    axis.axvline(0, color="#999999", linewidth=0.8, zorder=0)
    axis.set_yticks(range(len(size)), [FEATURE_LABELS.get(name, name) for name in size.index])
    axis.set_xlabel("SHAP value [percentage points]")
    return marks


def plot_attributions(values: pd.DataFrame) -> Figure:
    """Fig. 5.4: SHAP values of the two-step models, a panel for each in reverse order: XGBoost before the forest.

    values: model, strategy, feature, feature_value, shap_pp.
    """
    rows = values[values["strategy"] == "two_step"]
    models = list(dict.fromkeys(rows["model"]))[::-1]
    figure, axes = plt.subplots(1, len(models), figsize=(PAGE_WIDTH_IN, 2.8), squeeze=False)
    for axis, model in zip(axes.flat, models, strict=True):
        marks = _attribution_panel(axis, rows[rows["model"] == model])
        axis.set_title(f"two-step {TITLES[model]}", fontsize=8)
    bar = figure.colorbar(marks, ax=axes, ticks=[0, 1], aspect=30)
    bar.set_ticklabels(["low", "high"])
    bar.set_label("feature value")
    return figure
