"""Mills in the workflow: every mill of the box in the smoke run, and a mill from a drawing as in the handbook."""

import re

import pandas as pd
import yaml

from millprint.card.card_files import FILES
from millprint.cli.commands import main as millprint
from millprint.fingerprint.descriptors import MOTIONS
from millprint.run.files import read_json
from tests.browser import needs_browser
from tests.workflow import drawn_mill
from tests.workflow.conftest import LINED_RUN, LINED_SETTINGS, ROOT, jobs_of, run_snakemake

BOX = yaml.safe_load((ROOT / "config/smoke.yaml").read_text())["mills"]["box"]


def test_every_mill_of_the_box_is_simulated_and_drawn(smoke_project):
    for name in BOX:
        summaries = [read_json(path) for path in (smoke_project / "results/dem" / name).rglob("summary.json")]
        assert summaries, name
        assert all(summary["power_W"]["wall"] > 0 for summary in summaries)
        folder = smoke_project / "results/mills" / name
        assert {file.name for file in folder.iterdir()} >= {"geometry.svg", "geometry.png", "motion.svg", "motion.png"}


def test_fingerprint_of_a_mill_from_a_drawing_and_a_table_of_points(lined_project):
    folder = lined_project / "results/mills/mine"
    for name in ("fingerprint.pdf", "fingerprint.tsv", "geometry.png", "motion.png", "descriptors.tsv", "curves.tsv"):
        assert (folder / name).stat().st_size > 0
    collapse = pd.read_csv(folder / "collapse.tsv", sep="\t").set_index("quantity")
    # Shaken far above g, the power goes with about the cube of the speed; these few short runs show it roughly.
    assert 1.5 < collapse.loc["wall_power_per_ball_W", "omega"] < 5.5
    again = run_snakemake(lined_project, *drawn_mill.FILES, *LINED_RUN)
    assert "Nothing to be done" in again.stdout
    # The sweeps of the configuration do not simulate this mill, so there is no target chapter3.
    chapter = run_snakemake(lined_project, "chapter3", "-n", *LINED_SETTINGS)
    assert chapter.returncode != 0
    assert re.search(r"chapter3", chapter.stdout)


def test_a_charge_with_lifters_and_a_lining_goes_through_to_the_sheet_the_explorer_and_the_match(lined_project):
    summaries = [read_json(path) for path in (lined_project / "results/dem/lined").rglob("summary.json")]
    # Six of its sweep, and one that its fingerprint does not see.
    assert len(summaries) == 19
    for summary in summaries:
        assert summary["wall_static_friction"] == 0.5 and summary["static_friction"] == 0.7
        # What the wall gives, the balls dissipate.
        assert summary["power_W"]["wall"] > 0 and abs(summary["closure"]) < 2e-3
    folder = lined_project / "results/mills/lined"
    descriptors = pd.read_csv(folder / "descriptors.tsv", sep="\t", keep_default_na=False)
    assert sorted(descriptors["charge"]) == 3 * [""] + 3 * ["graded"]
    sheet = pd.read_csv(folder / "fingerprint.tsv", sep="\t", keep_default_na=False).set_index("quantity")["text"]
    assert sheet["at the wall"] == "restitution 0.4, static friction 0.5"
    assert (folder / "fingerprint.pdf").stat().st_size > 0
    assert "d30" in (folder / "explorer.html").read_text()
    match = pd.read_csv(lined_project / "results/mills/match.tsv", sep="\t", keep_default_na=False)
    # The mill is its own nearest match, with the same charge.
    # The target is what was simulated there, and the search follows the curves.
    nearest = match.loc[0]
    assert nearest["charge"] == "graded"
    for name in ("weighted_normal_energy_J", "weighted_tangential_energy_J"):
        assert nearest[f"{name}_ratio_lower"] < 1 < nearest[f"{name}_ratio_upper"]


