"""Writes schemas, config/keys.md (keys), workflow/descriptors.md (columns), workflow/card.md: `make reference`."""

import json
from collections import Counter
from pathlib import Path

from pydantic import BaseModel

from millprint.card.card_model import FORMAT, SCHEMA_VERSION, MillingCard
from millprint.config.document import MODELS, descriptions_on_a_line, on_a_line, schema_text, sections
from millprint.config.reference import reference_text
from millprint.config.section import nested_models
from millprint.fingerprint.columns import explain_columns
from millprint.run.files import whole_file

ROOT = Path(__file__).parent.parent
HEAD = f"""# The milling card

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
    """The page workflow/card.md: a table of fields for each part of a card, as Markdown.

    A part that appears in several places is named after its model.
    """
    found = sections(MillingCard)
    places = Counter(model for _, model in found)
    shared = {model for model, count in places.items() if count > 1}
    lines = [HEAD]
    for place, model in _first_places(found):
        title = f"a `{model.__name__}`" if model in shared else f"`{place}`" if place else "top level"
        lines += [f"## {title}", "", on_a_line(model.__doc__), "", "| field | meaning | |", "|---|---|---|"]
        for name, field in model.model_fields.items():
            part = next(iter(nested_models(field.annotation)), None)
            kind = "" if part is None else f"a `{part.__name__}`" if part in shared else "see below"
            meaning = "; ".join(filter(None, [on_a_line(field.description), kind]))
            lines.append(f"| `{name}` | {meaning} | {'required' if field.is_required() else ''} |")
        lines.append("")
    return "\n".join(lines)


def _first_places(found: list[tuple[str, type[BaseModel]]]) -> list[tuple[str, type[BaseModel]]]:
    """Each model once, at the first place where it appears."""
    firsts: dict[type[BaseModel], str] = {}
    for place, model in found:
        firsts.setdefault(model, place)
    return [(place, model) for model, place in firsts.items()]


PAGES = {
    "config/keys.md": reference_text,
    "workflow/descriptors.md": explain_columns,
    "workflow/card.md": explain_card,
    "workflow/schemas/card.schema.json": card_schema_text,
}


def main() -> None:
    """Write every schema and every page."""
    for name in MODELS:
        with whole_file(ROOT / "workflow" / "schemas" / f"{name}.schema.json") as draft:
            draft.write_text(schema_text(name))
    for name, text in PAGES.items():
        with whole_file(ROOT / name) as draft:
            draft.write_text(text())


if __name__ == "__main__":
    main()
