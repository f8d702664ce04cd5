"""Fixtures of several test files."""

from pathlib import Path

import pytest

from tests.unit.run_samples import write_sample


@pytest.fixture
def close_figures():
    yield
    from millprint.figures.style import plt

    plt.close("all")


@pytest.fixture
def run(tmp_path) -> Path:
    """A run.h5 of a few snapshots."""
    write_sample(tmp_path / "run.h5")
    return tmp_path / "run.h5"
