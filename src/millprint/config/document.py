"""The sections nested in a model, and JSON schemas with each description on one line."""

from typing import Any

from pydantic import BaseModel

from millprint.config.section import kind_of, nested_models


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
