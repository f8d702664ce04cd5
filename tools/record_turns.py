"""Records turns of the mills of the atlas for the page docs/mills.html: python tools/record_turns.py [KIND ...].

Ten conditions of each kind, spread over its groups without the contact (a Sobol sequence), are simulated for TURNS
turns, a second or two each. Lengths are in radii of the jar and speeds in 2 pi f A, so that a picture is of any mill
with these groups. Writes docs/turns.json, which keeps the kinds that are not named.
"""

import base64
import gzip
import json
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np
from scipy.stats import qmc

from millprint.atlas.design import case_of
from millprint.atlas.kind_groups import SETTINGS, Kind
from millprint.atlas.kinds import KINDS
from millprint.config.sweep import DemConfig
from millprint.dem.run import run_case
from millprint.run.files import read_json, whole_file
from millprint.view.frames import Snapshots

OUTPUT = Path(__file__).parents[1] / "docs/turns.json"
RECORDED, MOST_BALLS, SEED = 10, 200, 11
TURNS, FRAMES = 2, 40
# Groups are spread over this part of their ranges; those of the contact stay in the middle.
MIDDLE = (0.08, 0.92)
CONTACT = {setting.name for setting in SETTINGS} | {"softness"}
# Whole numbers in a length of the jar's radius, and in the fastest speed of a run.
PER_RADIUS, PER_SPEED = 1000, 255


@dataclass(frozen=True)
class View:
    """Axes that point right, up and towards the eye, in words `seen`; with_wheel: turned with the sun wheel, so that
    the jar stays in its place."""

    right: int
    up: int
    towards: int
    seen: str
    with_wheel: bool = False


VIEWS = {
    "planetary": View(0, 1, 2, "from above, turning with the sun wheel", with_wheel=True),
    "mixer": View(0, 1, 2, "from above"),
    "drum": View(0, 2, 1, "along its axis"),
    "spex": View(1, 2, 0, "from the side"),
}


def spread(kind: Kind) -> list[dict[str, float]]:
    """The conditions that are recorded."""
    sequence = qmc.Sobol(len(kind.groups), seed=SEED)
    found: list[dict[str, float]] = []
    while len(found) < RECORDED:
        for shares in sequence.random(16):
            inner = MIDDLE[0] + (MIDDLE[1] - MIDDLE[0]) * shares
            groups = {
                group.name: group.at(0.5 if group.name in CONTACT else share)
                for group, share in zip(kind.groups, inner, strict=True)
            }
            condition = kind.condition_of(groups)
            low, high = (group.at(end) for group in kind.groups if group.name == "fill" for end in (0, 1))
            if condition["number"] <= MOST_BALLS and low <= kind.groups_of(condition)["fill"] <= high:
                found.append(condition)
    return found[:RECORDED]


def record(kind: Kind, condition: dict[str, float]) -> dict:
    """Simulate a condition and quantise its turns."""
    mill, contact = kind.mill_of(condition), kind.contact_of(condition)
    turn = 1 / condition["speed_hz"]
    times = {"window_s": TURNS * turn, "snapshot_interval_s": turn / FRAMES}
    case = case_of(kind, condition, contact, 1).model_copy(update=times)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "run.h5"
        run_case(case, mill, contact, DemConfig(), path, path.with_name("summary.json"))
        with h5py.File(path) as file:
            return quantised(kind, condition, Snapshots(file, last=TURNS * FRAMES))


def quantised(kind: Kind, condition: dict[str, float], snapshots: Snapshots) -> dict:
    """The turns as the page reads them.

    poses (frames, 3): middle of the jar in radii, and its angle; bytes, compressed: for each ball, its place to the
    right and up in whole numbers of 1 / PER_RADIUS, the first and then differences (2 bytes each), its nearness to the
    eye and its speed relative to the wall (1 byte each).
    """
    view, radius_m = VIEWS[kind.name], condition["radius_mm"] / 1e3
    blocks = list(snapshots.blocks())
    position = np.concatenate([block.balls["position_m"] for block in blocks])
    speed = np.concatenate([
        np.linalg.norm(block.balls["velocity_m_s"] - block.poses.velocity_at(block.balls["position_m"]), axis=-1)
        for block in blocks
    ])  # fmt: skip
    rotation = np.concatenate([block.poses.rotation for block in blocks])
    vertices = snapshots.geometry.vertices_m
    middle = (vertices.min(axis=0) + vertices.max(axis=0))[None] / 2
    jar = np.concatenate([block.poses.to_laboratory(middle)[:, 0] for block in blocks])
    plane = [view.right, view.up]
    angle = np.arctan2(rotation[:, view.up, view.right], rotation[:, view.right, view.right])
    balls, jar_flat = position[..., plane], jar[:, plane]
    if view.with_wheel:
        wheel = np.arctan2(jar_flat[:, 1], jar_flat[:, 0])
        turned = np.exp(-1j * wheel)
        flat = ((balls - jar_flat[:, None]) @ [1, 1j]) * turned[:, None]
        balls, jar_flat, angle = np.stack([flat.real, flat.imag], axis=-1), np.zeros_like(jar_flat), angle - wheel
    whole = np.round(balls / radius_m * PER_RADIUS).astype(np.int16)
    steps = np.diff(whole, axis=0, prepend=np.zeros_like(whole[:1]))
    depth = position[..., view.towards] - jar[:, None, view.towards]
    nearness = np.round(127.5 * (1 + depth / np.abs(depth).max()))
    own = 2 * np.pi * condition["speed_hz"] * kind.stroke_m(condition)
    shares = np.round(PER_SPEED * speed / speed.max())
    parts = [
        *(steps[..., axis].astype("<i2") for axis in (0, 1)),
        *(each.astype(np.uint8) for each in (nearness, shares)),
    ]
    content = b"".join(np.ascontiguousarray(part.T).tobytes() for part in parts)
    poses = np.column_stack([jar_flat / radius_m, np.unwrap(angle)])
    return {
        "condition": {name: float(f"{value:.5g}") for name, value in condition.items()},
        "fastest": float(f"{speed.max() / own:.4g}"),
        "frames": len(whole),
        "poses": [[round(float(value), 4) for value in pose] for pose in poses],
        "bytes": base64.b64encode(gzip.compress(content, 9, mtime=0)).decode(),
    }


def main(names: list[str]) -> None:
    """Record the named kinds, or all."""
    kept = read_json(OUTPUT)["kinds"] if OUTPUT.exists() else {}
    for name in names or KINDS:
        view, axis = VIEWS[name], KINDS[name].content(spread(KINDS[name])[0])["geometry"]["axis"]
        runs = [record(KINDS[name], condition) for condition in spread(KINDS[name])]
        outline = "round" if "xyz"[view.towards] == axis else "lying"
        kept[name] = {"outline": outline, "seen": view.seen, "turns": TURNS, "runs": runs}
        with whole_file(OUTPUT) as draft:
            draft.write_text(json.dumps({"per_radius": PER_RADIUS, "kinds": kept}, separators=(",", ":")) + "\n")


if __name__ == "__main__":
    main(sys.argv[1:])
