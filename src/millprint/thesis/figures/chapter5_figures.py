"""Figures of chapter 5: predictions, SHAP values, searches and proposals, other regimes and other sources."""

from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.collections import PathCollection
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from millprint.figures.style import COLOURS, COLUMN_WIDTH_IN, MARKERS, PAGE_WIDTH_IN, PUBLISHED
from millprint.thesis.yields.regressors import AVERAGED, BASELINES, TITLES

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


# How error bars look.
BARS: dict[str, Any] = {"capsize": 1.5, "linewidth": 0.8}


def interval_errors(rows: pd.DataFrame, centre: str, scale: float = 1.0) -> list[pd.Series]:
    """Distances from `centre` to the columns lower and upper of the same kind, as error bars take them."""
    suffix = "_percent" if centre.endswith("_percent") else ""
    return [scale * (rows[centre] - rows[f"lower{suffix}"]), scale * (rows[f"upper{suffix}"] - rows[centre])]


def model_title(model: str, strategy: str) -> str:
    """Name of a model in figures."""
    return TITLES[model] if model in (AVERAGED, *BASELINES) else f"{TITLES[model]}, {STRATEGIES[strategy][0]}"


def names_of(table: pd.DataFrame) -> list[tuple[str, str]]:
    """Model and strategy of the rows of a table, each pair once."""
    return list(dict.fromkeys(zip(table["model"], table["strategy"], strict=True)))


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


SEARCHES = {
    "expected_improvement": ("expected improvement", COLOURS[0], "-"),
    "highest_mean": ("highest mean", COLOURS[2], "--"),
    "least_squares": ("least squares", COLOURS[1], "-."),
    "ridge": ("ridge", COLOURS[3], "-."),
    "most_balls_longest_time": ("most balls, longest time", COLOURS[4], "--"),
    "random": ("random", "#666666", ":"),
}
PURPOSES = {
    "repeat": ("repeated run", COLOURS[2], "D"),
    "centre": ("centre point", COLOURS[3], "^"),
    "yield": ("for a higher yield", COLOURS[1], "s"),
    "learning": ("for a better model", COLOURS[0], "o"),
}
DESCRIPTORS = {
    (AVERAGED, "power and share"): ("averaged GPR, power and share", COLOURS[2], "^"),
    (AVERAGED, "power alone"): ("averaged GPR, power alone", COLOURS[3], "v"),
    ("gpr_starts two_step", "energies and frequency"): ("two-step GPR", COLOURS[0], "o"),
    ("xgb two_step", "energies and frequency"): ("two-step XGBoost", COLOURS[1], "s"),
}
ADDED = {
    "nothing": "none",
    "other regime": "two of\nthe other",
    "1 of the regime": "one of\nits own",
    "other regime, 1 of the regime": "one own,\ntwo other",
}


def plot_retrospective(table: pd.DataFrame) -> Figure:
    """Share of starts that have found the best run against the runs done, for the first target only.

    table: target, strategy, runs, found, lower, upper.
    """
    table = table[table["target"] == table["target"].iloc[0]]
    figure, axis = plt.subplots(figsize=(COLUMN_WIDTH_IN, 2.4))
    for strategy, (title, colour, line) in SEARCHES.items():
        rows = table[table["strategy"] == strategy]
        axis.plot(rows["runs"], 100 * rows["found"], line, color=colour, label=title)
        axis.fill_between(rows["runs"], 100 * rows["lower"], 100 * rows["upper"], color=colour, alpha=0.15, linewidth=0)
    axis.set(xlabel="runs done", ylabel="best run found [% of starts]", ylim=(0, 102))
    axis.set_xlim(table["runs"].min(), table["runs"].max())
    axis.xaxis.set_major_locator(MaxNLocator(integer=True))
    axis.legend(fontsize=7, loc="lower right")
    return figure


def plot_proposals(proposals: pd.DataFrame) -> Figure:
    """The predicted yield of each proposed experiment, with its settings as labels.

    proposals: purpose, rank, the settings, predicted_percent, lower_percent, upper_percent.
    """
    figure, axis = plt.subplots(figsize=(PAGE_WIDTH_IN, 0.9 + 0.27 * len(proposals)))
    height = np.arange(len(proposals))[::-1]
    for purpose, (title, colour, marker) in PURPOSES.items():
        part = (proposals["purpose"] == purpose).to_numpy()
        rows = proposals[part]
        if rows.empty:
            continue
        errors = interval_errors(rows, "predicted_percent")
        axis.errorbar(
            rows["predicted_percent"], height[part], xerr=errors, fmt=marker, color=colour, capsize=2, label=title
        )
    labels = [
        f"{row.rank}. BPR {row.bpr:g}, ratio {row.molar_ratio:g}, {row.time_h:g} h, {row.speed_rpm:g} rpm, "
        f"fill {100 * row.fill_ratio:g} %"
        for row in proposals.itertuples()
    ]
    axis.set_yticks(height, labels)
    axis.tick_params(axis="y", length=0)
    axis.set(xlabel="predicted yield [%]", xlim=(0, 102))
    figure.legend(loc="outside upper center", ncols=4, fontsize=7)
    return figure


