"""Bad input is refused before a job starts, in one line that names file, key, value and what would be right."""

import numpy as np
import pytest
import trimesh
import yaml

from millprint.config.checks import load_workflow
from millprint.errors import ConfigError
from millprint.preflight import check_before_running
from tests.workflow.conftest import run_snakemake

CONFIG = "config/config.yaml"


def edit_yaml(path, *place, value):
    """Set a key, given as its path of keys and positions, in a YAML file."""
    content = yaml.safe_load(path.read_text())
    inner = content
    for key in place[:-1]:
        inner = inner[key]
    inner[place[-1]] = value
    path.write_text(yaml.safe_dump(content))


@pytest.fixture
def refusal(project, monkeypatch):
    """A function that returns the single line that refuses the project; it fails if there is none or more."""
    monkeypatch.chdir(project)

    def read_line() -> str:
        with pytest.raises(ConfigError) as caught:
            config, mills, contacts, cases = load_workflow(yaml.safe_load((project / CONFIG).read_text()), [CONFIG])
            check_before_running(config, mills, contacts, cases, CONFIG)
        (line,) = str(caught.value).splitlines()
        return line

    return read_line


@pytest.mark.parametrize("key", ["time_stp_s", "rayleigh_fraction_max"], ids=["what it says", "what it means"])
def test_snakemake_stops_before_any_job(project, key):
    edit_yaml(project / CONFIG, "dem", key, value=1e-4)
    done = run_snakemake(project)
    lines = [line for line in done.stdout.splitlines() if line.startswith("error: ")]
    assert done.returncode == 1, done.stdout
    assert len(lines) == 1, done.stdout
    assert "config/config.yaml: dem.time_st" in lines[0]
    assert "Traceback" not in done.stdout
    assert [path.name for path in (project / "results").iterdir()] == [".gitkeep"]
    assert not list((project / ".snakemake/locks").glob("*"))


@pytest.mark.parametrize("fault", ["dem: {time_stp_s: 1.0e-6}", "dem: {rayleigh_fraction_max: 1.0e-4}"])
def test_a_refusal_names_the_file_that_lies_on_top(project, fault):
    (project / "mine.yaml").write_text(fault)
    done = run_snakemake(project, "--configfile", "mine.yaml")
    (line,) = [line for line in done.stdout.splitlines() if line.startswith("error: ")]
    assert "/mine.yaml: dem." in line


def test_what_has_passed_is_not_checked_again(project):
    target = "results/doe/design.tsv"
    first, second = (run_snakemake(project, "--force", target).stdout for _ in range(2))
    assert "checking geometry" in first and "checking geometry" not in second
    table = project / "config/data/wear.tsv"
    table.write_text(table.read_text().replace("97.06", "heavy", 1))
    third = run_snakemake(project, "--force", target)
    assert third.returncode == 1
    assert "wear.tsv: column unused_mass_g" in third.stdout


@pytest.mark.parametrize(
    ("file", "place", "value", "parts"),
    [
        (CONFIG, ("dem", "time_stp_s"), 1e-6, ["dem.time_stp_s", "unknown key", "time_step_s"]),
        (CONFIG, ("sweeps", 0, "ball_diameters_mm"), [-10], ["sweeps.0.ball_diameters_mm.0", "-10", "greater than 0"]),
        (CONFIG, ("sweeps", 0, "ball_diameters_mm"), [0], ["sweeps.0.ball_diameters_mm.0", "greater than 0"]),
        (CONFIG, ("sweeps", 0, "fill_ratios"), [0.9], ["fill_ratios", "0.9", "fit"]),
        (CONFIG, ("sweeps", 0, "ball_diameters_mm"), [80], ["ball_diameters_mm", "80", "fit"]),
        (CONFIG, ("dem", "time_step_s"), 5e-5, ["dem.time_step_s", "5e-05", "Rayleigh"]),
        (CONFIG, ("dem", "time_step_s"), float("nan"), ["dem.time_step_s", "nan", "finite"]),
        (CONFIG, ("dem", "counting_rules", 0, "gap_s"), -1, ["dem.counting_rules.0.gap_s", "-1", "greater than"]),
        (
            CONFIG,
            ("sweeps", 4, "time_steps_s"),
            [1e-6, 5e-5],
            ["time_steps_s = 5e-05", "Rayleigh", "dt5e-05", "at most"],
        ),
        (CONFIG, ("fingerprint", "counting_rule"), "gap_9ms", ["fingerprint.counting_rule", "gap_9ms", "gap_3ms"]),
        (CONFIG, ("mill",), "emaks", ["emaks", "unknown mill", "emax"]),
        (CONFIG, ("contacts",), ["calibrated", "rubber"], ["rubber", "unknown contact set", "steel"]),
        (CONFIG, ("calibration", "drop_test", "measured"), "drops.tsv", ["drops.tsv", "no such table"]),
        (CONFIG, ("calibration", "oscillation", "experiments", 0, "track"), "t.tsv", ["t.tsv", "no such table"]),
        (CONFIG, ("calibration", "oscillation", "experiments", 0, "mill"), "emaks", ["emaks", "unknown mill"]),
        (CONFIG, ("data", "wear"), "config/data/no.tsv", ["config/data/no.tsv", "no such"]),
        (CONFIG, ("doe", "chemistry", "limiting"), "nabo2", ["doe.chemistry.limiting", "'nabo2'", "NaBO2.4H2O"]),
        (CONFIG, ("partition",), None, ["config.yaml", "partition is missing", "all of their sections, or none"]),
        (CONFIG, ("sweep",), {"speeds_rpm": [600], "ball_diameters_mm": [10]}, ["sweep.fill_ratios", "missing"]),
        ("config/mills/emax.yaml", ("motion", "amplitude_mm"), -17, ["emax.yaml", "motion", "amplitude_mm", "-17"]),
        ("config/mills/emax.yaml", ("name",), "emaks", ["emax.yaml", "name", "emaks"]),
        ("config/contacts/steel.yaml", ("restitution",), 1.5, ["steel.yaml", "restitution", "1.5"]),
    ],
)
def test_bad_value(project, refusal, file, place, value, parts):
    edit_yaml(project / file, *place, value=value)
    line = refusal()
    for part in parts:
        assert part in line


