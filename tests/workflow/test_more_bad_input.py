"""More of what is refused before the first job: names, paths, costs, and YAML that is more than plain data."""

import os

import pytest
import yaml

from millprint.config.strict_yaml import DEEPEST, read_yaml
from millprint.errors import LONGEST_LINE, ConfigError
from tests.workflow.conftest import run_snakemake
from tests.workflow.test_bad_input import CONFIG, edit_yaml, refusal  # noqa: F401

EMAX = "config/mills/emax.yaml"
CALIBRATED = "config/contacts/calibrated.yaml"


@pytest.mark.parametrize(
    ("file", "place", "value", "parts"),
    [
        # Numbers that are none.
        (CONFIG, ("dem", "window_s"), True, ["dem.window_s", "True", "yes, no, on and off"]),
        (CONFIG, ("sweeps", 0, "speeds_rpm"), [False], ["sweeps.0.speeds_rpm", "yes, no, on and off"]),
        (CONFIG, ("dem", "window_s"), float("inf"), ["dem.window_s", "inf", "finite"]),
        (CONFIG, ("dem", "window_s"), 10**400, ["dem.window_s", "valid number"]),
        (EMAX, ("geometry", "height_mm"), float("nan"), ["emax.yaml", "height_mm", "nan"]),
        (EMAX, ("geometry", "end_radius_mm"), 50_000, ["emax.yaml", "end_radius_mm", "less than or equal to 10000"]),
        (EMAX, ("volume_ml",), 0, ["emax.yaml", "volume_ml = 0", "greater than"]),
        (CALIBRATED, ("density_kg_m3",), 0, ["calibrated.yaml", "density_kg_m3", "greater than"]),
        (CALIBRATED, ("young_modulus_gpa",), 1e12, ["calibrated.yaml", "young_modulus_gpa", "less than"]),
        # What would not end, or not fit into a machine.
        (CONFIG, ("sweeps", 0, "speeds_rpm"), [1e12], ["sweeps.0.speeds_rpm.0", "100000"]),
        (CONFIG, ("sweeps", 0, "window_s"), 1e9, ["sweeps: case", "days on one core"]),
        (CONFIG, ("dem", "time_step_s"), 1e-15, ["sweeps: case", "days on one core"]),
        (CONFIG, ("dem", "time_step_s"), 5e-324, ["sweeps: case", "days on one core"]),
        (CONFIG, ("sweeps", 0, "snapshot_interval_s"), 1e-13, ["sweeps: case", "days on one core"]),
        (CONFIG, ("dem", "occupancy_cell_m"), 1e-9, ["sweeps: case", "GB", "occupancy_cell_m"]),
        (CONFIG, ("sweeps", 0, "ball_diameters_mm"), [0.001], ["ball_diameters_mm = 0.001", "too small to simulate"]),
        (CONFIG, ("sweeps", 0, "fill_ratios"), [1e-9], ["fill_ratios = 1e-09", "one ball needs at least"]),
        (CONFIG, ("sweeps", 0, "seeds"), [10**30], ["sweeps.0.seeds.0", "less than"]),
        (CONFIG, ("yields", "honest", "resamples"), 10**12, ["yields.honest.resamples", "less than"]),
        # Files outside of the project, and folders that are not for results.
        (CONFIG, ("data", "wear"), "../wear.tsv", ["data.wear = '../wear.tsv'", "inside the project"]),
        (CONFIG, ("data", "wear"), "/etc/passwd", ["data.wear = '/etc/passwd'", "inside the project"]),
        (CONFIG, ("doe", "literature"), "config/../../x", ["doe.literature", "inside the project"]),
        (CONFIG, ("data", "wear"), "a\0b", ["data.wear", "inside the project"]),
        (CONFIG, ("data", "wear"), "config/data", ["config/data", "cannot be read"]),
        (CONFIG, ("results",), "config/mills", ["results = 'config/mills'", "own files"]),
        (CONFIG, ("results",), "../out", ["results", "../out"]),
        # Names.
        (CONFIG, ("mill",), "emx", ["emx.yaml", "unknown mill 'emx'", "did you mean emax?"]),
        (CONFIG, ("sweeps", 1, "name"), "fill_ratio_10mm", ["sweeps: two have the name fill_ratio_10mm"]),
        (EMAX, ("geometry", "heigth_mm"), 3, ["emax.yaml: geometry.heigth_mm = 3", "did you mean height_mm?"]),
        (EMAX, ("geometry", "facets_per_half_circle"), 360, ["emax.yaml", "facets"]),
    ],
)
def test_bad_value(project, refusal, file, place, value, parts):  # noqa: F811
    if place[-1] == "facets_per_half_circle":
        edit_yaml(project / file, "geometry", "fillet_facets", value=180)
    edit_yaml(project / file, *place, value=value)
    line = refusal()
    for part in parts:
        assert part in line


def test_two_mills_of_one_name(project, refusal):  # noqa: F811
    (project / "config/mills/copy.yaml").write_text((project / EMAX).read_text())
    line = refusal()
    assert "config/mills/copy.yaml: name = 'emax': also the name of config/mills/emax.yaml" in line


def test_a_link_out_of_the_project_is_no_table(project, refusal):  # noqa: F811
    table = project / "config/data/wear.tsv"
    table.rename(project.parent / "wear.tsv")
    table.symlink_to(project.parent / "wear.tsv")
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
        ("a: \x07\n", "not valid YAML"),
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
    with pytest.raises(ConfigError, match="not valid YAML"):
        read_yaml(path)
    with pytest.raises(ConfigError, match="cannot be read"):
        read_yaml(tmp_path)


def test_merged_keys_are_not_keys_given_twice(tmp_path):
    path = tmp_path / "a.yaml"
    path.write_text("base: &base {a: 1, b: 2}\nother:\n  <<: *base\n  a: 3\n")
    assert read_yaml(path)["other"] == {"a": 3, "b": 2}


def test_a_line_stays_readable_whatever_the_value(project, refusal):  # noqa: F811
    edit_yaml(project / CONFIG, "dem", "window_s", value="x" * 100_000 + "\u202e\x1b[31m")
    line = refusal()
    assert len(line) < 2 * LONGEST_LINE
    assert line.isprintable()


def test_snakemake_refuses_a_key_given_twice(project):
    path = project / CONFIG
    path.write_text(path.read_text() + "mill: emax_smooth\n")
    done = run_snakemake(project)
    assert done.returncode == 1
    assert [line for line in done.stdout.splitlines() if line.startswith("error: ")] == [
        line for line in done.stdout.splitlines() if "key 'mill' twice" in line
    ]
    assert os.listdir(project / "results") == [".gitkeep"]


def test_all_faults_of_a_long_list_are_counted_and_some_shown(project, monkeypatch):
    from millprint.config.checks import load_workflow

    monkeypatch.chdir(project)
    edit_yaml(project / CONFIG, "sweeps", 0, "seeds", value=["x"] * 1000)
    with pytest.raises(ConfigError) as caught:
        load_workflow(yaml.safe_load((project / CONFIG).read_text()), [CONFIG])
    lines = str(caught.value).splitlines()
    assert len(lines) == 21
    assert lines[-1] == "... and 980 more"
