"""Figures of thesis chapters 3 and 4, of the calibration and of the convergence study. They draw tables and arrays."""

import itertools
from collections.abc import Iterator
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import EngFormatter

from millprint.dem.convergence import SERIES
from millprint.dose.kinetics import AXES, HITS, YIELD
from millprint.figures.style import (
    COLOURS,
    COLUMN_WIDTH_IN,
    FILL_LABEL,
    MARKERS,
    PAGE_WIDTH_IN,
    PUBLISHED,
    LineLook,
    draw_curve,
    legend_below,
    letter_panels,
    show_tolerance,
    ticks_at,
)
from millprint.observables.definitions import DESCRIPTORS, PANELS

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
    show_tolerance(axis, tolerance)
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
    ticks = [float(f"{MICROSECONDS * step:.2g}") for step in table["time_step_s"]]
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
        ticks_at(axis, ticks)
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
    ticks_at(deviation, table["young_modulus_gpa"])
    letter_panels((power, deviation))
    return figure


# Descriptors in the panels of Figs 3.7 and 3.8, and whether their axis is logarithmic.
ENERGY_PANELS = {
    "normal_energy_J": True,
    "tangential_energy_J": True,
    "collision_frequency_hz": True,
    "specific_frequency_hz": False,
}
# Zones that a panel of the master curves shows.
ZONES = {
    "Pn": {"normal_maximum": "largest power", "choking": "both powers below 90 %"},
    "Pt": {"tangential_maximum": "largest power", "choking": "both powers below 90 %"},
    "ratio": {"elbow": "elbow"},
}
EXPONENT_LABELS = {
    "rho": r"$\rho$: exponent $-$ 1 (f: 0)",
    "omega": r"$\omega$: exponent $-$ 3 (E: 2, f: 1)",
    "A": "A: exponent $-$ 2 (f: 0)",
    "d": "d: exponent $-$ 3 (f: 0)",
}
QUANTITY_LABELS = {
    "normal_power_per_ball_W": "normal power",
    "tangential_power_per_ball_W": "tangential power",
    "specific_frequency_hz": "frequency",
    "normal_energy_J": "normal energy",
    "tangential_energy_J": "tangential energy",
}
CONTACT_LINES = ("-", "--", ":", "-.")


def _panels(rows: int, columns: int, height: float) -> tuple[Figure, list]:
    figure, axes = plt.subplots(rows, columns, figsize=(PAGE_WIDTH_IN, height), squeeze=False)
    letter_panels(axes.flat)
    return figure, list(axes.flat)


def plot_cycle_densities(densities: pd.DataFrame) -> Figure:
    """Fig. 3.5: probability density of the dissipation per revolution; one row a ball size, one column a channel."""
    diameters = sorted(densities["ball_diameter_mm"].unique(), reverse=True) or [float("nan")]
    figure, axes = _panels(len(diameters), 2, 0.6 + 1.9 * len(diameters))
    speeds = sorted(densities["speed_rpm"].unique())
    contacts = sorted(densities["contact"].unique())
    for axis, (diameter, channel) in zip(axes, itertools.product(diameters, ("normal", "tangential")), strict=True):
        shown = densities[(densities["ball_diameter_mm"] == diameter) & (densities["channel"] == channel)]
        for (contact, speed), line in shown.groupby(["contact", "speed_rpm"]):
            style, colour = contacts.index(contact) % len(CONTACT_LINES), speeds.index(speed) % len(COLOURS)
            axis.plot(
                line["energy_J"], line["density_per_J"], color=COLOURS[colour], linestyle=CONTACT_LINES[style],
                label=f"{speed:g} rpm, {contact}",
            )  # fmt: skip
        axis.set(xlabel=f"{channel} dissipation per revolution [J]", ylabel="density [1/J]")
        axis.text(0.98, 0.95, f"{diameter:g} mm", transform=axis.transAxes, ha="right", va="top")
    legend_below(figure, [max(axes, key=lambda axis: len(axis.lines))], 4)
    return figure


