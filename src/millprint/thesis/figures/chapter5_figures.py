"""Figures of chapter 5: predictions, SHAP values and proposals; and how far models can be trusted."""

from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.collections import PathCollection
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure

from millprint.figures.style import COLOURS, COLUMN_WIDTH_IN, MARKERS, PAGE_WIDTH_IN, PUBLISHED, panels_for
from millprint.thesis.yields.features import LEFT_OUT, NESTED, SPREAD
from millprint.thesis.yields.regressors import AVERAGED, BASELINES, CLIMATOLOGY, TITLES

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
    figure, axes = panels_for(len(panels), 2, (COLUMN_WIDTH_IN, 1.75), sharex=True, sharey=True)
    if len(panels) % 2:
        # Nothing is below the last panel on the right.
        axes[-2:][0].tick_params(labelbottom=True)
    for axis, model in zip(axes, panels, strict=True):
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
    axes[0].legend(fontsize=6, handletextpad=0.2, borderpad=0)
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


SCHEMES = {
    "locked": ("locked split", COLOURS[1], "s"),
    "random_split": ("random 21/6 splits", COLOURS[4], "v"),
    "nested_cv": ("repeated k-fold", COLOURS[2], "^"),
    "leave_one_out": ("leave-one-out", COLOURS[0], "o"),
}
METHODS = {
    "gaussian": ("own normal distribution", COLOURS[1], "s"),
    "mixture": ("own mixture", COLOURS[2], "^"),
    "logit": ("Student's t of the logit", COLOURS[3], "D"),
    "cv_plus": ("CV+", COLOURS[0], "o"),
    "errors": ("spread of the training yields", "#666666", "x"),
}
R2_FROM = -1.0
# The range of a score over its repeats, with a tick at the median.
RANGE: dict[str, Any] = {"linewidth": 4, "alpha": 0.25, "zorder": 1, "capstyle": "butt"}


def draw_range(axis: Axes, rows: pd.DataFrame, height: np.ndarray, colour: str) -> None:
    """The range of every score over its repeats, and a tick at the median; rows: SPREAD."""
    several = (rows["repeats"] > 1).to_numpy()
    low, middle, high = (rows.loc[several, name] for name in ("lowest", "median", "highest"))
    axis.hlines(height[several], low, high, color=colour, **RANGE)
    axis.plot(middle, height[several], "|", color=colour, markersize=7)


def plot_evaluation(scores: pd.DataFrame, claims: pd.DataFrame) -> Figure:
    """R2 of every model by every scheme, with intervals and ranges over repeats, and the printed values of Table 5.6.

    scores: model, strategy, scheme, metric, value, lower, upper, SPREAD, without climatology, whose R2 is 0 by
    definition; claims: id, value.
    """
    published = claims.set_index("id")["value"]
    rows = scores[(scores["metric"] == "r2") & (scores["model"] != CLIMATOLOGY)]
    names = names_of(rows)
    figure, axis = plt.subplots(figsize=(PAGE_WIDTH_IN, 4.6))
    height = np.arange(len(names))[::-1]
    shifts = np.linspace(0.32, -0.32, len(SCHEMES))
    for shift, (scheme, (title, colour, marker)) in zip(shifts, SCHEMES.items(), strict=True):
        part = rows[rows["scheme"] == scheme].set_index(["model", "strategy"]).reindex(names)
        # Values beyond the axis are drawn at its edge.
        inside = part[["value", "lower", "upper", *SPREAD]].clip(lower=R2_FROM)
        draw_range(axis, inside, height + shift, colour)
        errors = interval_errors(inside, "value")
        axis.errorbar(inside["value"], height + shift, xerr=errors, fmt=marker, color=colour, label=title, **BARS)
    claimed = [f"5.{model}.r2" if model == "linear" else f"5.{model}.{strategy}.r2" for model, strategy in names]
    printed = pd.Series(height + shifts[0], index=claimed)[[name in published for name in claimed]]
    axis.plot(published[printed.index].astype(float), printed, label="printed", **PUBLISHED)
    for place in height[:-1]:
        axis.axhline(place - 0.5, color="#DDDDDD", linewidth=0.6, zorder=0)
    axis.set_yticks(height, [model_title(model, strategy) for model, strategy in names])
    axis.tick_params(axis="y", length=0)
    axis.axvline(0, color="#999999", linewidth=0.8, zorder=0)
    axis.set(xlabel="coefficient of determination $R^2$ [-]")
    axis.set(xlim=(R2_FROM - 0.03, 1.03), ylim=(-0.6, len(names) - 0.4))
    figure.legend(loc="outside upper center", ncols=6, fontsize=7, handletextpad=0.3, columnspacing=1.2)
    return figure


