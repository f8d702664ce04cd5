"""Schemas and the reference of keys follow the models: `make reference` writes them."""

import json
from pathlib import Path

import pytest
import yaml
from jsonschema import Draft202012Validator
from tools.write_reference import PAGES

from millprint.config.document import MODELS, nested_models, schema_text, sections
from millprint.config.meanings import meaning_of

ROOT = Path(__file__).parents[2]


@pytest.mark.parametrize("name", MODELS)
def test_schema_has_not_drifted(name):
    assert (ROOT / "workflow/schemas" / f"{name}.schema.json").read_text() == schema_text(name)


def test_reference_has_not_drifted():
    for name, text in PAGES.items():
        assert (ROOT / name).read_text() == text()


@pytest.mark.parametrize("name", MODELS)
def test_every_value_is_described(name):
    for place, section in sections(MODELS[name]):
        for key, field in section.model_fields.items():
            is_section = bool(nested_models(field.annotation))
            assert meaning_of(section, key) or is_section or key == "kind", f"{place}.{key} has no description"


@pytest.mark.parametrize("folder", ["mills", "contacts"])
def test_files_meet_their_schema(folder):
    schema = json.loads(schema_text(folder.removesuffix("s")))
    for path in (ROOT / "config" / folder).glob("*.yaml"):
        Draft202012Validator(schema).validate(yaml.safe_load(path.read_text()))


def test_config_meets_its_schema():
    schema = json.loads(schema_text("config"))
    Draft202012Validator(schema).validate(yaml.safe_load((ROOT / "config/config.yaml").read_text()))