def plot_cycle_means(cycles: pd.DataFrame, published: pd.DataFrame) -> Figure:
    """Fig. 3.6: mean dissipation per revolution against speed, published means of the calibrated set as diamonds."""
    figure, axes = _panels(1, 2, 2.7)
    for axis, channel in zip(axes, ("normal", "tangential"), strict=True):
        groups = cycles.groupby(["contact", "ball_diameter_mm"], sort=True)
        for index, ((contact, diameter), line) in enumerate(groups):
            mean, deviation = line[f"{channel}_mean_J"], line[f"{channel}_sd_J"]
            marker, label = MARKERS[index % len(MARKERS)], f"{contact}, {diameter:g} mm"
            axis.errorbar(line["speed_rpm"], mean, yerr=deviation, marker=marker, capsize=2, label=label)
        if not published.empty:
            mean = published[f"{channel}_mean_J"]
            axis.plot(published["speed_rpm"], mean, label="published, calibrated", **PUBLISHED)
        axis.set(xlabel="speed [rpm]", ylabel=f"{channel} dissipation\nper revolution [J]", ylim=(0, None))
    legend_below(figure, axes[:1], 3)
    return figure


def plot_energies(descriptors: pd.DataFrame) -> Figure:
    """Figs 3.7 and 3.8: energies per collision and collision frequencies against fill ratio, a line a condition."""
    figure, axes = _panels(2, 2, 4.4)
    # A colour a speed, a marker a ball size.
    diameters = sorted(descriptors["ball_diameter_mm"].unique())
    speeds = sorted(descriptors["speed_rpm"].unique())
    for axis, (quantity, is_logarithmic) in zip(axes, ENERGY_PANELS.items(), strict=True):
        for (diameter, speed), line in descriptors.groupby(["ball_diameter_mm", "speed_rpm"], sort=True):
            marker = MARKERS[diameters.index(diameter) % len(MARKERS)]
            colour = COLOURS[speeds.index(speed) % len(COLOURS)]
            label = f"{diameter:g} mm, {speed:g} rpm"
            axis.plot(line["fill_ratio"], line[quantity], marker=marker, color=colour, label=label)
        scale = "log" if is_logarithmic else "linear"
        axis.set(xlabel=FILL_LABEL, ylabel=DESCRIPTORS[quantity].label, yscale=scale)
    legend_below(figure, axes[:1], 4)
    return figure


def _show_zones(axis: Axes, zones: pd.DataFrame, shown: dict[str, str]) -> None:
    """Fill ratios that were found in the curves: a dashed line, shaded over its interval."""
    for index, (zone, label) in enumerate(shown.items()):
        for found in zones[(zones["zone"] == zone) & zones["value"].notna()].itertuples():
            colour = COLOURS[2 + index]
            axis.axvspan(found.lower, found.upper, color=colour, alpha=0.15, linewidth=0)
            axis.axvline(found.value, color=colour, linestyle="--", linewidth=0.9, label=label)


def plot_master_curves(
    descriptors: pd.DataFrame, means: pd.DataFrame, curves: pd.DataFrame, published: pd.DataFrame, zones: pd.DataFrame
) -> Figure:
    """Figs 3.11 and 3.12: every condition, the mean and its spread, the curve and its band, published values, zones.

    zones: zone, value, lower, upper; lines where a power is largest, the ratio turns and both powers have fallen.
    """
    figure, axes = _panels(2, 2, 4.8)
    for axis, quantity in zip(axes, PANELS, strict=True):
        draw_curve(axis, curves, quantity, "smooth curve")
        fill, single = descriptors["fill_ratio"], descriptors[quantity]
        axis.plot(fill, single, ".", color="0.6", markersize=3, label="single condition")
        mean, lower, upper = (means[name] for name in (quantity, f"{quantity}_lower", f"{quantity}_upper"))
        bars, label = [mean - lower, upper - mean], "mean and standard deviation"
        axis.errorbar(means["fill_ratio"], mean, yerr=bars, fmt="o", capsize=2, color=COLOURS[1], label=label)
        if quantity in published:
            axis.plot(published["fill_ratio"], published[quantity], label="published", **PUBLISHED)
        _show_zones(axis, zones, ZONES.get(quantity, {}))
        axis.set(xlabel=FILL_LABEL, ylabel=DESCRIPTORS[quantity].label, ylim=(0, None))
    legend_below(figure, axes, 3)
    return figure


