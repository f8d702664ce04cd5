"""Bad values are refused before a job starts, in one line that names file, key, value and what would be right."""

import subprocess

import numpy as np
import pytest
import trimesh

from millprint.checks import check_once
from millprint.config.checks import load_workflow
from millprint.config.errors import LONGEST_LINE, ConfigError
from millprint.config.load import read_yaml
from tests.refusals import refusals
from tests.workflow.conftest import CONFIG, edit_yaml, error_lines, run_snakemake

EMAX = "config/mills/emax.yaml"
PLANETARY = "config/mills/planetary.yaml"


@pytest.mark.parametrize(
    ("fault", "said"),
    [
        ("mill: emax\nmill: emax_smooth\n", "key 'mill' twice"),
        ("dem: {rayleigh_fraction_max: 1.0e-4}", "/mine.yaml: dem.time_step_s"),
    ],
    ids=["twice", "impossible value"],
)
def test_snakemake_stops_before_any_job_and_names_the_last_configuration_file(project, fault, said):
    (project / "mine.yaml").write_text(fault)
    done = run_snakemake(project, "--configfile", "mine.yaml")
    assert done.returncode == 1, done.stdout
    (line,) = error_lines(done.stdout)
    assert "mine.yaml" in line and said in line
    assert "Traceback" not in done.stdout
    assert [path.name for path in (project / "results").iterdir()] == [".gitkeep"]
    assert not list((project / ".snakemake/locks").glob("*"))


def test_balls_without_room_are_refused_before_any_job(project):
    edit_yaml(project / PLANETARY, "sweep", "fill_ratios", value=[0.1, 0.2, 0.7])
    done = run_snakemake(project, "--config", "mill=planetary")
    assert done.returncode == 1, done.stdout
    (line,) = error_lines(done.stdout)
    assert "planetary.yaml: sweep: fill_ratios = 0.7: " in line and "places at most" in line
    assert "Traceback" not in done.stdout


def test_valid_input_is_checked_only_once(settings, monkeypatch, capsys):
    """What has passed is checked again only after a change of a file that it names; what is refused, every time.

    Its warnings are given again.
    """
    monkeypatch.chdir(settings)
    config, mills, contacts, _ = load_workflow(read_yaml(CONFIG), [CONFIG])
    statuses, asked = [0, 1, 1], []

    def process(command, **_) -> subprocess.CompletedProcess:
        asked.append(command)
        return subprocess.CompletedProcess(command, statuses[len(asked) - 1], stderr="warning: fast\n")

    def check() -> None:
        check_once.check_once(config, mills, contacts, CONFIG, "python", [])

    monkeypatch.setattr(check_once.subprocess, "run", process)
    check()
    check()
    assert len(asked) == 1
    assert capsys.readouterr().err.count("warning: fast") == 2
    with (settings / "config/data/wear.tsv").open("a") as table:
        table.write("a line more")
    for count in (2, 3):
        with pytest.raises(SystemExit):
            check()
        assert len(asked) == count


@pytest.mark.parametrize(("file", "place", "value", "parts"), refusals("bad_value"))
def test_bad_value(settings, refusal, file, place, value, parts):
    if place[-1] == "facets_per_half_circle":
        edit_yaml(settings / file, "geometry", "fillet_facets", value=180)
    edit_yaml(settings / file, *place, value=value)
    line = refusal()
    for part in parts:
        assert part in line


def test_a_step_of_the_validation_is_bounded_like_the_others(settings, refusal):
    edit_yaml(settings / CONFIG, "dem", "rayleigh_fraction_max", value=0.18)
    edit_yaml(settings / CONFIG, "validation", value={"setups": ["bond_mill"], "quick": True})
    assert "config.yaml: validation.bond_mill.rayleigh_fraction = 0.2: at most dem.rayleigh_fraction_max" in refusal()


def test_an_open_mesh_is_refused(settings, refusal):
    box = trimesh.creation.box((50, 50, 50))
    mill = settings / "config/mills/emax.yaml"
    edit_yaml(mill, "geometry", value={"kind": "stl", "path": "config/mills/jar.stl", "unit": "mm"})
    box.update_faces(np.arange(12) > 0)
    box.export(settings / "config/mills/jar.stl")
    line = refusal()
    for part in ("config/mills/emax.yaml: geometry.path = 'config/mills/jar.stl'", "open"):
        assert part in line


def test_a_volume_within_its_tolerance_and_a_fast_mill_pass(settings, check):
    """Smaller faults than above pass: a volume within its tolerance, and with a warning a fast but possible speed."""
    edit_yaml(settings / EMAX, "volume_ml", value=127)
    edit_yaml(settings / PLANETARY, "volume_ml", value=200)
    edit_yaml(settings / PLANETARY, "volume_tolerance", value=0.25)
    edit_yaml(settings / PLANETARY, "sweep", "speeds_rpm", value=[300, 1200])
    (line,) = check()
    for part in ("planetary.yaml: sweep: speeds_rpm = 1200: ", "174 g", "some 100 g", "usual speeds go up to 1110 rpm"):
        assert part in line


def test_two_mills_of_one_name(settings, refusal):
    (settings / "config/mills/copy.yaml").write_text((settings / EMAX).read_text())
    line = refusal()
    assert "config/mills/copy.yaml: name = 'emax': also the name of config/mills/emax.yaml" in line


def test_a_line_stays_readable_whatever_the_value(settings, refusal):
    edit_yaml(settings / CONFIG, "dem", "window_s", value="x" * 100_000 + "\u202e\x1b[31m")
    line = refusal()
    assert len(line) < 2 * LONGEST_LINE
    assert line.isprintable()


def test_all_faults_of_a_long_list_are_counted_and_some_shown(settings, check):
    edit_yaml(settings / CONFIG, "sweeps", 0, "seeds", value=["x"] * 1000)
    with pytest.raises(ConfigError) as caught:
        check()
    lines = str(caught.value).splitlines()
    assert len(lines) == 21
    assert lines[-1] == "... and 980 more"
