"""Six jars that nothing in millprint was adjusted on, in a folder of their own: python -m tests.new_jars FOLDER.

For the coverage of the bands: `snakemake --cores 2 --directory FOLDER coverage` fits a fingerprint to the sweep of
each, simulates eight conditions of each that no fit has seen, and counts (docs/why/uncertainty.md).
"""

import sys
from pathlib import Path

import trimesh
import yaml

from millprint.config.mill import MillConfig
from millprint.mill.vessel import shape_vessel

FOUR_FILLS = [0.08, 0.14, 0.2, 0.3]
JARS: dict[str, dict] = {
    "wide_stadium": {
        "geometry": {
            "kind": "stadium", "end_radius_mm": 22, "straight_mm": 32, "height_mm": 45, "facets_per_half_circle": 20,
            "fillet_radius_mm": 12, "fillet_facets": 5,
        },
        "motion": {"kind": "circle", "amplitude_mm": 14},
        "sweep": {"speeds_rpm": [550, 900], "ball_diameters_mm": [9, 7], "fill_ratios": FOUR_FILLS},
    },
    "small_planetary": {
        "geometry": {
            "kind": "cylinder", "radius_mm": 27, "height_mm": 40, "facets": 90, "fillet_radius_mm": 6,
            "fillet_facets": 6,
        },
        "motion": {"kind": "planetary", "sun_radius_mm": 62, "ratio": -1.8},
        "sweep": {"speeds_rpm": [320, 480], "ball_diameters_mm": [8, 6.5], "fill_ratios": [0.18, 0.24, 0.3, 0.38]},
    },
    "narrow_shaker": {
        "geometry": {
            "kind": "cylinder", "axis": "y", "radius_mm": 16, "height_mm": 64, "facets": 36, "fillet_radius_mm": 2,
            "fillet_facets": 5, "fillet_ends": "both",
        },
        "motion": {"kind": "figure_of_eight", "along_mm": 24, "across_mm": 9, "plane": "yx"},
        "sweep": {"speeds_hz": [11, 16], "ball_diameters_mm": [8, 6], "fill_ratios": FOUR_FILLS},
    },
    "flat_mixer": {
        "geometry": {
            "kind": "cylinder", "axis": "x", "radius_mm": 14, "height_mm": 52, "facets": 36, "fillet_radius_mm": 3,
            "fillet_facets": 5, "fillet_ends": "both",
        },
        "motion": {"kind": "swing", "axis": [0, 0, 1], "pivot_mm": [0, -115, 0], "amplitude_deg": 10},
        "sweep": {"speeds_hz": [16, 24], "ball_diameters_mm": [8, 5.5], "fill_ratios": FOUR_FILLS},
    },
    "lifter_drum": {
        "geometry": {
            "kind": "lifter_drum", "axis": "y", "radius_mm": 55, "length_mm": 32, "facets": 48,
            "lifters": {"number": 6, "height_mm": 6, "width_mm": 8, "face_angle_deg": 75},
        },
        "motion": {"kind": "rotation", "axis": [0, 1, 0]},
        "sweep": {
            "speeds_rpm": [75, 105], "ball_diameters_mm": [12, 10], "fill_ratios": [0.14, 0.2, 0.28, 0.36],
            "discard_turns": 1, "window_turns": 3,
        },
    },
    "narrow_drum": {
        "geometry": {
            "kind": "cylinder", "axis": "y", "radius_mm": 40, "height_mm": 24, "facets": 48, "fillet_radius_mm": 0,
            "fillet_ends": "none",
        },
        "motion": {"kind": "rotation", "axis": [0, 1, 0]},
        "sweep": {
            "speeds_rpm": [95, 130], "ball_diameters_mm": [10, 8], "fill_ratios": [0.15, 0.22, 0.3, 0.38],
            "discard_turns": 1, "window_turns": 3,
        },
    },
    "shaken_box": {
        "geometry": {"kind": "box", "x_mm": 60, "y_mm": 36, "z_mm": 50},
        "motion": {
            "kind": "lissajous",
            "terms": [
                {"axis": "x", "amplitude_mm": 4, "phase_deg": 90},
                {"axis": "z", "amplitude_mm": 2.5},
            ],
        },
        "sweep": {
            "speeds_hz": [18, 26], "ball_diameters_mm": [9, 7], "fill_ratios": [0.14, 0.2, 0.28, 0.38],
            "discard_turns": 5,
        },
    },
}  # fmt: skip
# The jar that is given as a drawing, whose cylinder and torus are found again.
DRAWN = "small_planetary"


def write_folder(folder: Path) -> None:
    """Write the configuration, the mills, and the drawing of one of them."""
    (folder / "config/mills").mkdir(parents=True, exist_ok=True)
    settings = {"box": list(JARS), "precision": "quick", "held_out": 8}
    config = {"name": "new_jars", "mill": next(iter(JARS)), "contacts": ["calibrated"], "mills": settings}
    (folder / "config/config.yaml").write_text(yaml.safe_dump(config, sort_keys=False))
    for name, own in JARS.items():
        content = {"name": name, "title": name.replace("_", " "), "source": "made up", **own}
        vessel = shape_vessel(MillConfig(**content, volume_ml=1).geometry, name, False)
        content["volume_ml"] = round(1e6 * vessel.volume_m3, 2)
        if name == DRAWN:
            points, triangles = vessel.triangles()
            trimesh.Trimesh(1e3 * points, triangles[:, ::-1], process=False).export(folder / f"config/mills/{name}.stl")
            content["geometry"] = {"kind": "stl", "path": f"config/mills/{name}.stl", "unit": "mm"}
        (folder / f"config/mills/{name}.yaml").write_text(yaml.safe_dump(content, sort_keys=False))


if __name__ == "__main__":
    write_folder(Path(sys.argv[1]))
