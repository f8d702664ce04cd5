"""Figures of energy spectra, and of the heat balance over a programme. They draw tables and compute nothing."""

import itertools
import textwrap
from collections.abc import Callable, Sequence

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from millprint.config.charge import balls_in_words
from millprint.dose.spectra import BOTH
from millprint.figures.style import COLOURS, MARKERS, PAGE_WIDTH_IN, legend_below, letter_panels, no_formula, plt
from millprint.fingerprint.mill_sheet import shown_speed
from millprint.run.numbers import prefix_of, three

CHANNELS = {"normal": "normal energy [J]", "tangential": "tangential energy [J]"}
PAIRS = {"ball_ball": ("ball on ball", "-"), "ball_wall": ("ball on wall", "--")}
QUANTITIES = {
    "collisions_hz": "collisions per bin [1/s]",
    "power_W": "power per bin [W]",
    "power_above_share": "share of power above [-]",
}


def plot_spectra(spectra: pd.DataFrame, title: str) -> Figure:
    """Collisions, power and cumulative share of the power over the energy of a collision, a column per channel.

    spectra: of one charge at one speed by one rule, as of `dose.spectra_shown.shown`; a colour per fill ratio, solid
    lines for ball on ball, dashed lines for ball on wall. The open bins at both ends are not drawn.
    """
    bins = spectra.dropna(subset=["energy_low_J", "energy_high_J"])

    def draw(axis: Axes, channel: str, quantity: str) -> None:
        _draw(axis, bins[bins["channel"] == channel], quantity)

    figure = _channels_beside(list(QUANTITIES), 6.2, draw, decades=7)
    figure.suptitle(no_formula(title), fontsize=8)
    return figure


def _channels_beside(
    quantities: Sequence[str], height_in: float, draw: Callable[[Axes, str, str], None], decades: int
) -> Figure:
    """A column per channel and a row per quantity, each panel drawn by `draw`; decades: of logarithmic axes."""
    figure, axes = plt.subplots(len(quantities), 2, figsize=(PAGE_WIDTH_IN, height_in), sharex="col", sharey="row")
    for column, (channel, label) in enumerate(CHANNELS.items()):
        for axis, quantity in zip(axes[:, column], quantities, strict=True):
            draw(axis, channel, quantity)
            axis.set(xscale="log", yscale="linear" if quantity == "power_above_share" else "log")
            if column == 0:
                axis.set_ylabel(QUANTITIES[quantity])
        axes[-1, column].set_xlabel(label)
    for axis in axes[:2, 0]:
        _cut(axis, decades)
    letter_panels(axes.flat)
    legend_below(figure, axes.flat, columns=4, fontsize=7)
    return figure


CHANNEL_COLOURS = dict(zip(CHANNELS, COLOURS, strict=False))


def draw_sheet_spectra(axes: Sequence[Axes], spectra: pd.DataFrame, read_off: pd.DataFrame) -> None:
    """The two panels of a fingerprint sheet: collisions and power over the energy of a collision, at one condition.

    spectra: bins of the condition by one rule; read_off: the numbers read off them, for both pairs. A colour per
    channel; a vertical line is the energy above which half of the power falls.
    """
    bins = spectra.dropna(subset=["energy_low_J", "energy_high_J"])
    half = read_off.set_index("channel")["half_power_J"]
    for axis, (quantity, label) in zip(axes, list(QUANTITIES.items())[:2], strict=True):
        for (channel, pair), table in bins.groupby(["channel", "pair"], sort=True):
            words, line = PAIRS[str(pair)]
            _steps(axis, table, quantity, f"{channel}, {words}", CHANNEL_COLOURS[str(channel)], line)
        for channel, colour in CHANNEL_COLOURS.items():
            axis.axvline(half[channel], color=colour, linewidth=0.8, linestyle=":")
        axis.set(xscale="log", yscale="log", xlabel="energy of a collision [J]", ylabel=label)
        _cut(axis, 5)
        axis.yaxis.label.set_fontsize(7)
    for number, (channel, colour) in enumerate(CHANNEL_COLOURS.items()):
        factor, unit = prefix_of(half[channel], "J")
        axes[1].text(
            0.03, 0.88 - 0.14 * number, f"{channel}: {three(factor * half[channel])} {unit}", fontsize=6.5,
            color=colour, transform=axes[1].transAxes,
        )  # fmt: skip


