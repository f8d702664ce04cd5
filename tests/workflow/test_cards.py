"""Milling cards in the workflow and by the script: their files, their numbers, reading back, and bad input."""

import contextlib
import json
import subprocess
import sys

import numpy as np
import pytest
import yaml
from jsonschema import Draft202012Validator
from PIL import Image

from millprint.card.card_files import FILES, methods_paragraph
from millprint.card.read import read_card
from millprint.cli.commands import main as millprint
from millprint.cli.warm import balance_of_1_W
from millprint.dose.heat_balance import BODIES
from millprint.estimate.judge import judge
from millprint.own_machine.prediction import fit_power, power_of_charge, predicted_power, read_condition, unit_response
from millprint.own_machine.settings import WarmSettings, WattSettings
from millprint.run.files import read_json
from tests.refusals import refusals
from tests.workflow.conftest import ROOT, active_environment, error_lines, run_snakemake
from tests.workflow.handbook import READ_A_CARD, commands, pages, shown_file

SCHEMA = json.loads((ROOT / "workflow/schemas/card.schema.json").read_text())
# A short simulation of a planetary mill, and the experiment of the page, simulated for as short a time.
SHORT = {"seeds": [0, 1], "discard_turns": 1, "window_turns": 2}
PLANETARY = {
    "name": "short",
    "mill": "planetary",
    "speed_rpm": 400,
    "balls": {"diameter_mm": 10, "number": 40, "material": "stainless_steel"},
    "powder": {"name": "quartz", "mass_g": 20},
    "programme": {"duration_h": 2},
    **SHORT,
}
OF_PAGE = yaml.safe_load(shown_file("docs/how_to/card.md", "yaml", 0)) | SHORT


def test_the_smoke_run_has_a_card_with_the_numbers_of_its_simulation(smoke_project):
    folder = smoke_project / "results/cards/reference"
    content = read_json(folder / FILES.card)
    Draft202012Validator(SCHEMA).validate(content)
    card = read_card(folder / FILES.card)
    summary = read_json(smoke_project / "results/dem/emax/calibrated/d10_f0.10_n600_s0/summary.json")
    found, power = card.fingerprint.descriptors, summary["power_W"]
    assert found.normal_power_W.value == pytest.approx(power["normal"])
    assert found.rolling_power_W.value == pytest.approx(power["rolling"])
    # The parts add up to the whole; from the work at the wall it differs by the imbalance of the ledger.
    parts = power["normal"] + power["tangential"] + power["rolling"]
    assert found.wall_power_W.value == pytest.approx(parts)
    assert power["wall"] - parts == pytest.approx(summary["ledger_J"]["imbalance"] / summary["window_s"], abs=1e-9)
    assert card.balls.number == summary["balls"]
    # Power by time over mass; a kJ/g is a thousand J/g.
    assert card.powder.mass_g == pytest.approx(card.balls.mass_g / 30)
    expected = found.wall_power_W.value * 12.5 * 3600 / card.powder.mass_g / 1e3
    assert card.dose.total_kJ_g.value == pytest.approx(expected)
    # The spectra hold the powers of the ledger.
    for channel in ("normal", "tangential"):
        total = sum(spectrum.power_W for spectrum in card.spectra if spectrum.channel == channel)
        assert total == pytest.approx(power[channel], rel=5e-3)
    # Intervals by contact parameters of the same run, wear by the coefficient of the same run.
    assert found.wall_power_W.contact.lower < found.wall_power_W.contact.upper
    coefficient = read_json(smoke_project / "results/dose/wear_coefficient.json")["coefficient"]
    assert card.wear.coefficient == pytest.approx(coefficient)
    assert card.heat.powder.peak_degC.lower <= card.heat.powder.peak_degC.median <= card.heat.powder.peak_degC.upper
    assert (folder / FILES.methods).read_text().strip() == card.methods == methods_paragraph(card)
    assert all((folder / name).stat().st_size > 500 for name in FILES)
    assert "Milling card" in (folder / FILES.svg).read_text()
    assert "Cards" in (smoke_project / "results/report/report.html").read_text()


