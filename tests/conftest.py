"""Puts the library on the path, as Snakemake does for the scripts, and shares the tests out among processes."""

import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
sys.path.insert(0, str(ROOT / "scripts"))


# Before xdist reads the marks.
@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """One process for all that share the smoke run, one for each other file; the longest begin first.

    `--dist loadgroup` keeps a group in one process, so that what its tests share is made once.
    """
    for item in items:
        shared = "smoke" if "smoke_project" in item.fixturenames else str(item.path.relative_to(ROOT))
        item.add_marker(pytest.mark.xdist_group(shared))

    def turn(item: pytest.Item) -> tuple[bool, bool, bool]:
        return (
            "smoke_project" not in item.fixturenames,
            "test_kills" not in item.path.stem,
            "workflow" not in item.path.parts,
        )

    items.sort(key=turn)
