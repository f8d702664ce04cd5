"""Figures of the convergence study: time step and Young's modulus (thesis Fig. 3.4), with guides to the eye."""

from collections.abc import Iterator
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from millprint.dem.convergence import SERIES
from millprint.figures.style import COLOURS, COLUMN_WIDTH_IN, MARKERS, PAGE_WIDTH_IN, legend_below, letter_panels

DEVIATIONS = {
    "normal_energy": "normal energy\nper collision [%]",
    "tangential_energy": "tangential energy\nper collision [%]",
    "specific_frequency": "specific collision\nfrequency [%]",
}


SHORT = {"normal_energy": "normal energy", "tangential_energy": "tangential energy", "specific_frequency": "frequency"}


MICROSECONDS = 1e6


def _name(row: pd.Series) -> str:
    return f"{row['ball_diameter_mm']:g} mm, fill {row['fill_ratio']:g}, {row['speed_rpm']:g} rpm"


def _series(table: pd.DataFrame) -> Iterator[tuple[int, pd.DataFrame]]:
    """The series of runs of a table, numbered."""
    return enumerate(rows for _, rows in table.groupby(SERIES, sort=False))


def _guide(axis: Axes, x: pd.Series, anchor: tuple[float, float], power: float, label: str) -> None:
    """A straight line of slope `power` through `anchor` on logarithmic axes."""
    ends = np.array([x.min(), x.max()])
    axis.plot(ends, anchor[1] * (ends / anchor[0]) ** power, color="0.6", linestyle=":", linewidth=1, label=label)


def _plot_closure(axis: Axes, table: pd.DataFrame, choice: dict) -> None:
    orders = [series["closure_order"] for series in choice["series"]]
    for index, line in _series(table):
        label = f"{_name(line.iloc[0])}: order {orders[index]:.2f}"
        steps = MICROSECONDS * line["time_step_s"]
        axis.plot(steps, line["closure"], MARKERS[index % 4] + "-", color=COLOURS[index], label=label)
        _guide(axis, steps, (steps.iloc[0], line["closure"].iloc[0]), 2, "" if index else "order 2")
    bound = choice["criteria"]["closure_max"]
    axis.axhline(bound, color=COLOURS[1], linestyle="--", linewidth=1, label=f"bound, {100 * bound:g} %")
    axis.set(yscale="log", ylabel="energy balance error\nover wall work [-]")


def _errorbar(axis: Axes, x: pd.Series, line: pd.DataFrame, name: str, **look: Any) -> None:
    """The deviation of a quantity from the reference, with its standard error."""
    deviation, error = line[f"{name}_deviation_percent"], line[f"{name}_deviation_se_percent"]
    axis.errorbar(x, deviation, yerr=error, capsize=2, **look)


def _plot_deviation(axis: Axes, table: pd.DataFrame, name: str, tolerance: float) -> None:
    axis.axhspan(-tolerance, tolerance, color="0.9", linewidth=0)
    axis.axhline(0, color="0.6", linewidth=0.8)
    for index, line in _series(table):
        # Side by side, to distinguish bars of two series at the same step.
        steps = MICROSECONDS * line["time_step_s"] * (1 + 0.04 * index)
        _errorbar(axis, steps, line, name, marker=MARKERS[index % 4], color=COLOURS[index])
    axis.set_ylabel(f"change of {DEVIATIONS[name]}")


def plot_timestep(table: pd.DataFrame, choice: dict) -> Figure:
    """Energy balance error and descriptors against the time step, the step of the sweeps as a dash-dotted line.

    table: time_step_s, closure and deviations of the time-step sweep; choice: what `choose_step` returns.
    """
    figure, axes = plt.subplots(2, 2, figsize=(PAGE_WIDTH_IN, 4.4))
    ticks = sorted({float(f"{MICROSECONDS * step:.2g}") for step in table["time_step_s"]})
    _plot_closure(axes.flat[0], table, choice)
    for axis, name in zip(axes.flat[1:], DEVIATIONS, strict=True):
        _plot_deviation(axis, table, name, choice["criteria"]["tolerance_percent"])
    letter_panels(axes.flat)
    for axis in axes.flat:
        for index, series in enumerate(choice["series"]):
            taken = MICROSECONDS * series["taken_step_s"]
            label = "" if index else "step of the sweeps"
            axis.axvline(taken, color=COLOURS[index], linestyle="-.", linewidth=1, label=label)
        axis.set(xscale="log", xlabel="time step [µs]")
        axis.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
        axis.minorticks_off()
    legend_below(figure, axes.flat[:1], 3)
    return figure


def _plot_power(power: Axes, table: pd.DataFrame) -> None:
    """Fig. 3.4's form: power on the left axis, run time on the right one."""
    clock = power.twinx()
    clock.spines["right"].set_visible(True)
    for index, line in _series(table):
        moduli, marker, hard = line["young_modulus_gpa"], MARKERS[index % 4], line.iloc[0]
        bars = {"yerr": line["power_two_sigma_W"], "capsize": 2, "color": COLOURS[1]}
        power.errorbar(moduli, line["power_W"], marker=marker, label=f"power, {_name(hard)}", **bars)
        ends = (hard["power_W"] + sign * hard["power_two_sigma_W"] for sign in (-1, 1))
        power.axhspan(*ends, color=COLOURS[1], alpha=0.1, linewidth=0)
        clock.plot(moduli, line["processor_s"], marker=marker, color=COLOURS[6], label="run time")
        at = (hard["young_modulus_gpa"], hard["processor_s"])
        _guide(clock, moduli, at, 0.5, r"run time $\propto \sqrt{Y}$")
    power.set(ylim=(0, None))
    power.set_ylabel("dissipated power [W]", color=COLOURS[1])
    clock.set(ylabel="processor time [s]", yscale="log")
    entries = [axis.get_legend_handles_labels() for axis in (power, clock)]
    handles, labels = ([*first, *second] for first, second in zip(*entries, strict=True))
    power.figure.legend(handles, labels, loc="outside upper center", ncols=2, fontsize=6)


def plot_modulus(table: pd.DataFrame) -> Figure:
    """Fig. 3.4: mean power with two standard deviations between revolutions, and run time, against Young's modulus.

    table: young_modulus_gpa, power_W, power_two_sigma_W, processor_s and deviations of the modulus sweep, stiffest
    first. The band is for the stiffest ball; below, changes of the descriptors with one standard error.
    """
    figure, (power, deviation) = plt.subplots(2, 1, figsize=(COLUMN_WIDTH_IN, 4.4), sharex=True)
    _plot_power(power, table)
    deviation.axhline(0, color="0.6", linewidth=0.8)
    for index, line in _series(table):
        for place, (name, label) in enumerate(SHORT.items()):
            moduli, colour = line["young_modulus_gpa"] * (1 + 0.06 * place), COLOURS[(0, 2, 3)[place]]
            marker = MARKERS[index % 4]
            _errorbar(deviation, moduli, line, name, marker=marker, color=colour, label="" if index else label)
    deviation.set(xlabel="Young's modulus [GPa]", ylabel="change from the\nstiffest ball [%]", xscale="log")
    deviation.legend(fontsize=6)
    moduli = sorted(table["young_modulus_gpa"].unique())
    deviation.set_xticks(moduli, [f"{modulus:g}" for modulus in moduli])
    deviation.minorticks_off()
    letter_panels((power, deviation))
    return figure
