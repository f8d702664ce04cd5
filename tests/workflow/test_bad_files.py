"""Files that cannot be read as YAML or as a table are refused before a job starts, in one line."""

import pytest

from millprint.config.errors import ConfigError
from millprint.config.load import DEEPEST, read_yaml
from tests.refusals import refusals


def test_yaml_that_is_not_a_mapping(settings, refusal):
    (settings / "config/contacts/steel.yaml").write_text("- a\n- b\n")
    assert "mapping" in refusal()


def test_missing_data_column(settings, refusal):
    table = settings / "config/data/screening.tsv"
    table.write_text(table.read_text().replace("yield_percent", "outcome", 1))
    line = refusal()
    assert "screening.tsv" in line
    assert "yield_percent" in line


def test_text_in_a_number_column(settings, refusal):
    table = settings / "config/data/wear.tsv"
    table.write_text(table.read_text().replace("97.06", "heavy", 1))
    line = refusal()
    assert "wear.tsv" in line
    assert "unused_mass_g" in line
    assert "heavy" in line


@pytest.mark.parametrize(("row", "changed", "parts"), refusals("a_bad_run_of_the_screening"))
def test_a_bad_run_of_the_screening(settings, refusal, row, changed, parts):
    table = settings / "config/data/screening.tsv"
    text = table.read_text()
    assert row in text
    table.write_text(text.replace(row, changed, 1))
    line = refusal()
    assert all(part in line for part in ["screening.tsv", *parts])


VERDICT = "thesis\t2.1\tagrees\topen\ttoo few repeats\t1\t\t\tznver4\tAVX-512\tabc\t2026-11-20\n"


@pytest.mark.parametrize(
    ("damage", "parts"),
    [
        (lambda text: text.replace("verdict", "word"), ["column verdict is missing"]),
        (lambda text: text + VERDICT.replace("agrees", "perhaps"), ["column verdict", "'perhaps'", "must be"]),
        (
            lambda text: text + VERDICT.replace("open", "maybe"),
            ["column interval_verdict", "'maybe'", "must be"],
        ),
        (lambda text: text + VERDICT + VERDICT, ["column id, row 2 = '2.1'", "in a row above"]),
        (lambda text: text + VERDICT.strip() + "\tmore\n", ["cells", "header"]),
    ],
    ids=["column", "word", "interval", "twice", "cells"],
)
def test_bad_verdicts_of_other_machines(settings, refusal, damage, parts):
    table = settings / "config/data/verdicts_elsewhere.tsv"
    header = table.read_text().splitlines()[0]
    table.write_text(damage(f"{header}\n"))
    line = refusal()
    assert all(part in line for part in ["config/data/verdicts_elsewhere.tsv", *parts])


@pytest.mark.parametrize(
    ("name", "right", "wrong", "parts"), refusals("claims_of_no_nature_and_conclusions_on_no_claim")
)
def test_claims_of_no_nature_and_conclusions_on_no_claim(settings, refusal, name, right, wrong, parts):
    table = settings / "config/data" / name
    text = table.read_text()
    assert right in text
    table.write_text(text.replace(right, wrong, 1))
    line = refusal()
    assert all(part in line for part in [name, *parts])


def test_a_bad_study_of_the_literature(settings, refusal):
    table = settings / "config/data/literature_yields.tsv"
    table.write_text(table.read_text().replace("\t76\n", "\t760\n", 1))
    assert "literature_yields.tsv: column yield_percent" in refusal()


@pytest.mark.parametrize(("row", "changed", "parts"), refusals("a_bad_row_of_what_others_measured"))
def test_a_bad_row_of_what_others_measured(settings, refusal, row, changed, parts):
    table = settings / "config/data/measured.tsv"
    text = table.read_text()
    assert row in text
    table.write_text(text.replace(row, changed, 1))
    line = refusal()
    assert all(part in line for part in ["measured.tsv", *parts]), line


