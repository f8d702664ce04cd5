"""A mill that obeys the scaling laws exactly, so that every descriptor of it is known in closed form."""

from functools import cache

import numpy as np
import pandas as pd

from millprint.config.sweep import ball_count
from millprint.fingerprint.descriptors import tabulate_descriptors
from millprint.fingerprint.model import Fingerprint

VOLUME = 125e-6
AMPLITUDE = 0.017
DENSITY = 7700.0
CONTACT_SETS = {"calibrated": (0.30, 0.30), "steel": (0.68, 0.70)}
FILLS = (0.04, 0.06, 0.08, 0.10, 0.12, 0.16, 0.20, 0.30, 0.40)


def true_curves(fill_ratio):
    """Pn, Pt and f of the synthetic mill at a fill ratio."""
    return 40.0 * np.exp(-(np.log(fill_ratio / 0.15) ** 2)), 12.0 * fill_ratio**-0.8, 4.0 / fill_ratio


# The rolling power over the normal one.
ROLLING = 0.3
# The weighted energies over the mean ones, and the share of the collisions that is strong.
WEIGHTED_OVER_MEAN, STRONG = {"normal": 4.0, "tangential": 2.0}, 0.4


def weighted(channel, frequency, power, balls):
    """Weighted energy and frequency of a channel."""
    energy = WEIGHTED_OVER_MEAN[channel] * power / frequency
    return {
        "energy_J": energy,
        "specific_frequency_hz": power / energy / balls,
        "negative": {"count": 0, "share": 0.0},
    }


def counted(name, gap_turns, frequency, normal, tangential, balls):
    """One counting rule of a summary of a window of one second."""
    return {
        "name": name,
        "by": "surface",
        "gap_turns": gap_turns,
        "peak_force_min_N": 0.0,
        "duration_min_s": 0.0,
        "count": int(frequency),
        "frequency_hz": frequency,
        "specific_frequency_hz": frequency / balls,
        "collisions_of_a_ball_hz": 1.3 * frequency / balls,
        "mean_normal_J": normal / frequency,
        "mean_tangential_J": tangential / frequency,
        "shares": {
            "ball_ball": {"count": 0.3, "normal": 0.2, "tangential": 0.1},
            "ball_wall": {"count": 0.7, "normal": 0.8, "tangential": 0.9},
        },
        "dropped": {"count": 0.0, "normal": 0.0, "tangential": 0.0},
    }


