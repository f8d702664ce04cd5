"""A mill that obeys the scaling laws exactly, so that every descriptor of it is known in closed form."""

from functools import cache

import numpy as np
import pandas as pd
from millprint.fingerprint.master import MasterCurves, describe_curves
from millprint.fingerprint.smooth import smooth_curves

from millprint.config.sweep import ball_count
from millprint.fingerprint.descriptors import tabulate_descriptors

VOLUME = 125e-6
AMPLITUDE = 0.017
DENSITY = 7700.0
CONTACT_SETS = {"calibrated": (0.30, 0.30), "steel": (0.68, 0.70)}
FILLS = (0.04, 0.06, 0.08, 0.10, 0.12, 0.16, 0.20, 0.30, 0.40)


def true_curves(fill_ratio):
    """Pn, Pt and f of the synthetic mill at a fill ratio."""
    return 40.0 * np.exp(-(np.log(fill_ratio / 0.15) ** 2)), 12.0 * fill_ratio**-0.8, 4.0 / fill_ratio


def counted(name, gap_s, frequency, normal, tangential, balls):
    """One counting rule of a summary of a window of one second."""
    return {
        "name": name,
        "gap_s": gap_s,
        "peak_force_min_N": 0.0,
        "duration_min_s": 0.0,
        "count": int(frequency),
        "frequency_hz": frequency,
        "frequency_per_ball_hz": frequency / balls,
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
):
    """The summary of one run; `noise` is the relative change of powers, `factor` multiplies powers and frequency."""
    normal_curve, tangential_curve, frequency_curve = true_curves(fill_ratio)
    diameter, speed = diameter_mm * 1e-3, speed_rpm / 60.0
    balls = ball_count(fill_ratio, VOLUME, diameter)
    unit = balls * DENSITY * speed**3 * AMPLITUDE**2 * diameter**3 * factor * (1.0 + noise)
    normal, tangential = normal_curve * unit, tangential_curve * unit
    restitution, friction = CONTACT_SETS[contact]
    ripple = 1.0 + 0.1 * np.sin(np.arange(10) + seed)
    ripple /= ripple.mean()
    frequency = frequency_curve * speed * balls * factor
    return {
        "case": {"ball_diameter_mm": diameter_mm, "fill_ratio": fill_ratio, "speed_rpm": speed_rpm, "seed": seed},
        "mill": "emax",
        "contact": contact,
        "balls": balls,
        "ball_diameter_m": diameter,
        "density_kg_m3": DENSITY,
        "restitution": restitution,
        "static_friction": friction,
        "frequency_hz": speed,
        "amplitude_m": AMPLITUDE,
        "window_s": 1.0,
        "closure": 1e-4 * (-1) ** seed,
        "power_W": {"normal": normal, "tangential": tangential, "rolling": 0.3 * normal, "wall": normal + tangential},
        "power_standard_error_W": {"normal": 0.02 * normal, "tangential": 0.01 * tangential},
        "per_revolution": {
            "normal_J": list(normal / speed * ripple),
            "tangential_J": list(tangential / speed * ripple),
            "wall_J": list((normal + tangential) / speed * ripple),
        },
        "collisions": [
            counted("lifetimes", 0.0, 2.0 * frequency, normal, tangential, balls),
            counted("gap_3ms", 0.003, frequency, normal, tangential, balls),
        ],
        "mean_ball_height_m": 0.01,
        "median_contact_duration_s": 5e-4,
    }


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
    """Descriptors of a sweep of the synthetic mill under the 3 ms rule."""
    return tabulate_descriptors(summaries(**changes), "gap_3ms")


@cache
def fitted_curves() -> MasterCurves:
    """Smooth curves of the whole sweep."""
    exact = descriptors()
    return MasterCurves(smooth_curves(exact, 100, 0.95), describe_curves(exact, VOLUME))
