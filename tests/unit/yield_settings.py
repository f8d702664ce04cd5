"""Settings and rows of the yield stage for tests: those of the thesis, at a small search budget."""

import pandas as pd
import yaml

from millprint.config.load import check_model
from millprint.config.yields import YieldConfig
from millprint.predict.tables import read_parts
from tests.conftest import ROOT
from tests.unit.doe_settings import SCREENING
from tests.unit.doe_settings import settings as doe_settings

SPLIT = ROOT / "config/data/split.tsv"
SMALL = {"evaluations": {"gpr": 2, "rf": 2, "svr": 2, "xgb": 2}, "folds": 3, "repeats": 1}


def thesis_yields() -> dict:
    """The section `yields` of config/config.yaml."""
    section = yaml.safe_load((ROOT / "config/config.yaml").read_text())["yields"]
    return section | {"out_of_domain": str(ROOT / section["out_of_domain"])}


def settings(**choices) -> YieldConfig:
    """The thesis's settings with a small search, small forests, and changed `choices`."""
    section = thesis_yields()
    section["training"]["spaces"]["rf"]["n_estimators"] = [5, 10]
    section["training"]["spaces"]["xgb"]["n_estimators"] = [5, 10]
    section["training"]["choices"] |= choices
    section["search"] = SMALL
    section["honest"] |= {**SMALL, "resamples": 200}
    return check_model(section, YieldConfig, "config.yaml")


def parts() -> tuple[pd.DataFrame, pd.DataFrame]:
    """The training and test rows of the locked split."""
    return read_parts(str(SCREENING), str(SPLIT), doe_settings())
