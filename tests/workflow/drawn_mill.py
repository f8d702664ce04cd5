"""A mill of a user: its YAML file, a drawing of the shaken jar in mm, and a table of its measured motion."""

from pathlib import Path

import numpy as np
import pandas as pd
import trimesh
import yaml

SWEEP = {
    "speeds_rpm": [900, 1200],
    "ball_diameters_mm": [10],
    "fill_ratios": [0.08, 0.15, 0.25],
    "discard_turns": 2,
    "window_turns": 6,
}
# What asks for all of its fingerprint in a run of another mill.
FILES = tuple(f"results/mills/mine/{name}" for name in ("fingerprint.pdf", "geometry.png", "motion.png"))


def make(project: Path, **changes) -> None:
    """Write its files; changes: of its sweep."""
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
        "sweep": SWEEP | changes,
    }
    (mills / "mine.yaml").write_text(yaml.safe_dump(described))
