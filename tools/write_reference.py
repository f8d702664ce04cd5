"""Writes schemas, config/keys.md, workflow/descriptors.md, workflow/card.md, docs/mills.html, docs/fingerprints.html:
`make reference`.

The reference of keys has a table for every section and a row for every key, each written once. What a key means is the
docstring under it. A section that occurs in several places has its table at the first one, and a key that several
sections inherit has its row in the first of them; the others link there. A key has the anchor `SECTION-KEY`, such as
`dem-window_s`.
"""

import ast
import inspect
import json
import re
import textwrap
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cache
from itertools import groupby
from pathlib import Path
from typing import Any

from pydantic import BaseModel
from pydantic.fields import FieldInfo
from pydantic_core import PydanticUndefined

from millprint.atlas.page.atlas_page import atlas_page, read_content
from millprint.card.card_model import FORMAT, SCHEMA_VERSION, MillingCard
from millprint.config.card import Experiment
from millprint.config.contact_set import ContactConfig
from millprint.config.included import load_mill
from millprint.config.mill import MillConfig
from millprint.config.section import descriptions_on_a_line, kind_of, nested_models, on_a_line, sections
from millprint.config.workflow import ChapterSections, WorkflowConfig
from millprint.explorer.content import Machine, explorer_content, explorer_page, mill_content
from millprint.fingerprint.condition_search import simulated_request
from millprint.fingerprint.model import Fingerprint
from millprint.fingerprint.readers import find_ready_made, ready_made
from millprint.observables.definitions import explain_columns
from millprint.run.files import whole_file

HEAD = """# Every key

Made by `make reference` from the models in `src/millprint/config`; do not edit. [README.md](README.md) says how to
write a configuration of your own. Each key is explained once: where a section or a key occurs again, a link leads
there, and a default in parentheses is the section's own. A word in parentheses after a section's name, as in
`motion (circle)`, is its `kind`. The column `default` shows the value if a key is missing:

- `required`: the key must be given if its section is.
- see the section: every key of that section has its own default, in the table of the section. A section that needs
  no further word is only linked, above the table.
- left out: there is no value; the column `meaning` says what that means.
"""
FRONT = ["| key | meaning | bounds | default |", "|---|---|---|---|"]

# The sign of each bound, by its name in a JSON schema.
SIGNS = {"exclusiveMinimum": ">", "minimum": ">=", "exclusiveMaximum": "<", "maximum": "<="}
# Sections that only the chapters of the thesis need, and those that show how well it was repeated.
THESIS = {*ChapterSections.model_fields, "fit", "claims", "validation"}
# Places of a section that a line names.
NAMED_PLACES = 3


MODELS: dict[str, type[BaseModel]] = {
    "config": WorkflowConfig,
    "mill": MillConfig,
    "contact": ContactConfig,
    "experiment": Experiment,
}


def schema_text(name: str) -> str:
    """The JSON schema of a model, as stored in workflow/schemas."""
    return json.dumps(explained_schema(MODELS[name]), indent=1) + "\n"


def explained_schema(model: type[BaseModel]) -> dict[str, Any]:
    """The JSON schema of a model and of all models in it, with the meaning of each key on a line."""
    schema = model.model_json_schema(by_alias=True)
    for section in {section for _, section in sections(model)}:
        # pydantic lists models of the same name with their modules.
        full_name = f"{section.__module__}.{section.__qualname__}".replace(".", "__")
        places = schema.get("$defs", {})
        own = schema if section is model else places.get(full_name) or places[section.__name__]
        keys = own["properties"]
        for key, own_field in section.model_fields.items():
            if meaning := meaning_of(section, key):
                # In the order of pydantic, which sorts the properties of a key.
                name = own_field.alias or key
                keys[name] = dict(sorted({**keys[name], "description": meaning}.items()))
    return descriptions_on_a_line(schema)