def plot_rules(bins: pd.DataFrame, read_off: pd.DataFrame, title: str, note: str) -> Figure:
    """The spectra of one condition by each counting rule: collisions and power in a bin, a column per channel.

    bins: as of `dose.spectra_shown.over_pairs`; read_off: as of `of_sheet`, drawn for both pairs; note: how much the
    rules differ.
    """
    both = read_off[read_off["pair"] == BOTH]
    rules = list(dict.fromkeys(both["counting_rule"]))

    def draw(axis: Axes, channel: str, quantity: str) -> None:
        half = both[both["channel"] == channel].set_index("counting_rule")["half_power_J"]
        own = bins[bins["channel"] == channel]
        for rule, colour in zip(rules, itertools.cycle(COLOURS)):
            _steps(axis, own[own["counting_rule"] == rule], quantity, rule, colour, "-")
            axis.axvline(half[rule], color=colour, linewidth=0.8, linestyle=":")

    figure = _channels_beside(("collisions_hz", "power_W"), 4.6, draw, decades=6)
    figure.suptitle(f"{no_formula(title)}\n{textwrap.fill(note, 110)}", fontsize=7)
    return figure


def _cut(axis: Axes, decades: int) -> None:
    """Show only the largest decades: single contacts would stretch the axis over the whole range."""
    low, high = axis.get_ylim()
    axis.set_ylim(max(low, high * 10.0**-decades), high)


def _steps(axis: Axes, bins: pd.DataFrame, quantity: str, label: str, colour: str, line: str) -> None:
    """A quantity over the bins of one spectrum as steps."""
    edges = np.append(bins["energy_low_J"].to_numpy(), bins["energy_high_J"].to_numpy()[-1])
    axis.stairs(
        bins[quantity].to_numpy(), edges, baseline=None, label=label, linewidth=1.0, color=colour, linestyle=line
    )


def _draw(axis: Axes, bins: pd.DataFrame, quantity: str) -> None:
    fills = np.unique(bins["fill_ratio"])
    for (fill, pair), table in bins.groupby(["fill_ratio", "pair"], sort=True):
        words, line = PAIRS[str(pair)]
        colour = COLOURS[int(np.searchsorted(fills, fill)) % len(COLOURS)]
        _steps(axis, table, quantity, f"fill {fill:g}, {words}", colour, line)


BODY_NAMES = {"balls": "balls", "powder": "powder", "jar": "jar"}
# As in the explorer.
BODY_COLOURS = {"balls": COLOURS[0], "powder": COLOURS[1], "jar": COLOURS[-1]}


def plot_heat(temperatures: pd.DataFrame, limits: pd.DataFrame, title: str, speed_unit: str) -> Figure:
    """Temperatures of the condition of the largest power over time, and of every condition after long milling.

    temperatures, limits: as of `millprint.dose.heat_balance.heat_tables`; speed_unit: of the mill, rpm or hz.
    """
    figure, (left, right) = plt.subplots(1, 2, figsize=(PAGE_WIDTH_IN, 2.9))
    strongest = limits.loc[limits["total_W"].idxmax()]
    for number, (body, name) in enumerate(BODY_NAMES.items()):
        colour = BODY_COLOURS[body]
        rows = temperatures[(temperatures["condition"] == strongest["condition"]) & (temperatures["body"] == body)]
        left.fill_between(rows["time_h"], rows["lower_degC"], rows["upper_degC"], color=colour, alpha=0.18, linewidth=0)
        left.plot(rows["time_h"], rows["median_degC"], color=colour, label=name)
        lower, median, upper = (limits[f"{body}_steady_degC_{end}"].to_numpy() for end in ("lower", "median", "upper"))
        # Side by side, to distinguish bars at the same power.
        power = limits["total_W"].to_numpy() + 0.012 * strongest["total_W"] * (number - 1)
        right.errorbar(
            power, median, yerr=np.array([median - lower, upper - median]), linestyle="none", capsize=2,
            marker=MARKERS[number], color=colour, linewidth=0.8,
        )  # fmt: skip
    left.axhline(
        strongest["limit_degC"],
        color="black",
        linestyle="--",
        linewidth=0.8,
        label=f"limit ({strongest['limit_body']})",
    )
    left.set(xlabel="time [h]", ylabel="temperature [degC]")
    balls = balls_in_words(strongest["ball_diameter_mm"], strongest["charge"])
    speed = shown_speed(speed_unit, strongest["speed_rpm"] / 60)
    said = f"{balls}, fill {strongest['fill_ratio']:g}, {speed}: {strongest['total_W']:.3g} W"
    left.set_title(no_formula(said), fontsize=7, loc="right")
    right.set(
        xlabel="dissipated power [W]",
        ylabel="temperature after\nlong milling [degC]",
        xlim=(0, 1.1 * strongest["total_W"]),
    )
    letter_panels([left, right])
    legend_below(figure, [left], columns=4, fontsize=7)
    figure.suptitle(no_formula(title), fontsize=8)
    return figure
