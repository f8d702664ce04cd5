"""JSON schemas of the configuration models, and the sections in them."""

import json
from typing import Any

from pydantic import BaseModel

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