def plot_coverage(coverage: pd.DataFrame) -> Figure:
    """Share of left-out runs within their predictive intervals against the nominal level, and the intervals' width.

    coverage: model, strategy, scheme, method, nominal, covered, lower, upper, width_pp. Only repeated k-fold is drawn.
    """
    rows = coverage[coverage["scheme"] == NESTED]
    kinds = list(dict.fromkeys(zip(rows["model"], rows["strategy"], rows["method"], strict=True)))
    levels = sorted(rows["nominal"].unique())
    figure, axes = plt.subplots(1, len(levels) + 1, figsize=(PAGE_WIDTH_IN, 3.4), sharey=True)
    height = np.arange(len(kinds))[::-1]
    table = rows.set_index(["model", "strategy", "method", "nominal"])
    for axis, level in zip(axes[:-1], levels, strict=True):
        axis.axvline(100 * level, color="#999999", linewidth=0.8, zorder=0)
        axis.set(xlabel="runs held [%]", title=f"nominal {100 * level:g} %")
    axes[-1].set(xlabel="mean width [pp]", title=f"{100 * levels[-1]:g} % intervals")
    labelled: set[str] = set()
    for place, kind in zip(height, kinds, strict=True):
        title, colour, marker = METHODS[kind[2]]
        for axis, level in zip(axes[:-1], levels, strict=True):
            row = table.loc[[(*kind, level)]]
            errors = interval_errors(row, "covered", 100)
            axis.errorbar(100 * row["covered"], place, xerr=errors, fmt=marker, color=colour, **BARS)
        label = None if title in labelled else title
        labelled.add(title)
        axes[-1].plot(table.loc[(*kind, levels[-1]), "width_pp"], place, marker, color=colour, label=label)
    axes[-1].set_xlim(0, 105)
    axes[0].set_yticks(height, [model_title(model, strategy) for model, strategy, _ in kinds], fontsize=7)
    for axis in axes:
        axis.title.set_fontsize(8)
        axis.tick_params(axis="y", length=0)
    figure.legend(loc="outside upper center", ncols=3, fontsize=7)
    return figure


BOTH = (LEFT_OUT, NESTED)
AXES = {"crps_pp": "CRPS [percentage points]", "log_score": "logarithmic score [nats]"}


def plot_scores(scores: pd.DataFrame) -> Figure:
    """CRPS and logarithmic score of every model by both schemes, with ranges over repeats; smaller is better.

    scores: model, strategy, scheme, score, value, error, SPREAD.
    """
    names = names_of(scores)
    height = np.arange(len(names))[::-1]
    figure, axes = plt.subplots(1, len(AXES), figsize=(PAGE_WIDTH_IN, 3.2), sharey=True)
    for axis, (score, label) in zip(axes, AXES.items(), strict=True):
        for shift, scheme in zip((0.15, -0.15), BOTH, strict=True):
            title, colour, marker = SCHEMES[scheme]
            rows = scores[(scores["score"] == score) & (scores["scheme"] == scheme)]
            part = rows.set_index(["model", "strategy"]).loc[names]
            style = {"fmt": marker, "color": colour, **BARS}
            shown = title if score == "crps_pp" else None
            draw_range(axis, part, height + shift, colour)
            axis.errorbar(part["value"], height + shift, xerr=part["error"], label=shown, **style)
        axis.set(xlabel=label)
        axis.tick_params(axis="y", length=0)
    axes[0].set_yticks(height, [model_title(*name) for name in names])
    figure.legend(loc="outside upper center", ncols=2, fontsize=7)
    return figure


def plot_pit(table: pd.DataFrame) -> Figure:
    """Histogram of the probability integral of every model by both schemes; flat if predictive distributions are right.

    table: model, strategy, scheme, from, to, share, expected, SPREAD, whose range is shaded.
    """
    names = names_of(table)
    figure, axes = panels_for(len(names), 4, (PAGE_WIDTH_IN, 1.3), 0.4, sharex=True, sharey=True)
    for axis, (model, strategy) in zip(axes, names, strict=True):
        own = table[(table["model"] == model) & (table["strategy"] == strategy)]
        for scheme in BOTH:
            title, colour, _ = SCHEMES[scheme]
            rows = own[own["scheme"] == scheme]
            edges = [*rows["from"], rows["to"].iloc[-1]]
            axis.stairs(rows["share"], edges, color=colour, label=title if axis is axes[0] else None)
            if (rows["repeats"] > 1).all():
                axis.stairs(rows["highest"], edges, baseline=rows["lowest"], fill=True, color=colour, alpha=0.2)
        axis.axhline(own["expected"].iloc[0], color="#999999", linewidth=0.8, zorder=0)
        axis.set_title(model_title(model, strategy), fontsize=7)
    axes[0].set(xlim=(0, 1), ylim=(0, None))
    figure.supxlabel("probability integral of the measured yield [-]", fontsize=8)
    figure.supylabel("share of runs [-]", fontsize=8)
    figure.legend(loc="outside upper center", ncols=2, fontsize=7)
    return figure


def plot_permutations(table: pd.DataFrame) -> Figure:
    """Scores of the averaged model on shuffled yields, and on the measured ones.

    table: permutation (0: measured), r2.
    """
    figure, axis = plt.subplots(figsize=(COLUMN_WIDTH_IN, 2.2))
    shuffled, measured = table[table["permutation"] > 0]["r2"], table[table["permutation"] == 0]["r2"].iloc[0]
    axis.hist(shuffled, bins=25, color="#999999", label="shuffled yields")
    axis.axvline(measured, color=COLOURS[1], label="measured yields")
    axis.set(xlabel="$R^2$ by leave-one-out in closed form [-]", ylabel="shuffles", xlim=(None, 1))
    axis.legend(fontsize=7, loc="upper left")
    return figure
