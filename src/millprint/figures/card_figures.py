"""The milling card on one page: settings, fingerprint, spectra, temperatures, dose, wear and methods."""

import textwrap

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.transforms import Bbox

from millprint.card.card_model import Ends, MillingCard, Quantity, Spectrum
from millprint.card.latex import TITLES, settings_of
from millprint.card.methods import between, in_words
from millprint.config.contact_set import ASSUMED
from millprint.figures.dose_figures import BODY_NAMES, PAIRS
from millprint.figures.mill_pictures import draw_views
from millprint.figures.mill_sheet_figure import SHEET_IN, draw_table
from millprint.figures.style import COLOURS, legend_below, plt
from millprint.fingerprint.bands import FURTHER, MEAN, SCATTER
from millprint.run.numbers import prefix_of, three
from millprint.view.mill_picture import MillPicture

# Characters per line: of the settings, and over the whole page.
SETTING_LINE, PAGE_LINE = 62, 150
SMALL = 6.5
DECADES = 6


def _cell(quantity: Quantity, ends: Ends | None) -> str:
    return "-" if ends is None else between(ends, prefix_of(quantity.value, quantity.unit)[0])


def _write(axis: Axes, lines: list[str]) -> None:
    axis.axis("off")
    axis.text(0, 1, "\n".join(lines), va="top", fontsize=SMALL, transform=axis.transAxes, linespacing=1.35)


def _settings(card: MillingCard) -> list[str]:
    """The settings, and the source of the contact set."""
    rows = settings_of(card)
    rows += [(name, text) for name in ("atmosphere", "authors", "reference", "note") if (text := getattr(card, name))]
    rows += [("contact set", f"{card.contact_set.name}, {ASSUMED}; from {card.contact_set.source}")]
    return [line for title, text in rows for line in textwrap.wrap(f"{title}: {text}", SETTING_LINE, max_lines=3,
                                                                   subsequent_indent="  ")]  # fmt: skip


def _draw_table(axis: Axes, card: MillingCard) -> None:
    """Descriptors and doses with a column for each origin of intervals."""
    axis.axis("off")
    rows = list(card.fingerprint.descriptors.known.items()) + (list(vars(card.dose).items()) if card.dose else [])
    columns = ["scatter", "mean", *FURTHER]
    cells = [
        [TITLES[name], in_words(own), *(_cell(own, getattr(own, origin)) for origin in columns)] for name, own in rows
    ]
    titles = [SCATTER.title, MEAN.title, *(title for title, _ in FURTHER.values())]
    draw_table(axis, cells, ["", "value", *titles], Bbox.from_bounds(0, 0, 1, 1))


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
        axis.stairs(power, np.append(low, high[-1]), baseline=None, label=words, linestyle=line, linewidth=1.0)
        highest = max(highest, power.max())
        lowest_J += low[power > power.max() * 10.0**-DECADES].tolist()
    axis.set(xlabel=f"{channel} energy [J]", ylabel="power per bin [W]", xscale="log")
    if highest > 0:
        axis.set(yscale="log", ylim=(highest * 10.0**-DECADES, 2 * highest), xlim=(min(lowest_J), None))


def _draw_heat(axis: Axes, card: MillingCard) -> None:
    """Temperatures over the programme or, without a programme, after long milling."""
    if card.heat is None:
        axis.axis("off")
        return
    course = card.heat.course
    for number, (body, name) in enumerate(BODY_NAMES.items()):
        colour = COLOURS[number]
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
    axis.set(xlabel="" if course is None else "time [h]", ylabel="temperature [degC]")
    if course is None:
        axis.set_title("after long milling", loc="left", fontsize=7)


def _consequences(card: MillingCard) -> list[str]:
    """Lines on temperatures, wear and what is not known."""
    lines = []
    if heat := card.heat:
        limit = heat.time_to_limit_h.median
        reached = "is not reached" if limit is None else f"after {three(limit)} h of milling without pauses"
        steady = heat.powder.steady_degC
        lines.append(
            f"heat: powder {three(steady.median)} degC after long milling ({between(steady)}, "
            f"{100 * heat.probability:g} %); {heat.limit_degC:g} degC of the {heat.limit_body} {reached} (median)"
        )
    if wear := card.wear:
        lines.append(
            f"wear: balls lose {three(wear.wear_g.value)} g ({between(wear.wear_g)}), iron in the powder "
            f"{three(wear.iron_percent.value)} % ({between(wear.iron_percent)}); coefficient from "
            f"{wear.coefficient_from}"
        )
        lines += [f"wear, note: {wear.note}"] if wear.note else []
    lines += [f"{name}: not known, {why}" for name, why in card.not_known.items()]
    found = card.fingerprint
    titles = {"scatter": SCATTER.title, "mean": MEAN.title} | {name: title for name, (title, _) in FURTHER.items()}
    lines += [f"interval, {titles.get(name, name)}: not known, {why}" for name, why in found.missing.items()]
    lines += [f"motion, {against}" for against in found.motion]
    counted = f"collisions counted by {found.counting_rule}"
    lines.append(
        f"simulated: seeds {', '.join(map(str, found.seeds))}, {three(found.revolutions)} turns, {counted}; bands "
        f"of {100 * found.probability:g} %; energy balance closes to {found.closure or 0.0:.1g}"
    )
    return [line for text in lines for line in textwrap.wrap(text, PAGE_LINE, subsequent_indent="  ")]


def plot_card(card: MillingCard, picture: MillPicture) -> Figure:
    """The card on one A4 page. picture: of the mill."""
    figure = plt.figure(figsize=SHEET_IN)
    figure.suptitle(f"Milling card: {card.title}", fontsize=12)
    heights = [1.05, 1.0, 0.95, 0.95]
    top, table, graphs, words = figure.subfigures(4, 1, squeeze=False, height_ratios=heights).flat
    left, right = top.subfigures(1, 2, squeeze=False).flat
    _write(left.subplots(), _settings(card))
    draw_views(list(right.subplots(1, 2)), picture)
    _draw_table(table.subplots(), card)
    normal, tangential, heat = graphs.subplots(1, 3)
    for axis, channel in ((normal, "normal"), (tangential, "tangential")):
        _draw_spectra(axis, card.spectra, channel)
    _draw_heat(heat, card)
    legend_below(graphs, (normal, heat), 5, fontsize=7)
    software = card.software
    version = f"{software.name} {software.version}, commit {software.commit[:12]}, card schema {card.schema_version}"
    digests = ", ".join(f"{name} {digest[:12]}" for name, digest in card.digests.items())
    methods = textwrap.wrap(card.methods, PAGE_LINE)
    _write(words.subplots(), [*_consequences(card), "", *methods, "", version, f"SHA-256: {digests}"])
    return figure
