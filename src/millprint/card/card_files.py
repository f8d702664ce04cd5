"""The files of a card: JSON, one page, methods paragraph, table in LaTeX, references and animation."""

import re
import shutil
import tempfile
from importlib.metadata import PackageNotFoundError, metadata
from pathlib import Path
from typing import NamedTuple

import yaml

from millprint.card.card_model import Balls, ContactSet, MillingCard, Programme, Software, Temperature, WearLoss
from millprint.cases.table import ANIMATION
from millprint.config.contact_set import CONTACT_LAWS, NOMINAL_SPEED_M_S, ContactConfig
from millprint.config.mill import MillConfig
from millprint.config.sweep import Case, DemConfig
from millprint.dem.run import run_case
from millprint.estimate.estimates import Estimate, Interval
from millprint.observables.definitions import ON_CARD
from millprint.run.files import whole_file, write_json
from millprint.run.html_pages import fill_template
from millprint.run.machine import commit, package_versions
from millprint.run.numbers import counted, plain, prefix_of, three
from millprint.view.frames import picture_mill, read_movie


def in_words(quantity: Estimate, ends: Interval | None = None) -> str:
    """A quantity with its unit and an interval: "221 µJ (203 to 240)"; of several motions "18.3 or 1.40 W"."""
    factor, unit = prefix_of(quantity.value, quantity.unit)
    text = _values(quantity, factor) + ("" if unit == "-" else f" {unit}")
    return text if ends is None else f"{text} ({between(ends, factor)})"


def _values(quantity: Estimate, factor: float) -> str:
    return " or ".join(three(factor * value) for value in quantity.values)


def between(ends: Interval | Temperature | WearLoss, factor: float = 1.0) -> str:
    """The ends of an interval: "203 to 240"."""
    return f"{three(factor * ends.lower)} to {three(factor * ends.upper)}"


COOLING = {"still_air": "air at rest", "moving_air": "moving air", "water": "water"}


def charge_in_words(balls: Balls) -> str:
    """The balls: "24 balls of 10 mm"."""
    (first, *others), total = balls.sizes, counted(balls.number, "ball")
    if not others:
        return f"{total} of {first.diameter_mm:g} mm"
    return f"{total} ({', '.join(f'{group.number} of {group.diameter_mm:g} mm' for group in balls.sizes)})"


def programme_in_words(programme: Programme) -> str:
    """Milling and pauses: "12.5 h in cycles of 30 min with a pause of 10 min each (8.33 h of milling)"."""
    text = f"{programme.duration_h:g} h"
    if not programme.cycle_min:
        return f"{text} without pauses"
    turned = ", the direction reversed after each" if programme.reversal else ""
    return (
        f"{text} in cycles of {programme.cycle_min:g} min, each with a pause of {programme.pause_min:g} min{turned} "
        f"({plain(programme.milling_h)} h of milling)"
    )


def coefficient_in_words(contact: ContactSet, key: str) -> str:
    """A coefficient of ball on ball, at the nominal speed and at the ends of its table if it depends on the speed."""
    for table in contact.over_speed:
        if table.coefficient == key:
            ends = (f"{table.values[end]:.3g} at {table.speeds_m_s[end]:.3g} m/s" for end in (0, -1))
            return f"{getattr(contact, key):.3g} at hits of {NOMINAL_SPEED_M_S:g} m/s ({' and '.join(ends)})"
    return f"{getattr(contact, key):g}"


def cohesion_in_words(contact: ContactSet) -> str:
    """How bodies stick, as the end of a list; empty if they do not."""
    parts = [
        f"{key.split('_')[0]} on {key.split('_')[1]} {value:g} {'N' if key.endswith('N') else 'J/m2'}"
        for key, value in contact.cohesion.items()
    ]
    return f", cohesion by Derjaguin, Muller and Toporov: {', '.join(parts)}" if parts else ""


def methods_paragraph(card: MillingCard) -> str:
    """What was milled and how, how the numbers were computed, with the descriptors, and dose, temperatures and wear."""
    contact = card.contact_set
    law = CONTACT_LAWS[contact.kind]
    *coefficients, stiffness = [
        f"{name} {coefficient_in_words(contact, key)} {unit}".strip() for key, (name, unit) in law.told.items()
    ]
    text = fill_template(
        Path(__file__).with_name("methods.txt"),
        card=card,
        law=law.title,
        coefficients=coefficients,
        stiffness=stiffness,
        static_friction=coefficient_in_words(contact, "static_friction"),
        cohesion=cohesion_in_words(contact),
        cooling=COOLING,
        **{
            each.__name__: each
            for each in (in_words, between, counted, plain, three, charge_in_words, programme_in_words)
        },
    )
    return " ".join(text.split())


