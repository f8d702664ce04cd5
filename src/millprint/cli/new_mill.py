"""Describes a mill of your own: asks for its dimensions, writes its YAML and draws its jar and motion.

    millprint new planetary
    millprint new planetary --name mine --set radius_mm=32.5 height_mm=60 "fill_ratios=[25, 50, 75]"
    millprint new --list drum

It writes two files of yours: config/mills/NAME.yaml, the mill, and NAME.yaml, the run, with its contact set. With --set
(or --yes, which takes the default of everything else) nothing is asked. Then `millprint fingerprint NAME.yaml` runs it.
"""

import argparse
import math
import re
import sys
from collections.abc import Collection, Iterator
from pathlib import Path
from typing import NamedTuple

import yaml

from millprint.cli.commands import parser_of
from millprint.cli.engine import run_workflow
from millprint.config.charge import fill_of, named_fill
from millprint.config.contact_set import ContactConfig
from millprint.config.errors import ConfigError
from millprint.config.included import included_mills
from millprint.config.load import MILL_FOLDER, check_at, check_model, load_named, parse_yaml
from millprint.config.mill import MillConfig
from millprint.config.rows import PLAIN
from millprint.config.sweep import overridden
from millprint.config.wording import close_to
from millprint.run.files import whole_file
from millprint.run.machine import cores

# Stands at the place of a value that is looked for.
MARK = "MARK"
KINDS = Path(__file__).with_name("mills")
# A place of a template: `<default>`, `<name=default>` where the key of the line is another's name too, or `<=name>` for
# the same value again.
PLACE = re.compile(r"(?P<key>\w+): <(?P<name>\w*)(?P<equals>=?)(?P<default>[^>]*)>")
ASSUMED = "calibrated"
# From this on, the time of the simulations is said [h].
LONG_H = 2.0


class Question(NamedTuple):
    """A value that is asked: its name, what it is, and what is taken without an answer; empty for the volume."""

    name: str
    means: str
    default: str


def kinds() -> list[str]:
    """The kinds of mills that have a template."""
    return sorted(path.stem for path in KINDS.glob("*.yaml"))


def read_template(kind: str) -> str:
    """The template of a kind of mill. Raises ConfigError for an unknown kind."""
    if kind not in kinds():
        raise ConfigError(f"millprint new {kind}: unknown kind of mill{close_to(kind, kinds())}")
    return (KINDS / f"{kind}.yaml").read_text()


def _parts(found: re.Match) -> tuple[str, str, bool]:
    """Name and default of a place, and whether it repeats another one."""
    name, default = found["name"], found["default"]
    if not found["equals"]:
        return found["key"], name + default, False
    return (name, default, False) if name else (default, "", True)


def questions(template: str) -> list[Question]:
    """What a template asks, in the order of its lines, but the volume, which follows from the others, at last."""
    asked = []
    for line in template.splitlines():
        found = PLACE.search(line)
        if found and not (parts := _parts(found))[2]:
            asked.append(Question(parts[0], line.partition(" # ")[2].strip(), parts[1]))
    return sorted(asked, key=lambda question: question.name == "volume_ml")


def filled(template: str, answers: dict[str, str], defaults: Collection[str] = ()) -> str:
    """The template with the answers in its places; the comment of a value that is a default says so."""
    lines = []
    for line in template.splitlines():
        text, mark, comment = line.partition(" # ")
        place = PLACE.search(text)
        new = PLACE.sub(lambda found: f"{found['key']}: {answers[_parts(found)[0]]}", text)
        kept = "; a default, not yours" if place and _parts(place)[0] in defaults else ""
        # A line that is a comment as a whole begins with its mark.
        lines.append(f"{new.rstrip().ljust(len(text))} # {comment}{kept}" if mark else new)
    return "\n".join(lines) + "\n"


def value_of(question: Question, text: str) -> object:
    """The value that a text means in YAML. Raises ConfigError for one of another type than the default."""
    wanted = yaml.safe_load(question.default) if question.default else 1.0
    parts = re.split(r"[,;]?\s+|;", text.strip())
    if isinstance(wanted, list) and len(parts) > 1 and all(map(PLAIN.fullmatch, parts)):
        # A list without its brackets: 300, 500
        text = f"[{', '.join(parts)}]"
    try:
        value = parse_yaml(text, question.name)
    except ConfigError:
        value = None
    if isinstance(wanted, list) and isinstance(value, int | float) and not isinstance(value, bool):
        value = [value]
    alike = isinstance(value, list) and all(isinstance(item, int | float) for item in value)
    number = isinstance(value, int | float) and not isinstance(value, bool)
    if not (alike if isinstance(wanted, list) else number if isinstance(wanted, int | float) else bool(value)):
        example = question.default or "250"
        raise ConfigError(f"{question.name} = {text!r}: must be like {example}, with a point, without a unit")
    return value


