"""An invalid run stops with one line that names the fault, the ball and the time."""

import math
import re

import numpy as np
import pytest

from millprint.config.errors import SimulationError
from millprint.config.included import load_contact, load_mill
from millprint.config.sweep import Case, DemConfig, ball_count
from millprint.dem.layout import COUNTER, LANE, LANES, STATUS
from millprint.dem.overlap import feature_at, overlap_in_words
from millprint.dem.simulation import Simulation
from millprint.mill.kernel_columns import width_of
from millprint.mill.vessel import build_vessel
from millprint.mill.wall_features import features_of

MILL = load_mill("emax")
CONTACT = load_contact("calibrated")
DEM = DemConfig(time_step_s=4e-6, settle_s=0.02, window_s=0.02)


def simulation(dem=DEM, contact=CONTACT, **change) -> Simulation:
    settings = {"ball_diameter_m": 0.01, "fill_ratio": 0.1, "speed_hz": 10, "seed": 0}
    times = {name: getattr(dem, name) for name in ("settle_s", "window_s")} | {"discard_s": 0.0}
    return Simulation(Case(mill="emax", contact="calibrated", **(settings | times | change)), MILL, contact, dem)


def refusal(action) -> str:
    """The one line by which an action is refused."""
    with pytest.raises(SimulationError) as caught:
        action()
    (line,) = str(caught.value).splitlines()
    return line


def test_the_refusal_of_too_many_balls_names_what_the_packing_method_can_place():
    line = refusal(lambda: simulation(fill_ratio=0.9))
    balls, fill = re.fullmatch(
        r"(\d+) balls of 10 mm do not fit .* packing method, .* at most \d+, a fill ratio of ([\d.]+); .*", line
    ).groups()
    assert int(balls) == ball_count(0.9, 125e-6, 0.010)
    # The fill it names can be placed, and one more hundredth cannot.
    fits = simulation(fill_ratio=float(fill))
    assert len(np.unique(fits.balls.position, axis=0)) == ball_count(float(fill), 125e-6, 0.010)
    refusal(lambda: simulation(fill_ratio=float(fill) + 0.02))


def test_less_than_one_ball_is_refused():
    assert "less than one ball of 10 mm" in refusal(lambda: simulation(fill_ratio=0.001))


@pytest.mark.slow
def test_a_ball_outside_the_vessel_has_left_it():
    run = simulation()
    run.balls.position[7] += [0.0, 0.0, 1.0]
    assert re.fullmatch(r"ball 7 has left the vessel at -?\d+\.\d+ s", refusal(lambda: run.run("test")))


def test_a_ball_through_the_wall_is_caught_whatever_its_speed():
    """At 3 km/s a ball crosses a wall in less than a step: it overlaps too much or is outside, but never lost."""
    run = simulation()
    run.balls.velocity[3] = run.balls.velocity_now[3] = [0.0, 3000.0, 0.0]
    assert re.match(r"ball \d+ (has left the vessel|overlaps) ", refusal(lambda: run.run("test")))


@pytest.mark.parametrize("value", [math.nan, math.inf])
def test_a_number_that_is_not_finite_names_its_ball(value):
    run = simulation()
    run.balls.velocity[5, 1] = value
    assert re.match(r"the position of ball 5 is not a finite number at -?\d+\.\d+ s", refusal(lambda: run.run("test")))


@pytest.mark.slow
def test_an_overlap_by_speed_names_both_sides_the_speed_and_a_modulus():
    run = simulation(DEM.model_copy(update={"overlap_max": 1e-3}))
    line = refusal(lambda: run.run("test"))
    pattern = (
        r"ball \d+ overlaps (ball \d+|the wall of vessel) by [\d.]+ % of its radius, more than 0\.1 %, at .* s: .*; "
        r"they met at [\d.]+ m/s, and the ball has [\d.]+ m/s now\. the speed is too high for this Young's modulus: an "
        r"elastic impact at that speed reaches [\d.]+ %; it needs [\d.e+]+ GPa in place of 2\.05, or a slower mill"
    )
    assert re.fullmatch(pattern, line), line