def summary(
    fill_ratio=0.10,
    diameter_mm=10.0,
    speed_rpm=600.0,
    contact="calibrated",
    seed=0,
    noise=0.0,
    factor=1.0,
    amplitude_mm=None,
    density_kg_m3=None,
    error=0.02,
    mixture=None,
):
    """The summary of one run; `noise` is the relative change of powers, `factor` multiplies powers and frequency.

    `error` is the relative standard error of the normal power and of its weighted energy, twice the tangential ones.
    A `mixture` has the dissipation of its mean ball.
    """
    normal_curve, tangential_curve, frequency_curve = true_curves(fill_ratio)
    amplitude = AMPLITUDE if amplitude_mm is None else amplitude_mm * 1e-3
    density = DENSITY if density_kg_m3 is None else density_kg_m3
    diameter_mm = mixture.mean_diameter_mm if mixture else diameter_mm
    diameter, speed = diameter_mm * 1e-3, speed_rpm / 60.0
    balls = ball_count(fill_ratio, VOLUME, diameter)
    unit = balls * density * speed**3 * amplitude**2 * diameter**3 * factor * (1.0 + noise)
    normal, tangential = normal_curve * unit, tangential_curve * unit
    rolling = ROLLING * normal
    wall = normal + tangential + rolling
    restitution, friction = CONTACT_SETS[contact]
    # Turns that are not like the one before.
    ripple = 1.0 + 0.1 * np.sin(2.0 * np.arange(10) + seed)
    ripple /= ripple.mean()
    # A pattern of turns with a mean of zero and a standard error of one.
    pattern = np.array([1.0, 1.0, -1.0, -1.0, 1.0, -1.0, 1.0, -1.0, -1.0, 1.0]) * 3.0
    frequency = frequency_curve * speed * balls * factor
    return {
        "case": {
            "ball_diameter_m": diameter,
            "fill_ratio": fill_ratio,
            "speed_hz": speed,
            "seed": seed,
            "amplitude_mm": amplitude_mm,
            "density_kg_m3": density_kg_m3,
            "mixture": mixture and mixture.model_dump(mode="json"),
        },
        "mill": "emax",
        "contact": contact,
        "balls": balls,
        "ball_diameter_m": diameter,
        "density_kg_m3": density,
        "restitution": restitution,
        "static_friction": friction,
        "wall_restitution": restitution,
        "wall_static_friction": friction,
        "frequency_hz": speed,
        "amplitude_m": amplitude,
        "window_s": 1.0,
        "closure": 1e-4 * (-1) ** seed,
        "power_W": {
            "normal": normal,
            "tangential": tangential,
            "rolling": rolling,
            "wall": normal + tangential + rolling,
        },
        "power_standard_error_W": {"normal": error * normal, "tangential": 0.5 * error * tangential},
        "per_revolution": {
            "normal_J": list(normal / speed * ripple),
            "tangential_J": list(tangential / speed * ripple),
            "rolling_J": list(rolling / speed * ripple),
            "wall_J": list(wall / speed * ripple),
            "normal_square_J2": list(4.0 * normal**2 / frequency / speed * (ripple + error * pattern)),
            "tangential_square_J2": list(2.0 * tangential**2 / frequency / speed * (ripple + 0.5 * error * pattern)),
        },
        "collisions": [
            counted("lifetimes", 0.0, 2.0 * frequency, normal, tangential, balls),
            counted("gap_0_02", 0.02, frequency, normal, tangential, balls),
            counted("gap_0_03", 0.03, frequency, normal, tangential, balls),
        ],
        "weighted": {
            "normal": weighted("normal", frequency, normal, balls),
            "tangential": weighted("tangential", frequency, tangential, balls),
            "strong_frequency_hz": STRONG * frequency / balls,
        },
        "mean_ball_height_m": 0.01,
        "median_contact_duration_s": 5e-4,
    }


def still(fill, *condition) -> dict:
    """The summary of a run without impacts, whose hits have died away."""
    own = summary(fill, *condition)
    turns = own["per_revolution"]["normal_J"]
    own["per_revolution"]["normal_J"] = [turns[0] * 1e-9**place for place in range(1, len(turns) + 1)]
    own["power_W"]["normal"] *= 1e-9
    return own


def summaries(contacts=("calibrated",), fills=FILLS, diameters=(10.0, 5.0), speeds=(600.0, 1200.0), **changes):
    """A sweep of the synthetic mill."""
    return [
        summary(fill, diameter, speed, contact, **changes)
        for contact in contacts
        for diameter in diameters
        for fill in fills
        for speed in speeds
    ]


def descriptors(**changes) -> pd.DataFrame:
    """Descriptors of a sweep of the synthetic mill under the rule of 0.03 turns."""
    return tabulate_descriptors(summaries(**changes), "gap_0_03")


def overrides(fills=(0.06, 0.10, 0.17), contact="calibrated", **changes):
    """Runs over amplitude and density at 10 mm and 600 rpm."""
    swept = [{"amplitude_mm": value} for value in (14.0, 20.0, 24.0)]
    swept += [{"density_kg_m3": value} for value in (3900.0, 15000.0)]
    return [summary(fill, contact=contact, **change, **changes) for fill in fills for change in swept]


@cache
def fingerprint() -> Fingerprint:
    """The fingerprint of the whole sweep, amplitude and density included."""
    runs = summaries(error=0.002) + overrides(error=0.002)
    return Fingerprint.fit(tabulate_descriptors(runs, "gap_0_03"), VOLUME, 0.95)
