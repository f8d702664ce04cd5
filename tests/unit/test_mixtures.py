"""Charges of several ball sizes: numbers, shares, the ball of mean volume, and where they start."""

import math

import numpy as np
import pandas as pd
import pytest
from pydantic import ValidationError
from scipy.spatial.distance import pdist, squareform

from millprint.config.mixture import BallMixture
from millprint.config.sweep import DemConfig, SweepConfig, ball_count, expand_sweep
from millprint.dem.packing import inside, pack_mixture
from millprint.dem.run import balls_in_words
from millprint.dem.summary import largest_overlap
from millprint.errors import SimulationError
from tests.unit.test_mill_lifters import drum

BOND = BallMixture(name="bond", sizes_mm=(36.83, 29.72, 25.40, 19.05, 15.49), numbers=(43, 67, 10, 71, 94))


def test_the_ball_of_mean_volume_keeps_number_and_volume():
    volume = sum(n * math.pi / 6 * d**3 for n, d in zip(BOND.numbers, BOND.sizes_mm, strict=True))
    assert 285 * math.pi / 6 * BOND.mean_diameter_mm**3 == pytest.approx(volume, rel=1e-12)
    assert ball_count(volume / 22e6, 22e-3, BOND.mean_diameter_mm / 1e3) == 285
    assert BOND.counts(285) == [43, 67, 10, 71, 94]


def test_numbers_and_shares_of_the_volume_say_the_same():
    volumes = [n * d**3 for n, d in zip(BOND.numbers, BOND.sizes_mm, strict=True)]
    shares = tuple(volume / sum(volumes) for volume in volumes)
    by_shares = BallMixture(name="bond", sizes_mm=BOND.sizes_mm, shares=shares)
    assert by_shares.counts(285) == BOND.counts(285)
    assert by_shares.mean_diameter_mm == pytest.approx(BOND.mean_diameter_mm)


@pytest.mark.parametrize("balls", [5, 17, 100, 1234])
def test_counts_add_up_and_are_nearest_to_the_fractions(balls):
    counts = BOND.counts(balls)
    assert sum(counts) == balls
    assert all(abs(count - balls * part) < 1 for count, part in zip(counts, BOND.fractions, strict=True))


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"shares": (0.5, 0.4)}, "add up to 0.9; must add up to 1"),
        ({"numbers": (1, 2), "shares": (0.5, 0.5)}, "give either"),
        ({}, "give either"),
        ({"numbers": (1, 2, 3)}, "one value for each of 2 sizes"),
        ({"sizes_mm": (10, 10), "numbers": (1, 2)}, "a size appears twice"),
    ],
)
def test_a_charge_that_cannot_be_is_refused(keys, message):
    with pytest.raises(ValidationError, match=message):
        BallMixture(**{"name": "mine", "sizes_mm": (10, 5), **keys})


def test_a_sweep_has_numbers_and_mixtures_side_by_side():
    sweep = SweepConfig(
        name="both", contacts=["steel"], ball_diameters_mm=[10, BOND], fill_ratios=[0.2], speeds_rpm=[70], seeds=[0]
    )
    single, mixed = expand_sweep(sweep, DemConfig(), "drum")
    assert (single.name, mixed.name) == ("d10_f0.20_n70_s0", "bond_f0.20_n70_s0")
    assert single.sizes_mm == (10,) and mixed.sizes_mm == BOND.sizes_mm
    assert mixed.ball_diameter_mm == BOND.mean_diameter_mm


@pytest.mark.parametrize("counts", [[30, 60, 300], [60, 20, 900]])
def test_balls_of_several_sizes_start_apart_and_inside(counts):
    _, vessel = drum(length_mm=80)
    diameters = np.array([0.036, 0.022, 0.010])
    points, species = pack_mixture(vessel, diameters, counts, seed=1)
    assert np.bincount(species).tolist() == counts
    radii = diameters[species] / 2
    assert (squareform(pdist(points)) + np.diag(np.full(len(points), 1.0)) >= radii[:, None] + radii).all()
    for size, diameter in enumerate(diameters):
        assert inside(vessel, points[species == size], diameter / 2).all()
    again, _ = pack_mixture(vessel, diameters, counts, seed=1)
    other, _ = pack_mixture(vessel, diameters, counts, seed=2)
    assert np.array_equal(points, again) and not np.array_equal(points, other)


def test_balls_of_several_sizes_that_do_not_fit_are_refused():
    _, vessel = drum()
    with pytest.raises(SimulationError, match=r"do not fit into the vessel"):
        pack_mixture(vessel, np.array([0.022, 0.020]), [300, 300], seed=0)


def test_an_overlap_counts_by_the_smaller_ball():
    radius = np.array([0.010, 0.002, 0.010])
    contacts = pd.DataFrame({"first": [0, 0, 2], "second": [2, 1, -7], "peak_overlap_m": [2e-4, 1e-4, 3e-4]})
    assert largest_overlap(contacts, radius) == pytest.approx(0.05)
    assert largest_overlap(contacts.iloc[[0, 2]], radius) == pytest.approx(0.03)
    assert largest_overlap(contacts.iloc[:0], radius) == 0


def test_a_log_names_every_size():
    assert balls_in_words([3, 5], [36.83, 15.49]) == "8 balls: 3 of 36.83 mm, 5 of 15.49 mm"
    assert balls_in_words([8], [10]) == "8 balls of 10 mm"
