"""Factors, fractions, aliases and the audit of the runs."""

from itertools import combinations

import numpy as np
import pandas as pd
import pytest

from millprint.config.doe import DoeConfig
from millprint.config.errors import ConfigError
from millprint.thesis.doe.factorial_designs import (
    Fraction,
    alias_table,
    audit_table,
    describe,
    design_table,
    full_factorial_runs,
    interaction_partners,
    length,
    level_codes,
    treatments,
)
from millprint.thesis.doe.runs import read_runs
from tests.unit.doe_settings import SCREENING, settings, thesis_settings


def factors(number: int, levels: int) -> list[dict]:
    return [
        {"symbol": symbol, "column": symbol.lower(), "label": symbol, "levels": list(range(levels))}
        for symbol in "ABCDEFGH"[:number]
    ]


def two_level(number: int, generators: list[str]) -> DoeConfig:
    return settings(factors=factors(number, 2), generators=generators, model=["A", "B"], interactions=[])


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


@pytest.mark.parametrize(
    ("number", "generators", "expected"),
    [
        (3, ["C = A + B"], 3),
        (5, ["E = A + B + C + D"], 5),
        (7, ["D = A + B", "E = A + C", "F = B + C", "G = A + B + C"], 3),
        (8, ["E = B + C + D", "F = A + C + D", "G = A + B + C", "H = A + B + D"], 4),
    ],
)
def test_two_level_fractions_have_their_textbook_resolution(number, generators, expected):
    config = two_level(number, generators)
    assert Fraction(config).resolution() == expected
    assert len(level_codes(config)) == 2 ** (number - len(generators))


def test_defining_words_are_constant_over_the_fraction():
    config = settings(generators=["C = A + 2B", "D = A + B"], model=["A", "B"], interactions=[])
    codes = level_codes(config).to_numpy()
    subgroup = Fraction(config).subgroup
    assert len(subgroup) == 9
    for word in subgroup:
        assert len(set((codes @ np.array(word)) % 3)) == 1


def test_aliasing_is_an_equivalence_whose_classes_have_the_size_of_the_subgroup():
    config = settings()
    fraction = Fraction(config)
    classes = {}
    for word in fraction.low_order_words():
        members = {fraction.normalised(word), *fraction.aliases(word)}
        # Three cosets of a word and three of its square, two by two the same effect.
        assert len(members) == 3
        for other in members:
            assert {other, *fraction.aliases(other)} == members
        classes[frozenset(members)] = members
    # 26 degrees of freedom are 13 effects of two, no effect being in two classes.
    assert len(classes) == 13
    assert sum(map(len, classes.values())) == 39


def test_aliased_components_split_the_runs_into_the_same_groups():
    config = settings()
    codes = level_codes(config).to_numpy()
    fraction = Fraction(config)
    for word in fraction.low_order_words():
        groups = (codes @ np.array(word)) % 3
        for other in fraction.aliases(word):
            counts = pd.crosstab(groups, (codes @ np.array(other)) % 3).to_numpy()
            assert sorted(counts.ravel()) == [0] * 6 + [9] * 3


def test_words_multiply_and_spell():
    fraction = Fraction(settings())
    assert fraction.spell(fraction.normalised((0, 2, 1, 0))) == "BC2"
    assert fraction.times((1, 1, 0, 0), (1, 2, 1, 0)) == (2, 0, 1, 0)
    assert fraction.spell((0, 0, 0, 0)) == "I"
    assert length((0, 2, 1, 0)) == 2


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


def test_a_full_factorial_of_any_levels_has_no_aliases():
    mixed = [*factors(2, 3), {"symbol": "C", "column": "c", "label": "C", "levels": [1, 10]}]
    config = settings(factors=mixed, generators=[], model=["A"], interactions=[])
    table = alias_table(config)
    assert len(level_codes(config)) == 18
    assert (table["aliases"] == "").all()
    assert table.set_index("effect")["degrees_of_freedom"][["A", "C", "AB", "AC"]].tolist() == [2, 1, 4, 2]
    assert describe(config)["resolution"] is None


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