def plot_exponents(exponents: pd.DataFrame) -> Figure:
    """Differences between the exponents of our runs and those of Eqs 3.28 and 3.29, with intervals.

    exponents: contact, quantity, variable, supposed, exponent, lower, upper; a panel a variable, a row a quantity.
    """
    variables = [name for name in EXPONENT_LABELS if name in set(exponents["variable"])]
    quantities = [name for name in QUANTITY_LABELS if name in set(exponents["quantity"])]
    figure, axes = plt.subplots(
        1, max(len(variables), 1), figsize=(PAGE_WIDTH_IN, 2.6), sharey=True, squeeze=False, sharex=True
    )
    for axis, variable in zip(axes.flat, variables, strict=False):
        shown = exponents[exponents["variable"] == variable]
        axis.axvline(0.0, color="0.5", linewidth=0.8)
        for index, (contact, points) in enumerate(shown.groupby("contact", sort=True)):
            points = points[points["quantity"].isin(quantities)]
            rows = [quantities.index(name) + 0.2 * index for name in points["quantity"]]
            exponent, look = points["exponent"], {"markersize": 3, "capsize": 2, "color": COLOURS[index]}
            ends = [exponent - points["lower"], points["upper"] - exponent]
            axis.errorbar(exponent - points["supposed"], rows, xerr=ends, fmt=MARKERS[index], label=contact, **look)
        axis.set(xlabel=f"{EXPONENT_LABELS[variable]} [-]")
        axis.xaxis.label.set_fontsize(7)
    axes.flat[0].set_yticks(range(len(quantities)), [QUANTITY_LABELS[name] for name in quantities])
    axes.flat[0].set(ylabel="quantity [-]")
    axes.flat[0].invert_yaxis()
    legend_below(figure, list(axes.flat), 4)
    return figure


def plot_universal_curves(descriptors: pd.DataFrame, universal: pd.DataFrame) -> Figure:
    """Fig. 3.14: conditions of every contact set after Eqs 3.31 and 3.32, with their common mean and spread."""
    figure, axes = _panels(2, 2, 4.6)
    fill = universal["fill_ratio"]
    for axis, quantity in zip(axes, PANELS, strict=True):
        lower, upper = universal[f"{quantity}_lower"], universal[f"{quantity}_upper"]
        axis.fill_between(fill, lower, upper, color="0.85", label="standard deviation")
        axis.plot(fill, universal[quantity], color="0.3", label="mean")
        for index, (contact, points) in enumerate(descriptors.groupby("contact", sort=True)):
            fills, marker = points["fill_ratio"], MARKERS[index]
            axis.plot(fills, points[quantity], marker, color=COLOURS[index], markersize=3, label=contact)
        factor = "" if quantity == "ratio" else r" $\times (1-\varepsilon)^{1/2}$"
        label = DESCRIPTORS[quantity].label.replace(" [-]", f"{factor} [-]")
        axis.set(xlabel=FILL_LABEL, ylabel=label, ylim=(0, None))
        axis.yaxis.label.set_fontsize(7)
    legend_below(figure, axes[:1], 4)
    return figure


def plot_maps(maps: list) -> Figure:
    """Figs 3.9 and 3.10: share of time a ball spends in a cell, and granular temperature, one row a fill ratio.

    maps: `OccupancyMap` objects. Both columns have their own scale in each row.
    """
    figure, axes = _panels(len(maps), 2, 0.4 + 1.9 * len(maps))
    for row, chart in enumerate(maps):
        extent_x, extent_y = chart.edges_x_m * 1e3, chart.edges_y_m * 1e3
        pairs = (
            (axes[2 * row], chart.share, "viridis", "relative presence [-]"),
            (axes[2 * row + 1], chart.temperature_m2_s2, "inferno", "granular temperature [m$^2$/s$^2$]"),
        )
        for axis, values, palette, label in pairs:
            image = axis.pcolormesh(extent_x, extent_y, values.T, cmap=palette, rasterized=True)
            axis.set(xlabel="x [mm]", ylabel="y [mm]", aspect="equal")
            figure.colorbar(image, ax=axis, label=label)
        axes[2 * row].set_title(chart.title, fontsize=8)
    return figure


NAMES = {"static_friction": "static friction $\\mu$ [-]", "rolling_friction": "rolling friction $\\mu_r$ [-]"}
PLACES = {"across_mm": "across the jar [mm]", "height_mm": "height [mm]"}


