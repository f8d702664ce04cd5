"""Figures of the milling card, and of measurements on one's own mill. They draw what is given and compute nothing."""

import textwrap

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from millprint.card.card_files import TITLES, between, in_words, settings_of
from millprint.card.card_model import MillingCard, Spectrum
from millprint.config.contact_set import ASSUMED
from millprint.estimate.estimates import Estimate, Interval
from millprint.figures.dose_figures import BODY_COLOURS, BODY_NAMES, CHANNEL_COLOURS, PAIRS
from millprint.figures.mill_sheet_figure import SHEET_IN, draw_views
from millprint.figures.style import COLOURS, COLUMN_WIDTH_IN, draw_table, no_formula, plt, write_rows
from millprint.fingerprint.bands import ORIGINS
from millprint.run.numbers import prefix_of, three
from millprint.view.frames import MillPicture


def plot_warming(
    time_s: np.ndarray, read_degC: np.ndarray, model_degC: np.ndarray, milled_s: tuple[float, float], body: str
) -> Figure:
    """Read temperatures with the heat balance that fits them; the time of milling is shaded."""
    figure, axis = plt.subplots(figsize=(COLUMN_WIDTH_IN, 2.6))
    axis.axvspan(*milled_s, color=COLOURS[5], alpha=0.2, linewidth=0, label="mill runs")
    axis.plot(time_s, read_degC, "o", markersize=2.5, color=COLOURS[0], label="read")
    axis.plot(time_s, model_degC, color=COLOURS[1], label="heat balance")
    axis.set(xlabel="time [s]", ylabel=f"temperature of the {body} [°C]")
    axis.legend(fontsize=7)
    return figure


def plot_powers(estimates: dict[str, Estimate]) -> Figure:
    """Powers with their intervals, one under the other."""
    figure, axis = plt.subplots(figsize=(COLUMN_WIDTH_IN, 0.6 + 0.4 * len(estimates)))
    for place, own in enumerate(estimates.values()):
        hull = own.hull()
        ends = [[own.value - hull.lower], [hull.upper - own.value]]
        axis.errorbar([own.value], [place], xerr=ends, fmt="none", capsize=3, color=COLOURS[place % len(COLOURS)])
        axis.plot(own.values, [place] * len(own.values), "o", color=COLOURS[place % len(COLOURS)])
    axis.set_yticks(range(len(estimates)), list(estimates))
    axis.set(xlabel="power [W]", ylim=(len(estimates) - 0.5, -0.5))
    return figure


SMALL = 6.5
# Characters per line of names and texts: of the settings, and over the whole page.
SETTINGS, PAGE = (20, 46), (20, 132)
# Lines that fit into both.
ROOM = (19, 26)
DECADES = 6


def _cell(quantity: Estimate, ends: Interval | None) -> str:
    return "" if ends is None else between(ends, prefix_of(quantity.value, quantity.unit)[0])


def _settings(card: MillingCard) -> list[tuple[str, str | None]]:
    """The settings, and the source of the contact set."""
    rows: list[tuple[str, str | None]] = [("Settings", None), *settings_of(card)[:-1]]
    rows += [(name, text) for name in ("atmosphere", "authors", "reference", "note") if (text := getattr(card, name))]
    source = textwrap.shorten(card.contact_set.source, 2 * SETTINGS[1], placeholder=" ...")
    return [*rows, ("contact set", f"{card.contact_set.name}, {ASSUMED}; from {source}")]


def _draw_table(axis: Axes, card: MillingCard) -> None:
    """Descriptors and doses with a column for each origin of intervals."""
    rows = list(card.fingerprint.descriptors.known.items()) + (list(vars(card.dose).items()) if card.dose else [])
    # A column for each origin that is known of at least one row.
    titles = {name: own.title for name, own in ORIGINS.items() if any(name in each.intervals for _, each in rows)}
    cells = [
        [TITLES[name], in_words(own), *(_cell(own, getattr(own, origin)) for origin in titles)] for name, own in rows
    ]
    draw_table(axis, ["Fingerprint", "value", *titles.values()], cells, SMALL)


def _draw_spectra(axis: Axes, spectra: list[Spectrum], channel: str) -> None:
    """Power per bin over the energy of a collision of one channel."""
    highest, lowest_J = 0.0, []
    for spectrum in spectra:
        if spectrum.channel != channel or spectrum.bins is None:
            continue
        bins = spectrum.bins
        closed = [
            (low, high, power)
            for low, high, power in zip(bins.energy_low_J, bins.energy_high_J, bins.power_W, strict=True)
            if low is not None and high is not None
        ]
        if not closed:
            continue
        words, line = PAIRS[spectrum.pair]
        low, high, power = map(np.array, zip(*closed, strict=True))
        axis.stairs(
            power, np.append(low, high[-1]), baseline=None, label=words, linestyle=line, linewidth=1.0,
            color=CHANNEL_COLOURS[channel],
        )  # fmt: skip
        highest = max(highest, power.max())
        lowest_J += low[power > power.max() * 10.0**-DECADES].tolist()
    axis.set(xlabel=f"{channel} energy [J]", ylabel="power per bin [W]", xscale="log")
    if highest > 0:
        axis.set(yscale="log", ylim=(highest * 10.0**-DECADES, 2 * highest), xlim=(min(lowest_J), None))
        axis.legend(loc="lower right", fontsize=6)


