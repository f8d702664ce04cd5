"""What transfers between sources of yields. It draws tables and computes nothing."""

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from millprint.figures.style import COLOURS, COLUMN_WIDTH_IN, MARKERS, PAGE_WIDTH_IN
from millprint.thesis.figures.chapter5_figures import STRATEGIES, interval_errors
from millprint.thesis.yields.regressors import AVERAGED, TITLES

R2_FROM = -2.0


def _title(model: str, strategy: str) -> str:
    return TITLES[model] if model == AVERAGED else f"{TITLES[model]}, {STRATEGIES[strategy][0]}"


def plot_sources(scores: pd.DataFrame, predictions: pd.DataFrame) -> Figure:
    """Predicted against measured yields of every held-out source, and R2 and mean error with their intervals.

    scores: of score_sources; predictions: of leave_sources_out. Where nothing was predicted, the figure says why.
    """
    if predictions.empty:
        figure, axis = plt.subplots(figsize=(COLUMN_WIDTH_IN, 1.2))
        axis.set_axis_off()
        said = "\n".join(f"{row.source} ({row.runs:g} runs): {row.verdict}" for row in scores.itertuples())
        axis.text(0.5, 0.5, said, ha="center", va="center", wrap=True, fontsize=7)
        return figure
    scored = scores[scores["model"].notna()]
    sources = list(dict.fromkeys(scored["source"]))
    models = list(dict.fromkeys(zip(scored["model"], scored["strategy"], strict=True)))
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
            *(own[name] for name in ("yield_percent", "predicted_percent")), marker, color=colour, label=_title(*key)
        )
        rows = scored[(scored["model"] == key[0]) & (scored["strategy"] == key[1])].set_index("source").loc[sources]
        # Values beyond the axis are drawn at its edge.
        inside = rows[["r2", "r2_lower", "r2_upper"]].clip(lower=R2_FROM)
        _bars(r2, inside, "r2", height + shift, colour, marker)
        _bars(error, rows, "mean_error_pp", height + shift, colour, marker)
    points.set(xlabel="measured yield [%]", ylabel="predicted yield [%]", xlim=(0, 102), ylim=(0, 102))
    r2.set(xlabel="$R^2$ on the source [-]", xlim=(R2_FROM - 0.05, 1.05))
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
    axis.errorbar(ends[name], height, xerr=errors, fmt=marker, color=colour, capsize=1.5, linewidth=0.8)
