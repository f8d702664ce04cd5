"""What a mill of your own does, at once, from its dimensions: nothing is simulated. Example:

    millprint estimate mixer --balls 10 --charge number=6 --speed 25Hz
    millprint estimate mixer --radius-mm 12 --height-mm 38 --fillet-radius-mm 12 --balls 7 --charge 0.1 --speed 25Hz
    millprint estimate mixer --balls 10 --charge number=6 --speed 25Hz --contact steel --exponents
    millprint estimate mine.yaml
    millprint estimate planetary --balls 10 --charge number=50 --speed 400 --most-shear 100 \\
        --within number=20:120 --within speed_hz=4:10 --within ball_diameter_mm=6:15

A mill is the name of an included one, its file in config/mills, or the configuration of a run, as `millprint new`
writes it. Its dimensions are replaced by those that are given. Without --balls, --charge and --speed, every condition
of the mill's sweep is told. --charge is a fill ratio, or number=, mass_g= or bulk_filling=; --speed is in rpm, or in Hz
as 25Hz. The numbers come from simulations over mills of the kind (docs/why/atlas.md); 90 % intervals are of one
simulation. A mill that they do not cover is refused.

--within gives bounds, of settings or dimensions, within which the most normal power per mass of balls is searched, with
at most --most-shear of shear, which wears; the optimum is simulated once. With --map and two of them, power and hits
are drawn instead. --simulated shows the fingerprint of the mill next to the atlas: a number that is farther off than
both intervals allow, and than 30 %, is worth a look, into the mill's file first.
"""

from __future__ import annotations

import argparse
import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from pydantic import Field

from millprint.atlas.kind_groups import Kind, Values
from millprint.atlas.kinds import KINDS, balls_of, recognise
from millprint.cli.commands import parser_of
from millprint.config.arguments import value_of
from millprint.config.charge import charge_words, diameter_of, fill_of, mixture_of, speed_words
from millprint.config.contact_set import ContactConfig
from millprint.config.errors import ConfigError
from millprint.config.included import load_contact, load_mill, read_run
from millprint.config.load import YAML, check_model
from millprint.config.mill import MillConfig
from millprint.config.mill_sweep import ConditionSection
from millprint.config.section import Diameter
from millprint.config.sweep import ball_count
from millprint.config.wording import close_to
from millprint.run.numbers import plain, prefix_of, three

if TYPE_CHECKING:
    from millprint.atlas.estimate_mill import MillEstimate
    from millprint.fingerprint.model import Fingerprint

ASSUMED = "calibrated"
# What is told, in which words, in this order.
TOLD = {
    "wall_power_W": "power",
    "weighted_normal_energy_J": "a strong hit, E*n",
    "weighted_normal_frequency_hz": "such hits of a ball, f*n",
    "weighted_tangential_energy_J": "a strong shear, E*t",
    "weighted_tangential_frequency_hz": "such shears of a ball, f*t",
}
# The mark of a number that the atlas tells worse than it is meant to, and what it means.
UNSURE = "(*)"
UNSURE_MEANS = f"{UNSURE}: worse known than most; simulate it (millprint card)"
DIMENSIONS = {own.name: own for kind in KINDS.values() for own in kind.dimensions}


def parse(arguments: list[str], name: str) -> argparse.Namespace:
    """Parse the command line."""
    parser = parser_of(name, __doc__)
    add = parser.add_argument
    add("mill", help="name, file or configuration of a mill")
    add("--balls", type=value_of("ball_diameter_mm", Diameter), metavar="MM", help="diameter of the balls [mm]")
    add("--charge", help="fill ratio, or number=50, mass_g=200, bulk_filling=0.3")
    add("--speed", help="400 for rpm, 25Hz for Hz")
    add("--contact", help=f"contact set, name or file (default: that of the run, or {ASSUMED})")
    add("--exponents", action="store_true", help="say what one dimension more or less changes")
    add("--simulated", action="store_true", help="show the mill's fingerprint next to it, and name large differences")
    add("--results", default="results", metavar="FOLDER", help="where mills were run (default: %(default)s)")
    add("--within", action="append", metavar="NAME=LOW:HIGH", help="bounds of a search for the best settings")
    shear = value_of("most_shear", Annotated[float, Field(gt=0)])
    add("--most-shear", type=shear, metavar="W/KG", help="with --within: the most shear, per mass of balls")
    add("--map", metavar="FILE", help="with --within for two: draw power and hits over them, as SVG and PNG")
    for own in DIMENSIONS.values():
        kind = value_of(own.name, Annotated[float, Field(ge=own.least, le=own.most)])
        add(f"--{own.name.replace('_', '-')}", type=kind, metavar="X", help=own.means.replace("%", "%%"))
    return parser.parse_args(arguments)