def edited(tmp_path, change) -> str:
    frame = pd.read_csv(SCREENING, sep="\t", comment="#", dtype=str)
    path = tmp_path / "runs.tsv"
    change(frame).to_csv(path, sep="\t", index=False)
    return str(path)


def with_cell(row: int, column: str, value: str):
    def change(frame: pd.DataFrame) -> pd.DataFrame:
        frame.loc[row, column] = value
        return frame

    return change


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda frame: frame.drop(columns="time_h"), ["time_h", "missing"]),
        (lambda frame: frame.drop(columns="yield_percent"), ["yield_percent", "missing"]),
        (lambda frame: frame.drop(columns="case"), ["case", "missing"]),
        (with_cell(4, "bpr", "ten"), ["bpr", "ten", "number"]),
        (with_cell(4, "bpr", "12,5"), ["bpr", "12.5", "must be one of the levels"]),
        (with_cell(4, "yield_percent", ""), ["yield_percent", "number"]),
        (with_cell(4, "yield_percent", "NaN"), ["yield_percent", "case 5", "finite number"]),
        (with_cell(4, "yield_percent", "inf"), ["yield_percent", "inf", "finite number"]),
        (with_cell(4, "case", " 4"), ["case", "4", "twice"]),
        (with_cell(4, "case", ""), ["case", "row 5", "must not be empty"]),
        (lambda frame: frame.assign(run_order=1), ["run_order", "case 2", "a whole number that no other run has"]),
        (lambda frame: frame.assign(run_order="first"), ["run_order", "first", "number"]),
        (with_cell(4, "case", "4"), ["case", "4", "twice"]),
        (with_cell(4, "yield_percent", "140"), ["yield_percent", "case 5", "140", "between 0 and 100"]),
        (with_cell(4, "yield_percent", "-3"), ["yield_percent", "-3", "between 0 and 100"]),
        (with_cell(4, "speed_rpm", "700"), ["speed_rpm", "case 5", "700", "600, 800, 1000"]),
        (lambda frame: frame.head(0), ["no rows"]),
    ],
)
def test_bad_tables_are_refused_in_one_line(tmp_path, change, words):
    path = edited(tmp_path, change)
    with pytest.raises(ConfigError) as caught:
        read_runs(path, settings().factors)
    text = str(caught.value)
    assert "\n" not in text
    assert all(word in text for word in [path, *words])


def test_runs_may_lack_the_treatment_code(tmp_path):
    runs = read_runs(edited(tmp_path, lambda frame: frame.drop(columns="treatment")), settings().factors)
    assert "treatment" not in runs
    assert len(runs) == 27


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"generators": ["D = A + X"]}, "X is not a base factor"),
        ({"generators": ["D = A - B"]}, "a sum such as"),
        ({"generators": ["D = D + A"]}, "appear once"),
        ({"generators": ["D = A + 3B"]}, "zero modulo 3"),
        ({"generators": ["E = A + B"]}, "E is not a factor"),
        ({"model": ["A", "A:E"]}, "A:E"),
        ({"model": ["A:B", "B:A"]}, "appears twice"),
        ({"simulations": 5}, "greater than or equal to 100"),
        ({"fraction": 3}, "unknown key"),
        ({"factors": [*thesis_settings()["factors"], thesis_settings()["factors"][0]]}, "appears twice"),
    ],
)
def test_bad_settings_are_refused_in_one_line(changes, words):
    with pytest.raises(ConfigError) as caught:
        settings(**changes)
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)


def test_levels_must_increase():
    changed = thesis_settings()["factors"]
    changed[0]["levels"] = [30, 10, 50]
    with pytest.raises(ConfigError, match="values must rise"):
        settings(factors=changed)
