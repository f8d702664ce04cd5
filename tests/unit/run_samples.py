"""A small run.h5 with made-up snapshots: balls and contacts at random in a box with a ridge that moves and may turn."""

import json
from pathlib import Path

import h5py
import numpy as np

from millprint.dem.store import put_geometry
from millprint.mill.outlines import facets_of
from millprint.mill.vessel import Vessel
from millprint.mill.wall_features import features_of

RADIUS, BALLS, INTERVAL = 0.005, 5, 2e-3
RADII = np.array([0.002, 0.005, 0.003, 0.005, 0.006])
MM = 1e-3

# An L seen from above [mm]: the inward corner makes a convex edge from floor to lid.
OUTLINE = MM * np.array([[-40, -30], [40, -30], [40, 0], [0, 0], [0, 30], [-40, 30]])


def ell(height: float = 0.03) -> Vessel:
    """An upright prism over OUTLINE with its floor at z = 0."""
    low = np.column_stack([OUTLINE, np.zeros(len(OUTLINE))])
    high = low + np.array([0, 0, height])
    # Seen from inside, outlines run counter-clockwise.
    sides = [[np.array([low[k - 1], high[k - 1], high[k], low[k]])] for k in range(len(low))]
    return Vessel(facets_of([*sides, [low], [high[::-1]]]))


def turn(angle: np.ndarray) -> np.ndarray:
    """Rotations (n, 3, 3) about z."""
    c, s, o, i = np.cos(angle), np.sin(angle), np.zeros_like(angle), np.ones_like(angle)
    return np.moveaxis(np.array([[c, -s, o], [s, c, o], [o, o, i]]), -1, 0)


def write_sample(
    path: Path, steps: int = 60, turning: float = 0.0, seed: int = 0, kind: str = "circle", mixed: bool = False
) -> None:
    """A run at 600 rpm; `turning` is the jar's spin about z [rad/s]. Snapshot 3 has no contact, 0 one.

    mixed: balls of RADII, otherwise all of RADIUS.
    """
    random = np.random.default_rng(seed)
    vessel, time_s = ell(), 0.5 + INTERVAL * np.arange(steps)
    phase = 2 * np.pi * 10 * time_s
    body = 0.017 * np.stack([np.cos(phase), np.sin(phase), 0 * phase], axis=1)
    velocity = 0.017 * 2 * np.pi * 10 * np.stack([-np.sin(phase), np.cos(phase), 0 * phase], axis=1)
    counts = random.integers(1, 6, steps)
    counts[0], counts[3] = 1, 0
    features = len(vessel.facets) + len(features_of(vessel).lines) + len(features_of(vessel).corners)
    first = random.integers(0, BALLS - 1, counts.sum())
    # A pair's second ball has the larger number.
    second = np.where(random.random(len(first)) < 0.5, first + 1, -1 - random.integers(0, features, len(first)))
    config = {
        "mill": {"title": "box with a ridge", "motion": {"kind": kind}},
        "case": {"speed_hz": 10.0, "ball_diameter_m": 0.01, "mixture": {"name": "three"} if mixed else None},
    }
    with h5py.File(path, "w") as file:
        file.attrs["config"], file.attrs["ball_radius_m"] = json.dumps(config), RADIUS
        file["balls/radius_m"] = RADII if mixed else np.full(BALLS, RADIUS)
        put_geometry(file.create_group("geometry"), vessel)
        group = file.create_group("snapshots")
        group["time_s"], group["body_position_m"], group["body_velocity_m_s"] = time_s, body, velocity
        if turning:
            group["body_rotation"] = turn(turning * time_s)
            group["body_spin_rad_s"] = np.tile([0, 0, turning], (steps, 1))
        group["position_m"] = body[:, None] + random.uniform(-0.02, 0.02, (steps, BALLS, 3)) + [0, 0, 0.02]
        for name in ("velocity_m_s", "spin_rad_s", "contact_force_N"):
            group[name] = random.standard_normal((steps, BALLS, 3)).astype(np.float32)
        group["normal_J"], group["tangential_J"] = random.random((2, steps))
        group["contact_offset"] = np.concatenate([[0], np.cumsum(counts)])
        group["contact_first"], group["contact_second"] = first.astype(np.int32), second.astype(np.int32)
