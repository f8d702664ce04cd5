"""Designs: the thesis's fraction, other levels and replicates, aliases, generators, and the audit of the runs."""

import json
from itertools import combinations

import numpy as np
import pytest
import yaml

from millprint.cli.commands import main as millprint
from millprint.config.doe import AnalysisConfig, DesignConfig
from millprint.config.errors import ConfigError
from millprint.config.load import check_model
from millprint.run.files import read_table
from millprint.thesis.doe.factorial_designs import (
    Fraction,
    alias_table,
    audit_table,
    best_generators,
    contrasts,
    describe,
    design_table,
    full_factorial_runs,
    level_codes,
    level_contrasts,
    shared_degrees_of_freedom,
    term_columns,
    treatments,
)
from tests.refusals import refusals, truths
from tests.unit.doe_settings import settings


def test_the_thesis_fraction_is_27_of_81_runs_of_resolution_4():
    config = settings()
    assert full_factorial_runs(config) == 81
    description = describe(config)
    assert (description["runs"], description["resolution"]) == (27, 4)
    assert description["defining_words"] == ["ABCD2"]


def test_the_order_of_the_runs_is_a_permutation_that_the_seed_decides():
    first, again, other = (design_table(settings(order_seed=seed))["run_order"] for seed in (2, 2, 3))
    assert sorted(first) == list(range(1, 28))
    assert first.tolist() == again.tolist()
    assert first.tolist() != other.tolist()


STEELS = ["steel", "zirconia", "tungsten carbide"]


def factor(symbol: str, levels: list) -> dict:
    return {"symbol": symbol, "column": symbol.lower(), "label": f"factor {symbol} (-)", "levels": levels}


def design(symbols: str, levels: int | list, generators: list[str] = (), **others) -> DesignConfig:
    levels = list(range(levels)) if isinstance(levels, int) else levels
    content = {"factors": [factor(symbol, levels) for symbol in symbols], "generators": list(generators)}
    return check_model({**content, "order_seed": 1, **others}, DesignConfig, "design.yaml")


def mixed(generators: list[str] = ()) -> DesignConfig:
    """Three factors of two levels, one of three names, one of four numbers."""
    factors = [factor(symbol, [-1, 1]) for symbol in "ABC"] + [factor("D", STEELS), factor("E", [1, 2, 5, 10])]
    content = {"factors": factors, "generators": list(generators), "order_seed": 1}
    return check_model(content, DesignConfig, "design.yaml")


def test_the_quarter_of_2_to_the_5_has_the_aliases_of_the_textbook():
    # Montgomery, Design and Analysis of Experiments, the 2^(5-2) design of resolution III with D = AB, E = AC.
    config = design("ABCDE", [-1, 1], ["D = AB", "E = AC"])
    table = alias_table(config).set_index("effect")["aliases"]
    known = {"I": "ABD = ACE = BCDE", "A": "BD = CE = ABCDE", "B": "AD = CDE = ABCE", "D": "AB = BCE = ACDE"}
    assert table[[*known, "BC"]].to_dict() == known | {"BC": "DE = ABE = ACD"}
    signs = design_table(config)[list("abcde")]
    assert len(signs) == 8 and (signs["d"] == signs["a"] * signs["b"]).all()
    assert (signs["e"] == signs["a"] * signs["c"]).all()


def test_a_word_is_a_product_of_signs_and_a_sum_may_choose_the_other_half():
    assert describe(design("ABC", 2, ["C = AB"]))["defining_words"] == ["ABC"]
    assert describe(design("ABC", 2, ["C = A + B"]))["defining_words"] == ["-ABC"]
    assert describe(design("ABC", 2, ["C = A + B + 1"]))["defining_words"] == ["ABC"]
    halves = [set(treatments(level_codes(design("ABC", 2, [text])))) for text in ("C = A + B", "C = A + B + 1")]
    assert not halves[0] & halves[1]
    assert len(halves[0] | halves[1]) == 8
    assert describe(design("ABC", 3, ["C = A + B + 1"]))["defining_words"] == ["ABC2(2)"]
    pairs = level_codes(design("ABC", 3, ["C = AB2"]))
    assert (pairs["C"] == (pairs["A"] + 2 * pairs["B"]) % 3).all()


def test_a_mixed_full_factorial_has_every_treatment_and_no_aliases():
    table, aliases = design_table(mixed()), alias_table(mixed()).set_index("effect")
    assert len(table) == 2 * 2 * 2 * 3 * 4 == table["treatment"].nunique() and set(table["d"]) == set(STEELS)
    assert (aliases["aliases"] == "").all()
    assert aliases["degrees_of_freedom"][["A", "D", "E", "AD", "DE"]].tolist() == [1, 2, 3, 2, 6]


@pytest.mark.parametrize(
    "config",
    [
        design("ABCDE", 2, ["D = AB", "E = AC"]),
        design("ABCD", 3, ["D = A + B + C"]),
        design("ABC", 5, ["C = A + 2B"]),
        mixed(["C = AB"]),
        mixed(),
    ],
)
def test_two_effects_share_degrees_of_freedom_exactly_if_they_are_aliases(config):
    codes, table = level_codes(config), alias_table(config)
    names = list(config.symbols) + [":".join(pair) for pair in combinations(config.symbols, 2)]
    linked = set()
    for row in table[table["letters"] > 0].itertuples():
        own = [symbol for symbol in config.symbols if symbol in row.effect]
        for other in filter(None, row.aliases_up_to_two_letters.split(" = ")):
            linked.add(frozenset([":".join(own), ":".join(symbol for symbol in config.symbols if symbol in other)]))
    for one, two in combinations(names, 2):
        shared = shared_degrees_of_freedom(term_columns(config, codes, one), term_columns(config, codes, two))
        assert (shared > 1e-9) == (frozenset([one, two]) in linked), (one, two)