def mill_and_contact(given: str, contact: str | None) -> tuple[MillConfig, ContactConfig]:
    """The mill and the contact set of a name, a mill's file or a run's. Raises ConfigError, a line for each fault."""
    run = read_run(given) if Path(given).suffix in YAML else {}
    if "mill" in run:
        contacts = run.get("contacts") or [ASSUMED]
        return load_mill(str(run["mill"])), load_contact(contact or str(contacts[0]))
    return load_mill(given), load_contact(contact or ASSUMED)


def dimensions_of(options: argparse.Namespace, kind: Kind, built: Values) -> dict[str, float]:
    """The dimensions of a mill, with those that are given in place of its own. Raises ConfigError for another's."""
    given = {name: value for name in DIMENSIONS if (value := getattr(options, name)) is not None}
    for name in given:
        if name not in built:
            known = ", ".join(built)
            raise ConfigError(f"--{name.replace('_', '-')}: a {kind.title} has no such dimension; it has {known}")
    return {**built, **given}


def asked_of(options: argparse.Namespace) -> ConditionSection | None:
    """The condition that is asked for, if one is. Raises ConfigError, in one line, for a part of one."""
    given = [options.balls, options.charge, options.speed]
    if all(word is None for word in given):
        for word in ("exponents", "within", "map"):
            if getattr(options, word):
                raise ConfigError(f"--{word}: of one condition; give --balls, --charge and --speed")
        return None
    if None in given:
        raise ConfigError("--balls, --charge, --speed: give all three, or none for the conditions of the mill's sweep")
    words = {"ball_diameter_mm": options.balls, **charge_words(options.charge), **speed_words(options.speed)}
    return check_model(words, ConditionSection, "estimate")


def condition_of(kind: Kind, dimensions: Values, asked: ConditionSection, contact: ContactConfig) -> dict[str, float]:
    """A condition as the atlas takes it. Raises ConfigError, in one line, for balls that fill the jar or more."""
    volume_ml, ball_mm = 1e6 * kind.volume_m3(dimensions), diameter_of(asked.ball_diameter_mm)
    fill = fill_of(asked.given, volume_ml, ball_mm, contact.density_kg_m3, "estimate")
    number = float(ball_count(fill, volume_ml / 1e6, ball_mm / 1e3))
    settings = {"ball_diameter_mm": ball_mm, "number": number, "speed_hz": asked.hz}
    return {**dimensions, **settings, **balls_of(contact)}


def swept(mill: MillConfig) -> list[ConditionSection]:
    """The conditions of a mill's sweep, of balls of one size. Raises ConfigError for a mill without any."""
    from millprint.cases.of_mill import conditions_of, sweep_of
    from millprint.config.checks import with_own_fills

    sweep = sweep_of(with_own_fills(mill, 1.0, "sweep"))
    found = [own for own in conditions_of(sweep) if mixture_of(own.ball_diameter_mm) is None]
    if not found:
        raise ConfigError(f"{mill.name}: its sweep has only mixed sizes; give --balls, --charge and --speed")
    return found


def quantity(value: float, unit: str) -> str:
    """A number with three digits and a prefix."""
    factor, shown = prefix_of(value, unit)
    return f"{three(factor * value)} {shown}"


def simulated_over_atlas(found: MillEstimate, fingerprint: Fingerprint) -> tuple[dict[str, str], list[str]]:
    """What the mill's fingerprint has for the condition over what the atlas says, in words, of each of TOLD; and notes
    on where it is extrapolated, or nothing hits.

    It is simulated if that charge was simulated at these settings, and by curves otherwise. A difference is large as of
    `beside_simulation.is_far`, and nothing is told from extrapolated curves.
    """
    from millprint.atlas.beside_simulation import LARGE, is_far
    from millprint.fingerprint.condition_search import variables_in_words
    from millprint.fingerprint.model import LAYERS, NO_IMPACTS

    own = found.condition
    condition = fingerprint.condition(
        speed_hz=own["speed_hz"], ball_diameter_mm=own["ball_diameter_mm"], number=own["number"],
        density_kg_m3=own["density_kg_m3"],
    )  # fmt: skip
    simulated = fingerprint.as_simulated(condition)
    prediction, said = fingerprint.predict(simulated or condition), {}
    outside = tuple(name for name in prediction.outside if name != LAYERS)
    notes = [f"the fingerprint is extrapolated: {variables_in_words(outside)} not simulated"] if outside else []
    notes += [f"the fingerprint: {NO_IMPACTS}"] if LAYERS in prediction.outside else []
    how = "simulated" if simulated else "extrapolated" if outside else "by its curves"
    for name in TOLD:
        own, told_ = prediction.known[name], found.known[name]
        if math.isnan(own.value):
            said[name] = "; not known"
            continue
        large = f", {LARGE}" if not outside and is_far(own, told_) else ""
        said[name] = f"; {how} {three(own.value / told_.value)} of it{large}"
    return said, notes


