"""Factors, fractions, aliases and the audit of the runs."""

from itertools import combinations

import numpy as np
import pandas as pd

from millprint.thesis.doe.factorial_designs import (
    alias_table,
    audit_table,
    describe,
    design_table,
    full_factorial_runs,
    interaction_partners,
    level_codes,
    treatments,
)
from millprint.thesis.doe.runs import read_runs
from tests.unit.doe_settings import SCREENING, settings


def test_the_thesis_fraction_is_27_of_81_runs_of_resolution_4():
    config = settings()
    assert full_factorial_runs(config) == 81
    description = describe(config)
    assert (description["runs"], description["resolution"]) == (27, 4)
    assert description["defining_words"] == ["ABCD2"]


def test_the_fraction_agrees_with_table_2_3_but_for_case_4():
    config = settings()
    design = design_table(config)
    printed = pd.read_csv(SCREENING, sep="\t", comment="#", dtype={"treatment": str})
    different = design["case"][design["treatment"] != printed["treatment"]]
    assert different.tolist() == [4]
    columns = [factor.column for factor in config.factors]
    same = np.isclose(design[columns], printed[columns]).all(axis=1)
    assert design["case"][~same].tolist() == [4]


def test_the_order_of_the_runs_is_a_permutation_that_the_seed_decides():
    first, again, other = (design_table(settings(order_seed=seed))["run_order"] for seed in (2, 2, 3))
    assert sorted(first) == list(range(1, 28))
    assert first.tolist() == again.tolist()
    assert first.tolist() != other.tolist()


def test_an_ideal_fraction_is_orthogonal():
    codes = level_codes(settings())
    for one, two in combinations("ABCD", 2):
        counts = pd.crosstab(codes[one], codes[two])
        assert (counts.to_numpy() == 3).all()
    # Resolution 4: any three factors see all 27 combinations of their levels.
    for three in combinations("ABCD", 3):
        assert treatments(codes[list(three)]).nunique() == 27


def test_the_alias_table_pairs_the_interactions_as_table_2_5_does():
    config = settings()
    table = alias_table(config).set_index("effect")
    assert table.loc["I", "aliases"] == "ABCD2"
    assert (table.loc[list("ABCD"), "clear"] == "yes").all()
    assert table.loc["AB", "aliases_up_to_two_letters"] == "CD2"
    assert table.loc["AC", "aliases_up_to_two_letters"] == "BD2"
    assert table.loc["BC", "aliases_up_to_two_letters"] == "AD2"
    assert table.loc[["AB2", "AC2", "BC2", "AD", "BD", "CD"], "clear"].eq("yes").all()
    assert [interaction_partners(config, term) for term in ("A:B", "A:C", "B:C")] == [
        ["AB", "CD"],
        ["AC", "BD"],
        ["AD", "BC"],
    ]


def test_the_audit_finds_case_4_and_the_treatment_that_was_meant():
    config = settings()
    audit = audit_table(config, read_runs(SCREENING, config.factors))
    wrong = audit[audit["check"].str.startswith("generator") & (audit["departs"] == "yes")]
    assert wrong["subject"].tolist() == ["case 4"]
    assert wrong["found"].item() == "D = 0 (speed_rpm 600)"
    assert wrong["wanted"].item() == "D = 1 (speed_rpm 800)"
    assert "0101" in wrong["note"].item()
    counts = audit[audit["check"] == "runs at each level"].set_index("subject")["found"]
    assert counts.tolist() == ["9/9/9", "9/9/9", "9/9/9", "10/8/9"]


def test_the_audit_of_the_planned_design_finds_nothing():
    config = settings()
    design = design_table(config).assign(yield_percent=50.0)
    audit = audit_table(config, design)
    assert set(audit["departs"]) == {"no"}
