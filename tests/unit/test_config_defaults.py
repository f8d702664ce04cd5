"""The defaults of the package are the values of the thesis, except for those listed here with a reason."""

from typing import Any

import pytest
from pydantic import TypeAdapter, create_model
from pydantic_core import PydanticUndefined
from tools.write_reference import MODELS

from millprint.config.section import sections


def as_text(value) -> str:
    """A value as JSON: 2 and 2.0 differ, as they do for what a job is told."""
    return TypeAdapter(Any).dump_json(value).decode()


@pytest.mark.parametrize("name", MODELS)
def test_every_default_is_what_the_model_would_make_of_it(name):
    """Pydantic does not look at defaults: none may be out of bounds, nor a whole number where others are decimal."""
    for place, section in sections(MODELS[name]):
        for key, field in section.model_fields.items():
            default = field.get_default(call_default_factory=True)
            if default is not PydanticUndefined:
                plain = TypeAdapter(Any).dump_python(default, mode="json")
                read = create_model("One", value=(field.annotation, field)).model_validate({"value": plain}).value
                assert as_text(read) == as_text(default), f"{place}.{key}"