def plot_drops(drops: pd.DataFrame, means: pd.DataFrame) -> Figure:
    """Restitution of every drop against its height; lines are means, bands their confidence intervals.

    drops: contact, drop_height_mm, restitution; means: contact, mean, lower, upper.
    """
    figure, axis = plt.subplots(figsize=(COLUMN_WIDTH_IN, 2.5))
    for index, row in enumerate(means.itertuples()):
        line, colour = drops[drops["contact"] == row.contact], COLOURS[index % len(COLOURS)]
        label = f"{row.contact}: {row.mean:.3f}"
        marker = MARKERS[index % len(MARKERS)]
        axis.plot(line["drop_height_mm"], line["restitution"], marker, color=colour, label=label)
        axis.axhline(row.mean, color=colour, linewidth=0.8)
        axis.axhspan(row.lower, row.upper, color=colour, alpha=0.15, linewidth=0)
    axis.set(xlabel="drop height [mm]", ylabel="restitution [-]", ylim=(0, 1))
    axis.set_xlim(0, 1.08 * drops["drop_height_mm"].max())
    axis.legend()
    return figure


def _plot_path(axis: Axes, track: pd.DataFrame, paths: pd.DataFrame, place: str) -> None:
    for index, (pair, line) in enumerate(paths.groupby(["static_friction", "rolling_friction"], sort=False)):
        is_fit = line["path"].iloc[0] == "fit"
        label = f"{'fit: ' if is_fit else ''}$\\mu$ {pair[0]:.3g}, $\\mu_r$ {pair[1]:.3g}"
        look: LineLook = {"color": COLOURS[0], "zorder": 3} if is_fit else {"color": COLOURS[index], "linewidth": 0.7}
        axis.plot(line["time_s"], line[place], label=label, **look)
    if place in track:
        axis.plot(
            track["time_s"], track[place], "o", color=COLOURS[6], markersize=2, markerfacecolor="none",
            markeredgewidth=0.5, label="track", zorder=2,
        )  # fmt: skip
    axis.set(xlabel="time [s]", ylabel=PLACES[place])
    axis.margins(x=0)


def _plot_profile(axis: Axes, profile: pd.DataFrame, row: pd.Series) -> None:
    axis.axvspan(row["lower"], row["upper"], color="0.9", linewidth=0)
    axis.plot(profile["value"], profile["excess"], "o-", color=COLOURS[0], markersize=3)
    axis.axhline(profile["threshold"].iloc[0], color=COLOURS[1], linestyle="--", linewidth=1)
    if pd.notna(row["given"]):
        axis.axvline(row["given"], color=COLOURS[2], linestyle="-.", linewidth=1)
    axis.locator_params(axis="x", nbins=5)
    axis.set(xlabel=NAMES[row["parameter"]], ylabel="excess over the best fit [-]")


def plot_friction_fit(track: pd.DataFrame, paths: pd.DataFrame, fit: pd.DataFrame, profile: pd.DataFrame) -> Figure:
    """Fig. 3.3: the track of the ball with fitted and varied pairs, and the profile of each coefficient.

    track: time_s and places; paths: path, both coefficients, time_s, places; fit: parameter, given, lower, upper;
    profile: parameter, value, excess, threshold. Grey is the interval, dashed its threshold,
    dash-dotted what was put in.
    """
    figure, axes = plt.subplot_mosaic(
        [["across", "across"], ["height", "height"], ["first", "second"]], figsize=(PAGE_WIDTH_IN, 5.6)
    )
    for name, place in (("across", "across_mm"), ("height", "height_mm")):
        _plot_path(axes[name], track, paths, place)
    axes["across"].set_xlabel("")
    for name, (_, row) in zip(("first", "second"), fit.iterrows(), strict=True):
        _plot_profile(axes[name], profile[profile["parameter"] == row["parameter"]], row)
    letter_panels(axes.values())
    legend_below(figure, axes.values(), 3)
    return figure


MODES = {"speed": ("constant speed", COLOURS[0], "o"), "power": ("constant power", COLOURS[1], "s")}
FILL_PERCENT = "fill ratio [%]"