def told(found: MillEstimate, fingerprint: Fingerprint | None = None) -> list[str]:
    """What the atlas tells about a condition, a line each; fingerprint: of the mill, which is shown next to it."""
    from millprint.atlas.atlas_model import HITS

    own, speed = found.condition, found.condition["speed_hz"]
    shown = f"{plain(speed)} Hz" if found.kind.speed_unit == "hz" else f"{plain(60 * speed)} rpm"
    balls = f"{plain(own['number'])} ball{'s' if own['number'] > 1 else ''} of {plain(own['ball_diameter_mm'])} mm"
    lines = [f"{balls}, fill ratio {found.groups['fill']:.2g}, {shown}", *(f"  {note}" for note in found.notes)]
    rows = TOLD
    if found.hits < HITS:
        lines.append(
            f"  balls roll, slide or go round with the wall: only power is told (hits {100 * found.hits:.0f} % likely)"
        )
        rows = {name: words for name, words in TOLD.items() if name == "wall_power_W"}
    compared, notes = simulated_over_atlas(found, fingerprint) if fingerprint else ({}, [])
    lines += [f"  {note}" for note in notes]
    for name, words in rows.items():
        value = found.known[name]
        factor, unit = prefix_of(value.value, value.unit)
        ends = " to ".join(three(factor * end) for end in value.ends("scatter"))
        mark = f" {UNSURE}" if name in found.unsure else ""
        lines.append(f"  {words:<28} {three(factor * value.value):>8} {unit:<5} ({ends}){mark}{compared.get(name, '')}")
    power = found.known["wall_power_W"].value
    lines.append(f"  {'power per mass of balls':<28} {quantity(power / found.charge_kg, 'W/kg')}")
    if found.hits >= HITS:
        shear = found.known["tangential_power_W"].value
        share = shear / (shear + found.known["normal_power_W"].value)
        lines.append(f"  {'share of shear':<28} {100 * share:.0f} %; hits: {100 * found.hits:.0f} % likely")
    return lines


def with_marks_told(lines: list[str]) -> list[str]:
    """Lines, and at their end what UNSURE means where one has it."""
    return [*lines, UNSURE_MEANS] if any(UNSURE in line for line in lines) else lines


def exponent_lines(found: MillEstimate) -> list[str]:
    """A line for each dimension and setting: the exponents of power and of a hit's energy with 90 % intervals."""
    from millprint.atlas.estimate_mill import exponents

    shown = {name: TOLD[name] for name in ("wall_power_W", "weighted_normal_energy_J", "weighted_tangential_energy_J")}
    table = exponents(found.kind, found.condition)
    lines = [f"  {'exponent of':<22}" + "".join(f"{words:<28}" for words in shown.values())]
    for name in table["wall_power_W"]:
        cells = (table[observable][name] for observable in shown)
        texts = (f"{own.value:+.2f} ({own.lower:+.2f} to {own.upper:+.2f})" for own in cells)
        lines.append(f"  {name:<22}" + "".join(f"{text:<28}" for text in texts))
    return lines


def bounds_of(words: list[str], condition: Values) -> dict[str, tuple[float, float]]:
    """The bounds of --within. Raises ConfigError, in one line, for an unknown setting or a range that is none."""
    found = {}
    for word in words:
        name, _, ends = word.partition("=")
        try:
            low, high = map(float, ends.split(":"))
        except ValueError:
            raise ConfigError(f"--within {word}: write a name and a range, such as number=20:80") from None
        if name not in condition or name == "ratio":
            known = ", ".join(own for own in condition if own != "ratio")
            raise ConfigError(f"--within {word}: no such setting{close_to(name, condition)}; it is one of {known}")
        if not 0 < low < high:
            raise ConfigError(f"--within {word}: must rise from a number above 0")
        found[name] = (low, high)
    return found


