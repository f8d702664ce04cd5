"""Settings of the doe stage for tests: those of the thesis, with changes."""

import pandas as pd
import pytest

from millprint.config.doe import DoeConfig
from millprint.config.load import check_model
from millprint.thesis.doe.factorial_designs import read_runs
from tests.conftest import ROOT, configuration

SCREENING = ROOT / "config/data/screening.tsv"


def thesis_settings() -> dict:
    """The section `doe` of config/config.yaml."""
    return configuration()["doe"]


def settings(**changes) -> DoeConfig:
    """The thesis's settings with `changes`."""
    return check_model({**thesis_settings(), **changes}, DoeConfig, "config.yaml")


@pytest.fixture(scope="module", name="config")
def thesis_config() -> DoeConfig:
    """The settings of the thesis; a test module imports this fixture to have it."""
    return settings()


@pytest.fixture(scope="module", name="runs")
def thesis_runs(config: DoeConfig) -> pd.DataFrame:
    """The screening runs of the thesis; a test module imports this fixture to have it."""
    return read_runs(SCREENING, config.factors)
