"""A small simulation for the surrogate's tests: soft balls in a sphere that moves on a circle."""

import json
from pathlib import Path

import h5py
import numpy as np
import torch

from millprint.config.surrogate import EdgeConfig, GraphConfig, NetworkConfig, Recipe, TrainingConfig
from millprint.thesis.surrogate.rollout import Scene, Trajectory

RADIUS, VESSEL, MASS, STEP = 0.005, 0.02, 0.004, 1e-4
STIFFNESS, DAMPING = 2000.0, 0.6
GRAVITY = np.array([0.0, 0.0, -9.81])
AMPLITUDE, OMEGA = 0.004, 2 * np.pi * 5
# Networks this small run fastest on one thread, and many times slower on several where others use the cores too.
torch.set_num_threads(1)

CONTACTS = EdgeConfig(
    training="contacts", wall_threshold_m=-0.0052, ball_threshold_m=0.0015, ball_threshold_reading="surface_gap"
)


def sphere_distance(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Signed distance to a sphere about the origin, and its gradient."""
    length = np.linalg.norm(points, axis=-1)
    return length - VESSEL, points / length[..., None]


def circle(time_s: np.ndarray) -> np.ndarray:
    phase = OMEGA * np.asarray(time_s, dtype=float)
    return AMPLITUDE * np.stack([np.cos(phase), np.sin(phase), 0 * phase], axis=-1)


def sphere_scene() -> Scene:
    bounds = VESSEL * np.array([[-1.0, -1, -1], [1, 1, 1]])
    return Scene(RADIUS, MASS, 300.0, bounds, sphere_distance, circle)


def _forces(position: np.ndarray, velocity: np.ndarray, wall: np.ndarray) -> tuple:
    """Spring and damper normal forces, contacts and dissipated power."""
    force, contacts, power = np.zeros_like(position), [], 0.0
    distance, normal = sphere_distance(position - wall)
    for ball in np.flatnonzero(distance > -RADIUS):
        rate = velocity[ball] @ normal[ball]
        force[ball] -= (STIFFNESS * (distance[ball] + RADIUS) + DAMPING * rate) * normal[ball]
        power += DAMPING * rate**2
        # Two facets of one wall, as in a seam.
        contacts += [(ball, -1), (ball, -2)]
    first, second = np.triu_indices(len(position), 1)
    gap = position[second] - position[first]
    length = np.linalg.norm(gap, axis=1)
    for i, j, way, far in zip(first, second, gap, length, strict=True):
        if far < 2 * RADIUS:
            normal_ij = way / far
            rate = (velocity[j] - velocity[i]) @ normal_ij
            push = (STIFFNESS * (2 * RADIUS - far) - DAMPING * rate) * normal_ij
            force[i], force[j] = force[i] - push, force[j] + push
            power += DAMPING * rate**2
            contacts.append((i, j))
    return force, contacts, power


def simulate(snapshots: int = 300, balls: int = 6, seed: int = 0) -> Trajectory:
    """Snapshots of balls that start at rest on a small lattice."""
    generator = np.random.default_rng(seed)
    lattice = np.stack(np.meshgrid(*[[-1.0, 1.0]] * 3), -1).reshape(-1, 3)[:balls]
    position = 0.0055 * lattice + 1e-4 * generator.standard_normal((balls, 3)) + circle(0.0)
    velocity = 0.3 * generator.standard_normal((balls, 3))
    time_s = STEP * np.arange(snapshots)
    rows = {name: [] for name in ("position", "velocity", "force", "energy", "first", "second")}
    offset = [0]
    for now in time_s:
        force, contacts, power = _forces(position, velocity, circle(now))
        for name, value in (("position", position), ("velocity", velocity), ("force", force)):
            rows[name].append(value)
        rows["energy"].append(power * STEP)
        rows["first"] += [pair[0] for pair in contacts]
        rows["second"] += [pair[1] for pair in contacts]
        offset.append(len(rows["first"]))
        position, velocity = position + velocity * STEP, velocity + (force / MASS + GRAVITY) * STEP
    # The energy of a step is reported with the snapshot that ends it.
    energy = np.concatenate([[0.0], rows["energy"][:-1]])
    return Trajectory(
        time_s=time_s,
        position_m=np.array(rows["position"]),
        velocity_m_s=np.array(rows["velocity"]),
        force_N=np.array(rows["force"]),
        dissipated_J=energy,
        wall_position_m=circle(time_s),
        contact_offset=np.array(offset),
        first=np.array(rows["first"], dtype=np.int64),
        second=np.array(rows["second"], dtype=np.int64),
    )


def write_run(run: Trajectory, path: Path, config: dict | None = None) -> None:
    """Write a trajectory as the simulation does, half of the energy in each channel."""
    with h5py.File(path, "w") as file:
        file.attrs["config"] = json.dumps(config or {})
        group = file.create_group("snapshots")
        group["time_s"] = run.time_s
        group["position_m"], group["velocity_m_s"] = run.position_m, run.velocity_m_s
        group["contact_force_N"] = run.force_N
        group["normal_J"] = group["tangential_J"] = run.dissipated_J / 2
        group["body_position_m"] = run.wall_position_m
        group["contact_offset"], group["contact_first"] = run.contact_offset, run.first
        group["contact_second"] = run.second


def small_recipe(width: int = 32, window: int = 4, epochs: int = 2, **training) -> Recipe:
    """The recipe of the thesis at a small size."""
    values = {
        "dissipation_weight": 1,
        "velocity_noise": 0.005,
        "epochs": epochs,
        "snapshots_per_epoch": 64,
        "batch_size": 8,
        "learning_rate": 1e-3,
        "final_learning_rate": 1e-4,
        "wall_time_max_s": 100,
        "validation_snapshots": 32,
        "seed": 3,
    }
    return Recipe(
        graph=GraphConfig(window=window, acceleration="finite_difference"),
        network=NetworkConfig(width=width, mlp_layers=4, interaction_layers=1),
        training=TrainingConfig(**(values | training)),
    )
