"""Settings of the doe stage for tests: those of the thesis, with changes."""

import yaml

from millprint.config.doe import DoeConfig
from millprint.config.load import check_model
from tests.conftest import ROOT

SCREENING = ROOT / "config/data/screening.tsv"


def thesis_settings() -> dict:
    """The section `doe` of config/config.yaml."""
    return yaml.safe_load((ROOT / "config/config.yaml").read_text())["doe"]


def settings(**changes) -> DoeConfig:
    """The thesis's settings with `changes`."""
    return check_model({**thesis_settings(), **changes}, DoeConfig, "config.yaml")