REFERENCES = Path(__file__).with_name("references.yaml")
SPECIAL = {
    "\\": r"\textbackslash{}", "{": r"\{", "}": r"\}", "$": r"\$", "&": r"\&", "#": r"\#", "%": r"\%", "_": r"\_",
    "^": r"\textasciicircum{}", "~": r"\textasciitilde{}", "<": r"\textless{}", ">": r"\textgreater{}",
}  # fmt: skip
# Characters that pdflatex cannot print in text.
MATHS = {"µ": r"\textmu{}", "°": r"\textdegree{}", "²": r"\textsuperscript{2}", "³": r"\textsuperscript{3}",
         "±": r"\textpm{}", "×": r"\texttimes{}", "·": r"\textperiodcentered{}"}  # fmt: skip
TITLES = {name: own.title for name, own in ON_CARD.items()} | {
    "normal_kJ_g": "normal dose", "tangential_kJ_g": "tangential dose", "rolling_kJ_g": "rolling dose",
    "total_kJ_g": "dose",
    "hits_per_g": "hits per gram", "rate_W_g": "power per mass of powder",
}  # fmt: skip


def escape(text: str) -> str:
    """A text for LaTeX, with its special characters escaped."""
    return "".join(SPECIAL.get(letter, MATHS.get(letter, letter)) for letter in " ".join(text.split()))


def _unit(unit: str) -> str:
    """A unit in LaTeX."""
    text = {"-": "--", "1/s": r"s\textsuperscript{-1}", "1/g": r"g\textsuperscript{-1}"}.get(unit)
    if text is not None:
        return text
    return escape(unit)


def _row(title: str, quantity: Estimate) -> str:
    factor, unit = prefix_of(quantity.value, quantity.unit)

    def cell(ends: Interval | None) -> str:
        return "--" if ends is None else between(ends, factor)

    cells = (cell(quantity.scatter), cell(quantity.mean), cell(quantity.contact))
    return f"{escape(title)} & {_tex_number(_values(quantity, factor))} & {_unit(unit)} & " + " & ".join(
        map(_tex_number, cells)
    )


def _tex_number(text: str) -> str:
    """Numbers with an exponent as people print them: 1.2e+07 is 1.2 x 10^7."""
    return re.sub(r"([\d.]+)e([+-]\d+)", lambda m: rf"${m[1]} \times 10^{{{int(m[2])}}}$", text)


def settings_of(card: MillingCard) -> list[tuple[str, str]]:
    """The settings of the experiment as titles and texts: the head of the table and of the page."""
    jar = [f"{card.jar.volume_ml:g} mL", card.jar.material, card.jar.shape.replace("_", " ")]
    material = f", {card.balls.material.replace('_', ' ')}" if card.balls.material else ""
    rows = [
        ("mill", card.machine.title),
        ("speed", card.machine.speed),
        ("jar", ", ".join(filter(None, jar))),
        *([("wall", card.jar.wall)] if card.jar.wall else []),
        ("balls", f"{charge_in_words(card.balls)}, {plain(card.balls.mass_g)} g{material}"),
        ("fill ratio", plain(card.balls.fill_ratio)),
    ]
    if card.powder:
        ratio = plain(card.powder.ball_to_powder_ratio)
        rows += [("powder", f"{card.powder.name}, {plain(card.powder.mass_g)} g (ball-to-powder ratio {ratio})")]
    if card.programme:
        rows += [("programme", programme_in_words(card.programme))]
    return [*rows, ("contact set", card.contact_set.name)]


def latex_table(card: MillingCard) -> str:
    """The card as a table environment; it needs the package booktabs."""
    lines = [
        "% Needs \\usepackage{booktabs} and \\usepackage{textcomp}.",
        r"\begin{table}",
        rf"\caption{{{escape(card.title)}: what was set, and the mechanical fingerprint with its bands of a new "
        rf"simulation and of the mean ({100 * card.fingerprint.probability:g}\,\%), and its interval by contact "
        rf"parameters. {escape(card.fingerprint.against)}}}",
        rf"\label{{tab:{card.name.replace('_', '-')}}}",
        r"\begin{tabular}{llllll}",
        r"\toprule",
    ]
    for title, text in settings_of(card):
        lines.append(rf"{escape(title)} & \multicolumn{{5}}{{p{{0.62\linewidth}}}}{{{escape(text)}}} \\")
    lines += [r"\midrule", r"quantity & value & unit & new simulation & mean & contact parameters \\", r"\midrule"]
    lines += [rf"{_row(TITLES[name], own)} \\" for name, own in card.fingerprint.descriptors.known.items()]
    if card.dose:
        lines.append(r"\midrule")
        lines += [rf"{_row(TITLES[name], own)} \\" for name, own in vars(card.dose).items()]
    return "\n".join([*lines, r"\bottomrule", r"\end{tabular}", r"\end{table}", ""])


def _entry(key: str, kind: str, fields: dict[str, str]) -> str:
    inner = ",\n".join(f"  {name} = {{{value}}}" for name, value in fields.items() if value)
    return f"@{kind}{{{key},\n{inner}\n}}\n"