def answer(question: Question, text: str) -> str:
    """An answer as it stands in the file; one value where a list is asked becomes a list."""
    value = value_of(question, text)
    return f"[{', '.join(map(str, value))}]" if isinstance(value, list) else text.strip()


def fractions(counts: list[float], volume_ml: float, diameter_mm: float) -> list[float]:
    """Fill ratios of numbers of balls; a value below 1 is one already. Raises ConfigError for too many balls."""

    def fill(number: float) -> float:
        if number != int(number):
            raise ConfigError(f"fill_ratios = {number:g}: must be less than 1, or a whole number of balls")
        return float(named_fill(fill_of({"number": number}, volume_ml, diameter_mm, 1.0, "fill_ratios")))

    return [fill(count) if count >= 1 else count for count in counts]


def head_of(name: str, title: str) -> str:
    """The first lines of a mill's file."""
    return f"name: {name}\ntitle: {title}\nsource: measured or from a drawing; say here by whom and when\n"


def mill_of(name: str, title: str, template: str, answers: dict[str, str]) -> MillConfig:
    """The mill that the answers describe. Raises ConfigError, a line for each fault."""
    content = yaml.safe_load(head_of(name, title) + filled(template, answers))
    return check_model(content, MillConfig, "answers")


def check_answer(template: str, question: Question, text: str) -> None:
    """Raise ConfigError, in one line, for an answer that is beyond the limits of its key."""
    others = {each.name: each.default or "1" for each in questions(template)}
    marked = yaml.safe_load(filled(template, {**others, question.name: MARK}))
    if question.name == "fill_ratios":
        counts = yaml.safe_load(text)
        fractions(counts, math.inf, 1.0)
        # What numbers of balls fill follows with the volume: others in their places, no two alike.
        text = str([count if count < 1 else 0.1 + place / 1000 for place, count in enumerate(counts)])
    content = yaml.safe_load(head_of("mine", "mine") + filled(template, {**others, question.name: text}))
    check_at(content, MillConfig, "answers", next(_places(marked)))


def _places(content: object, place: tuple = ()) -> Iterator[tuple]:
    """The paths of MARK in some data."""
    if content == MARK:
        yield place
    items = enumerate(content) if isinstance(content, list) else content.items() if isinstance(content, dict) else ()
    for key, value in items:
        yield from _places(value, (*place, key))


def completed(name: str, title: str, template: str, answers: dict[str, str], defaults: Collection[str] = ()) -> str:
    """The text of the mill's file: the volume follows from the shape if it was not given, fills from numbers of balls.

    defaults: the names that were not answered. Raises ConfigError where the volume and the shape contradict each other.
    """
    from millprint.mill.bodies import check_volume
    from millprint.mill.vessel import build_vessel

    given = dict(answers)
    own = {**answers, "volume_ml": answers["volume_ml"] or "1", "fill_ratios": "[0.1, 0.2, 0.3]"}
    mill = mill_of(name, title, template, own)
    vessel = build_vessel(mill)
    if given["volume_ml"]:
        check_volume(mill, vessel)
    else:
        given["volume_ml"] = f"{vessel.volume_m3 * 1e6:.4g}"
    counts = yaml.safe_load(given["fill_ratios"])
    (diameter, *_) = yaml.safe_load(given["ball_diameters_mm"])
    given["fill_ratios"] = str(fractions(counts, float(given["volume_ml"]), diameter))
    mill_of(name, title, template, given)
    first, _, rest = filled(template, given, {*defaults} - {"volume_ml"}).partition("\n")
    return f"{first}\n{head_of(name, title)}{rest}"


