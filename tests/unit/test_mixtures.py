"""Charges of several ball sizes: numbers, shares, the ball of mean volume, and where they start."""

import math

import numpy as np
import pandas as pd
import pytest
from scipy.spatial.distance import pdist, squareform

from millprint.checks.before_running import check_same_charges
from millprint.config.charge import BallMixture
from millprint.config.errors import ConfigError, SimulationError
from millprint.config.sweep import Case, ball_count, balls_of
from millprint.dem.packing import inside, pack_mixture
from millprint.dem.run import largest_overlap
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


@pytest.mark.parametrize("counts", [[30, 60, 300], [60, 20, 900]])
@pytest.mark.slow
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


@pytest.mark.slow
def test_balls_of_several_sizes_that_do_not_fit_are_refused():
    _, vessel = drum()
    with pytest.raises(SimulationError, match=r"packing method cannot place them"):
        pack_mixture(vessel, np.array([0.022, 0.020]), [300, 300], seed=0)


def test_an_overlap_counts_by_the_smaller_ball():
    radius = np.array([0.010, 0.002, 0.010])
    contacts = pd.DataFrame({"first": [0, 0, 2], "second": [2, 1, -7], "peak_overlap_m": [2e-4, 1e-4, 3e-4]})
    assert largest_overlap(contacts, radius) == pytest.approx(0.05)
    assert largest_overlap(contacts.iloc[[0, 2]], radius) == pytest.approx(0.03)
    assert largest_overlap(contacts.iloc[:0], radius) == 0


GOOD = {"name": "bond", "sizes_mm": [10, 5], "numbers": [1, 2]}


def test_a_charge_has_one_composition_in_a_run():
    keys = {"mill": "drum", "contact": "steel", "fill_ratio": 0.2, "speed_hz": 1.2, "seed": 0}
    keys |= {"settle_s": 0.1, "discard_s": 0.1, "window_s": 0.1}
    one, other = (Case(**keys, **balls_of(BallMixture(**{**GOOD, "numbers": n}))) for n in ([1, 2], [2, 1]))
    check_same_charges({one.path: one}, {"drum": [one]}, "config.yaml")
    with pytest.raises(ConfigError, match="charge bond has other balls in the sweep of mill drum"):
        check_same_charges({one.path: one}, {"drum": [other]}, "config.yaml")
