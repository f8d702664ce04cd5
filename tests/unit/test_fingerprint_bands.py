"""Intervals told apart: their algebra, factors over the fill ratio, and the files that hold them."""

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from millprint.config.errors import ConfigError
from millprint.estimate.estimates import columns_of
from millprint.fingerprint.bands import FURTHER, checked_factors, read_factors
from millprint.fingerprint.model import Fingerprint
from millprint.fingerprint.predicted_values import banded, conditions_of
from millprint.fingerprint.processes import Told
from millprint.observables.definitions import COUNTED, CURVES
from millprint.run.files import write_json
from tests.refusals import refusal, refusals
from tests.unit.factor_samples import FACTOR_FILLS, factors_of
from tests.unit.synthetic_mill import fingerprint

AT = {"speed_hz": 10.0, "ball_diameter_m": 0.01}
BANDS = ("normal_energy_J", "tangential_energy_J", "specific_frequency_hz", "wall_power_W", "tangential_share")


@pytest.fixture(scope="module")
def plain() -> Fingerprint:
    return fingerprint()


@pytest.fixture(scope="module")
def about(plain) -> dict:
    return plain.about


@pytest.fixture(scope="module")
def own(plain, about) -> Fingerprint:
    """A fingerprint with both further origins; the shape is known at fewer fill ratios."""
    shape = factors_of("shape", fill_ratios=[0.10, 0.12])
    for ends in shape["factors"].values():
        ends |= {end: values[:2] for end, values in ends.items()}
    contents = {"contact": factors_of(), "shape": shape}
    further = {origin: checked_factors(content, origin, about, "x") for origin, content in contents.items()}
    return plain.with_further(further)


def test_factors_are_read_at_their_fill_ratios_and_interpolated_in_between(about):
    content = factors_of()
    factors = checked_factors(content, "contact", about, "x")
    found = factors.at(np.array(FACTOR_FILLS))
    for name in CURVES:
        np.testing.assert_allclose(
            found[name], [content["factors"][name][end] for end in ("lower", "upper")], rtol=1e-12
        )
    # Halfway in the logarithm of the fill ratio: the geometric mean of the factors.
    between = factors.at(np.array([np.sqrt(0.06 * 0.12)]))["En"][:, 0]
    expected = [np.sqrt(np.prod(content["factors"]["En"][end][:2])) for end in ("lower", "upper")]
    np.testing.assert_allclose(between, expected, rtol=1e-12)


def test_a_prediction_has_the_intervals_of_the_analysis_and_its_own_as_before(own, plain):
    condition = own.condition(fill_ratio=0.12, **AT)
    found, before = own.predict(condition), plain.predict(condition)
    content = factors_of()["factors"]
    for name, quantity in (("wall_power_W", "Pw"), ("normal_energy_J", "En"), ("specific_frequency_hz", "f")):
        band, old = getattr(found, name), getattr(before, name)
        assert (band.value, band.lower, band.upper) == (old.value, old.lower, old.upper)
        ends = [band.value * content[quantity][end][1] for end in ("lower", "upper")]
        assert [band.contact.lower, band.contact.upper] == pytest.approx(ends, rel=1e-12)
        assert [band.shape.lower, band.shape.upper] == pytest.approx(ends, rel=1e-12)
        assert old.contact is None and old.shape is None
    ratio = found.tangential_energy_J.value / found.normal_energy_J.value * content["ratio"]["upper"][1]
    assert found.tangential_share.contact.upper == pytest.approx(ratio / (1 + ratio), rel=1e-9)
    assert found.missing == {} and before.missing == dict.fromkeys(FURTHER, "not analysed")


def test_where_an_interval_is_not_known_it_is_none_and_the_reason_is_named(own):
    for fill, unknown in ((0.08, ["shape"]), (0.40, ["contact", "shape"]), (0.11, [])):
        found = own.predict(own.condition(fill_ratio=fill, **AT))
        assert sorted(found.missing) == unknown and found.outside == ()
        for name in BANDS:
            assert sorted(origin for origin in FURTHER if origin not in getattr(found, name).intervals) == unknown
    assert found.missing == {}
    said = own.predict(own.condition(fill_ratio=0.40, **AT)).missing
    assert said["contact"] == "fill_ratio = 0.4: analysed from 0.06 to 0.3"


def test_master_curves_have_the_intervals_too(own, plain):
    fills = np.array([0.05, 0.11, 0.30])
    curve = own.further_curve(own.curve(fills))
    assert list(curve)[: len(plain.curve(fills).columns)] == list(plain.curve(fills))
    lower, upper = (curve[column] for column in columns_of("Pn", "contact"))
    assert np.isnan(lower[0]) and (lower[1:] < curve["Pn"][1:]).all() and (curve["Pn"][1:] < upper[1:]).all()
    band = own.at(0.11)["Pn"]
    assert (lower[1], upper[1]) == pytest.approx((band.contact.lower, band.contact.upper), rel=1e-12)
    assert plain.further_curve(plain.curve(fills)).equals(plain.curve(fills))