def _draw_heat(axis: Axes, card: MillingCard) -> None:
    """Temperatures over the programme or, without a programme, after long milling."""
    if card.heat is None:
        axis.axis("off")
        return
    course = card.heat.course
    for number, (body, name) in enumerate(BODY_NAMES.items()):
        colour = BODY_COLOURS[body]
        if course is not None:
            values = [[each.lower, each.median, each.upper] for each in getattr(course, f"{body}_degC")]
            lower, median, upper = np.transpose(values)
            axis.fill_between(course.time_h, lower, upper, color=colour, alpha=0.18, linewidth=0)
            axis.plot(course.time_h, median, color=colour, label=name)
        else:
            own = getattr(card.heat, body).steady_degC
            error = [[own.median - own.lower], [own.upper - own.median]]
            axis.errorbar([number], [own.median], yerr=error, marker="o", capsize=2, color=colour, label=name)
    if course is None:
        axis.set_xticks(range(len(BODY_NAMES)), list(BODY_NAMES.values()))
    axis.set(xlabel="" if course is None else "time [h]", ylabel="temperature [°C]")
    if course is None:
        axis.set_title("after long milling", loc="left", fontsize=7)
    else:
        axis.legend(loc="lower right", fontsize=6)


def _consequences(card: MillingCard) -> list[tuple[str, str | None]]:
    """What follows for powder and balls, what is not known, and how it was simulated."""
    rows: list[tuple[str, str | None]] = [("What follows", None)]
    if heat := card.heat:
        limit = heat.time_to_limit_h.median
        reached = "is not reached" if limit is None else f"after {three(limit)} h of milling without pauses"
        steady = heat.powder.steady_degC
        text = f"{three(steady.median)} °C after long milling ({between(steady)}, {100 * heat.probability:g} %)"
        limit_text = f"{heat.limit_degC:g} °C of the {heat.limit_body} {reached} (median)"
        rows.append(("heat", f"at {three(heat.power_W)} W powder {text}; {limit_text}"))
    if wear := card.wear:
        text = (
            f"balls lose {three(wear.wear_g.value)} g ({between(wear.wear_g)}), iron in the powder "
            f"{three(wear.iron_percent.value)} % ({between(wear.iron_percent)}); coefficient from "
            f"{wear.coefficient_from}"
        )
        rows.append(("wear", f"{text}; {wear.note}" if wear.note else text))
    found = card.fingerprint
    lacking = card.not_known | {
        f"interval by {ORIGINS[name].title if name in ORIGINS else name}": why for name, why in found.missing.items()
    }
    rows += [("not known", "; ".join(f"{name}: {why}" for name, why in lacking.items()))] if lacking else []
    rows += [("motion", "; ".join(found.motion))] if found.motion else []
    simulated = (
        f"seeds {', '.join(map(str, found.seeds))}, {three(found.revolutions)} turns, collisions counted by "
        f"{found.counting_rule}; bands of {100 * found.probability:g} %; energy balance closes to "
        f"{found.closure or 0.0:.1g}"
    )
    return [*rows, ("simulated", simulated)]


def plot_card(card: MillingCard, picture: MillPicture) -> Figure:
    """The card on one A4 page. picture: of the mill."""
    figure = plt.figure(figsize=SHEET_IN)
    figure.suptitle(f"Milling card: {no_formula(card.title)}", fontsize=13, fontweight="bold", x=0.01, ha="left")
    heights = [0.85, 1.0, 0.85, 1.05]
    top, table, graphs, words = figure.subfigures(4, 1, squeeze=False, height_ratios=heights).flat
    left, right = top.subfigures(1, 2, squeeze=False).flat
    write_rows(left.subplots(), _settings(card), SETTINGS, SMALL, ROOM[0])
    draw_views(list(right.subplots(1, 2)), picture)
    _draw_table(table.subplots(), card)
    normal, tangential, heat = graphs.subplots(1, 3)
    for axis, channel in ((normal, "normal"), (tangential, "tangential")):
        _draw_spectra(axis, card.spectra, channel)
    _draw_heat(heat, card)
    software = card.software
    version = f"{software.name} {software.version}, commit {software.commit[:12]}, card schema {card.schema_version}"
    digests = ", ".join(f"{name} {digest[:12]}" for name, digest in card.digests.items())
    rows = [*_consequences(card), ("For the methods section", None), ("", card.methods)]
    rows += [("made with", version), ("SHA-256", digests)]
    write_rows(words.subplots(), rows, PAGE, SMALL, ROOM[1])
    return figure
