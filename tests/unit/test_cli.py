"""The command `millprint`: its help, what it refuses, the mills that it describes, the commands that it runs."""

import math
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
import yaml

from millprint.cli import engine
from millprint.cli.commands import INTERRUPTED, main
from millprint.cli.new_mill import completed, filled, fractions, kinds, questions, read_template
from millprint.cli.plan_run import with_targets_first
from millprint.config import included
from millprint.config.checks import CONFIG_FILE, base_of
from millprint.config.included import SOURCES, included_mills
from millprint.config.load import check_model
from millprint.config.mill import MillConfig
from tests.conftest import ROOT
from tests.refusals import refusals

SIZES = ["radius_mm=32.5", "height_mm=60", "fillet_radius_mm=5", "fill_ratios=[25, 50, 75]"]


@pytest.fixture
def ran(monkeypatch) -> list[list[str]]:
    """The commands that would have run, without the Python that runs them."""
    commands: list[list[str]] = []

    def run(words: list[str]) -> int:
        commands.append(words)
        return 0

    monkeypatch.setattr(engine, "run_python", run)
    return commands


def test_an_interrupted_run_ends_when_snakemake_has_tidied_up(tmp_path):
    """It takes more than the quarter of a second after which Python's `subprocess.run` kills it."""
    program = """
import pathlib, sys, time
try:
    pathlib.Path("begun").touch()
    time.sleep(60)
except KeyboardInterrupt:
    time.sleep(1)
    pathlib.Path("tidy").touch()
    sys.exit(1)
"""
    waits = f"""
import subprocess, sys
from millprint.cli.engine import waited_for
sys.exit(waited_for(subprocess.Popen([sys.executable, "-c", {program!r}])))
"""
    # A shell has its jobs in the background ignore the signal, which they would inherit.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    process = subprocess.Popen([sys.executable, "-c", waits], cwd=tmp_path, start_new_session=True)
    signal.signal(signal.SIGINT, before)
    with process:
        while not (tmp_path / "begun").exists() and process.poll() is None:
            time.sleep(0.01)
        os.killpg(process.pid, signal.SIGINT)
        assert process.wait(timeout=30) == INTERRUPTED
    assert (tmp_path / "tidy").exists()


@pytest.mark.parametrize(("words", "parts"), refusals("what_is_wrong_is_one_line"))
def test_what_is_wrong_is_one_line(tmp_path, monkeypatch, capsys, ran, words, parts):
    monkeypatch.chdir(tmp_path)
    assert main(words) in (1, 2)
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("error: ") and all(part in line for part in parts), line
    assert not ran and not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("energies", "meant"),
    [(("221", "500"), ("0.000221", "0.0005")), (("0.5", "1.2"), ("0.0005",)), (("2.21e-4", "5e-4"), ())],
)
def test_energies_in_another_unit_are_asked_about(energies, meant, capsys):
    """A planetary mill of this size hits with some 0.5 mJ, as its fingerprint says."""
    assert main(["match", "planetary", "--energies", *energies]) == 0
    told = " ".join(capsys.readouterr().out.split())
    assert ("J? Write" in told) == bool(meant) and all(f"Write {value}" in told for value in meant), told


