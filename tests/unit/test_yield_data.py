"""The locked split, the engineered features, and tables that are refused."""

import hashlib

import numpy as np
import pandas as pd
import pytest
from sklearn.model_selection import train_test_split

from millprint.config.errors import ConfigError
from millprint.config.load import check_model
from millprint.config.yields import YieldConfig
from millprint.thesis.yields.features import FEATURES, engineer
from millprint.thesis.yields.run_tables import check_yield_tables, read_parts, read_rows, read_split
from tests.unit.doe_settings import SCREENING
from tests.unit.doe_settings import settings as doe_settings
from tests.unit.yield_settings import SPLIT, parts, settings, thesis_yields

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


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("tangential_energy_uJ", "tangential_energy", "column tangential_energy_uJ is missing"),
        ("\t28\n", "\tplenty\n", "column yield_percent, case 4 = 'plenty'"),
        ("\n5\t10", "\n4\t10", "case = 4 appears twice"),
        ("\t90\n", "\t140\n", "column yield_percent, case 24 = 140: must be between 0 and 100"),
        ("\t221\t500\t400\t12\n", "\t-221\t500\t400\t12\n", "normal_energy_uJ, case 1 = -221: must be above 0"),
    ],
)
def test_bad_screening_table_is_refused_in_one_line(tmp_path, old, new, message):
    text = SCREENING.read_text()
    assert old in text
    table = tmp_path / "screening.tsv"
    table.write_text(text.replace(old, new))
    with pytest.raises(ConfigError) as caught:
        read_parts(str(table), str(SPLIT), doe_settings().factors)
    assert message in str(caught.value) and "\n" not in str(caught.value) and str(table) in str(caught.value)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("\n9\ttest", "\n9\tvalidation", "column role, case 9 = 'validation': must be train or test"),
        ("\n9\ttest", "\n14\ttest", "case = 14 appears twice"),
        ("\n9\ttest", "", "case 9 of"),
        ("\n9\ttest", "\n99\ttest", "case 9 of"),
        ("\n9\ttest", "\n9\ttest\n28\ttest", "case = 28: there is no such case"),
        ("test\n", "train\n", "at least two cases must have the role test"),
    ],
)
def test_bad_split_is_refused_in_one_line(tmp_path, old, new, message):
    split = tmp_path / "split.tsv"
    split.write_text(SPLIT.read_text().replace(old, new))
    with pytest.raises(ConfigError) as caught:
        read_parts(str(SCREENING), str(split), doe_settings().factors)
    assert message in str(caught.value) and "\n" not in str(caught.value)


def test_bad_rows_outside_the_domain_are_refused(tmp_path):
    table = tmp_path / "outside.tsv"
    good = settings().out_of_domain
    with open(good) as file:
        table.write_text(file.read().replace("\t94", "\t194"))
    with pytest.raises(ConfigError, match=r"outside\.tsv: column yield_percent, case 28 = 194: must be between 0"):
        read_rows(str(table))


@pytest.mark.parametrize(
    ("place", "value", "message"),
    [
        (("training", "spaces", "svr", "C"), [10.0, 1.0], "the first bound must be below the second"),
        (("training", "spaces", "rf", "min_samples_split"), [1, 20], "greater than or equal to 2"),
        (("training", "spaces", "rf", "n_trees"), [1, 20], "rf.n_trees = [1, 20]: no such hyper-parameter"),
        (("training", "spaces", "rf", "max_depth"), [1.5, 20], "must be whole numbers"),
        (("search", "evaluations", "gpr"), 0, "greater than or equal to 1"),
        (("training", "choices", "time_model"), "cubic", "must be 'same' or 'linear'"),
        (("training", "seeds"), 3, "unknown key"),
    ],
)
def test_bad_settings_are_refused_in_one_line(place, value, message):
    section = thesis_yields()
    target = section
    for key in place[:-1]:
        target = target.setdefault(key, {})
    target[place[-1]] = value
    with pytest.raises(ConfigError) as caught:
        check_model(section, YieldConfig, "config.yaml")
    assert message in str(caught.value) and ".".join(place[:2]) in str(caught.value)


def test_settings_are_checked_against_the_tables():
    section = thesis_yields()
    section["training"]["choices"]["linear_features"] = ["bpr", "temperature"]
    with pytest.raises(ConfigError, match="linear_features = 'temperature': no feature; known: bpr"):
        check_yield_tables(YieldConfig(**section), str(SCREENING), str(SPLIT), doe_settings(), "config.yaml")
    section = thesis_yields()
    section["search"]["folds"] = 22
    with pytest.raises(ConfigError, match=r"yields\.search\.folds = 22: at most 21"):
        check_yield_tables(YieldConfig(**section), str(SCREENING), str(SPLIT), doe_settings(), "config.yaml")