def commands_of_cards() -> set[tuple[str, ...]]:
    """The commands of the pages that write or read a card."""
    found = {command.words for page in pages() for command in commands(page) if READ_A_CARD in str(command)}
    return {words for words in found if words[0] == "millprint"}


@pytest.fixture(scope="module")
def written(smoke_project, tmp_path_factory):
    """The folder of the page's card, which its command has written, and what that printed."""
    folder = tmp_path_factory.mktemp("card")
    (folder / "card.yaml").write_text(yaml.safe_dump(OF_PAGE))
    # Results of a run beside it.
    (folder / "results").symlink_to(smoke_project / "results")
    (words,) = {words for words in commands_of_cards() if words[1] == "card"}
    command = [sys.executable, "-m", "millprint.cli", *words[1:]]
    done = subprocess.run(command, cwd=folder, env=active_environment(), capture_output=True, text=True, timeout=600)
    assert done.returncode == 0, done.stderr[-3000:]
    return folder, done.stdout


def test_the_script_writes_the_card_of_one_condition_without_a_sweep(written):
    folder, said = written
    card = read_card(folder / "my_card" / FILES.card)
    assert card.balls.number == 95 and card.machine.speed_rpm == 400 and card.fingerprint.seeds == [0, 1]
    assert card.methods in said
    with Image.open(folder / "my_card/mill.gif") as image:
        assert image.n_frames > 40


@pytest.fixture(scope="module")
def other_cards(smoke_project, tmp_path_factory) -> list:
    """The folders of cards of two mills in which few balls roll much."""
    folders = []
    for mill, diameter_mm, number, speed_rpm in (("mixer", 15, 2, 1500), ("spex", 12.7, 2, 1060)):
        folder = tmp_path_factory.mktemp(mill)
        balls = {"diameter_mm": diameter_mm, "number": number, "material": "stainless_steel"}
        content = {**PLANETARY, "mill": mill, "speed_rpm": speed_rpm, "balls": balls, "window_turns": 20}
        (folder / "card.yaml").write_text(yaml.safe_dump(content))
        with contextlib.chdir(smoke_project):
            assert (
                millprint(["card", f"{folder}/card.yaml", "--out", f"{folder}/out", "--no-animation", "--cores", "1"])
                == 0
            )
        folders.append(folder / "out")
    return folders