def plot_yield(cases: pd.DataFrame, slopes: pd.DataFrame) -> Figure:
    """Fig. 4.3: yield against fill ratio with both lines; the upper axis gives the dissipation ratio.

    cases: Table 4.2 (mode, fill_ratio, ratio, yield_percent); slopes: series, intercept, slope_per_pp, r2.
    """
    figure, axis = plt.subplots(figsize=(COLUMN_WIDTH_IN, 2.9))
    for mode, (title, colour, marker) in MODES.items():
        line = cases[cases["mode"].isin(["reference", mode])].sort_values("fill_ratio")
        axis.plot(100 * line["fill_ratio"], line["yield_percent"], marker, color=colour, label=title)
        for fit in slopes[slopes["series"] == mode].itertuples():
            ends = 100 * line["fill_ratio"].iloc[[0, -1]]
            label = f"{fit.slope_per_pp:.3f} per point, $R^2$ = {fit.r2:.3f}"
            axis.plot(ends, 100 * (fit.intercept + fit.slope_per_pp * ends), color=colour, label=label)
    axis.set(xlabel=FILL_PERCENT, ylabel="yield [%]", ylim=(0, 105))
    ratios = cases.drop_duplicates("fill_ratio").sort_values("fill_ratio")
    upper = axis.secondary_xaxis("top")
    upper.set_xticks(100 * ratios["fill_ratio"], [f"{ratio:.2f}" for ratio in ratios["ratio"]])
    upper.set_xlabel("tangential over normal dissipation [-]")
    axis.legend(fontsize=7)
    return figure


def _against_fill(published: pd.DataFrame, ours: pd.DataFrame, quantity: str, label: str) -> Figure:
    """A quantity of the cases against fill ratio: dashed and open of the published curves, solid of ours."""
    figure, axis = plt.subplots(figsize=(COLUMN_WIDTH_IN, 2.7))
    for source, table in {"published curves": published, "our curves": ours}.items():
        for mode, (title, colour, marker) in MODES.items():
            line = table[table["mode"].isin(["reference", mode])].sort_values("fill_ratio")
            look: LineLook = {"linestyle": "-"} if table is ours else {"linestyle": "--", "markerfacecolor": "none"}
            look |= {"marker": marker, "color": colour}
            axis.plot(100 * line["fill_ratio"], line[quantity], label=f"{title}, {source}", **look)
    axis.set(xlabel=FILL_PERCENT, ylabel=label, ylim=(0, None))
    axis.legend(fontsize=7)
    return figure


def plot_specific_yield(published: pd.DataFrame, ours: pd.DataFrame) -> Figure:
    """Fig. 4.4: yield over power against fill ratio, with the powers of the published and of our curves."""
    return _against_fill(published, ours, "specific_yield_per_W", "specific yield [1/W]")


def plot_mass_per_watt(published: pd.DataFrame, ours: pd.DataFrame) -> Figure:
    """Fig. 4.5: converted mass over power against fill ratio, with the powers of the published and of our curves."""
    return _against_fill(published, ours, "mass_per_watt_g_W", "converted mass [g/W]")


SETS = {"screening": "27 screening runs", "regimes": "five cases of chapter 4"}


def plot_doses(doses: pd.DataFrame, curves: pd.DataFrame) -> Figure:
    """Yield against time, each dose, and hits: points, and the law with the smallest AICc; a row per set of runs.

    doses: set, AXES, yield_percent, bpr; curves: set, x (one of AXES), value, yield_percent, model. Colours are
    ball-to-powder ratios.
    """
    figure, axes = plt.subplots(len(SETS), len(AXES), figsize=(PAGE_WIDTH_IN, 3.8), sharey=True)
    ratios = np.unique(doses["bpr"])
    for row, (name, title) in enumerate(SETS.items()):
        runs, lines = doses[doses["set"] == name], curves[curves["set"] == name]
        for axis, (column, label) in zip(axes[row], AXES.items(), strict=True):
            for ratio, group in runs.groupby("bpr"):
                colour = COLOURS[int(np.searchsorted(ratios, ratio))]
                axis.plot(group[column], group[YIELD], "o", markersize=3, color=colour, label=f"BPR {ratio:g}")
            line = lines[lines["x"] == column]
            axis.plot(line["value"], line[YIELD], color="#000000", linewidth=0.8)
            law = line["model"].iloc[0] if len(line) else "all runs as long"
            axis.set_title(law, fontsize=7)
            axis.set_xlim(left=0)
            if column == HITS:
                axis.xaxis.set_major_formatter(EngFormatter(sep=""))
            axis.xaxis.label.set_fontsize(7)
            axis.tick_params(labelsize=6)
            if row == len(SETS) - 1:
                axis.set_xlabel(label)
        axes[row, 0].set_ylabel(f"yield [%]\n{title}", fontsize=7)
        axes[row, 0].set_ylim(0, 100)
    legend_below(figure, axes.flat, columns=len(ratios), fontsize=7)
    return figure
