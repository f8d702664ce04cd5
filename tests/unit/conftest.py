"""Fixtures of several test files."""

from pathlib import Path

import pytest

from tests.unit.run_samples import write_sample


@pytest.fixture
def close_figures():
    yield
    from millprint.figures.style import plt

    plt.close("all")


@pytest.fixture(scope="session")
def built(tmp_path_factory) -> dict:
    """The explorer of two made-up mills, which tests open and read, and do not change."""
    from tests.unit.explorer_pages import two_mills

    return two_mills(tmp_path_factory.mktemp("two_mills"))


@pytest.fixture
def run(tmp_path) -> Path:
    """A run.h5 of a few snapshots."""
    write_sample(tmp_path / "run.h5")
    return tmp_path / "run.h5"
