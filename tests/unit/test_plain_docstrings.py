"""Docstrings on the pages of docs/ show what stands in the code, and no sign of theirs means anything else."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[2] / "docs" / "extensions"))

from docutils.core import publish_doctree
from plain_docstrings import plain_docstring


def shown(text: str) -> str:
    """The text of a docstring as a page has it; docutils raises for anything that is not clean reStructuredText."""
    source = "\n".join(plain_docstring(text.splitlines()))
    return publish_doctree(source, settings_overrides={"halt_level": 2, "report_level": 5}).astext()


@pytest.mark.parametrize(
    "text",
    ["|F_t| <= mu F_n", "NAME_ and Q_lower", "a * b * c", "x -> y <x@y>", "[1/s] and :math:", "C:\\path", "**kwargs"],
)
def test_signs_are_shown_as_they_stand(text):
    assert shown(text) == text


def test_names_in_backticks_are_code():
    tree = publish_doctree("\n".join(plain_docstring(["as `run_case` of `NAME_se`"])))
    assert [node.astext() for node in tree.findall() if node.tagname == "literal"] == ["run_case", "NAME_se"]


def test_indented_lines_keep_their_form():
    tree = publish_doctree("\n".join(plain_docstring(["The law:", "    y = |x|_1", "      + z", "", "and so on."])))
    assert [node.astext() for node in tree.findall() if node.tagname == "literal_block"] == ["y = |x|_1\n  + z"]


def test_lists_keep_the_lines_of_their_items():
    tree = publish_doctree("\n".join(plain_docstring(["Two things:", "- one, which", "  goes on,", "- two."])))
    items = [node.astext() for node in tree.findall() if node.tagname == "list_item"]
    assert [" ".join(item.split()) for item in items] == ["one, which goes on,", "two."]
