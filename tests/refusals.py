"""What is refused, and what follows from an input: tables of all tests, refusals.tsv and truths.tsv of tests/data."""

import csv
import json
from collections.abc import Callable
from functools import cache

import pytest

from millprint.config.errors import MillprintError
from tests.conftest import ROOT


@cache
def _rows(table: str) -> list[list[str]]:
    with open(ROOT / f"tests/data/{table}.tsv", encoding="utf-8") as file:
        return list(csv.reader(file, delimiter="\t", quoting=csv.QUOTE_NONE))


def _of(test: str, table: str) -> list[list]:
    found = [[*json.loads(given), json.loads(end)] for name, given, end in _rows(table) if name == test]
    assert found, f"{test}: no such test in tests/data/{table}.tsv"
    return found


def refusals(test: str) -> list[list]:
    """Of a test, the inputs in JSON, each with the line by which it is refused, or the parts of that line."""
    return _of(test, "refusals")


def truths(test: str) -> list[list]:
    """Of a test, the inputs in JSON, each with what follows from it."""
    return _of(test, "truths")


def refusal(call: Callable, *given) -> str:
    """The one line with which a call is refused; several lines are a failure."""
    with pytest.raises(MillprintError) as caught:
        call(*given)
    (line,) = str(caught.value).splitlines()
    return line
