"""The drop test, simulated and measured: restitution from the bounce of a ball (thesis Sec. 3.2.2, Eq. 3.19).

A ball that is released at the wall of a jar and swings until it rests (thesis Sec. 3.2.2, Figs 3.2 and 3.3).

The jar is turned so that a curved wall is at the bottom: gravity has a direction in the jar's axes. The thesis starts
the ball in the middle of a straight side that stands upright. It falls without rotation, slides on the curved wall,
and rolls once friction has turned it, so that the first swings show static friction and the later ones rolling.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from millprint.config.calibration import FRICTION_PAIR, SwingConfig
from millprint.config.contact_set import NOMINAL_SPEED_M_S, ContactConfig, SpeedTable
from millprint.config.errors import ConfigError
from millprint.config.mill import BoxGeometry, MillConfig
from millprint.dem.resources import resolved_step
from millprint.dem.simulation import FewBalls, walls_for
from millprint.estimate.estimates import ENDS, mean_of
from millprint.mill.distance import signed_distance
from millprint.mill.gravity import GRAVITY
from millprint.mill.vessel import Vessel, build_vessel, shape_vessel
from millprint.mill.walls import Walls
from millprint.run.tables import Number, read_measured, refuse_rows

if TYPE_CHECKING:
    from scipy.interpolate import CubicSpline

SAMPLE_S = 1e-4  # the top of a bounce is flat: it is missed by at most g dt^2 / 8, 0.01 micrometre
FEWEST_HEIGHTS = 3
HEIGHTS = ["drop_height_mm", "bounce_height_mm"]


def _room(diameter: float, height: float) -> Vessel:
    """A box much larger than the ball, since restitution depends on the contact set and not on the mill."""
    wide, tall = 6e3 * diameter, 1e3 * (height + 3 * diameter)
    box = BoxGeometry(kind="box", x_mm=wide, y_mm=wide, z_mm=tall)
    return shape_vessel(box, "drop test", solid=False)


def hit_speed(height_m: float) -> float:
    """Speed of a hit after a fall from rest from a height [m] over the floor [m/s]."""
    return math.sqrt(2 * GRAVITY * height_m)


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


def simulate_drops(
    contact: ContactConfig, step_s: float, rayleigh_fraction_max: float, diameter: float, heights: list[float]
) -> pd.DataFrame:
    """Drop one ball of a diameter [m] from each of `heights` [m]; e = (h_bounce / h_drop)^(1/2) (Eq. 3.19).

    The floor is a wall: restitution_given is that of a ball at a wall, at the speed of the hit.
    step_s: integration step [s], shortened to a fraction of the ball's Rayleigh time where it exceeds it.
    One row a height: contact, drop_height_mm, bounce_height_mm, restitution_given, restitution.
    Raises SimulationError.
    """
    rows, contact = [], contact.at_wall
    step = resolved_step(contact, diameter / 2, step_s, rayleigh_fraction_max)
    for height in heights:
        start = [0.0, 0.0, diameter / 2 + height]
        world = FewBalls(
            _room(diameter, height), contact, start, radius=diameter / 2, step=step, gravity=GRAVITY, pitch=diameter
        )
        # The fall, a bounce that is no higher than the drop, and a margin.
        _, positions = world.track(3.2 * np.sqrt(2 * height / GRAVITY), max(1, round(SAMPLE_S / step)))
        bounce = bounce_height(positions[:, 0, 2] - diameter / 2)
        given = contact.value_of("restitution", hit_speed(height))
        rows.append((contact.name, 1e3 * height, 1e3 * bounce, given))
    return add_restitution(pd.DataFrame(rows, columns=["contact", *HEIGHTS, "restitution_given"]))


def add_restitution(drops: pd.DataFrame) -> pd.DataFrame:
    """The drops with a column restitution = (bounce_height_mm / drop_height_mm)^(1/2) (Eq. 3.19)."""
    return drops.assign(restitution=np.sqrt(drops["bounce_height_mm"] / drops["drop_height_mm"]))


def read_heights(path: str) -> pd.DataFrame:
    """Read measured drops: drop_height_mm and bounce_height_mm, both of the ball's lowest point over the floor.

    Raises ConfigError for fewer than two drops, a height that is not positive, or a bounce above its drop.
    """
    # From one drop there is no interval.
    drops = read_measured(path, [Number(column, 0, above=True) for column in HEIGHTS], fewest_rows=2)
    refuse_rows(
        drops,
        path,
        "bounce_height_mm",
        drops["bounce_height_mm"] > drops["drop_height_mm"],
        lambda drop: f"must be at most the drop height, {drop['drop_height_mm']:g} mm",
    )
    return add_restitution(drops[HEIGHTS])


def summarise_drops(drops: pd.DataFrame, probability: float) -> dict[str, float]:
    """Mean restitution of some drops, as in the thesis, with Student's interval of that mean.

    drops, mean, sd, lower, upper; the interval of simulated drops says how far the height matters, nothing more.
    """
    values = drops["restitution"].to_numpy()
    spread = float(np.std(values, ddof=1)) if len(values) > 1 else float("nan")
    found = mean_of(values, "-", probability)
    ends = dict(zip(ENDS, found.ends("repeats"), strict=True))
    return {"drops": len(values), "mean": found.value, "sd": spread, **ends}


def restitution_over_speed(drops: pd.DataFrame, probability: float) -> pd.DataFrame:
    """The restitution at the speed of each drop height: speed_m_s, and the columns of `summarise_drops`."""
    rows = [
        {"speed_m_s": hit_speed(1e-3 * height), **summarise_drops(own, probability)}
        for height, own in drops.groupby("drop_height_mm", sort=True)
    ]
    return pd.DataFrame(rows)


def table_in_words(found: pd.DataFrame) -> list[str]:
    """A table of `restitution_over_speed` as the key of a contact set, and its interval at the nominal speed.

    Lines; one, that says what is missing, for fewer than FEWEST_HEIGHTS heights or one that was dropped from only once.
    """
    if len(found) < FEWEST_HEIGHTS or found["drops"].min() < 2:
        return [f"a restitution over speed needs drops from {FEWEST_HEIGHTS} heights, two or more from each"]
    speeds, values = (", ".join(f"{value:.3g}" for value in found[name]) for name in ("speed_m_s", "mean"))
    ends = {name: SpeedTable(speeds_m_s=tuple(found["speed_m_s"]), values=tuple(found[name])) for name in ENDS}
    lower, upper = (ends[name].at(NOMINAL_SPEED_M_S) for name in ENDS)
    return [
        f"restitution: {{speeds_m_s: [{speeds}], values: [{values}]}}",
        f"uncertainty.parameters.restitution, which is that at {NOMINAL_SPEED_M_S:g} m/s: "
        f"lower: {lower:.3g}, upper: {upper:.3g}",
    ]


SWING_SAMPLE_S = 4e-3  # between positions of the ball: a cubic through them is exact to about a micrometre
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
        times, positions = world.track(duration + 2 * SWING_SAMPLE_S, max(1, round(SWING_SAMPLE_S / self.step)))
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
