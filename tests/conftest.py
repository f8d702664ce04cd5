"""Puts the library and the scripts on the path."""

import csv
import gc
import os
import pickle
import sys
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
import yaml

if TYPE_CHECKING:
    from tests.browser import Browser

ROOT = Path(__file__).parent.parent
sys.path[:0] = [str(ROOT / "src"), str(ROOT / "scripts")]

# One thread for numerical libraries, as in every job of a run, and before any of them is imported: next to the other
# half of `make test`, threads that wait for each other take up to a hundred times as long as one.
for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(variable, "1")

# Python keeps the modules that it compiles, whatever the environment says: the tests start hundreds of processes, and
# each would compile the library again.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
sys.dont_write_bytecode = False

# What the thesis prints, as text, by the id of the claim.
with open(ROOT / "config/data/claims.tsv") as file:
    PRINTED = {row["id"]: row["value"] for row in csv.DictReader(file, delimiter="\t")}


@cache
def _configuration() -> bytes:
    return pickle.dumps(yaml.safe_load((ROOT / "config/config.yaml").read_text()))


def configuration() -> dict:
    """The content of config/config.yaml, which is read once; the caller may change it."""
    return pickle.loads(_configuration())


@pytest.hookimpl(tryfirst=True)
def pytest_collection() -> None:
    """What is imported stays to the end: the collector of garbage need not go through it again and again."""
    gc.disable()


def pytest_collection_finish() -> None:
    """From here on, there is garbage."""
    gc.freeze()
    gc.enable()


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark what opens a browser, and as slow what copies the project and starts Snakemake: all of tests/workflow."""
    for item in items:
        if "browser" in getattr(item, "fixturenames", ()):
            item.add_marker("browser")
        if ROOT / "tests/workflow" in item.path.parents:
            item.add_marker("slow")


@pytest.fixture(scope="module")
def browser() -> "Iterator[Browser]":
    """A browser for the tests of a file, whose pages share nothing."""
    # Not every environment has the driver: that of the lowest versions has the core only.
    from tests.browser import open_browser

    with open_browser() as browser:
        yield browser
