"""What is refused, and in which words: one table of all tests, tests/data/refusals.tsv."""

import csv
import json
from collections.abc import Callable
from functools import cache

import pytest

from millprint.config.errors import MillprintError
from tests.conftest import ROOT


@cache
def _rows() -> list[dict[str, str]]:
    with open(ROOT / "tests/data/refusals.tsv", encoding="utf-8") as file:
        return list(csv.DictReader(file, delimiter="\t", quoting=csv.QUOTE_NONE))


def refusals(test: str) -> list[list]:
    """Of a test, the inputs in JSON, each with the line by which it is refused, or the parts of that line."""
    found = [[*json.loads(row["input"]), json.loads(row["line"])] for row in _rows() if row["test"] == test]
    assert found, f"{test}: no such test in tests/data/refusals.tsv"
    return found


def refusal(call: Callable, *given) -> str:
    """The one line with which a call is refused; several lines are a failure."""
    with pytest.raises(MillprintError) as caught:
        call(*given)
    (line,) = str(caught.value).splitlines()
    return line
