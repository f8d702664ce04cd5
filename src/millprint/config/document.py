"""JSON schemas and the reference of every key, generated from the configuration models."""

import json
from typing import Any

from pydantic import BaseModel
from pydantic.fields import FieldInfo
from pydantic_core import PydanticUndefined

from millprint.config.card import Experiment
from millprint.config.contact_set import ContactConfig
from millprint.config.meanings import meaning_of
from millprint.config.mill import MillConfig
from millprint.config.section import kind_of, nested_models
from millprint.config.workflow import WorkflowConfig

MODELS: dict[str, type[BaseModel]] = {
    "config": WorkflowConfig,
    "mill": MillConfig,
    "contact": ContactConfig,
    "experiment": Experiment,
}
FILES = {
    "config": "config/config.yaml, config/smoke.yaml and your own",
    "mill": "config/mills/NAME.yaml",
    "contact": "config/contacts/NAME.yaml",
    "experiment": "card.yaml, of scripts/write_card.py; in a table of experiments each key is a column",
}

HEAD = """# Every key

Made by `make reference` from the models in `src/millprint/config`; do not edit. [README.md](README.md) says how to
write a configuration of your own. The column `default` shows the value if a key is missing:

- `required`: the key must be given if its section is.
- see the section: every key of that section has its own default, in the table of the section.
- left out: there is no value; the column `meaning` says what that means.
"""

# The sign of each bound, by its name in a JSON schema.
SIGNS = {"exclusiveMinimum": ">", "minimum": ">=", "exclusiveMaximum": "<", "maximum": "<="}


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
        for key, field in section.model_fields.items():
            if meaning := meaning_of(section, key):
                # In the order of pydantic, which sorts the properties of a key.
                keys[field.alias or key] = dict(sorted({**keys[field.alias or key], "description": meaning}.items()))
    return descriptions_on_a_line(schema)


def descriptions_on_a_line(schema: Any) -> Any:
    """A JSON schema in which a description that fills several lines of a docstring fills one."""
    if isinstance(schema, list):
        return [descriptions_on_a_line(item) for item in schema]
    if not isinstance(schema, dict):
        return schema
    plain = {key: descriptions_on_a_line(value) for key, value in schema.items()}
    if isinstance(plain.get("description"), str):
        plain["description"] = on_a_line(plain["description"])
    return plain


def reference_text() -> str:
    """Markdown: a table for every section of every YAML file, with each key's meaning, unit, bounds and default."""
    lines = [HEAD]
    for name, model in MODELS.items():
        lines += [f"## {FILES[name]}", ""]
        for title, section in sections(model):
            lines += [f"### `{title}`" if title else "### top level", "", on_a_line(section.__doc__), ""]
            lines += ["| key | meaning | bounds | default |", "|---|---|---|---|"]
            keys = section.model_json_schema()["properties"]
            fields = section.model_fields
            lines += [_row(section, key, fields[key], keys[fields[key].alias or key]) for key in fields]
            lines.append("")
    return "\n".join(lines)


def on_a_line(text: str | None) -> str:
    """A text without its line breaks."""
    return " ".join((text or "").split())


def sections(model: type[BaseModel], place: str = "") -> list[tuple[str, type[BaseModel]]]:
    """The model and every model nested in it, each with its dotted key."""
    found = [(place, model)]
    for name, field in model.model_fields.items():
        key = f"{place}.{name}".lstrip(".")
        nested = nested_models(field.annotation)
        for item in nested:
            found += sections(item, key if len(nested) == 1 else f"{key} ({kind_of(item)})")
    return found


def _row(section: type[BaseModel], key: str, field: FieldInfo, schema: dict) -> str:
    default = "required" if field.is_required() else _default(field)
    meaning = (on_a_line(meaning_of(section, key)) or "a section of its own").replace("|", "\\|")
    return f"| `{key}` | {meaning} | {_bounds(schema)} | {default} |"


def _default(field: FieldInfo) -> str:
    """The default as YAML; for a section whose keys all have defaults, a reference to its table."""
    value = field.default
    if value is PydanticUndefined or _is_empty_section(value):
        return "see the section"
    return "left out" if value is None else f"`{_in_yaml(value)}`"


def _is_empty_section(value: Any) -> bool:
    if not isinstance(value, BaseModel) or any(field.is_required() for field in type(value).model_fields.values()):
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


def _bounds(schema: dict) -> str:
    """Choices or bounds of a key, or of what its list holds, from its JSON schema."""
    choices = [f"`{value}`" for value in schema.get("enum", [schema["const"]] if "const" in schema else [])]
    marks = [f"{sign} {schema[name]:g}" for name, sign in SIGNS.items() if name in schema]
    if choices or marks:
        return " or ".join(choices) or ", ".join(marks)
    inner = [*schema.get("anyOf", []), *schema.get("oneOf", []), *([schema["items"]] if "items" in schema else [])]
    return next(filter(None, map(_bounds, inner)), "")
