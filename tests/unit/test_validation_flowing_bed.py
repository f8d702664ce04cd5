"""Measures of a flowing bed, on beds whose surface and speeds are known."""

import math

import numpy as np
import pytest

from millprint.config.contact_set import ContactConfig
from millprint.config.setup_models import FILES
from millprint.estimate.estimates import half_width
from millprint.validation.drums import Motion, Surface, fit_surface, measure, sample_contacts, speed_profile, zero_place

RADIUS, HEIGHT, CELL = 0.12, -0.03, 0.003
# The speed is 0 at this place [m] and grows at this rate towards the surface [1/s].
ZERO, RATE = -0.06, 12.0


def bed(slope_deg: float, number: int = 200_000, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Places and velocities (n, 2) of a uniform bed in a drum: a plane surface at HEIGHT, a linear shear above ZERO."""
    draw = np.random.default_rng(seed)
    place = draw.uniform(-RADIUS, RADIUS, (6 * number, 2))
    along, up = place.T
    place = place[(np.hypot(along, up) < RADIUS) & (up < HEIGHT)][:number]
    slope = math.radians(slope_deg)
    axes = np.array([[math.cos(slope), math.sin(slope)], [-math.sin(slope), math.cos(slope)]])
    # Down the slope: against the first axis where the surface rises along it.
    speed = -np.sign(slope_deg) * RATE * (place[:, 1] - ZERO)
    return place @ axes, np.outer(speed, axes[0])


@pytest.mark.parametrize("slope_deg", [27.0, -27.0, 4.0, -41.0])
def test_the_angle_of_a_tilted_plane(slope_deg):
    surface = fit_surface(bed(slope_deg)[0], 0.06, CELL)
    assert math.degrees(surface.slope_rad) == pytest.approx(slope_deg, abs=0.15)
    assert surface.angle_deg == pytest.approx(abs(slope_deg), abs=0.15)
    assert surface.height_m == pytest.approx(HEIGHT, abs=0.25 * CELL)


def test_the_angle_does_not_depend_on_balls_in_flight():
    places, _ = bed(27.0)
    flying = np.random.default_rng(1).uniform([-0.05, 0.0], [0.05, 0.08], (2000, 2))
    with_some = fit_surface(np.concatenate([places, flying]), 0.06, CELL)
    assert with_some.angle_deg == pytest.approx(fit_surface(places, 0.06, CELL).angle_deg, abs=0.1)


@pytest.mark.parametrize("slope_deg", [27.0, -27.0])
def test_a_linear_shear_is_found_with_its_sign_and_its_zero(slope_deg):
    places, velocities = bed(slope_deg)
    surface = fit_surface(places, 0.06, CELL)
    depths = np.linspace(-0.11, HEIGHT - CELL, 40)
    speeds = speed_profile(places, velocities, surface, depths, 1.5 * CELL, 0.5 * CELL)
    assert speeds == pytest.approx(RATE * (depths - ZERO), abs=0.05 * RATE * CELL + 0.004)
    assert speeds[-1] > 0 > speeds[0]
    assert zero_place(depths, speeds) == pytest.approx(ZERO, abs=3e-4)


def test_a_place_without_balls_has_no_speed():
    places, velocities = bed(27.0)
    surface = Surface(math.radians(27.0), HEIGHT)
    speeds = speed_profile(places, velocities, surface, np.array([0.05, -0.06]), CELL, CELL)
    assert math.isnan(speeds[0])
    assert math.isfinite(speeds[1])


def test_a_bed_that_turns_with_the_drum_has_no_zero():
    depths = np.linspace(-0.11, -0.04, 20)
    assert math.isnan(zero_place(depths, 1.2 * depths))


def test_blocks_of_known_scatter():
    values = np.random.default_rng(0).normal(5.0, 2.0, (10_000, 4))
    covered = np.abs(values.reshape(2500, 4, 4).mean(axis=1) - 5.0)
    widths = np.array([half_width(block) for block in values.reshape(2500, 4, 4)])
    assert np.mean(covered < widths) == pytest.approx(0.95, abs=0.01)
    assert np.isnan(half_width(values[:1])).all()


def test_a_motion_is_measured_in_its_own_frame_or_in_a_given_one():
    places, velocities = bed(27.0, 40_000)
    motion = Motion(places.reshape(4, 10_000, 2), velocities.reshape(4, 10_000, 2), RADIUS)
    depths, settings = np.linspace(-0.11, HEIGHT - CELL, 30), FILES["bead_drum"].read()
    found = measure(motion, depths, settings)
    assert found.angle_deg == pytest.approx(27.0, abs=0.3)
    assert found.zero == pytest.approx(ZERO, abs=6e-4)
    # In a frame that is turned by 20 degrees, a place on its normal lies higher, and speeds are cosines.
    turned = measure(motion, np.array([-0.09, -0.08]), settings, Surface(math.radians(47.0), HEIGHT))
    cosine = math.cos(math.radians(20.0))
    assert turned.speeds[1] == pytest.approx(RATE * (-0.08 * cosine - ZERO) * cosine, abs=0.01)
    assert [len(block.places) for block in motion.blocks(2)] == [2, 2]


def test_contact_parameters_are_spread_over_their_intervals():
    contact = ContactConfig(
        name="a", source="b", restitution=0.5, static_friction=0.5, rolling_friction=0.01, density_kg_m3=1768,
        young_modulus_gpa=0.01, poisson_ratio=0.37,
    )  # fmt: skip
    settings = FILES["repose_drum"].read()
    drawn = sample_contacts(contact, settings)
    assert drawn == sample_contacts(contact, settings)
    for name in ("restitution", "static_friction", "rolling_friction"):
        low, high = getattr(settings, name)
        values = np.array([getattr(each, name) for each in drawn])
        share = (
            np.log(values / low) / np.log(high / low) if name == "rolling_friction" else (values - low) / (high - low)
        )
        # A Latin hypercube: one value in each of as many equal parts as there are samples.
        assert sorted(np.floor(share * settings.samples)) == list(range(settings.samples))
    assert {each.density_kg_m3 for each in drawn} == {1768}