def _changed(**changes) -> dict:
    return factors_of() | changes


def test_factors_by_another_counting_rule_tell_of_what_needs_none(about, tmp_path):
    path = tmp_path / "contact.json"
    path.write_text(json.dumps(_changed(counting_rule="lifetimes")))
    found = read_factors(str(path), "contact", about).at(np.array([0.12]))
    assert [name for name, ends in found.items() if np.isnan(ends).any()] == list(COUNTED)
    path.write_text(json.dumps(factors_of()))
    assert not any(
        np.isnan(ends).any() for ends in read_factors(str(path), "contact", about).at(np.array([0.12])).values()
    )


@pytest.mark.parametrize(("content", "message"), refusals("factors_of_something_else_are_refused_in_one_line"))
def test_factors_of_something_else_are_refused_in_one_line(about, tmp_path, content, message):
    path = tmp_path / "contact.json"
    path.write_text(json.dumps(content))
    line = refusal(read_factors, str(path), "contact", about)
    assert message in line and str(path) in line


def test_a_missing_or_broken_file_is_refused_in_one_line(about, tmp_path):
    with pytest.raises(ConfigError, match="no such file; the target `uncertainty` writes it"):
        read_factors(str(tmp_path / "contact.json"), "contact", about)
    (tmp_path / "contact.json").write_text("{")
    with pytest.raises(ConfigError, match="not valid JSON"):
        read_factors(str(tmp_path / "contact.json"), "contact", about)


def test_an_interval_stays_where_it_was_sampled_and_not_where_the_curve_lies(plain, tmp_path):
    """The emulator had half of the curve's power: at the sampled condition the ends are the emulator's own."""
    fills, settings = np.array(FACTOR_FILLS), {"speed_hz": 10.0, "ball_diameter_m": 0.01}
    own = plain.scaled(conditions_of(pd.DataFrame({"fill_ratio": fills} | settings), plain.about))
    values = {name: (0.5 * own[name]).tolist() for name in CURVES}
    sampled = settings | {name: plain.about[name] for name in ("density_kg_m3", "amplitude_m")} | {"values": values}
    write_json(factors_of(sampled=sampled), tmp_path / "contact.json")
    found = Fingerprint.read(_written(plain, tmp_path)).with_factors({"contact": str(tmp_path / "contact.json")})
    condition = found.condition(fill_ratio=FACTOR_FILLS[1], **settings)
    power, known = found.predict(condition).normal_power_W, factors_of()["factors"]["Pn"]
    assert power.contact.lower == pytest.approx(0.5 * power.value * known["lower"][1], rel=1e-9)
    # The curve's own value is of a possible set of parameters: the interval holds it.
    assert 0.5 * power.value * known["upper"][1] < power.value == pytest.approx(power.contact.upper, rel=1e-9)
    with pytest.raises(ConfigError, match=r"sampled.values.f: must have a number for each of fill_ratios"):
        checked_factors(factors_of(sampled=sampled | {"values": values | {"f": [1.0]}}), "contact", plain.about, "x")


def _written(own: Fingerprint, folder: Path) -> Path:
    own.write(folder / "plain.json")
    return folder / "plain.json"


def test_the_parts_of_a_power_respect_the_whole_however_little_is_known_of_their_ratio():
    rng = np.random.default_rng(7)
    places = 400
    told = {
        name: Told(rng.normal(0, spread, places), *(rng.uniform(0, 0.5, places) for _ in range(2)))
        for name, spread in {"P": 1.0, "ratio": 2.0, **dict.fromkeys(("f", "En_star", "Et_star", "f90"), 0.1)}.items()
    }
    table = banded(told, 2.5)
    np.testing.assert_allclose(table["Pn"] + table["Pt"], table["P"], rtol=1e-12)
    for one, other in (("Pn", "Pt"), ("Pt", "Pn")):
        for kind in ("", "_mean"):
            lower, upper = (table[f"{one}{kind}_{end}"] for end in ("lower", "upper"))
            known = lower.notna() & table[f"P{kind}_upper"].notna() & table[f"{other}{kind}_upper"].notna()
            assert known.sum() > 50
            assert (upper <= table[f"P{kind}_upper"] * (1 + 1e-12))[known].all()
            assert (lower + table[f"{other}{kind}_upper"] >= table[f"P{kind}_lower"] * (1 - 1e-12))[known].all()
            assert (upper / lower <= 10 * (1 + 1e-12))[known].all()
