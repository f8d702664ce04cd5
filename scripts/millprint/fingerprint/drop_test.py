"""The virtual drop test: restitution read back from the bounce of a simulated ball (thesis Sec. 3.2.2, Eq. 3.19)."""

import math

import numpy as np
import pandas as pd

from millprint.config.contact import ContactConfig
from millprint.config.mill import CircleMotion, MillConfig, StadiumGeometry
from millprint.config.sweep import Case, DemConfig
from millprint.dem.simulation import Simulation
from millprint.errors import ConfigError

GRAVITY = 9.81
SNAPSHOT_S = 1e-4  # the top of a bounce is flat: it is missed by at most g dt^2 / 8, 0.01 micrometre


def _plain_jar(diameter: float, height: float) -> MillConfig:
    """A jar with a flat floor and room to spare: restitution belongs to the contact set and not to the mill."""
    across, tall = diameter * 1e3, (height + 3 * diameter) * 1e3
    return MillConfig(
        name="plain",
        title="a jar with a flat floor",
        source="made for the drop test",
        volume_ml=math.pi * (3 * across) ** 2 * tall * 1e-3,
        geometry=StadiumGeometry(
            kind="stadium",
            end_radius_mm=3 * across,
            straight_mm=across,
            height_mm=tall,
            facets_per_half_circle=6,
            fillet_radius_mm=0.2 * across,
        ),
        motion=CircleMotion(kind="circle", amplitude_mm=across),
    )


def _falling_ball(contact: ContactConfig, dem: DemConfig, diameter: float, height: float) -> Simulation:
    """One ball at rest, `height` [m] above the middle of the floor of a jar that stands still."""
    mill = _plain_jar(diameter, height)
    case = Case(
        mill=mill.name,
        contact=contact.name,
        ball_diameter_mm=diameter * 1e3,
        fill_ratio=math.pi / 6 * diameter**3 / (mill.volume_ml * 1e-6),
        speed_rpm=0.0,
        seed=0,
        settle_s=dem.time_step_s,
        discard_s=0.0,
        # The fall, a bounce that is no higher than the drop, and a margin.
        window_s=3.2 * math.sqrt(2 * height / GRAVITY),
        snapshot_interval_s=SNAPSHOT_S,
    )
    simulation = Simulation(case, mill, contact, dem)
    simulation.balls.position[0] = _floor(simulation) + np.array([0.0, 0.0, diameter / 2 + height])
    return simulation


def _floor(simulation: Simulation) -> np.ndarray:
    """Middle of the floor (3,) [m]."""
    low, high = simulation.vessel.bounds
    return simulation.motion.position(0.0) + np.array([*(low + high)[:2] / 2, low[2]])


def bounce_height(clearance: np.ndarray) -> float:
    """Height of the first bounce from a track of heights above the floor (n,) [m].

    Raises ConfigError if the track holds no rise after a fall: it ends too early, or nothing bounced.
    """
    rising = np.flatnonzero(np.diff(clearance) > 0)
    if rising.size == 0:
        raise ConfigError("drop test: the track of the ball holds no bounce")
    after = clearance[rising[0] :]
    falling = np.flatnonzero(np.diff(after) < 0)
    falling = falling[falling > 0]
    if falling.size == 0:
        raise ConfigError("drop test: the track of the ball ends before the top of its bounce")
    return float(after[: falling[0] + 1].max())


def simulate_drops(contact: ContactConfig, dem: DemConfig, diameter: float, heights: list[float]) -> pd.DataFrame:
    """Drop one ball from each of `heights` [m] and read e = (h_bounce / h_drop)^(1/2) (Eq. 3.19) back.

    One row a height: contact, drop_height_m, bounce_height_m, restitution_given, restitution_found.
    """
    rows = []
    for height in heights:
        simulation = _falling_ball(contact, dem, diameter, height)
        rest = _floor(simulation)[2] + diameter / 2
        recording = simulation.run(f"drop from {height * 1e3:g} mm")
        bounce = bounce_height(np.concatenate(recording.snapshots)[:, 0, 2] - rest)
        rows.append(
            {
                "contact": contact.name,
                "drop_height_m": height,
                "bounce_height_m": bounce,
                "restitution_given": contact.restitution,
                "restitution_found": math.sqrt(bounce / height),
            }
        )
    return pd.DataFrame(rows)
