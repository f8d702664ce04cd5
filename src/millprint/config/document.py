"""JSON schemas of the configuration models, the sections in them, and what each key means: the docstring under it.

Only references, schemas and `--help` show meanings. pydantic would read the source of every class whenever it is
imported, in every job.
"""

import ast
import inspect
import json
import textwrap
from functools import cache
from typing import Any

from pydantic import BaseModel

from millprint.config.card import Experiment
from millprint.config.contact_set import ContactConfig
from millprint.config.mill import MillConfig
from millprint.config.section import kind_of, nested_models
from millprint.config.workflow import WorkflowConfig


@cache
def _docstrings(model: type[BaseModel]) -> dict[str, str]:
    """The docstrings under the keys that this class defines itself."""
    (own,) = ast.parse(textwrap.dedent(inspect.getsource(model))).body
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