def warnings_of(mill: MillConfig, contact: ContactConfig) -> list[str]:
    """A line for each value that is unusual or that a run would refuse, and how long long simulations take."""
    # Imported here: slow to import, and `--list` and a wrong answer do not need it.
    from scipy.constants import hour as HOUR

    from millprint.card.experiment_checks import check_cases
    from millprint.cases.of_mill import mill_cases, sweep_of
    from millprint.checks.before_running import mill_warnings
    from millprint.config.checks import with_own_fills
    from millprint.config.workflow import WorkflowConfig

    settings = WorkflowConfig(mill=mill.name)
    about = mill_warnings({mill.name: mill})
    mill = mill.model_copy(update={"sweep": sweep_of(with_own_fills(mill, contact.density_kg_m3, "sweep"))})
    cases = mill_cases(mill, settings.mills.model_copy(update={"contact": contact.name}))
    speed = ("speeds_hz", "Hz") if mill.sweep and mill.sweep.speeds_hz else ("speeds_rpm", "rpm")
    try:
        found, seconds = check_cases(
            cases, mill, overridden(cases[0], mill, contact)[1], settings, f"mill {mill.name}", speed
        )
    except ConfigError as error:
        # The answers are kept: a value is quicker changed in the file than all are typed again.
        return [*about, *(f"{line}; a run refuses it: change it in the file" for line in str(error).splitlines())]
    hours = seconds / HOUR
    long = [f"all simulations take about {hours:.3g} h of one core"] if hours > LONG_H else []
    return [*found, *about, *long]


def run_text(name: str, contact: str) -> str:
    """The text of the run's file, which names what was assumed."""
    from millprint.config.included import load_contact

    assumed = (
        "assumed: steel balls with the powder of a thesis (NaBO2.4H2O and MgH2); yours is not known"
        if contact == ASSUMED
        else load_contact(contact).source
    )
    return (
        f"# A run of the mill {name}: `millprint fingerprint {name}.yaml`. config/keys.md has every key.\n"
        f"name: {name}\n"
        f"mill: {name} # {MILL_FOLDER}/{name}.yaml\n"
        f"# {' '.join(assumed.split())}. Own values: docs/how_to/contact_set.md\n"
        f"contacts: [{contact}]\n"
        f"results: results/{name}\n"
    )


def ask(question: Question, template: str, kept: str = "") -> str:
    """An answer of the terminal within the limits of its key; empty for the default; kept: what was answered before."""
    shown = kept or question.default or "from the dimensions"
    while True:
        text = input(f"{question.name}: {question.means}\n  [{shown}] ").strip()
        try:
            if text:
                text = answer(question, text)
                check_answer(template, question, text)
            return text or kept
        except ConfigError as error:
            print(f"  {error}", file=sys.stderr)


def name_asked() -> str:
    """The name of the mill from the terminal, which no other one has."""
    while True:
        name = input("name: small letters, digits, _\n  [mine] ").strip() or "mine"
        try:
            check_name(name)
            return name
        except ConfigError as error:
            print(f"  {error}", file=sys.stderr)


def files_of(name: str) -> tuple[Path, Path]:
    """The files of a mill and of its run."""
    return Path(MILL_FOLDER) / f"{name}.yaml", Path(f"{name}.yaml")


def check_name(name: str) -> None:
    """Raise ConfigError, in one line, for a name that cannot be one, or that a mill has."""
    check_at({"name": name}, MillConfig, "answers", ("name",))
    for path in files_of(name):
        if path.exists():
            raise ConfigError(f"{path}: is there already; give another --name, or remove it")
    if name in included_mills():
        raise ConfigError(f"--name {name}: is the name of an included mill; give yours another")


def settings_of(words: list[str], asked: list[Question]) -> dict[str, str]:
    """The answers of --set, by name. Raises ConfigError for an unknown name."""
    known, found = {question.name: question for question in asked}, {}
    for word in words:
        name, equals, text = word.partition("=")
        if not equals or name not in known:
            fault = f"{name} cannot be set" if equals else "must be NAME=VALUE"
            raise ConfigError(f"--set {word}: {fault}{close_to(name, known)}")
        found[name] = answer(known[name], text)
    return found


def choice(question: str, known: list[str], what: str, default: str = "") -> str:
    """What the terminal answers, or the default; asks again until it is known."""
    while True:
        text = input(question).strip() or default
        if text in known:
            return text
        print(f"  {text!r}: unknown {what}{close_to(text, known)}", file=sys.stderr)