def test_a_meter_of_the_work_of_the_walls_agrees_with_each_card(written, other_cards):
    """A wattmeter with a little noise and a thermometer, of what the simulation's own walls did."""
    for folder in (written[0] / "my_card", *other_cards):
        condition = read_condition(folder)
        ledgers = [summary["ledger_J"] for summary in condition.summaries]
        stored = [own["kinetic_change"] + own["elastic_change"] - own["gravity_work"] for own in ledgers]
        windows = [summary["window_s"] for summary in condition.summaries]
        works = [own["wall_work"] - kept for own, kept in zip(ledgers, stored, strict=True)]
        wall = float(np.mean([work / window for work, window in zip(works, windows, strict=True)]))
        predicted = predicted_power(condition)
        assert predicted.value == pytest.approx(wall, rel=1e-2)
        # Blocks that scatter by three per cent of the power.
        loose, lossless = (
            100 + wall * (1 + 0.03 * np.array([1, -1] * 5)),
            WattSettings(efficiency_low=1, efficiency_high=1),
        )
        _, by_watt = power_of_charge(loose, np.full(10, 100.0), lossless)
        settings, time_s = WarmSettings(jar_kg=0.5), np.arange(0.0, 600.0, 10.0)
        response = unit_response(balance_of_1_W(condition, settings), time_s, 10.0, 300.0, BODIES.index("jar"))
        # A jar in the middle of those that nobody can tell apart.
        jar = response[:, np.argsort(response.max(axis=0))[response.shape[1] // 2]]
        by_warm = fit_power(response, time_s, 22.0 + wall * jar, settings.resolution_K).power_W
        for measured in (by_watt, by_warm):
            assert judge(predicted, measured).agrees, (folder, str(predicted), str(measured))


def test_the_commands_of_the_pages_run_on_a_card(written, tmp_path, monkeypatch):
    """Those that match a card or compare it with readings, each as its page has it."""
    (tmp_path / "my_card").symlink_to(written[0] / "my_card")
    for name, power_W in {"loose": 150, "fixed": 100}.items():
        rows = "".join(f"{second}\t{power_W + second % 3}\n" for second in range(300))
        (tmp_path / f"{name}.tsv").write_text(f"time_s\tpower_W\n{rows}")
    # Two minutes of milling warm the jar by 6 K.
    rows = "".join(f"{second}\t{22 + 0.05 * min(max(second - 30, 0), 120)}\n" for second in range(0, 600, 10))
    (tmp_path / "thermometer.tsv").write_text(f"time_s\ttemperature_degC\n{rows}")
    run = {words for words in commands_of_cards() if words[1] != "card"}
    assert {words[1] for words in run} == {"match", "warm", "watt"}
    monkeypatch.chdir(tmp_path)
    for words in sorted(run):
        assert millprint(list(words[1:])) == 0, words


def test_a_second_call_simulates_nothing_again(written, smoke_project, monkeypatch, capsys):
    folder, _ = written
    before = {path: path.stat().st_mtime_ns for path in (folder / "my_card/runs").rglob("run.h5")}
    first = (folder / "my_card" / FILES.card).read_bytes()
    monkeypatch.chdir(smoke_project)
    assert millprint(["card", f"{folder}/card.yaml", "--out", f"{folder}/my_card", "--no-animation"]) == 0
    assert "2 of 2 simulations were done before" in "".join(capsys.readouterr())
    assert before == {path: path.stat().st_mtime_ns for path in before}
    assert (folder / "my_card" / FILES.card).read_bytes() == first


def test_a_card_is_read_back_and_matched(written, smoke_project, monkeypatch, capsys):
    folder, _ = written
    monkeypatch.chdir(smoke_project)
    words = ["match", "--from", folder / "my_card" / FILES.card, "--to", "emax", "--out", folder / "ranked.tsv"]
    assert millprint(list(map(str, words))) == 0
    said = capsys.readouterr().out
    assert "E*n" in said and "verdict" in said and said.startswith("quartz_400: ")
    assert (folder / "ranked.tsv").read_text().count("\n") > 1


@pytest.mark.parametrize(("mill", "parts"), refusals("a_mill_that_was_not_run_is_refused_in_one_line"))
def test_a_mill_that_was_not_run_is_refused_in_one_line(written, smoke_project, monkeypatch, capsys, mill, parts):
    folder, _ = written
    monkeypatch.chdir(smoke_project)
    assert millprint(["match", "--from", str(folder / "my_card" / FILES.card), "--to", mill]) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert all(part in line for part in parts), line


@pytest.mark.parametrize(("place", "value", "parts"), refusals("an_experiment_that_cannot_be_is_refused_in_one_line"))
def test_an_experiment_that_cannot_be_is_refused_in_one_line(tmp_path, monkeypatch, capsys, place, value, parts):
    content = json.loads(json.dumps(PLANETARY))
    inner = content
    for key in place[:-1]:
        inner = inner[key]
    inner[place[-1]] = value
    (tmp_path / "card.yaml").write_text(yaml.safe_dump(content))
    monkeypatch.chdir(ROOT)
    # In this process: starting one takes longer than the check.
    assert millprint(["card", str(tmp_path / "card.yaml"), "--out", str(tmp_path / "out")]) == 1
    (line,) = error_lines(capsys.readouterr().err)
    assert "card.yaml" in line or "config/" in line
    assert all(part in line for part in parts), line
    assert not (tmp_path / "out").exists()


def test_the_cards_of_the_thesis_need_no_simulation_of_their_own(project):
    """Those of the Emax are conditions of its sweeps; the planetary one is a condition of its own, with three seeds."""
    plan = run_snakemake(project, "-n", "--verbose", "cards").stdout
    for name in ("reference", "speed_tangential", "speed_normal", "planetary_400"):
        assert f"results/cards/{name}/card.json" in plan
    for seed in (0, 1, 2):
        assert f"results/dem/planetary/calibrated/d10_f0.20_n400_s{seed}/summary.json" in plan
    assert "results/dem/emax/calibrated/d10_f0.17_n600_s1/summary.json" in plan
    assert "d10_f0.17_n600_s2" not in plan
    assert "results/cards/match.tsv" in plan
