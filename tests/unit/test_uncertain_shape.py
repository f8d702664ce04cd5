"""What a fit leaves open of a jar's shape, on a search whose values follow from the jar in closed form."""

import numpy as np
import pandas as pd
import pytest
from scipy.stats import qmc

from millprint.config.calibration import JarSearch
from millprint.config.errors import ConfigError
from millprint.fingerprint.bands import checked_factors
from millprint.thesis.fit.jar_search import JAR_PARAMETERS, SHAPE
from millprint.thesis.fit.open_shape import agreement, shape_factors

RANGES = {name: own._asdict() for name, own in SHAPE.items()}
SETTINGS = JarSearch(contact="calibrated", fitted=["Pn_f0.10"], ball_diameters_mm=[10])
PRESENT = {name: (ends["low"] + ends["high"]) / 2 for name, ends in RANGES.items()}
PUBLISHED = {"Pn_f0.10": 40.0, "Pt_f0.10": 80.0, "f_f0.10": 40.0}
STEEP, MISFIT = 2.0, 0.1


def searched(jars: int = 48, rule: str = "gap_0_02") -> pd.DataFrame:
    """A search in which Pn follows from the straight ratio, Pt from the height, f from nothing; places 0 to 1."""
    places = qmc.Sobol(len(JAR_PARAMETERS), seed=3).random(64)[:jars]
    low, high = (np.array([ends[end] for ends in RANGES.values()]) for end in ("low", "high"))
    logs = {
        "Pn_f0.10": MISFIT + STEEP * (places[:, 0] - 0.5),
        "Pt_f0.10": 0.5 * (places[:, 1] - 0.5),
        "f_f0.10": 1e-3 * np.sin(40 * places[:, 2]),
    }
    table = pd.DataFrame(low + places * (high - low), columns=list(JAR_PARAMETERS))
    return table.assign(counting_rule=rule, **{f"{name}_percent": 100 * np.expm1(log) for name, log in logs.items()})


def found(**changes):
    given = {"search": searched(), "published": PUBLISHED, "settings": SETTINGS, "present": PRESENT}
    return shape_factors(**{**given, **changes}, mill="emax", counting_rule="gap_0_02", probability=0.95)


def test_what_was_fitted_is_sure_and_what_was_not_is_open():
    factors = found()
    assert factors.fill_ratios == [0.10] and factors.samples == 48
    ends = {name: (each.lower[0], each.upper[0]) for name, each in factors.factors.items()}
    # Of the fitted power: log(ours / published) is normal about 0 with the misfit of the present jar, which is at +1.
    assert np.log(ends["Pn"]) == pytest.approx([-MISFIT - 1.96 * MISFIT, -MISFIT + 1.96 * MISFIT], abs=0.02)
    # Of the other power: the height is anywhere in its range.
    assert np.log(ends["Pt"]) == pytest.approx([0.5 * (0.025 - 0.5), 0.5 * (0.975 - 0.5)], abs=0.02)
    assert np.log(ends["f"]) == pytest.approx([0, 0], abs=0.01)
    # Energies are powers over the frequency, and the ratio is free of both ends at once.
    assert ends["Et"] == pytest.approx(ends["Pt"], rel=0.02)
    assert ends["ratio"][1] / ends["ratio"][0] > ends["Pt"][1] / ends["Pt"][0]
    height, ratio = (factors.parameters[name] for name in ("height_mm", "straight_ratio"))
    assert (height["lower"], height["upper"]) == pytest.approx((31.225, 39.775), abs=0.15)
    # Of the place in the range.
    width = SHAPE["straight_ratio"].high - SHAPE["straight_ratio"].low
    assert (ratio["upper"] - ratio["lower"]) / width == pytest.approx(2 * 1.96 * MISFIT / STEEP, rel=0.1)


def test_the_factors_are_a_file_that_a_fingerprint_takes():
    about = {"mill": "emax", "contact": "calibrated", "counting_rule": "gap_0_02"}
    content = found().model_dump(mode="json")
    assert checked_factors(content, "shape", about, "shape.json").fill_range == (0.10, 0.10)


def test_weights_are_the_likelihood():
    weights = agreement(np.array([[0.0, 0.0], [0.1, 0.0], [0.1, 0.1]]), 0.1)
    np.testing.assert_allclose(weights / weights[0], np.exp([0, -0.5, -1.0]), rtol=1e-12)
    assert weights.sum() == pytest.approx(1)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"search": searched(20)}, "has 20 jars with the rule gap_0_02; a shape's interval needs 24"),
        ({"search": searched(rule="gap_0_04")}, "has 0 jars with the rule gap_0_02"),
        ({"search": searched().drop(columns="Pn_f0.10_percent")}, "lacks Pn_f0.10"),
    ],
)
def test_a_search_that_says_too_little_is_refused(changes, message):
    with pytest.raises(ConfigError, match=message):
        found(**changes)
