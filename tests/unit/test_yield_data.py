"""The locked split, the engineered features, and tables that are refused."""

import hashlib

import numpy as np
import pandas as pd
import pytest
from sklearn.model_selection import train_test_split

from millprint.config.errors import ConfigError
from millprint.config.yields import YieldConfig
from millprint.thesis.yields.features import FEATURES, engineer
from millprint.thesis.yields.run_tables import check_yield_tables, read_split
from tests.unit.doe_settings import SCREENING
from tests.unit.doe_settings import settings as doe_settings
from tests.unit.yield_settings import SPLIT, parts, thesis_yields

CHECK_SUM = "c7ab738189ad643cdf8943bb4b818edf0c87e5e9fa68c64bfc7dcf5b9e1de63e"


def test_split_is_the_locked_one():
    split = read_split(str(SPLIT))
    lines = "\n".join(f"{row.case} {row.role}" for row in split.itertuples())
    assert hashlib.sha256(lines.encode()).hexdigest() == CHECK_SUM
    train, test = train_test_split(np.arange(27), test_size=0.2, random_state=42)
    assert list(test) == [8, 13, 9, 21, 0, 11]
    assert split["case"].astype(int).tolist() == [*(test + 1), *(train + 1)]
    assert split["role"].tolist() == ["test"] * 6 + ["train"] * 21


def test_parts_keep_the_order_of_the_split_and_share_no_case():
    train, test = parts()
    assert test["case"].tolist() == ["9", "14", "10", "22", "1", "12"]
    assert test["yield_percent"].tolist() == [73, 71, 26, 31, 12, 42]
    assert len(train) == 21 and not set(train["case"]) & set(test["case"])


def test_features_are_those_of_the_thesis():
    rows = pd.DataFrame(
        {
            "bpr": [10, 30],
            "molar_ratio": [8, 12],
            "time_h": [5.0, 12.5],
            "normal_energy_uJ": [221, 382],
            "tangential_energy_uJ": [500, 888],
            "specific_frequency_hz": [400, 533],
        }
    )
    features = engineer(rows)
    assert list(features) == list(FEATURES) and len(FEATURES) == 10
    assert features["molar_ratio_squared"].tolist() == [64, 144]
    assert features["bpr_molar_ratio"].tolist() == [80, 360]
    np.testing.assert_allclose(features["time_sigmoid"], 1 / (1 + np.exp([-5, -12.5])), rtol=1e-14)
    np.testing.assert_allclose(features["bpr_sigmoid"], 1 / (1 + np.exp([-10.0, -30.0])), rtol=1e-14)


def test_settings_are_checked_against_the_tables():
    section = thesis_yields()
    section["training"]["choices"]["linear_features"] = ["bpr", "temperature"]
    with pytest.raises(ConfigError, match="linear_features = 'temperature': no feature; known: bpr"):
        check_yield_tables(YieldConfig(**section), str(SCREENING), str(SPLIT), doe_settings(), "config.yaml")
    section = thesis_yields()
    section["search"]["folds"] = 22
    with pytest.raises(ConfigError, match=r"yields\.search\.folds = 22: at most 21"):
        check_yield_tables(YieldConfig(**section), str(SCREENING), str(SPLIT), doe_settings(), "config.yaml")