def test_few_turns_are_said_beside_the_numbers_wherever_they_stand(lined_project, tmp_path, monkeypatch, capsys):
    """Three seeds of two turns, and a card of one: in table, page, explorer, match, dose, card, methods and LaTeX."""
    word, folder = MOTIONS["few_turns"].word, lined_project / "results/mills/lined"
    descriptors = pd.read_csv(folder / "descriptors.tsv", sep="\t")
    assert (descriptors["seeds"] == 3).all() and descriptors["motion"].str.contains(word).all()
    sheet = pd.read_csv(folder / "fingerprint.tsv", sep="\t")
    numbers = sheet[sheet["section"].isin(["descriptors", "dose"]) & sheet["value"].notna()]
    assert len(numbers) > 10 and numbers["text"].str.contains(word).all()
    assert word in (folder / "fingerprint.svg").read_text()
    assert read_json(folder / "fingerprint.json")["about"]["few_turns"] == len(descriptors)

    card = {"name": "short", "mill": "lined", "contact": "lined", "speed_rpm": 90, "seeds": [0], "window_turns": 2}
    (tmp_path / "card.yaml").write_text(yaml.safe_dump(card | {"balls": {"diameter_mm": 11, "fill_ratio": 0.17}}))
    run = "case\tmill\tpowder_mass_g\ttime_h\tfill_ratio\tspeed_rpm\tball_diameter_mm\na\tlined\t5\t1\t0.17\t90\t11\n"
    (tmp_path / "runs.tsv").write_text(run)
    monkeypatch.chdir(lined_project)
    written = tmp_path / "card"
    for command in (
        ["card", str(tmp_path / "card.yaml"), "--out", str(written), "--no-animation"],
        ["match", "lined", "--like", "lined", "90", "11", "0.17"],
        ["match", "planetary", "--like", "lined", "90", "11", "0.17"],
        ["match", "--from", str(written / FILES.card), "--to", "planetary"],
        ["dose", str(tmp_path / "runs.tsv"), "lined"],
    ):
        assert millprint(command) == 0
        assert capsys.readouterr().out.count(word) == 1, command
    for name in (FILES.card, FILES.methods, FILES.table, FILES.svg):
        assert word in (written / name).read_text(), name


@needs_browser
def test_few_turns_are_said_on_the_page_with_sliders(lined_project, browser):
    with browser.page() as page:
        page.open(lined_project / "results/mills/lined/explorer.html")
        assert "Few turns: 6 of the simulated conditions" in page.run("return document.body.innerText;")


def test_the_tumbling_mill_of_the_handbook_would_run(project):
    """Its fingerprint, explorer and match by the charge that it names, and a large one with the same charge."""
    handbook = (project / "docs/how_to/mill_from_drawing.md").read_text().split("## A tumbling mill")[1]
    text = handbook.split("```yaml")[1].split("```")[0]
    (project / "config/mills/tumbler.yaml").write_text(text)
    sizes = yaml.safe_load(text)["sweep"]["ball_diameters_mm"]
    like = {"mill": "tumbler", "speed_rpm": 60, "ball_diameter_mm": "graded", "fill_ratio": 0.15}
    large = {"mill": "tumbler", "volume_l": 30, "ball_diameter_mm": "graded", "fill_ratio": 0.15, "speed_rpm": 45}
    mills = {"match": {"mill": "spex", "like": like}, "scale_up": large}
    targets = ("fingerprint", "explorer", "match", "scale_up")
    done = run_snakemake(project, *targets, "-n", "--verbose", "--config", "mill=tumbler", f"mills={mills}")
    assert done.returncode == 0, done.stdout[-4000:]
    assert [size["name"] for size in sizes] == ["graded"]
    simulated = set(re.findall(r"Simulating (tumbler\w*)/\w+/(\w+?)_", done.stdout))
    assert simulated == {("tumbler", "graded"), ("tumbler_large", "graded")}
    assert jobs_of(done.stdout)["explore_mill"] == 1
