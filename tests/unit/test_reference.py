"""Schemas and the reference of keys follow the models: `make reference` writes them."""

import json
from pathlib import Path

import pytest
import yaml
from jsonschema import Draft202012Validator
from tools.write_reference import FINGERPRINTS, MILLS, MODELS, PAGES, fingerprints_page, mills_page, schema_text

from tests.conftest import configuration

ROOT = Path(__file__).parents[2]


@pytest.mark.parametrize("name", MODELS)
@pytest.mark.slow
def test_schema_has_not_drifted(name):
    assert (ROOT / "workflow/schemas" / f"{name}.schema.json").read_text() == schema_text(name)


def test_reference_has_not_drifted():
    for name, text in PAGES.items():
        assert (ROOT / name).read_text() == text()


@pytest.mark.slow
@pytest.mark.parametrize(("path", "text"), [(MILLS, mills_page), (FINGERPRINTS, fingerprints_page)])
def test_the_pages_of_the_mills_have_not_drifted(path, text):
    assert (ROOT / path).read_text() == text()
    assert (ROOT / path).stat().st_size < 4e6


@pytest.mark.parametrize("folder", ["mills", "contacts"])
def test_files_meet_their_schema(folder):
    schema = json.loads(schema_text(folder.removesuffix("s")))
    for path in (ROOT / "config" / folder).glob("*.yaml"):
        Draft202012Validator(schema).validate(yaml.safe_load(path.read_text()))


def test_config_meets_its_schema():
    schema = json.loads(schema_text("config"))
    Draft202012Validator(schema).validate(configuration())