def bibtex(card: MillingCard) -> str:
    """What to cite: the software, the contact law, the methods of further parts, the sources of mill and contact set.

    The reference of the experiment is copied if it is BibTeX, and becomes a note otherwise.
    """
    own = citation()
    note = f"commit {card.software.commit}" if card.software.commit not in ("", "unknown") else ""
    entries = [
        _entry(
            escape(card.software.name), "software",
            {
                "title": f"{{{escape(card.software.name)}}}: the mechanical fingerprint of a ball mill",
                "author": f"{{{escape(own['authors'])}}}", "version": escape(card.software.version),
                "note": escape(note),
            },
        )
    ]  # fmt: skip
    known = yaml.safe_load(REFERENCES.read_text())
    groups = ["always"]
    groups += [name for name in ("heat", "wear") if getattr(card, name)]
    if any(re.search(r"\bthesis\b", text, re.IGNORECASE) for text in (card.machine.source, card.contact_set.source)):
        groups.append("thesis")
    for group in groups:
        for key, fields in known[group].items():
            values = {name: str(value) for name, value in fields.items() if name != "type"}
            entries.append(_entry(key, fields["type"], values))
    sources = (
        (f"mill:{card.machine.name}", f"Mill {card.machine.title}", card.machine.source),
        (f"contact:{card.contact_set.name}", f"Contact parameters {card.contact_set.name}", card.contact_set.source),
    )
    for key, title, source in sources:
        if source:
            entries.append(_entry(key.replace("_", "-"), "misc", {"title": escape(title), "note": escape(source)}))
    if card.reference.lstrip().startswith("@"):
        entries.append(card.reference.strip() + "\n")
    elif card.reference:
        fields = {"author": escape(card.authors), "title": escape(card.title), "note": escape(card.reference)}
        entries.append(_entry(f"experiment:{card.name}".replace("_", "-"), "misc", fields))
    return "\n".join(entries)


# Packages that a card's numbers depend on.
PACKAGES = ("numpy", "numba", "scipy", "pandas")
CITATION = Path(__file__).parents[3] / "CITATION.cff"


def citation() -> dict[str, str]:
    """Title, version and authors of this software, from CITATION.cff in a checkout, or from the installed package."""
    if CITATION.is_file():
        own = yaml.safe_load(CITATION.read_text())
        return {
            "title": own["title"],
            "version": str(own["version"]),
            "authors": " and ".join(author["name"] for author in own["authors"]),
        }
    try:
        own = metadata("millprint")
    except PackageNotFoundError:
        return {"title": "millprint", "version": "unknown", "authors": "millprint developers"}
    return {"title": own["Name"], "version": own["Version"], "authors": own["Author"]}


def software() -> Software:
    """Name, version and commit of this software, and the versions of the packages that its numbers depend on."""
    own, versions = citation(), package_versions()
    return Software(
        name=own["title"], version=own["version"], commit=commit(), packages={name: versions[name] for name in PACKAGES}
    )


class CardFiles(NamedTuple):
    """The names of a card's files in its folder."""

    card: str = "card.json"
    svg: str = "card.svg"
    png: str = "card.png"
    pdf: str = "card.pdf"
    tsv: str = "card.tsv"
    methods: str = "methods.txt"
    table: str = "table.tex"
    references: str = "references.bib"


FILES = CardFiles()
GIF = "mill.gif"


def write_card(card: MillingCard, mill: MillConfig, folder: str | Path) -> None:
    """Write the files of CardFiles."""
    # Imported here: slow to import, and not needed by tests of texts.
    from millprint.figures.card_figures import plot_card
    from millprint.figures.style import save

    folder = Path(folder)
    page = (folder / name for name in (FILES.svg, FILES.png, FILES.pdf, FILES.tsv))
    save(plot_card(card, picture_mill(mill)), *page)
    for name, text in (
        (FILES.methods, card.methods + "\n"),
        (FILES.table, latex_table(card)),
        (FILES.references, bibtex(card)),
    ):
        with whole_file(folder / name) as partial:
            partial.write_text(text, encoding="utf-8")
    # Written last, so that a folder with a card is complete.
    write_json(card.model_dump(mode="json"), folder / FILES.card)


def animate(case: Case, mill: MillConfig, contact: ContactConfig, dem: DemConfig, path: str | Path) -> None:
    """Simulate a case with snapshots in the folder of `path`, and draw its animation there (.gif)."""
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix=".animation.", dir=path.parent) as folder:
        run = Path(folder) / "run.h5"
        run_case(case, mill, contact, dem, run, run.with_name("summary.json"))
        draw_run(run, path)


def draw_run(run: Path, gif: Path) -> None:
    """Draw the animation of a run with snapshots."""
    # Imported here: slow to import, and only one process needs it.
    from millprint.figures.animation import save_animation

    save_animation(read_movie(run, ANIMATION), gif)


def remove_left_overs(folder: str | Path) -> None:
    """Remove what killed calls of `animate` have left in a folder."""
    for left in Path(folder).glob(".animation.*"):
        shutil.rmtree(left, ignore_errors=True)