def test_two_balls_that_start_in_one_place_are_told_to_be_in_the_start():
    run = simulation()
    run.balls.position[4] = run.balls.position[9] + [0.0, 0.0, 1e-3]
    line = refusal(lambda: run.run("test"))
    assert re.match(r"ball 4 overlaps ball 9 by [\d.]+ % of its radius, more than 15 %, at ", line)
    assert "and touch at 10 mm" in line
    assert "Neither speed nor step is the cause" in line and "from the start on; look at the starting positions" in line
    assert "GPa" not in line


def stopped_at_a_wall(point, speed, contact=CONTACT):
    """The message of a run that stops in a contact of ball 0, at a point of the vessel's frame [m], with the vessel."""
    run = simulation(contact=contact)
    run.balls.position[0] = run.bodies[0].to_laboratory(np.asarray(point)[None], 0.0)[0]
    values = {"step": 0, "used": 1, "status": STATUS.overlap, "ball": 0, "partner": -1}
    for name, value in values.items():
        run.counters[getattr(COUNTER, name)] = value
    run.contacts.ball[0], run.contacts.partner[0], run.contacts.slot[0] = 0, -1, 0
    lane = run.contacts.lanes.reshape(-1, width_of(LANE), LANES)[0, :, 0]
    history = LANE.history
    lane[[history.peak_overlap, history.approach_speed, history.start]] = 0.16 * run.radius, speed, 0.0
    return overlap_in_words(run)


MIDDLE = build_vessel(MILL).bounds.mean(axis=0)
PRESSED = np.array([MIDDLE[0], MIDDLE[1], 0.0042])


def test_a_ball_that_is_clear_of_the_exact_surface_is_not_told_to_be_too_fast():
    """Ball 0 in the middle of the jar, in contact with a wall that is not there."""
    line = stopped_at_a_wall(MIDDLE, 0.3)
    assert "so that it is clear of it by" in line and "a fault of millprint's wall; please report it" in line
    assert "GPa" not in line and "too large" not in line


def test_a_ball_that_is_pressed_into_a_wall_is_told_the_distance_and_the_place():
    line = stopped_at_a_wall(PRESSED, 0.3)
    assert "its centre is 4.2 mm from the nearest point of the wall, on a facet at (" in line
    assert "0) mm of the vessel's frame, so that it is in it by 0.8 mm; they met at 0.3 m/s" in line
    assert "the ball is pressed there, with no other contact" in line


@pytest.mark.parametrize(("speed", "is_unresolved"), [(30.0, False), (3e5, True)])
def test_speed_and_step_are_named_only_where_they_are_the_cause(speed, is_unresolved):
    line = stopped_at_a_wall(PRESSED, speed)
    assert "the speed is too high for this Young's modulus" in line
    assert ("the step is too large: an elastic impact at that speed lasts" in line) is is_unresolved


def test_corners_edges_seams_and_facets_are_told_apart():
    vessel = build_vessel(load_mill("emax_post"))
    corner = features_of(vessel).corners[0].point if features_of(vessel).corners else vessel.vertices[0]
    assert feature_at(vessel, corner) == "a corner"
    seam = next(edge for edge in vessel.edges if edge.turn < 0)
    assert feature_at(vessel, (seam.start + seam.end) / 2) == "a seam"
    for edge in features_of(vessel).lines[:1]:
        assert feature_at(vessel, (edge.start + edge.end) / 2) == "a convex edge"
    assert feature_at(vessel, vessel.facets[0].loops[0][:3].mean(axis=0)) == "a facet"


def test_a_step_over_the_fraction_of_the_case_is_refused_and_a_wider_bound_lets_it_pass():
    """Steps of the case's own; 9e-6 s is 0.17 of the Rayleigh time of 10 mm balls."""
    tight = DEM.model_copy(update={"rayleigh_fraction_max": 0.1})
    line = refusal(lambda: simulation(tight, time_step_s=9e-6))
    assert re.match(r"the time step of 9e-06 s is 0\.17\d* of the Rayleigh time; at most 0\.1 \(", line)
    run = simulation(tight, time_step_s=9e-6, rayleigh_fraction_max=0.2)
    assert 0.99 * 9e-6 < run.step <= 9e-6