def optimum_lines(kind: Kind, condition: Values, options: argparse.Namespace) -> list[str]:
    """The best settings within the bounds that are asked for, and one simulation of them."""
    from millprint.atlas.design import simulate_row
    from millprint.atlas.estimate_mill import model_of
    from millprint.atlas.search_mills import best_settings

    best = best_settings(model_of(kind), condition, bounds_of(options.within, condition), options.most_shear)
    lines, row = ["the most normal power per mass of balls:", *told(best)], simulate_row(kind, dict(best.condition), 0)
    if not isinstance(row.get("wall_power_W"), float):
        return [*lines, f"  simulated once: {row['motion']}"]
    lines.append("  simulated once, over what the atlas says:")
    for name, words in {**TOLD, "normal_power_W": "normal power", "tangential_power_W": "shear power"}.items():
        if isinstance(row.get(name), float):
            ratio = float(row[name]) / best.known[name].value
            low, high = (end / best.known[name].value for end in best.known[name].ends("scatter"))
            inside = "within" if low <= ratio <= high else "OUTSIDE"
            lines.append(f"  {words:<28} {ratio:>8.2f}       {inside} {low:.2f} to {high:.2f}")
    return lines


def draw_map(kind: Kind, condition: Values, options: argparse.Namespace) -> str:
    """Draw the map of --map, and say where it is. Raises ConfigError unless two are to vary."""
    bounds = bounds_of(options.within or [], condition)
    if len(bounds) != 2:
        raise ConfigError("--map: give --within for two settings or dimensions, the axes of the map")
    from millprint.atlas.estimate_mill import model_of
    from millprint.figures.atlas_figures import plot_map
    from millprint.figures.style import both_of, save

    made = both_of(options.map)
    save(plot_map(model_of(kind), condition, bounds), *made)
    return f"{' and '.join(made)}: power and hits over {' and '.join(bounds)}"


def sweep_lines(
    kind: Kind, dimensions: Values, mill: MillConfig, contact: ContactConfig, most: int | None = None,
    fingerprint: Fingerprint | None = None,
) -> list[str]:  # fmt: skip
    """What the atlas tells about every condition of a mill's sweep, or of `most` of them, or why it says nothing."""
    from millprint.atlas.estimate_mill import estimate

    lines = []
    for asked in swept(mill)[:most]:
        try:
            lines += told(estimate(kind, condition_of(kind, dimensions, asked, contact)), fingerprint)
        except ConfigError as error:
            lines += [str(error)] if str(error) not in lines else []
    return lines


def lines_of_mill(mill: MillConfig, contact: ContactConfig) -> list[str]:
    """The same of its first condition for a mill of any kind; nothing for one that the atlas does not have."""
    from millprint.atlas.estimate_mill import included_models

    known = recognise(mill)
    try:
        return (
            with_marks_told(sweep_lines(*known, mill, contact, 1))
            if known and known[0].name in included_models()
            else []
        )
    except ConfigError:
        return []


def _fingerprint(given: str, contact: ContactConfig, is_as_built: bool, results: str) -> Fingerprint:
    """The fingerprint of the mill that is given. Raises ConfigError for one of other dimensions or balls."""
    from millprint.fingerprint.model import Fingerprint
    from millprint.fingerprint.readers import find_fingerprint

    found = Fingerprint.read(find_fingerprint(given, results))
    if not is_as_built or found.about["contact"] != contact.name:
        raise ConfigError(
            f"--simulated: {given} was simulated as built, with {found.about['contact']}; leave out other "
            "dimensions and contacts"
        )
    return found


def main(arguments: list[str], name: str = "estimate") -> None:
    """Tell what the mill does in each condition."""
    options = parse(arguments, name)
    from millprint.atlas.estimate_mill import estimate, included_models, model_of

    mill, contact = mill_and_contact(options.mill, options.contact)
    known = recognise(mill)
    if known is None:
        raise ConfigError(
            f"{mill.name}: no kind of the atlas; it has round jars without inserts of {', '.join(included_models())}: "
            "`millprint fingerprint` simulates any other mill"
        )
    kind, asked = known[0], asked_of(options)
    dimensions = dimensions_of(options, *known)
    model_of(kind)
    fingerprint = (
        _fingerprint(options.mill, contact, dimensions == known[1], options.results) if options.simulated else None
    )
    if options.most_shear and not options.within:
        raise ConfigError("--most-shear: is a limit of a search; give --within NAME=LOW:HIGH too")
    if asked is None:
        lines = sweep_lines(kind, dimensions, mill, contact, fingerprint=fingerprint)
    elif options.map:
        lines = [draw_map(kind, condition_of(kind, dimensions, asked, contact), options)]
    elif options.within:
        lines = optimum_lines(kind, condition_of(kind, dimensions, asked, contact), options)
    else:
        found = estimate(kind, condition_of(kind, dimensions, asked, contact))
        lines = [*told(found, fingerprint), *(exponent_lines(found) if options.exponents else [])]
    print(
        f"{mill.title}, balls and walls: {contact.name}; 90 % intervals of one simulation",
        *with_marks_told(lines),
        sep="\n",
    )