def test_an_open_mesh_is_refused_and_a_closed_one_is_not(project, refusal):
    box = trimesh.creation.box((50, 50, 50))
    box.export(project / "config/mills/jar.stl")
    mill = project / "config/mills/emax.yaml"
    edit_yaml(mill, "geometry", value={"kind": "stl", "path": "config/mills/jar.stl", "unit": "mm"})
    with pytest.raises(pytest.fail.Exception, match="DID NOT RAISE"):
        refusal()
    box.update_faces(np.arange(12) > 0)
    box.export(project / "config/mills/jar.stl")
    line = refusal()
    for part in ("config/mills/emax.yaml: geometry.path = 'config/mills/jar.stl'", "open"):
        assert part in line


def test_yaml_that_is_not_a_mapping(project, refusal):
    (project / "config/contacts/steel.yaml").write_text("- a\n- b\n")
    assert "mapping" in refusal()


def test_missing_data_column(project, refusal):
    table = project / "config/data/screening.tsv"
    table.write_text(table.read_text().replace("yield_percent", "outcome", 1))
    line = refusal()
    assert "screening.tsv" in line
    assert "yield_percent" in line


def test_text_in_a_number_column(project, refusal):
    table = project / "config/data/wear.tsv"
    table.write_text(table.read_text().replace("97.06", "heavy", 1))
    line = refusal()
    assert "wear.tsv" in line
    assert "unused_mass_g" in line
    assert "heavy" in line


@pytest.mark.parametrize(
    ("row", "changed", "parts"),
    [
        ("1\t10\t8\t5\t600", "1\t10\t8\t5\t650", ["speed_rpm", "case 1", "650", "600, 800, 1000"]),
        ("\n2\t10", "\n1\t10", ["case = 1", "twice"]),
        ("\t400\t12\n", "\t400\t140\n", ["yield_percent", "case 1", "140", "between 0 and 100"]),
        ("\t400\t12\n", "\t400\tNaN\n", ["yield_percent", "case 1", "finite number"]),
        ("\t400\t12\n", "\t400\thigh\n", ["yield_percent", "high", "finite number"]),
    ],
)
def test_a_bad_run_of_the_screening(project, refusal, row, changed, parts):
    table = project / "config/data/screening.tsv"
    text = table.read_text()
    assert row in text
    table.write_text(text.replace(row, changed, 1))
    line = refusal()
    assert all(part in line for part in ["screening.tsv", *parts])


def test_a_bad_study_of_the_literature(project, refusal):
    table = project / "config/data/literature_yields.tsv"
    table.write_text(table.read_text().replace("\t76\n", "\t760\n", 1))
    assert "literature_yields.tsv: column yield_percent" in refusal()


def test_levels_that_yaml_takes_for_truth_values(project, refusal):
    edit_yaml(project / CONFIG, "doe", "factors", 0, "levels", value=[False, True])
    line = refusal()
    assert "doe.factors.0.levels" in line
    assert "quote them" in line