@cache
def _docstrings(model: type[BaseModel]) -> dict[str, str]:
    """The docstrings under the keys that this class defines itself; one that a registry makes has none."""
    try:
        (own,) = ast.parse(textwrap.dedent(inspect.getsource(model))).body
    except OSError:
        return {}
    assert isinstance(own, ast.ClassDef)
    found = {}
    for key, text in zip(own.body, own.body[1:], strict=False):
        value = text.value.value if isinstance(text, ast.Expr) and isinstance(text.value, ast.Constant) else None
        if isinstance(key, ast.AnnAssign) and isinstance(key.target, ast.Name) and isinstance(value, str):
            found[key.target.id] = inspect.cleandoc(value)
    return found


def source_of_meaning(model: type[BaseModel], key: str) -> type[BaseModel]:
    """The nearest class that has a docstring for a key; without any, the one that is the first to have the key."""
    classes = [each for each in model.__mro__ if issubclass(each, BaseModel) and key in each.model_fields]
    return next((each for each in classes if key in _docstrings(each)), classes[-1])


def meaning_of(model: type[BaseModel], key: str) -> str:
    """The docstring of a key, of the nearest class that has one, or the description of its type; empty without any."""
    return _docstrings(source_of_meaning(model, key)).get(key) or model.model_fields[key].description or ""


@dataclass(frozen=True)
class Place:
    """A section in a part of the reference: its dotted key (empty for the whole file), its model, and its anchors.

    root: the first word of its anchors; in the run's configuration that of the section itself.
    """

    key: str
    model: type[BaseModel]
    root: str = ""

    @property
    def slug(self) -> str:
        """The anchor of its heading, as GitHub and Sphinx derive it."""
        return re.sub(r"[^\w -]", "", self.key).replace(" ", "-").lower()

    def anchor(self, key: str) -> str:
        """The anchor of one of its keys."""
        return "-".join(filter(None, [self.root, *re.findall(r"\w+", self.key), key]))

    @property
    def link(self) -> str:
        """A link to its table."""
        return f"[`{self.key}`](#{self.slug})"


@dataclass
class Written:
    """What the reference has already: the place of each model, and of each key by the class that explains it."""

    tables: dict[type[BaseModel], Place] = field(default_factory=dict)
    rows: dict[tuple[type[BaseModel], str], tuple[Place, FieldInfo]] = field(default_factory=dict)


def parts() -> dict[str, list[Place]]:
    """The sections of each heading, in the order in which a user meets them; a section may occur again."""
    _, *inner = [Place(key, model) for key, model in sections(WorkflowConfig)]
    thesis = [place for place in inner if place.key.split(".")[0] in THESIS]
    return {
        "config/config.yaml, config/smoke.yaml and your own": [Place("", WorkflowConfig, "config")],
        "config/mills/NAME.yaml": [Place(key, model, "mill") for key, model in sections(MillConfig)],
        "config/contacts/NAME.yaml": [Place(key, model, "contact") for key, model in sections(ContactConfig)],
        "Sections of the configuration": [place for place in inner if place not in thesis],
        "card.yaml, of `millprint card`; in a table of experiments each key is a column": [
            Place(key, model, "card") for key, model in sections(Experiment)
        ],
        "Sections of the configuration for the chapters of the thesis": thesis,
    }


def reference_text() -> str:
    """The whole page config/keys.md."""
    written, found = Written(), parts()
    places = [place for group in found.values() for place in group]
    for place in places:
        written.tables.setdefault(place.model, place)
    lines = [HEAD]
    for title, group in found.items():
        lines += [f"## {title}", ""]
        for place in group:
            if written.tables[place.model] is place:
                lines += _section(place, written, [one.key for one in places if one.model is place.model][1:])
    return "\n".join(lines)


