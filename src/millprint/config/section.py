"""The base of every configuration model, the quantities that the models share, and their JSON schemas."""

import math
from collections import Counter
from collections.abc import Hashable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import PurePosixPath
from typing import Annotated, Any, TypeVar, get_args

from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, Field, model_validator
from pydantic_core import PydanticCustomError

Item = TypeVar("Item", bound=Hashable)

# The type of an error that concerns one key of a section; its context names the key.
TRUTH = "truth_value"


# The name of the alternative, in the path of a fault, where a key holds a plain value or a section.
PLAIN_VALUE = "(plain value)"


class Section(BaseModel):
    """A mapping in a YAML file: unknown keys, NaN, infinity, and truth values for numbers or texts are refused."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    @model_validator(mode="before")
    @classmethod
    def _no_truth_value_by_mistake(cls, content: Any) -> Any:
        for name, value in content.items() if isinstance(content, dict) else ():
            field = cls.model_fields.get(name)
            if field and _holds_truth(value) and not _takes(field.annotation, bool):
                words = "YAML reads yes, no, on and off as true and false; quote them, or give a number"
                raise PydanticCustomError(TRUTH, words, {"key": name, "value": value})
        return content

    def part(self, base: type["Section"]) -> dict[str, Any]:
        """The keys that this section inherits from `base`, as plain values."""
        return self.model_dump(mode="json", include=set(base.model_fields))


def _holds_truth(value: Any) -> bool:
    return isinstance(value, bool) or (isinstance(value, list | tuple) and any(map(_holds_truth, value)))


def _takes(annotation: Any, kind: type) -> bool:
    """Whether a type is part of a field's annotation."""
    return annotation is kind or any(_takes(item, kind) for item in get_args(annotation))


# Sizes and positions of mills [mm], with bounds beyond any machine but without overflow.
Size = Annotated[float, Field(ge=0.01, le=10_000)]
VesselSize = Annotated[float, Field(ge=1, le=10_000)]
Place = Annotated[float, Field(ge=-10_000, le=10_000)]
Vector = tuple[float, float, float]
PlaceVector = tuple[Place, Place, Place]


def has_direction(vector: Vector) -> Vector:
    """The vector, if it has a direction that its length does not spoil. Raises ValueError."""
    length = math.hypot(*vector)
    if length == 0:
        raise ValueError("[0, 0, 0]: an axis needs a direction")
    if not 1e-6 <= length <= 1e6:
        raise ValueError(f"{list(vector)}: a direction has a length of 1e-6 to 1e6; only its sense counts, write 1")
    return vector


# A factor for the lengths of a file.
Scale = Annotated[float, Field(ge=1e-3, le=1e3)]

# Larger whole numbers are typing errors: no job could count to them, and libraries refuse such seeds.
Count = Annotated[int, Field(ge=1, le=10_000_000)]
Seed = Annotated[int, Field(ge=0, le=2**32 - 1)]

# Speeds [rpm, Hz], bounded so that no number overflows; mill.speed_limits knows what mills can do.
FASTEST = 10_000_000
Speed = Annotated[float, Field(ge=0, le=FASTEST)]
PositiveSpeed = Annotated[float, Field(gt=0, le=FASTEST)]


@dataclass(frozen=True)
class InProject:
    """Marks a text that is the path of a file inside the project; `millprint.checks.before_running` checks that."""


ProjectFile = Annotated[str, InProject()]

NAME_PATTERN = r"^[a-z][a-z0-9_]*$"
Name = Annotated[str, Field(pattern=NAME_PATTERN, max_length=60)]
Positive = Annotated[float, Field(gt=0)]
# Balls of any mill, from beads of 20 micrometres [mm], and what they are made of, from plastic to gold [kg/m3].
Diameter = Annotated[float, Field(ge=0.02, le=10_000)]
Density = Annotated[float, Field(ge=100, le=25_000)]
NonNegative = Annotated[float, Field(ge=0)]
Fraction = Annotated[float, Field(gt=0, lt=1)]


class NamedSection(Section):
    """A section with a YAML file of its own, named after it."""

    name: Name


def project_path(*suffixes: str) -> AfterValidator:
    """Validates a text as a path from the project's root that stays inside it and ends in one of `suffixes`."""

    def check(value: str) -> str:
        path = PurePosixPath(value)
        if path.is_absolute() or ".." in path.parts or "\\" in value or "\0" in value:
            raise ValueError(f"path = {value!r}: must be a path inside the project, without '..'")
        if path.suffix.lower() not in suffixes:
            raise ValueError(f"path = {value!r}: must end in {', '.join(suffixes)}")
        return value

    return AfterValidator(check)


def completed(default: Mapping[str, Any]) -> BeforeValidator:
    """Fills in what a mapping of a key leaves out, in the order of `default`."""

    def complete(content: Any) -> Any:
        return {**default, **content} if isinstance(content, dict) else content

    return BeforeValidator(complete)


def first_repeated(items: Iterable[Item]) -> Item | None:
    """The first item that appears more than once; None if all differ."""
    return next((item for item, count in Counter(items).items() if count > 1), None)


def nested_models(annotation: Any) -> list[type[BaseModel]]:
    """Models that a field's annotation holds: directly, in a list, or as one of several."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    return [model for item in get_args(annotation) for model in nested_models(item)]


def kind_of(model: type[BaseModel]) -> str:
    """The name of a model in YAML if it is one of several: its `kind`, otherwise the name of the model."""
    kind = model.model_fields.get("kind")
    names = get_args(kind.annotation) if kind else ()
    return names[0] if names else model.__name__


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
