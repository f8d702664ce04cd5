"""JSON schemas and the reference of every key, generated from the configuration models."""

import json
from types import UnionType
from typing import Annotated, Any, Union, get_args, get_origin

from annotated_types import Ge, Gt, Le, Lt
from pydantic import BaseModel
from pydantic.fields import FieldInfo
from pydantic_core import PydanticUndefined

from millprint.config.bench import BenchConfig
from millprint.config.contact import ContactConfig
from millprint.config.mill import MillConfig
from millprint.config.section import kind_of, nested_models
from millprint.config.workflow import WorkflowConfig

MODELS: dict[str, type[BaseModel]] = {
    "config": WorkflowConfig,
    "mill": MillConfig,
    "contact": ContactConfig,
    "bench": BenchConfig,
}
FILES = {
    "config": "config/config.yaml and config/smoke.yaml",
    "mill": "config/mills/NAME.yaml",
    "contact": "config/contacts/NAME.yaml",
    "bench": "config/bench.yaml",
}

_BOUNDS = {Gt: (">", "gt"), Ge: (">=", "ge"), Lt: ("<", "lt"), Le: ("<=", "le")}


def schema_text(name: str) -> str:
    """The JSON schema of a model, as it is committed in workflow/schemas."""
    return json.dumps(MODELS[name].model_json_schema(by_alias=True), indent=1) + "\n"


def reference_text() -> str:
    """Markdown: a table for every section of every YAML file, with each key's meaning, unit, bounds and default."""
    lines: list[str] = []
    for name, model in MODELS.items():
        lines += [f"### {FILES[name]}", ""]
        for title, section in sections(model):
            lines += [f"#### `{title}`" if title else "#### top level", "", _summary(section), ""]
            lines += ["| key | meaning | bounds | default |", "|---|---|---|---|"]
            lines += [_row(key, field) for key, field in section.model_fields.items()]
            lines.append("")
    return "\n".join(lines)


def _summary(section: type[BaseModel]) -> str:
    return " ".join((section.__doc__ or "").split())


def sections(model: type[BaseModel], place: str = "") -> list[tuple[str, type[BaseModel]]]:
    """The model and every model nested in it, each with its dotted key."""
    found = [(place, model)]
    for name, field in model.model_fields.items():
        key = f"{place}.{name}".lstrip(".")
        nested = nested_models(field.annotation)
        for item in nested:
            found += sections(item, key if len(nested) == 1 else f"{key} ({kind_of(item)})")
    return found


def _row(key: str, field: FieldInfo) -> str:
    default = "required" if field.is_required() else _default(field)
    meaning = (field.description or "a section of its own").replace("|", "\\|")
    return f"| `{key}` | {meaning} | {_bounds(field)} | {default} |"


def _default(field: FieldInfo) -> str:
    if field.default is not PydanticUndefined:
        return "left out" if field.default is None else f"`{field.default}`"
    return "see the section"


def _bounds(field: FieldInfo) -> str:
    marks = _marks(field.metadata) or _marks(_inner_metadata(field.annotation))
    choices = [f"`{value}`" for value in get_args(field.annotation) if isinstance(value, str)]
    return " or ".join(choices) or ", ".join(marks)


def _marks(metadata: list) -> list[str]:
    marks = []
    for item in metadata:
        for kind, (sign, attribute) in _BOUNDS.items():
            if isinstance(item, kind):
                marks.append(f"{sign} {getattr(item, attribute):g}")
        if isinstance(item, FieldInfo):
            marks += _marks(item.metadata)
    return marks


def _inner_metadata(annotation: Any) -> list:
    """Metadata inside `list[Annotated[...]]` and `Annotated[...] | None`."""
    if get_origin(annotation) is Annotated:
        return list(get_args(annotation)[1:])
    if get_origin(annotation) in (list, Union, UnionType):
        return [item for part in get_args(annotation) for item in _inner_metadata(part)]
    return []