@pytest.mark.parametrize(("symbols", "levels", "made", "lengths"), truths("generators_of_minimum_aberration"))
def test_the_best_generators_are_those_of_minimum_aberration(symbols, levels, made, lengths):
    config = design(symbols, levels)
    generators = best_generators(config, list(made))
    assert Fraction(design(symbols, levels, generators)).word_lengths() == {
        int(own): count for own, count in lengths.items()
    }


@pytest.mark.parametrize(
    ("made", "words"),
    [(["X"], "factor X"), (["A", "D"], "same number of levels"), (["E"], "2, 3, 5 or 7"), (["D"], "make 0")],
)
def test_factors_that_cannot_be_generated_are_refused_in_one_line(made, words):
    with pytest.raises(ConfigError, match=words) as caught:
        best_generators(mixed(), made)
    assert "\n" not in str(caught.value)


def test_replicates_are_spread_over_the_order_and_the_audit_counts_them(tmp_path):
    config = design("AB", 3, replicates=2)
    table = design_table(config)
    assert (len(table), table["treatment"].nunique()) == (18, 9)
    assert table["replicate"].tolist() == [1] * 9 + [2] * 9
    assert sorted(table["run_order"]) == list(range(1, 19))
    assert not table.sort_values("run_order")["replicate"].is_monotonic_increasing
    assert set(audit_table(config, table)["departs"]) == {"no"}
    fewer = audit_table(config, table.drop(index=17).reset_index(drop=True))
    lost = fewer[fewer["check"] == "treatment repeated"]
    assert lost[["subject", "found", "wanted"]].to_numpy().tolist() == [["22", "1", "2"]]


def test_contrasts_follow_the_distances_of_the_levels_and_only_span_the_names():
    levels = np.array([1.0, 2.0, 5.0, 10.0])
    linear = contrasts(levels)[:, 0]
    np.testing.assert_allclose(linear, (levels - 4.5) / np.linalg.norm(levels - 4.5), atol=1e-12)
    names = level_contrasts(mixed().factor("D"))
    np.testing.assert_allclose(names.T @ names, np.eye(2), atol=1e-12)
    np.testing.assert_allclose(names.sum(axis=0), 0, atol=1e-12)


def test_the_command_writes_the_design_of_a_file(tmp_path, capsys):
    path = tmp_path / "design.yaml"
    path.write_text(yaml.safe_dump(design("ABCDEFG", [-1, 1]).model_dump()))
    millprint(["design", str(path), str(tmp_path / "out"), "--generate", "E", "F", "G"])
    assert "16 runs of 128" in capsys.readouterr().out
    table = read_table(tmp_path / "out/design.tsv", text=["treatment"])
    assert (len(table), table["treatment"].nunique()) == (16, 16)
    assert json.loads((tmp_path / "out/fraction.json").read_text())["resolution"] == 4
    path.write_text("factors: []\norder_seed: 1\n")
    assert millprint(["design", str(path), str(tmp_path / "none")]) == 1
    assert "factors" in capsys.readouterr().err and not (tmp_path / "none").exists()


def screened(tmp_path, **changes) -> tuple:
    """A design with a factor of names in a file of its own, and its runs with a planted effect of that factor."""
    factors = [factor("A", STEELS), factor("B", [1, 10]), factor("C", [300, 600, 900])]
    content = {
        "factors": factors,
        "replicates": 2,
        "order_seed": 3,
        "model": ["A", "B", "C", "A:B"],
    }
    content["interactions"] = [{"name": "pair", "title": "pair", "panels": [["A", "B"], ["C", "A"]]}]
    (tmp_path / "design.yaml").write_text(yaml.safe_dump({**content, **changes}))
    table = design_table(check_model(content, AnalysisConfig, "design.yaml"))
    noise = np.random.default_rng(4).normal(size=len(table))
    runs = table[["case", "run_order", "a", "b", "c"]].assign(yield_percent=50 + 10 * table["A"] + noise)
    runs.to_csv(tmp_path / "runs.tsv", sep="\t", index=False)
    return str(tmp_path / "design.yaml"), str(tmp_path / "runs.tsv"), str(tmp_path / "out")


@pytest.mark.slow
def test_a_design_with_names_is_analysed_by_one_command(tmp_path):
    out = tmp_path / "out"
    millprint(["analyse", *screened(tmp_path)])
    # The same file makes the design.
    millprint(["design", str(tmp_path / "design.yaml"), str(tmp_path / "again")])
    assert (tmp_path / "again/design.tsv").read_bytes() == (out / "design.tsv").read_bytes()
    anova = read_table(out / "anova_printed.tsv", text=["term"]).set_index("term")
    # Names have no linear trend; with two levels there is no quadratic one.
    assert list(anova.index) == ["A", "B", "BL", "C", "CL", "CQ", "A:B", "Residual"] and anova["F"].idxmax() == "A"
    assert read_table(out / "lack_of_fit.tsv", text=["against"])["p_value"].between(0.001, 1).all()
    assert all(name in (out / "interaction_pair.svg").read_text() for name in STEELS)


@pytest.mark.parametrize(("changes", "row", "words"), refusals("the_analysis_refuses_in_one_line"))
def test_the_analysis_refuses_in_one_line(tmp_path, capsys, changes, row, words):
    paths, runs = screened(tmp_path, **changes), tmp_path / "runs.tsv"
    runs.write_text(runs.read_text().replace(*row, 1))
    assert millprint(["analyse", *paths]) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("error: ") and words in line
