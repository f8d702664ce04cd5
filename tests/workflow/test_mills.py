"""Mills in the workflow: every mill of the box in the smoke run, and a mill from a drawing as in the README."""

import re

import numpy as np
import pandas as pd
import trimesh
import yaml

from millprint.files import read_json
from tests.workflow.conftest import ROOT, error_lines, run_snakemake

SMOKE = ("--configfile", "config/smoke.yaml")
BOX = yaml.safe_load((ROOT / "config/config.yaml").read_text())["mills"]["box"]


def test_every_mill_of_the_box_is_simulated_and_drawn(smoke_project):
    for name in BOX:
        summaries = [read_json(path) for path in (smoke_project / "results/dem" / name).rglob("summary.json")]
        assert summaries, name
        assert all(summary["power_W"]["wall"] > 0 for summary in summaries)
        folder = smoke_project / "results/mills" / name
        assert {file.name for file in folder.iterdir()} >= {"geometry.svg", "geometry.png", "motion.svg", "motion.png"}


def make_mill(project) -> None:
    """Write the files of a shaken jar: a drawing in mm and a measured motion."""
    mills = project / "config/mills"
    jar = trimesh.creation.cylinder(radius=20, height=40, sections=24)
    jar.apply_translation([0, 0, 20])
    jar.export(mills / "mine.stl")
    turn = np.linspace(0, 1, 41)
    table = pd.DataFrame({"time_s": 0.05 * turn, "x_m": 0.02 * np.cos(2 * np.pi * turn), "y_m": 0.0, "z_m": 0.0})
    table.to_csv(mills / "mine.tsv", sep="\t", index=False)
    described = {
        "name": "mine",
        "title": "Jar from the workshop",
        "source": "made for a test",
        "volume_ml": round(float(jar.volume) / 1e3, 2),
        "geometry": {"kind": "stl", "path": "config/mills/mine.stl", "unit": "mm"},
        "motion": {"kind": "points", "path": "config/mills/mine.tsv"},
        "sweep": {
            "speeds_rpm": [900, 1200],
            "ball_diameters_mm": [10],
            "fill_ratios": [0.08, 0.15, 0.25],
            "discard_turns": 2,
            "window_turns": 6,
        },
    }
    (mills / "mine.yaml").write_text(yaml.safe_dump(described))


def test_fingerprint_of_a_mill_from_a_drawing_and_a_table_of_points(smoke_project):
    make_mill(smoke_project)
    done = run_snakemake(smoke_project, "fingerprint", *SMOKE, "--config", "mill=mine", timeout=600)
    assert done.returncode == 0, done.stdout[-4000:]
    folder = smoke_project / "results/mills/mine"
    for name in ("fingerprint.pdf", "fingerprint.tsv", "geometry.png", "motion.png", "descriptors.tsv", "curves.tsv"):
        assert (folder / name).stat().st_size > 0
    collapse = pd.read_csv(folder / "collapse.tsv", sep="\t").set_index("quantity")
    # Shaken far above g, the power goes with about the cube of the speed; these few short runs show it roughly.
    assert 1.5 < collapse.loc["power_per_ball_W", "omega"] < 5.5
    again = run_snakemake(smoke_project, "fingerprint", *SMOKE, "--config", "mill=mine")
    assert "Nothing to be done" in again.stdout
    # The sweeps of the configuration do not simulate this mill, so there is no target chapter3.
    chapter = run_snakemake(smoke_project, "chapter3", *SMOKE, "--config", "mill=mine", "-n")
    assert chapter.returncode != 0
    assert re.search(r"chapter3", chapter.stdout)


def test_the_refusal_of_a_bad_sweep_names_the_file_of_the_mill(project):
    make_mill(project)
    file = project / "config/mills/mine.yaml"
    described = yaml.safe_load(file.read_text())
    described["sweep"]["fill_ratios"] = [0.1, 0.2, 0.9]
    file.write_text(yaml.safe_dump(described))
    done = run_snakemake(project, "fingerprint", "--config", "mill=mine")
    (line,) = error_lines(done.stdout)
    assert "config/mills/mine.yaml: sweep: fill_ratios = 0.9" in line
    assert "Traceback" not in done.stdout