def plot_regimes(summary: pd.DataFrame) -> Figure:
    """RMSE at fill ratios that were left out, against the cases added to the training rows.

    summary: model, descriptors, added, rmse_pp.
    """
    figure, axis = plt.subplots(figsize=(COLUMN_WIDTH_IN, 2.9))
    place = np.arange(len(ADDED))
    for (model, descriptors), (title, colour, marker) in DESCRIPTORS.items():
        rows = summary[(summary["model"] == model) & (summary["descriptors"] == descriptors)].set_index("added")
        axis.plot(place, rows.loc[list(ADDED), "rmse_pp"], marker, linestyle="-", color=colour, label=title)
    axis.set_xticks(place, list(ADDED.values()), fontsize=6)
    axis.set(xlabel="cases at other fill ratios in training", ylabel="RMSE [percentage points]")
    axis.set_ylim(bottom=0)
    figure.legend(loc="outside upper center", ncols=2, fontsize=6, columnspacing=1.0)
    return figure


SOURCE_R2_FROM = -2.0


def plot_sources(scores: pd.DataFrame, predictions: pd.DataFrame) -> Figure:
    """Predicted against measured yields of every held-out source, and R2 and mean error with their intervals.

    scores: of score_sources; predictions: of leave_sources_out. Where nothing was predicted, the figure says why.
    """
    if predictions.empty:
        figure, axis = plt.subplots(figsize=(COLUMN_WIDTH_IN, 1.2))
        axis.set_axis_off()
        said = "\n".join(
            f"{row.source} ({row.runs:g} runs): {row.verdict}: {row.reason}" for row in scores.itertuples()
        )
        axis.text(0.5, 0.5, said, ha="center", va="center", wrap=True, fontsize=7)
        return figure
    scored = scores[scores["model"].notna()]
    sources = list(dict.fromkeys(scored["source"]))
    models = names_of(scored)
    looks = {key: (COLOURS[i % len(COLOURS)], MARKERS[i % len(MARKERS)]) for i, key in enumerate(models)}
    figure, (points, r2, error) = plt.subplots(
        1, 3, figsize=(PAGE_WIDTH_IN, 2.2 + 0.35 * len(sources)), width_ratios=[1.2, 1, 1]
    )
    points.plot([0, 100], [0, 100], color="#999999", linewidth=0.8, zorder=0)
    height = np.arange(len(sources))[::-1]
    shifts = np.linspace(0.22, -0.22, len(models))
    for shift, key in zip(shifts, models, strict=True):
        colour, marker = looks[key]
        own = predictions[(predictions["model"] == key[0]) & (predictions["strategy"] == key[1])]
        points.plot(
            *(own[name] for name in ("yield_percent", "predicted_percent")),
            marker,
            color=colour,
            label=model_title(*key),
        )
        rows = scored[(scored["model"] == key[0]) & (scored["strategy"] == key[1])].set_index("source").loc[sources]
        # Values beyond the axis are drawn at its edge.
        inside = rows[["r2", "r2_lower", "r2_upper"]].clip(lower=SOURCE_R2_FROM)
        _bars(r2, inside, "r2", height + shift, colour, marker)
        _bars(error, rows, "mean_error_pp", height + shift, colour, marker)
    points.set(xlabel="measured yield [%]", ylabel="predicted yield [%]", xlim=(0, 102), ylim=(0, 102))
    r2.set(xlabel="$R^2$ on the source [-]", xlim=(SOURCE_R2_FROM - 0.05, 1.05))
    error.set(xlabel="mean error [pp]")
    for axis in (r2, error):
        axis.axvline(0, color="#999999", linewidth=0.8, zorder=0)
        axis.set_ylim(-0.6, len(sources) - 0.4)
        axis.tick_params(axis="y", length=0)
        axis.set_yticks(height, [])
    runs = scored.drop_duplicates("source").set_index("source")["runs"]
    r2.set_yticks(height, [f"{name}\n{runs[name]:g} runs" for name in sources], fontsize=7)
    figure.legend(*points.get_legend_handles_labels(), loc="outside upper center", ncols=3, fontsize=7)
    return figure


def _bars(axis: plt.Axes, rows: pd.DataFrame, name: str, height: np.ndarray, colour: str, marker: str) -> None:
    """A value with its interval for every row; a value without one where there were too few runs."""
    ends = rows[[name, f"{name}_lower", f"{name}_upper"]].set_axis([name, "lower", "upper"], axis=1)
    ends = ends.assign(lower=ends["lower"].fillna(ends[name]), upper=ends["upper"].fillna(ends[name]))
    errors = interval_errors(ends, name)
    axis.errorbar(ends[name], height, xerr=errors, fmt=marker, color=colour, **BARS)
