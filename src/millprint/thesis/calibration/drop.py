"""The drop test, simulated and measured: restitution from the bounce of a ball (thesis Sec. 3.2.2, Eq. 3.19)."""

import math

import numpy as np
import pandas as pd
from scipy.special import stdtrit

from millprint.config.contact_set import ContactConfig
from millprint.config.errors import ConfigError
from millprint.config.mill import BoxGeometry
from millprint.config.over_speed import NOMINAL_SPEED_M_S, SpeedTable
from millprint.dem.few_balls import FewBalls
from millprint.dem.timestep import resolved_step
from millprint.mill.gravity import GRAVITY
from millprint.mill.vessel import Vessel, shape_vessel
from millprint.run.tables import Number, read_measured, refuse_rows

SAMPLE_S = 1e-4  # the top of a bounce is flat: it is missed by at most g dt^2 / 8, 0.01 micrometre
FEWEST_HEIGHTS = 3
ENDS = ("lower", "upper")
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
    half = float(stdtrit(len(values) - 1, (1 + probability) / 2)) * spread / len(values) ** 0.5
    mean = float(values.mean())
    return {"drops": len(values), "mean": mean, "sd": spread, "lower": mean - half, "upper": mean + half}


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
