"""The gallery: every figure of a run with its caption, its tables and its origin, on a page that fetches nothing."""

import base64
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from docutils.core import publish_parts
from docutils.frontend import get_default_settings
from docutils.parsers.rst import Parser
from docutils.writers.html5_polyglot import Writer
from jinja2 import Environment, StrictUndefined
from markupsafe import Markup
from PIL import Image

from millprint.config.errors import ConfigError
from millprint.provenance.lineage import Job
from millprint.report.table_pages import FOLDER, section_id
from millprint.run.html_pages import embed_files, render_page
from millprint.run.outputs import captioned

# Twice the width of a thumbnail on the page [px], and its quality: lines and letters stay sharp.
THUMBNAIL_PX, THUMBNAIL_QUALITY = 640, 80
# Largest number of inputs that are named one by one; any further ones are only counted.
NAMED_INPUTS = 12
# What readers look for comes first: the card of an experiment, the mills; then in order of name.
FIRST = ("Cards", "Mills")
# A word that the configuration does not have is an error, not a gap.
TEMPLATES = Environment(autoescape=False, undefined=StrictUndefined)
# Made once: docutils takes longer to collect them than to render a caption. Files that a caption names are not read.
CAPTIONS = get_default_settings(Parser, Writer)
CAPTIONS.raw_enabled, CAPTIONS.file_insertion_enabled = False, False
CAPTIONS.report_level, CAPTIONS.initial_header_level = 5, 4


@dataclass(frozen=True)
class Listed:
    """A figure as the workflow lists it: path in the results folder, stage, labels, and the text of its caption."""

    path: str
    stage: str
    labels: Mapping[str, str]
    caption: str


@dataclass(frozen=True)
class Shown:
    """A figure on the page. Paths are links from report/; picture: a data URI; more: a number of inputs not named."""

    id: str
    title: str
    caption: Markup
    alt: str
    link: str
    picture: str
    width: int
    height: int
    tables: tuple[tuple[str, str], ...]
    reason: str
    rule: str
    inputs: tuple[str, ...]
    more: int


def render_caption(text: str, config: Mapping[str, Any], words: Mapping[str, str]) -> Markup:
    """A caption of the report, a Jinja template of reStructuredText, as markup. Files that it names are not read."""
    given = SimpleNamespace(config=config, wildcards=SimpleNamespace(**words))
    filled = TEMPLATES.from_string(text).render(snakemake=given)
    return Markup(publish_parts(filled, writer="html5", settings=CAPTIONS.copy())["body"])


def first_sentence(caption: Markup) -> str:
    """The first sentence of a caption as plain text: what somebody hears who does not see the figure."""
    text = caption.striptags()
    cut = text.find(". ")
    return text if cut < 0 else text[: cut + 1]


def thumbnail(path: Path) -> tuple[str, int, int]:
    """A small picture of a figure as a data URI, with its width and height [px]; of an animation, its first frame."""
    try:
        with Image.open(path) as image:
            small = image.convert("RGBA")
    except (OSError, SyntaxError) as error:
        raise ConfigError(f"{path}: not a picture ({error}); delete it and run the same command again") from None
    # Shrunk first, so that everything else has few pixels to go through; by whole pixels as far as that goes.
    small.thumbnail((THUMBNAIL_PX, THUMBNAIL_PX), reducing_gap=1.0)
    flat = Image.new("RGB", small.size, "white")
    flat.paste(small, mask=small)
    buffer = BytesIO()
    flat.save(buffer, "WEBP", quality=THUMBNAIL_QUALITY, method=0)
    return f"data:image/webp;base64,{base64.b64encode(buffer.getvalue()).decode()}", *flat.size


def show(listed: Listed, results: Path, job: Job, config: Mapping[str, Any]) -> Shown:
    """A figure with everything that the page says about it. Raises ConfigError for one whose tables are missing."""
    about = captioned(listed.path)
    if absent := [table for table in about.data if not (results / table).is_file()]:
        raise ConfigError(f"{results / absent[0]}: the table of {listed.path} is missing; run the same command again")
    labels = ", ".join(str(value).format(**about.words) for value in listed.labels.values())
    caption = render_caption(listed.caption, config, about.words)
    picture, width, height = thumbnail((results / listed.path).with_suffix(".png"))
    inputs = tuple(dict.fromkeys(job.inputs))
    return Shown(
        id=section_id(listed.path),
        title=f"{labels[:1].upper()}{labels[1:]}" or listed.path,
        caption=caption,
        alt=first_sentence(caption),
        link=f"../{listed.path}",
        picture=picture,
        width=width,
        height=height,
        tables=tuple((f"../{table}", table) for table in about.data),
        reason=about.none,
        rule=job.rule,
        inputs=inputs[:NAMED_INPUTS],
        more=max(0, len(inputs) - NAMED_INPUTS),
    )


def gallery_page(name: str, figures: Iterable[tuple[str, Shown]], commit: str) -> str:
    """The page of the run `name`; figures: each after its stage; commit: of the software that drew them."""
    stages: dict[str, list[Shown]] = {}
    for stage, figure in figures:
        stages.setdefault(stage, []).append(figure)
    count = sum(map(len, stages.values()))
    order = [*(stage for stage in FIRST if stage in stages), *sorted(stages.keys() - FIRST)]
    return render_page(
        FOLDER / "gallery.html",
        title="Figures",
        introduction=f"The {count} figures of the run {name}. A picture leads to the figure itself; under it are its "
        "whole caption, the tables that it is drawn from, and how it was made.",
        stages=[{"title": stage, "id": section_id(stage), "figures": stages[stage]} for stage in order],
        commit=commit,
        style=embed_files(FOLDER, "page.css", "gallery.css"),
    )