def test_a_link_out_of_the_project_is_no_table(settings, refusal):
    table = settings / "config/data/wear.tsv"
    table.rename(settings.parent / "wear.tsv")
    table.symlink_to(settings.parent / "wear.tsv")
    assert "data.wear" in refusal()


BOMB = "a0: &a0 [x]\n" + "".join(f"a{k}: &a{k} [{', '.join([f'*a{k - 1}'] * 9)}]\n" for k in range(1, 12))


@pytest.mark.parametrize(
    ("text", "part"),
    [
        ("a: 1\nb: 2\na: 3\n", "key 'a' twice"),
        ("x: {a: 1, a: 1}\n", "key 'a' twice"),
        (BOMB, "aliases"),
        ("a: &a [*a]\n", "alias"),
        ("a: &a\n  b: *a\n", "alias"),
        ("[" * 100_000, f"{DEEPEST} levels"),
        ("!!python/object/apply:os.system ['true']", "not valid YAML"),
        ("a: !!python/name:os.system\n", "not valid YAML"),
        ("x: !!int ''\n", "not valid YAML"),
        ("x: !!timestamp nothing\n", "not valid YAML"),
        ("x: 2020-99-99\n", "not valid YAML"),
        ("a: \x07\n", "is not a text file (byte 7 at 3)"),
        ("x: {a: 1, b: [1}\n", "not valid YAML"),
        ("a: [1\n", "line 2"),
        ("x: " + "y" * 5_000_000, "larger than"),
    ],
)
def test_yaml_that_is_more_than_plain_data(tmp_path, text, part):
    path = tmp_path / "a.yaml"
    path.write_text(text)
    with pytest.raises(ConfigError) as caught:
        read_yaml(path)
    (line,) = str(caught.value).splitlines()
    assert part in line
    assert line.startswith(str(path))


def test_yaml_that_cannot_be_read_as_text(tmp_path):
    path = tmp_path / "a.yaml"
    path.write_bytes(b"a: \xff\xfe\n")
    with pytest.raises(ConfigError, match="line 1: is not in UTF-8; in Windows-1252 it has 'ÿ' there"):
        read_yaml(path)
    with pytest.raises(ConfigError, match="cannot be read"):
        read_yaml(tmp_path)


@pytest.mark.parametrize(("value", "parts"), refusals("a_value_that_versions_of_yaml_read_differently_is_refused"))
def test_a_value_that_versions_of_yaml_read_differently_is_refused(tmp_path, value, parts):
    """Snakemake reads by YAML 1.1, and a person means what YAML 1.2 reads."""
    (tmp_path / "mine.yaml").write_text(f"name: mine\nratio: [1.5, {value}]\n")
    with pytest.raises(ConfigError) as caught:
        read_yaml(tmp_path / "mine.yaml")
    place = f"mine.yaml: line 2: ratio: [1.5, {value}]: {value} would be"
    assert all(part in str(caught.value) for part in [place, *parts])


def test_values_that_every_version_of_yaml_reads_the_same(tmp_path):
    text = "[0, -0, 7, +5, -1.82, .5, 1., 1.5e+3, 0x1f, 010.5, .inf, true, False, null, '070', \"yes\", a:b]"
    (tmp_path / "mine.yaml").write_text(text)
    expected = [0, 0, 7, 5, -1.82, 0.5, 1.0, 1500.0, 31, 10.5, float("inf"), True, False, None, "070", "yes", "a:b"]
    found = read_yaml(tmp_path / "mine.yaml")
    assert found == expected and [type(value) for value in found] == [type(value) for value in expected]


def test_merged_keys_are_not_keys_given_twice(tmp_path):
    path = tmp_path / "a.yaml"
    path.write_text("base: &base {a: 1, b: 2}\nother:\n  <<: *base\n  a: 3\n")
    assert read_yaml(path)["other"] == {"a": 3, "b": 2}
