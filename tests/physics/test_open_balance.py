"""An open energy balance is told its cause: hits that the step does not resolve, a wall that jumps, or a jam.

The cases are made so that the cause is known: the step, a facet that is moved a little out of its surface, or balls
that are wider than the gap between arms and tank.
"""

import logging
import re

import numpy as np
import pytest

from millprint.cases.of_mill import reference_case
from millprint.config.mill import MillConfig
from millprint.config.mill_sweep import MillsConfig
from millprint.config.sweep import Case, DemConfig
from millprint.dem import run, simulation
from millprint.dem.ledger import OpenBalanceError
from millprint.mill.gravity import GRAVITY
from millprint.mill.walls import PLANE
from tests.physics.setups import CALIBRATED, FewBalls

DEM = DemConfig(closure_max=0.005)


def simulated(mill, contact, dem=DEM, **change) -> dict:
    case = reference_case(mill, MillsConfig(contact=contact.name)).model_copy(update=change)
    return run.simulate(case, mill, contact, dem)


def refused(*given, **change) -> OpenBalanceError:
    with pytest.raises(OpenBalanceError) as caught:
        simulated(*given, **change)
    return caught.value


@pytest.mark.parametrize("restitution", [0.3, 0.6, 0.9])
@pytest.mark.parametrize("speed", [0.1, 3.0])
@pytest.mark.parametrize("share", [0.01, 0.03])
def test_a_hit_makes_four_times_the_square_of_the_step_over_its_duration(restitution, speed, share):
    """By the closed form of Hertz's impact, and from the kinetic energy that is lost; a mean over where it begins."""
    contact, radius = CALIBRATED.model_copy(update={"restitution": restitution}), 5e-3
    mass = contact.density_kg_m3 * 4 / 3 * np.pi * radius**3
    modulus = contact.young_modulus_gpa * 1e9 / (2 * (1 - contact.poisson_ratio**2))
    duration = 2.868 * (mass**2 / (radius * modulus**2 * speed)) ** 0.2
    step, errors = share * duration, []
    for begin in np.linspace(0, 1, 16, endpoint=False):
        ball = FewBalls([0, 0, radius + (10 + begin) * step * speed], [0, 0, -speed], contact=contact, step=step)
        series = ball.run(10 * step + 4 * duration, sample_every=round(10 + 4 / share))
        errors.append(-series["imbalance_J"].iloc[-1] / (mass / 2 * speed**2 * (1 - restitution**2)))
    assert np.mean(errors) / share**2 == pytest.approx(4, rel=0.2)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(2))
def test_a_step_that_is_too_large_is_told_what_it_should_be(mills, contacts, seed):
    """At 0.2 of the Rayleigh time a shaker's balance opens by 0.8 to 0.9 %."""
    step = simulated(mills["spex"], contacts["calibrated"], rayleigh_fraction=0.1, seed=seed)["time_step_s"]
    error = refused(mills["spex"], contacts["calibrated"], rayleigh_fraction=None, time_step_s=2 * step, seed=seed)
    advised = float(re.search(r"the step is too large, .*; make time_step_s ([\d.e-]+)$", str(error))[1])
    assert 0.5 * step < advised < 1.5 * step
    assert simulated(mills["spex"], contacts["calibrated"], time_step_s=advised, seed=seed)["closure"] < 0.005


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(2))
def test_a_wall_that_jumps_is_not_put_down_to_the_step(mills, contacts, seed, monkeypatch, caplog):
    """A facet of the jar stands 0.2 mm inside its surface; nothing is simulated again."""
    build = simulation.build_walls

    def with_a_step(*given, **options):
        walls = build(*given, **options)
        walls.plane[np.flatnonzero(walls.is_drawing[: len(walls.plane)] == 0)[0], PLANE.offset] += 2e-4
        return walls

    monkeypatch.setattr(simulation, "build_walls", with_a_step)
    with caplog.at_level(logging.WARNING, logger="millprint"):
        error = refused(mills["emax"], contacts["calibrated"], rayleigh_fraction=0.11, seed=seed)
    assert error.step_factor == 0 and not caplog.records
    assert "a shorter one does not help. Contacts make or lose energy" in str(error)
    assert re.search(r"ball \d+ and vessel met at", str(error))
    assert "step_s" not in str(error) and "jammed" not in str(error)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(2))
def test_a_jam_names_what_the_balls_are_pressed_between(mills, contacts, seed):
    """Balls of 12 mm between arms and tank, 11 mm apart, at a step that resolves their hits, from the start on."""
    error = refused(
        mills["attritor"], contacts["calibrated"], DEM.model_copy(update={"closure_max": 1e-5}),
        ball_diameter_m=0.012, fill_ratio=0.14, seed=seed, rayleigh_fraction=None, time_step_s=7e-6, window_s=0.6,
        power_error_max=None,
    )  # fmt: skip
    pressed = str(error).partition("balls are jammed: ")[2]
    assert re.search("_arms|vessel", pressed) and "step_s" not in str(error)


@pytest.mark.slow
def test_a_jam_is_simulated_again_with_half_the_step(mills, contacts, caplog):
    with caplog.at_level(logging.WARNING, logger="millprint"):
        # Most starts jam, and not with half the step.
        for seed in range(8):
            found = simulated(mills["attritor"], contacts["calibrated"], ball_diameter_m=0.012, fill_ratio=0.14,
                              seed=seed, rayleigh_fraction=0.11, window_s=0.6, power_error_max=None)  # fmt: skip
            if caplog.records:
                break
    assert found["rayleigh_fraction"] == pytest.approx(0.055, rel=0.02)
    assert len(caplog.records) == 1 and "jammed" in caplog.text


@pytest.mark.parametrize("fill", [0.1, 0.2])
def test_balls_on_a_floor_that_never_leaves_them_close_the_balance_of_what_goes_to_and_fro(fill):
    """A vertical shaker below 1 g: A (2 pi f)^2 < g, so the floor lifts and lowers the balls, 4 A m g in each turn."""
    amplitude, speed = 0.5e-3, 10.0
    assert amplitude * (2 * np.pi * speed) ** 2 < 0.3 * GRAVITY
    shaker = MillConfig(
        name="calm",
        title="A vertical shaker",
        source="made up",
        volume_ml=60.1,
        geometry={"kind": "cylinder", "radius_mm": 19, "height_mm": 53, "fillet_radius_mm": 0},
        motion={"kind": "lissajous", "terms": [{"axis": "z", "amplitude_mm": 1e3 * amplitude, "multiple": 1}]},
    )
    case = Case(
        mill="calm", contact="calibrated", ball_diameter_m=0.008, fill_ratio=fill, speed_hz=speed, seed=0,
        settle_s=0.2, discard_s=0.1, window_s=0.4,
    )  # fmt: skip
    found = run.simulate(case, shaker, CALIBRATED, DEM)
    to_and_fro = 4 * amplitude * found["balls"] * found["ball_mass_kg"] * GRAVITY * speed * found["window_s"]
    assert found["closure"] <= DEM.closure_max
    assert abs(found["ledger_J"]["imbalance"]) < 1e-3 * to_and_fro
    # Little of it is dissipated: balls that still creep take up to 1.3 % of it, by the start.
    assert 0 <= found["power_W"]["wall"] * found["window_s"] < 3e-2 * to_and_fro
