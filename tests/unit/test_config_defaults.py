"""The defaults of the package are the values of the thesis, except for those listed here with a reason."""

from collections.abc import Iterator
from typing import Any

import pytest
from pydantic import BaseModel, TypeAdapter, create_model
from pydantic_core import PydanticUndefined
from tools.write_reference import MODELS

from millprint.config.document import sections
from millprint.config.load import check_model
from millprint.config.section import Section, nested_models
from millprint.config.workflow import WorkflowConfig
from tests.conftest import configuration

OWN = "the thesis's own, and another mill's or laboratory's are others"
EXCEPTIONS = {
    "name": "a run of another mill is not the thesis",
    "contacts": "one set is enough for a fingerprint; the thesis compares two",
    "sweeps": OWN,
    "doe.generators": "a design without generators is a full factorial",
    "doe.interactions": OWN,
    "doe.repeatability_percent": OWN,
    "dem.counting_rules": "every rule costs time in every run; those with a threshold answer a question of the thesis",
    "dose.spectra.counting_rules": "as dem.counting_rules",
    "fingerprint.counting_rule": "the thesis counted by facet, which is a number of the mesh",
    "mills.precision": "the thesis keeps the seeds and windows that its claims were judged with",
    "mills.counting_rule": "`fingerprint.counting_rule`, which is another one in the thesis",
    "cards.experiments": OWN,
    "cards.match": OWN,
    "fingerprint.cycle_fill_ratio": OWN,
    "mills.contact": "the first of `contacts`",
    "mills.match.speeds_rpm": "what was simulated of the mill",
    "mills.match.ball_diameters_mm": "what was simulated of the mill",
    "mills.scale_up.cores": "results depend on the number of threads by rounding, so that one is the choice for all",
    "fit.equal_jars": "the result of a search, as the jar of the mill is",
    "partition.fill_ratios": OWN,
    "validation.setups": "a run of one's own need not simulate the mills of others",
    "uncertainty.mills": "the mill of the thesis; a run of another mill asks for its own",
    "surrogate.ablations": "appendix A of the thesis",
    "surrogate.ablation_budget.rollout": "appendix A of the thesis",
}


@pytest.fixture(scope="module")
def content() -> dict:
    return configuration()


def as_text(value) -> str:
    """A value as JSON: 2 and 2.0 differ, as they do for what a job is told."""
    return TypeAdapter(Any).dump_json(value).decode()


def compared(
    model: type[BaseModel], default: BaseModel | None, given: dict, value: BaseModel, place: str = ""
) -> Iterator[tuple[str, object, object]]:
    """Dotted key, default and value of every key that the file gives and that has a default, through all sections.

    default: the section as it is if it is left out, None if it cannot be or has no value then.
    """
    for key, inner in given.items():
        field = model.model_fields[key]
        own = getattr(value, key)
        fallback = getattr(default, key) if default is not None else field.get_default(call_default_factory=True)
        named = f"{place}.{key}".lstrip(".")
        if isinstance(own, Section):
            inner_default = fallback if isinstance(fallback, Section) else None
            (section,) = nested_models(field.annotation)
            yield from compared(section, inner_default, inner, own, named)
        elif fallback is not PydanticUndefined:
            yield named, fallback, own


def test_every_default_is_the_value_of_the_thesis(content):
    config = check_model(content, WorkflowConfig, "config.yaml")
    pairs = list(compared(WorkflowConfig, None, content, config))
    assert len(pairs) > 100
    other = {place for place, default, value in pairs if as_text(default) != as_text(value)}
    assert other - set(EXCEPTIONS) == set()
    assert set(EXCEPTIONS) - other == set(), "these are no exceptions any more"


def test_the_thesis_is_read_as_it_is_written(content):
    read = check_model(content, WorkflowConfig, "config.yaml").model_dump(mode="json", exclude_unset=True)
    assert read == content


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