def test_settings_in_place_of_energies_are_told_how_to_get_them(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    Path("runs.tsv").write_text("case\tfill_ratio\tspeed_rpm\na\t0.2\t300\n")
    assert main(["yields", "model.json", "runs.tsv", "out.tsv"]) == 1
    assert "millprint.predict" in capsys.readouterr().err


@pytest.mark.slow
@pytest.mark.parametrize("kind", kinds())
def test_each_kind_is_a_mill_with_its_defaults(kind):
    template = read_template(kind)
    answers = {question.name: question.default for question in questions(template)}
    assert len(answers) == len(questions(template)) >= 6 and list(answers)[-1] == "volume_ml"
    assert all(question.means for question in questions(template))
    if kind == "stl":
        # The walls are those of a file.
        content = yaml.safe_load(filled(template, answers | {"volume_ml": "100"}))
        check_model(content | {"name": "mine", "title": "mine", "source": "-"}, MillConfig, kind)
        return
    mill = check_model(yaml.safe_load(completed("mine", "mine", template, answers)), MillConfig, kind)
    if kind not in included_mills():
        assert kind == "shaker" and mill.volume_ml == pytest.approx(np.pi * 1.9**2 * 5.3, rel=0.001)
        return
    included = yaml.safe_load((ROOT / f"config/mills/{kind}.yaml").read_text())
    assert mill.volume_ml == pytest.approx(included["volume_ml"], rel=0.02)
    assert mill.motion.kind == included["motion"]["kind"]


def test_numbers_of_balls_become_fill_ratios():
    assert fractions([0.1, 50], 198.0, 10.0) == [0.1, pytest.approx(50 * math.pi / 6 / 198, rel=5e-6)]


def test_a_mill_of_ones_own_is_two_files_and_its_pictures(tmp_path, monkeypatch, capsys, ran):
    monkeypatch.chdir(tmp_path)
    assert main(["new", "planetary", "--name", "mine", "--set", *SIZES]) == 0
    mill = yaml.safe_load(Path("config/mills/mine.yaml").read_text())
    assert mill["geometry"]["radius_mm"] == 32.5 and mill["sweep"]["fill_ratios"][1] == pytest.approx(0.132, abs=0.002)
    run = yaml.safe_load(Path("mine.yaml").read_text())
    assert run == {"name": "mine", "mill": "mine", "contacts": ["calibrated"], "results": "results/mine"}
    assert "assumed" in Path("mine.yaml").read_text() and "a default" in Path("config/mills/mine.yaml").read_text()
    (words,) = ran
    assert words[:2] == ["-m", "snakemake"] and words[-2:] == ["--configfile", "mine.yaml"]
    assert "results/mine/mills/mine/motion.png" in words
    said = capsys.readouterr().err
    assert "snakemake " in said and "next:  millprint fingerprint mine.yaml" in said
    assert main(["new", "planetary", "--name", "mine", "--yes"]) == 1
    assert "is there already" in capsys.readouterr().err


def test_questions_are_asked_until_an_answer_is_right(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    typed = iter(["", "drm", "drum", "mine", "My drum", "32,5", "32.5", "", "20, 40", "12", "", "", "stel", "steel"])
    monkeypatch.setattr("builtins.input", lambda text: next(typed))
    assert main(["new", "--no-picture"]) == 0
    mill = yaml.safe_load(Path("config/mills/mine.yaml").read_text())
    assert mill["geometry"]["radius_mm"] == 32.5 and mill["sweep"]["ball_diameters_mm"] == [12]
    assert mill["title"] == "My drum" and mill["sweep"]["speeds_rpm"] == [20, 40]
    assert yaml.safe_load(Path("mine.yaml").read_text())["contacts"] == ["steel"]
    said = capsys.readouterr().err
    assert "39 balls of 12 mm do not fit" in said
    assert "with a point" in said and "did you mean steel" in said


def test_an_answer_beyond_the_limits_of_its_key_is_asked_again_and_no_answer_is_lost(tmp_path, monkeypatch, capsys):
    """The radius of 0.1 mm is refused at its question; the volume when all is known, and is asked with the rest."""
    monkeypatch.chdir(tmp_path)
    first = ["Mine", "mine", "", "0.1", "40", "", "[85, -1]", "[80, 110]", "", "0.2 0.5 1.2", "0.2 0.3 10", "1000", ""]
    typed = iter([*first, "", "", "", "", "150.8", ""])
    asked = []
    monkeypatch.setattr("builtins.input", lambda text: asked.append(text.split(":")[0]) or next(typed))
    assert main(["new", "drum", "--no-picture"]) == 0
    mill = yaml.safe_load(Path("config/mills/mine.yaml").read_text())
    assert mill["geometry"]["radius_mm"] == 40 and mill["sweep"]["speeds_rpm"] == [80, 110]
    assert mill["volume_ml"] == 150.8 and mill["sweep"]["fill_ratios"][:2] == [0.2, 0.3]
    names = ["radius_mm", "speeds_rpm", "fill_ratios", "height_mm", "volume_ml", "name"]
    assert [asked.count(name) for name in names] == [3, 3, 3, 2, 2, 2]
    said = capsys.readouterr().err
    assert "radius_mm = 0.1" in said and "holds 150.8 mL" in said


def test_the_snakemake_command_is_printed_and_run(tmp_path, monkeypatch, capsys, ran):
    monkeypatch.chdir(ROOT)
    assert main(["fingerprint", "planetary", "--cores", "3", "--dry-run", "--config", "name=own"]) == 0
    expected = ["--cores", "3", "fingerprint", "--dry-run", "--config", "mill=planetary", "name=own"]
    assert [words[2:] for words in ran] == [expected]
    assert capsys.readouterr().err == f"snakemake {' '.join(expected)}\n"
    assert main(["explore", "config/first_hour/mixer.yaml", "--cores", "1"]) == 0
    assert ran[1][2:] == ["--cores", "1", "explorer", "--configfile", "config/first_hour/mixer.yaml"]
    assert main(["run", "heat", "config/mills/spex.yaml", "--cores", "1"]) == 0
    assert ran[2][2:] == ["--cores", "1", "heat", "--config", "mill=spex"]
    # Outside a checkout Snakemake is told where the workflow is.
    monkeypatch.chdir(tmp_path)
    assert main(["fingerprint", "planetary", "--cores", "1"]) == 0
    assert ran[3][2:4] == ["--snakefile", str(ROOT / "workflow/Snakefile")]


def test_without_the_workflow_one_line_says_what_is_missing(tmp_path, monkeypatch, capsys, ran):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(included, "shipped", lambda path: None)
    assert main(["fingerprint", "planetary"]) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert "workflow/Snakefile: not in this installation" in line and not ran


@pytest.mark.parametrize("own", [True, False])
@pytest.mark.parametrize(
    ("given", "thesis"),
    [
        ({"mill": "planetary"}, False),
        # The thesis's own mill, and a name of it.
        ({"mill": "emax"}, False),
        ({"mill": "emax_motion1", "sweeps": []}, False),
        ({"mill": None}, False),
        ({"mills": {"precision": "fine"}}, True),
        ({}, True),
    ],
)
def test_the_thesis_is_the_base_of_a_run_that_names_no_mill(tmp_path, monkeypatch, own, given, thesis):
    """In a clone, whose own configuration it is, and in an empty folder."""
    monkeypatch.chdir(ROOT if own else tmp_path)
    base = base_of(given, SOURCES)
    assert (base is not None and Path(base).samefile(ROOT / CONFIG_FILE)) == thesis


def test_a_users_own_configuration_is_changed_and_not_replaced(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("config").mkdir()
    Path(CONFIG_FILE).write_text("mill: mine\ncontacts: [steel]\n")
    assert base_of({"mill": "planetary"}, SOURCES) == base_of({}, SOURCES) == CONFIG_FILE


def test_the_completion_is_that_of_bash(capsys):
    assert main(["completion"]) == 0
    script = f"{capsys.readouterr().out}\nCOMP_WORDS=(millprint fin); COMP_CWORD=1; _millprint; echo ${{COMPREPLY[@]}}"
    script += "\nCOMP_WORDS=(millprint run conv); COMP_CWORD=2; _millprint; echo ${COMPREPLY[@]}"
    done = subprocess.run(["bash", "-c", script], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["fingerprint", "convergence"]


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        ("planetary --cores 2", "planetary --cores 2"),
        ("--cores 2 planetary", "planetary --cores 2"),
        ("fingerprint -n mine.yaml -j2", "fingerprint mine.yaml -n -j2"),
        ("--until planetary explore emax", "--until planetary explore emax"),
        ("--config name=own --cores 2 emax", "emax --config name=own --cores 2"),
        ("--configfile a.yaml -- heat results/a", "heat results/a --configfile a.yaml"),
        # Snakemake refuses it itself.
        ("--cores planetary", "--cores planetary"),
    ],
)
def test_a_plan_finds_its_targets_before_and_after_options(given, expected):
    assert with_targets_first(given.split()) == expected.split()