def _section(place: Place, written: Written, further: list[str]) -> list[str]:
    """Heading, meaning and table of a section that also occurs at `further` keys."""
    model = place.model
    schema = model.model_json_schema()["properties"]
    lines = [f"### `{place.key}`", ""] if place.key else []
    lines += [on_a_line(model.__doc__), *_other_places(further), ""]
    rows, shared, inner = [], [], []
    for key, own in model.model_fields.items():
        if key == "kind" and place.key.endswith(")"):
            continue
        source = source_of_meaning(model, key), key
        if source in written.rows:
            shared.append((written.rows[source][0], _with_default(key, own, written.rows[source][1])))
        elif len(nested := nested_models(own.annotation)) == 1 and not meaning_of(model, key):
            needed = " (required)" if own.is_required() else ""
            inner.append(f'<a id="{place.anchor(key)}"></a>{written.tables[nested[0]].link}{needed}')
        else:
            written.rows[source] = place, own
            rows.append(_row(place, key, schema[own.alias or key], written))
    for other, keys in groupby(shared, lambda each: each[0]):
        lines += [f"Keys as in {other.link}: {', '.join(named for _, named in keys)}.", ""]
    if inner:
        lines += [f"Sections in it: {', '.join(inner)}.", ""]
    return [*lines, *FRONT, *rows, ""] if rows else lines


def _other_places(keys: list[str]) -> Iterator[str]:
    if keys:
        more = f" and in {len(keys) - NAMED_PLACES} more places" if len(keys) > NAMED_PLACES else ""
        yield f"Also: {', '.join(f'`{key}`' for key in keys[:NAMED_PLACES])}{more}."


def _with_default(key: str, own: FieldInfo, shown: FieldInfo) -> str:
    """A key of another table, with its own default where that differs."""
    return f"`{key}`" if default_of(own) == default_of(shown) else f"`{key}` ({default_of(own)})"


def _row(place: Place, key: str, schema: dict, written: Written) -> str:
    own = place.model.model_fields[key]
    meaning = on_a_line(meaning_of(place.model, key)).replace("|", "\\|")
    nested = [written.tables[model] for model in nested_models(own.annotation) if model in written.tables]
    words = [f"[{kind_of(one.model)}](#{one.slug})" for one in nested] if len(nested) > 1 else []
    words = words or [f"section {one.link}" for one in nested]
    meaning = "; ".join(filter(None, [meaning, ", ".join(words)]))
    return f'| `{key}`<a id="{place.anchor(key)}"></a> | {meaning} | {bounds_of(schema)} | {default_of(own)} |'


def default_of(own: FieldInfo) -> str:
    """The default as YAML; for a section whose keys all have defaults, a reference to its table."""
    value = own.default
    if own.is_required():
        return "required"
    if value is PydanticUndefined or _is_empty_section(value):
        return "see the section"
    return "left out" if value is None else f"`{_in_yaml(value)}`"


def _is_empty_section(value: Any) -> bool:
    if not isinstance(value, BaseModel) or any(own.is_required() for own in type(value).model_fields.values()):
        return False
    return value == type(value)()


def _in_yaml(value: Any) -> str:
    """A value as one line of YAML: readable numbers, and sections without their default values."""
    if isinstance(value, BaseModel):
        value = value.model_dump(mode="json", exclude_defaults=True)
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key}: {_in_yaml(item)}" for key, item in value.items()) + "}"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(map(_in_yaml, value)) + "]"
    if isinstance(value, float):
        # Without a point YAML takes 2e-6 for a text.
        digits, letter, power = f"{value:.15g}".partition("e")
        return digits + (f"{'' if '.' in digits else '.0'}e{int(power)}" if letter else "")
    if isinstance(value, bool):
        return str(value).lower()
    return str(value)


def bounds_of(schema: dict) -> str:
    """Choices or bounds of a key, or of what its list holds, from its JSON schema."""
    choices = [f"`{value}`" for value in schema.get("enum", [schema["const"]] if "const" in schema else [])]
    marks = [f"{sign} {schema[name]:g}" for name, sign in SIGNS.items() if name in schema]
    if choices or marks:
        return " or ".join(choices) or ", ".join(marks)
    inner = [*schema.get("anyOf", []), *schema.get("oneOf", []), *([schema["items"]] if "items" in schema else [])]
    return next(filter(None, map(bounds_of, inner)), "")


