"""Schemas and the reference of keys follow the models: `make reference` writes them."""

import json
import re
from pathlib import Path

import pytest
import yaml
from jsonschema import Draft202012Validator
from tools.write_reference import MILLS, MODELS, PAGES, meaning_of, mills_page, parts, reference_text, schema_text

from millprint.config.document import nested_models, sections
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
def test_the_page_of_the_mills_has_not_drifted():
    assert (ROOT / MILLS).read_text() == mills_page()


@pytest.mark.slow
def test_every_key_is_written_once_and_every_link_of_the_reference_leads_somewhere():
    page = reference_text()
    headings = re.findall(r"^### `(.+)`$", page, re.MULTILINE)
    slugs = [re.sub(r"[^\w -]", "", heading).replace(" ", "-").lower() for heading in headings]
    rows = re.findall(r'^\| `(\w+)`<a id="([^"]+)"></a> \|', page, re.MULTILINE)
    assert len(rows) == page.count("\n| `") and len(rows) > 100
    anchors = [*slugs, *(anchor for _, anchor in rows)]
    assert len(set(anchors)) == len(anchors)
    assert set(re.findall(r"\(#([^)]+)\)", page)) <= set(slugs)
    assert {"dem-window_s", "contact-restitution", "mill-volume_ml", "mill-sweep-conditions-fill_ratio"} <= set(anchors)
    # A key without a row is in the line of a section that has it, or is a section that is only linked.
    linked = re.findall(r'<a id="([^"]+)"></a>\[`', page)
    assert len({*anchors, *linked}) == len(anchors) + len(linked)
    models = {place.model for group in parts().values() for place in group}
    explained = {key for key, _ in rows} | set(re.findall(r"`(\w+)`", "".join(re.findall("^Keys as in.*", page, re.M))))
    explained |= {anchor.rpartition("-")[2] for anchor in linked}
    assert {key for model in models for key in model.model_fields} - explained == set()
    # One that occurs in many places has one table.
    assert page.count("### `geometry (cylinder)`") == 1 and "### `inserts.geometry (cylinder)`" not in page
    assert page.count("\n| `sizes_mm`") == 1


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
    Draft202012Validator(schema).validate(configuration())
