"""A ball that is released at the wall of a jar and swings until it rests (thesis Sec. 3.2.2, Figs 3.2 and 3.3).

The jar is turned so that a curved wall is at the bottom: gravity has a direction in the jar's axes. The thesis starts
the ball in the middle of a straight side that stands upright. It falls without rotation, slides on the curved wall,
and rolls once friction has turned it, so that the first swings show static friction and the later ones rolling.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from millprint.config.calibration import FRICTION_PAIR, SwingConfig
from millprint.config.contact_set import ContactConfig
from millprint.config.errors import ConfigError
from millprint.config.mill import MillConfig
from millprint.dem.few_balls import FewBalls, walls_for
from millprint.dem.timestep import resolved_step
from millprint.mill.distance import signed_distance
from millprint.mill.gravity import GRAVITY
from millprint.mill.vessel import Vessel, build_vessel
from millprint.mill.walls import Walls
from millprint.run.tables import Number, read_measured, refuse_rows

if TYPE_CHECKING:
    from scipy.interpolate import CubicSpline

SAMPLE_S = 4e-3  # between positions of the ball: a cubic through them is exact to about a micrometre
PLACES = ["across_mm", "height_mm"]
FEWEST_FRAMES = 20  # of a measured track
START_GAP = 1e-4  # gap to the wall at the start over the ball's radius [-]


@dataclass(frozen=True)
class Swing:
    """A jar on its side with a ball at its wall, for any friction pair; make it with `make_swing`."""

    vessel: Vessel
    contact: ContactConfig
    radius: float  # of the ball [m]
    step: float  # [s]
    start: np.ndarray  # (3,) centre of the ball in the jar's axes [m]
    axes: np.ndarray  # (2, 3) unit vectors across and up
    origin: np.ndarray  # (2,) across and up of the jar's middle and the ball's lowest place [m]

    @cached_property
    def walls(self) -> Walls:
        """The jar's walls for a ball of this radius; made when first asked for, as this takes long."""
        return walls_for(self.vessel, self.radius)

    def positions(self, pairs: Sequence[tuple[float, float]], duration: float) -> "list[CubicSpline]":
        """Position (across, height) [mm] against time [s], for each pair (static, rolling) of friction coefficients.

        The balls swing side by side, in one simulation, unless the restitution depends on the speed of the hit. across
        is counted from the jar's middle, height from the lowest place of the ball. Raises SimulationError.
        """
        # Slow to import, and the check of the input imports this module.
        from scipy.interpolate import CubicSpline

        first = dict(zip(FRICTION_PAIR, map(float, pairs[0]), strict=True))
        contact = self.contact.model_copy(update=first)
        if contact.speed_tables and len(pairs) > 1:
            return [self.positions([pair], duration)[0] for pair in pairs]
        world = FewBalls(
            self.vessel, contact, np.tile(self.start, (len(pairs), 1)), radius=self.radius, step=self.step,
            walls=self.walls, gravity=-GRAVITY * self.axes[1], friction=pairs,
        )  # fmt: skip
        # Two samples more: a spline is least exact at its ends.
        times, positions = world.track(duration + 2 * SAMPLE_S, max(1, round(SAMPLE_S / self.step)))
        places = 1e3 * (positions @ self.axes.T - self.origin)
        return [CubicSpline(times, places[:, ball]) for ball in range(len(pairs))]


def make_swing(
    mill: MillConfig, contact: ContactConfig, rayleigh_fraction_max: float, diameter: float, settings: SwingConfig
) -> Swing:
    """The jar of a mill at rest, turned, and a ball of a diameter [m] that just touches its wall.

    rayleigh_fraction_max: longest step, over the Rayleigh time of the ball [-]. Raises ConfigError if no such place is
    in the jar.
    """
    from scipy.optimize import brentq

    # The ball meets nothing but the wall.
    contact = contact.at_wall
    vessel, radius, release = build_vessel(mill), diameter / 2, settings.release
    axes = np.array([release.across, [-component for component in release.down]], dtype=float)
    axes /= np.linalg.norm(axes, axis=1)[:, None]
    middle = vessel.bounds.mean(axis=0)
    across, heights = (vessel.vertices @ axes.T).T
    level = heights.min() + release.height_fraction * np.ptp(heights)
    begin = middle + (level - middle @ axes[1]) * axes[1]

    def clearance(way: float) -> float:
        """Gap between the ball and the wall at a distance across from the middle [m]."""
        return float(-signed_distance(vessel)(begin + way * axes[0])[0]) - radius * (1 + START_GAP)

    if clearance(0.0) <= 0:
        raise ConfigError(
            f"config/mills/{mill.name}.yaml: a ball of {1e3 * diameter:g} mm does not fit at "
            f"calibration.oscillation.release.height_fraction = {release.height_fraction:g}"
        )
    way = brentq(clearance, 0.0, np.ptp(across), xtol=1e-9)
    return Swing(
        vessel, contact, radius,
        resolved_step(contact, radius, settings.time_step_s, rayleigh_fraction_max),
        start=begin + way * axes[0], axes=axes, origin=np.array([middle @ axes[0], heights.min() + radius]),
    )  # fmt: skip


def simulate_track(swing: Swing, settings: SwingConfig) -> pd.DataFrame:
    """A track as a camera would take it: time_s, across_mm, height_mm, each place with a normal error.

    Raises SimulationError.
    """
    times = np.arange(0, settings.duration_s, 1 / settings.frames_per_second)
    friction = swing.contact.value_of("static_friction"), swing.contact.rolling_friction
    places = swing.positions([friction], settings.duration_s)[0](times)
    noise = np.random.default_rng(settings.seed).normal(0, settings.noise_mm, places.shape)
    return pd.DataFrame({"time_s": times, **dict(zip(PLACES, (places + noise).T, strict=True))})


def read_track(path: str) -> pd.DataFrame:
    """Read a measured track: time_s since the release, and across_mm, height_mm or both.

    across_mm is the place of the ball's centre from the jar's middle, positive on the side of the start; height_mm is
    counted from the lowest place that it can have. Frames in which the ball was not found are left out of the table.
    Raises ConfigError for a table without a place, too few frames, or times that do not rise from 0 or more.
    """
    places = [Number(column, optional=True) for column in PLACES]
    track = read_measured(path, [Number("time_s", 0), *places], FEWEST_FRAMES)
    found = [column for column in PLACES if column in track]
    if not found:
        raise ConfigError(f"{path}: column {' or '.join(PLACES)} is missing; the table has {', '.join(track.columns)}")
    before = track["time_s"].shift()
    refuse_rows(
        track.assign(before=before),
        path,
        "time_s",
        track["time_s"] <= before,
        lambda frame: f"must be more than in the row before, {frame['before']:g}",
    )
    return track[["time_s", *found]]