CARD_HEAD = f"""# The milling card

Made by `make reference` from `src/millprint/card/card_model.py`; do not edit. `card.json` describes one experiment in a
mill in numbers. Any program can write such a file: [schemas/card.schema.json](schemas/card.schema.json) is its
JSON schema (draft 2020-12), and this page has every field. A field that is not required may be left out or be `null`.
`format` is `{FORMAT}` and `schema_version` {SCHEMA_VERSION}; a change that makes older cards invalid raises it, and a
card of another version is refused. `millprint match --from card.json --to MILL` reads any
card: it needs only the required fields, and for doses also `powder` and `programme`.

Numbers are in the unit at the end of their name, or in their `unit`. Intervals of different origins are given
separately and not added up.
"""


def card_schema_text() -> str:
    """The JSON schema of a card, as stored in workflow/schemas."""
    return json.dumps(descriptions_on_a_line(MillingCard.model_json_schema()), indent=1) + "\n"


def explain_card() -> str:
    """The page workflow/card.md: a table of fields for each part of a card, from its JSON schema, as Markdown.

    A part that appears in several places is named after its class.
    """
    schema = descriptions_on_a_line(MillingCard.model_json_schema())
    places: list[tuple[str, str]] = []
    _add_places("", MillingCard.__name__, schema, places)
    counts = Counter(part for _, part in places)
    lines, parts = [CARD_HEAD], {MillingCard.__name__: schema, **schema["$defs"]}
    for part in counts:
        place = next(place for place, each in places if each == part)
        title = _named(part) if counts[part] > 1 else f"`{place}`" if place else "top level"
        lines += [f"## {title}", "", parts[part]["description"], "", "| field | meaning | |", "|---|---|---|"]
        for name, own in parts[part]["properties"].items():
            kinds = [_named(inner) if counts[inner] > 1 else "see below" for inner in _parts_in(own)]
            meaning = "; ".join(filter(None, [own.get("description"), *kinds]))
            lines.append(f"| `{name}` | {meaning} | {'required' * (name in parts[part]['required'])} |")
        lines.append("")
    return "\n".join(lines)


def _named(part: str) -> str:
    return f"{'an' if part[0] in 'AEIOU' else 'a'} `{part}`"


def _parts_in(own: dict) -> list[str]:
    """The names of the parts that a field of a JSON schema holds."""
    return re.findall(r'"#/\$defs/(\w+)"', json.dumps(own))


def _add_places(place: str, part: str, schema: dict, places: list[tuple[str, str]]) -> None:
    """Add every place of a card, with the name of the part there, from this one on downwards."""
    places.append((place, part))
    properties = schema["$defs"][part]["properties"] if place else schema["properties"]
    for name, own in properties.items():
        for inner in _parts_in(own):
            _add_places(f"{place}.{name}".lstrip("."), inner, schema, places)


ROOT = Path(__file__).parent.parent
PAGES = {
    "config/keys.md": reference_text,
    "workflow/descriptors.md": explain_columns,
    "workflow/card.md": explain_card,
    "workflow/schemas/card.schema.json": card_schema_text,
}


# Their texts take longer than those of the others.
MILLS, FINGERPRINTS = "docs/mills.html", "docs/fingerprints.html"
TURNS = ROOT / "docs/turns.json"


def mills_page() -> str:
    """The page from a paper to one's own mill, from the atlas, without a simulation."""
    return atlas_page(read_content(ROOT / "config/atlas", TURNS, ready_made()))


def fingerprints_page() -> str:
    """The explorer of the mills that come with millprint, from their fingerprints, without a simulation."""
    contents = []
    for name in ready_made():
        path = find_ready_made(name)
        assert path is not None, f"{name}: its file is another one than config/fingerprints was made of"
        request = simulated_request(Fingerprint.read(path), "weighted")
        contents.append(mill_content(Machine.of_mill(load_mill(name)), [path], request))
    return explorer_page(explorer_content("the mills of millprint", contents))


def main() -> None:
    """Write every schema and every page."""
    for name in MODELS:
        with whole_file(ROOT / "workflow" / "schemas" / f"{name}.schema.json") as draft:
            draft.write_text(schema_text(name))
    for name, text in (PAGES | {MILLS: mills_page, FINGERPRINTS: fingerprints_page}).items():
        with whole_file(ROOT / name) as draft:
            draft.write_text(text())


if __name__ == "__main__":
    main()