def contact_asked(chosen: str | None, quiet: bool) -> str:
    """The contact set of the balls: chosen, asked, or the default. Raises ConfigError for an unknown one."""
    from millprint.config.included import included_contacts
    from millprint.config.load import CONTACT_FOLDER

    known = included_contacts()
    if chosen is None and not quiet:
        question = f"contact: how balls bounce and rub, one of {', '.join(known)}\n  [{ASSUMED}] "
        return choice(question, known, "contact set", ASSUMED)
    chosen = chosen or ASSUMED
    if chosen not in known:
        raise ConfigError(f"--contact {chosen}: unknown contact set{close_to(chosen, known)}: {CONTACT_FOLDER}")
    return chosen


def parse(arguments: list[str], name: str) -> argparse.Namespace:
    """Parse the command line."""
    parser = parser_of(name, __doc__)
    parser.add_argument("kind", nargs="?", help=f"one of {', '.join(kinds())}")
    parser.add_argument("--name", help="name of the mill: small letters, digits, _ (default: mine)")
    parser.add_argument("--title", help="its name in figures")
    parser.add_argument("--set", nargs="+", default=[], metavar="NAME=VALUE", help="values; nothing is asked")
    parser.add_argument("--contact", help=f"contact set of the balls (default: {ASSUMED}, which is an assumption)")
    parser.add_argument("--yes", action="store_true", help="ask nothing: defaults for everything that is not set")
    parser.add_argument("--list", action="store_true", help="show what can be set, and end")
    parser.add_argument("--no-picture", action="store_true", help="do not draw the mill")
    return parser.parse_args(arguments)


def main(arguments: list[str], name: str = "new") -> int:
    """Write the files of a mill, and draw it."""
    options = parse(arguments, name)
    from millprint.cli.estimate_condition import lines_of_mill
    from millprint.config.included import load_contact
    from millprint.mill.bodies import build_bodies
    from millprint.mill.wall_words import walls_in_words

    quiet = bool(options.yes or options.set or options.list)
    if options.kind is None:
        if quiet:
            raise ConfigError(f"millprint new: name the kind of mill: {', '.join(kinds())}")
        options.kind = choice(f"kind of mill: {', '.join(kinds())}\n  ", kinds(), "kind of mill")
    template = read_template(options.kind)
    asked = questions(template)
    if options.list:
        print("\n".join(f"{each.name:<20} {each.default or '-':<20} {each.means}" for each in asked))
        return 0
    own = options.name or ("mine" if quiet else name_asked())
    check_name(own)
    title = options.title or ("" if quiet else input(f"title: its name in figures\n  [{own}] ").strip()) or own
    given = settings_of(options.set, asked)
    mill_text = ""
    while not mill_text:
        if not quiet:
            given = {each.name: text for each in asked if (text := ask(each, template, given.get(each.name, "")))}
        answers = {each.name: given.get(each.name, each.default) for each in asked}
        try:
            mill_text = completed(own, title, template, answers, {each.name for each in asked} - set(given))
        except ConfigError as error:
            if quiet:
                raise
            print(f"  {error}\n  once more; an empty answer keeps what stands in brackets", file=sys.stderr)
    contact = contact_asked(options.contact, quiet)
    mill_file, run_file = files_of(own)
    mill = check_model(yaml.safe_load(mill_text), MillConfig, "answers")
    for line in warnings_of(mill, load_contact(contact)):
        print(f"warning: {line}", file=sys.stderr)
    for path, text in {mill_file: mill_text, run_file: run_text(own, contact)}.items():
        path.parent.mkdir(parents=True, exist_ok=True)
        with whole_file(path) as partial:
            partial.write_text(text)
    load_named(MILL_FOLDER, own, MillConfig, "mill")
    print(f"made:  {mill_file} (the mill), {run_file} (the run)", file=sys.stderr)
    print(f"wall:  {walls_in_words(build_bodies(mill))}", file=sys.stderr)
    if estimated := lines_of_mill(mill, load_contact(contact)):
        words = f"atlas: without a simulation (`millprint estimate {run_file}` tells all conditions):"
        print(words, *estimated, sep="\n", file=sys.stderr)
    if options.no_picture:
        return 0
    folder = f"results/{own}/mills/{own}"
    pictures = [f"{folder}/geometry.png", f"{folder}/motion.png"]
    status = run_workflow(["--cores", str(cores()), *pictures, "--configfile", str(run_file)])
    if not status:
        print(f"look:  {' and '.join(pictures)}: are these your jar and its motion?", file=sys.stderr)
        print(f"next:  millprint fingerprint {run_file}", file=sys.stderr)
    return status
