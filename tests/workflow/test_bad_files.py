"""Files that cannot be read as YAML or as a table are refused before a job starts, in one line."""

import pytest

from millprint.config.errors import ConfigError
from millprint.config.load import DEEPEST, read_yaml
from tests.refusals import refusals


def test_yaml_that_is_not_a_mapping(settings, refusal):
    (settings / "config/contacts/steel.yaml").write_text("- a\n- b\n")
    assert "mapping" in refusal()


@pytest.mark.parametrize(("file", "old", "new", "parts"), refusals("a_file_with_a_fault_is_refused_in_one_line"))
def test_a_file_with_a_fault_is_refused_in_one_line(settings, refusal, file, old, new, parts):
    text = (settings / file).read_text()
    assert old in text
    (settings / file).write_text(text.replace(old, new, 1))
    line = refusal()
    assert all(part in line for part in parts), line


def test_a_link_out_of_the_project_is_no_table(settings, refusal):
    table = settings / "config/data/wear.tsv"
    table.rename(settings.parent / "wear.tsv")
    table.symlink_to(settings.parent / "wear.tsv")
    assert "data.wear" in refusal()


BOMB = "a0: &a0 [x]\n" + "".join(f"a{k}: &a{k} [{', '.join([f'*a{k - 1}'] * 9)}]\n" for k in range(1, 12))


SPECIAL = [[BOMB, "aliases"], ["[" * 100_000, f"{DEEPEST} levels"], ["x: " + "y" * 5_000_000, "larger than"]]


@pytest.mark.parametrize(("text", "part"), [*refusals("yaml_that_is_more_than_plain_data"), *SPECIAL])
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
