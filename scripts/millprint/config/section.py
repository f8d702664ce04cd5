"""The base of every configuration model, and the quantities that the models share."""

from collections.abc import Sequence
from pathlib import PurePosixPath
from typing import Annotated, Any, get_args

from pydantic import BaseModel, ConfigDict, Field


class Section(BaseModel):
    """A mapping in a YAML file: unknown keys, NaN and infinity are refused."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False, populate_by_name=True)


# Sizes and places of mills [mm], in bounds that no machine reaches and no number overflows in.
Size = Annotated[float, Field(ge=0.01, le=10_000)]
Place = Annotated[float, Field(ge=-10_000, le=10_000)]
Vector = tuple[float, float, float]
PlaceVector = tuple[Place, Place, Place]

Name = Annotated[str, Field(pattern=r"^[a-z][a-z0-9_]*$")]
Positive = Annotated[float, Field(gt=0)]
NonNegative = Annotated[float, Field(ge=0)]
Fraction = Annotated[float, Field(gt=0, lt=1)]


def inside_the_project(value: str, suffixes: Sequence[str]) -> str:
    """A path from the project's root that stays inside it and ends in one of `suffixes`; raises ValueError."""
    path = PurePosixPath(value)
    if path.is_absolute() or ".." in path.parts or "\\" in value or "\0" in value:
        raise ValueError(f"path = {value!r}: must be a path inside the project, without '..'")
    if path.suffix.lower() not in suffixes:
        raise ValueError(f"path = {value!r}: must end in {', '.join(suffixes)}")
    return value


def nested_models(annotation: Any) -> list[type[BaseModel]]:
    """Models that a field's annotation holds: directly, in a list, or as one of several."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    return [model for item in get_args(annotation) for model in nested_models(item)]


def kind_of(model: type[BaseModel]) -> str:
    """What a YAML file calls a model that is one of several: its `kind`, or else the model's name."""
    kind = model.model_fields.get("kind")
    return get_args(kind.annotation)[0] if kind else model.__name__
