"""The fingerprint as an object: curves with bands, predictions, ranges, its file, coverage and zones."""

import json
import pickle

import numpy as np
import pandas as pd
import pytest

from millprint.api import plot, predict
from millprint.config.errors import ConfigError
from millprint.estimate.estimates import Estimate
from millprint.fingerprint.coverage import tabulate_coverage
from millprint.fingerprint.descriptors import tabulate_descriptors
from millprint.fingerprint.mill_collapse import find_zones
from millprint.fingerprint.model import Fingerprint
from millprint.fingerprint.processes import varied_components
from millprint.observables.condition import Condition
from millprint.observables.definitions import CURVES, DESCRIPTOR_SETS, POWER_PARTS
from tests.refusals import refusal, refusals
from tests.unit.synthetic_mill import (
    AMPLITUDE,
    DENSITY,
    FILLS,
    VOLUME,
    descriptors,
    fingerprint,
    overrides,
    summaries,
    summary,
    true_curves,
)

AT = {"fill_ratio": 0.10, "ball_diameter_m": 0.01, "speed_hz": 10.0}


def scattered(seed: int, size: float = 0.05) -> pd.DataFrame:
    """Conditions whose powers scatter by chance, with next to no error of their own."""
    generator = np.random.default_rng(seed)
    runs = [
        summary(fill, diameter, speed, noise=size * generator.standard_normal(), error=1e-3)
        for fill in FILLS
        for diameter in (5.0, 10.0)
        for speed in (600.0, 1200.0)
    ]
    return tabulate_descriptors(runs, "gap_0_03")


def at(mill: Fingerprint, speed_hz: float, ball_diameter_m: float, fill_ratio: float, **other: float) -> Condition:
    return mill.condition(speed_hz=speed_hz, ball_diameter_m=ball_diameter_m, fill_ratio=fill_ratio, **other)


@pytest.fixture(scope="module")
def exact() -> pd.DataFrame:
    return descriptors()


@pytest.fixture(scope="module")
def own() -> Fingerprint:
    return fingerprint()


@pytest.fixture(scope="module")
def noisy() -> Fingerprint:
    return Fingerprint.fit(scattered(2), VOLUME, 0.95)


def test_the_curve_passes_through_an_exact_mill(own):
    table = own.curve(np.geomspace(0.04, 0.40, 60))
    for name, curve in zip(("Pn", "Pt", "f"), true_curves(table["fill_ratio"]), strict=True):
        np.testing.assert_allclose(table[name], curve, rtol=0.02)
    for name in CURVES:
        assert (table[f"{name}_lower"] < table[name]).all() and (table[name] < table[f"{name}_upper"]).all()
    np.testing.assert_allclose(table["ratio"], table["Pt"] / table["Pn"], rtol=1e-12)


@pytest.mark.slow
def test_the_band_holds_the_stated_fraction_of_new_conditions(noisy):
    new = scattered(3)
    band = noisy.curve(new["fill_ratio"].to_numpy())
    held = (band["Pn_lower"] < new["Pn"]) & (new["Pn"] < band["Pn_upper"])
    assert 0.85 <= held.mean() <= 1.0
    # Two standard deviations of 5 % on either side, and not much more.
    assert 1.15 < np.median(band["Pn_upper"] / band["Pn_lower"]) < 1.45


def test_the_band_holds_the_stated_fraction_of_left_out_conditions(noisy):
    table = tabulate_coverage(noisy).set_index(["left_out", "quantity"])
    for quantity in ("Pn", "Pt"):
        row = table.loc[("condition", quantity)]
        assert row["conditions"] == 36 and row["nominal"] == 0.95
        assert row["covered_lower"] <= 0.95 <= row["covered_upper"]
        assert 4.0 < row["error_percent"] < 7.0
    assert set(table.index.get_level_values(0)) == {"condition", "fill ratio", "setting"}


def test_a_band_that_is_too_narrow_is_found_out(noisy):
    """The check of the bands must be able to fail: with a tenth of the noise they hold too little."""
    processes = {
        name: type(process)(**{**vars(process), "noise": process.noise / 100, "stretch": 0.3})
        for name, process in noisy.processes.items()
    }
    row = tabulate_coverage(Fingerprint(noisy.about, processes)).set_index(["left_out", "quantity"])
    assert row.loc[("condition", "Pn")]["covered_upper"] < 0.95


def test_predictions_return_the_simulated_conditions(exact, own):
    for row in exact.itertuples():
        found = own.predict(at(own, row.speed_hz, row.ball_diameter_m, row.fill_ratio))
        assert found.outside == ()
        assert found.balls == row.balls
        assert found.normal_energy_J.value == pytest.approx(row.normal_energy_J, rel=0.02)
        assert found.specific_frequency_hz.value == pytest.approx(row.specific_frequency_hz, rel=0.02)
        parts = [found.known[name] for name in POWER_PARTS]
        for name in ("scatter", "mean"):
            low, high = found.wall_power_W.ends(name)
            assert low < row.wall_power_W < high and all(part.ends(name)[1] < high for part in parts)
        assert sum(part.value for part in parts) == pytest.approx(found.wall_power_W.value, rel=1e-12)


def test_energies_times_frequency_are_the_power_without_rolling(own):
    found = own.predict(at(own, 13.14, 0.01, 0.06))
    energies = found.normal_energy_J.value + found.tangential_energy_J.value
    power = found.wall_power_W.value - found.rolling_power_W.value
    assert found.balls * found.specific_frequency_hz.value * energies == pytest.approx(power, rel=1e-9)


def test_predictions_of_an_exact_mill_scale_as_the_equations_say(own):
    base, fast = own.predict(at(own, 10.0, 0.01, 0.10)), own.predict(at(own, 20.0, 0.01, 0.10))
    assert fast.wall_power_W.value == pytest.approx(8 * base.wall_power_W.value, rel=5e-3)
    assert fast.normal_energy_J.value == pytest.approx(4 * base.normal_energy_J.value, rel=5e-3)
    half = own.predict(at(own, 10.0, 0.005, 0.10))
    assert half.tangential_energy_J.value == pytest.approx(base.tangential_energy_J.value / 8, rel=5e-3)
    far = own.predict(at(own, 10.0, 0.01, 0.10, density_kg_m3=2 * DENSITY, amplitude_m=1.4 * AMPLITUDE))
    assert far.wall_power_W.value == pytest.approx(2 * 1.4**2 * base.wall_power_W.value, rel=5e-3)


@pytest.mark.slow
def test_a_departure_from_the_scaling_is_learned():
    """A mill whose scaled frequency falls with omega^-0.3: predicted at a speed that was not simulated."""
    runs = summaries(speeds=(600.0, 800.0, 1200.0), error=2e-3)
    for run in runs:
        for counted in run["collisions"]:
            counted["frequency_hz"] *= (run["frequency_hz"] / 10.0) ** -0.3
    model = Fingerprint.fit(tabulate_descriptors(runs, "gap_0_03"), VOLUME, 0.95)
    found = model.predict(at(model, 1000.0 / 60.0, 0.01, 0.12)).specific_frequency_hz
    true = true_curves(0.12)[2] * (1000.0 / 60.0) * (1000.0 / 600.0) ** -0.3
    assert found.value == pytest.approx(true, rel=0.01)
    assert found.lower < true < found.upper and found.upper / found.lower < 1.1
    # The curve over all speeds cannot know the speed, and says so by its band.
    band = model.at(0.12)["f"]
    assert band.upper / band.lower > 1.3


def test_the_band_widens_away_from_what_was_simulated(noisy):
    near, far = (noisy.predict(at(noisy, speed, 0.01, 0.11)).wall_power_W for speed in (10.0, 60.0))
    assert far.upper / far.lower >= near.upper / near.lower


def test_what_lies_outside_is_named_or_refused(own):
    assert own.predict(at(own, 20.0, 0.005, 0.40, density_kg_m3=3900.0, amplitude_m=0.024)).outside == ()
    assert set(own.predict(at(own, 30.0, 0.02, 0.10, amplitude_m=0.03)).outside) == {
        "speed_hz",
        "ball_diameter_m",
        "amplitude_m",
    }
    assert own.predict(at(own, 10.0, 0.01, 0.5)).outside == ("fill_ratio",)
    assert own.predict(at(own, 10.0, 0.01, 0.10), volume_m3=2 * VOLUME).outside == ("volume_m3",)
    with pytest.raises(ConfigError, match=r"fill_ratio = 0\.5.*0\.04 to 0\.4"):
        own.at(0.5)
    for wrong in ({"fill_ratio": 1.0}, {"speed_hz": 0.0}, {"ball_diameter_m": -0.01}):
        with pytest.raises(ConfigError, match=f"{next(iter(wrong))} = .*must be .*over 0"):
            own.predict(own.condition(**(AT | wrong)))


@pytest.mark.parametrize(("end", "same", "another"), [(0.04, 0.0399, 0.037), (0.40, 0.40002, 0.405)])
def test_as_many_balls_as_at_an_end_of_the_simulated_fills_are_that_end(own, end, same, another):
    exact, found, beyond = (own.predict(at(own, 10.0, 0.01, fill)) for fill in (end, same, another))
    assert found.outside == () and found.known == exact.known and found.balls == exact.balls
    assert beyond.outside == ("fill_ratio",) and beyond.balls != exact.balls
    table = own.predict(pd.DataFrame({"fill_ratio": [same], "ball_diameter_mm": [10.0], "speed_hz": [10.0]}))
    assert table["outside"].tolist() == [""]
    assert table["wall_power_W"].iloc[0] == pytest.approx(exact.wall_power_W.value)


@pytest.mark.slow
def test_amplitude_and_density_are_ranged_only_if_they_were_varied(exact):
    assert set(varied_components(exact)) == {"fill", "machine"}
    model = Fingerprint.fit(exact, VOLUME, 0.95)
    assert model.predict(at(model, 10.0, 0.01, 0.10, amplitude_m=0.02)).outside == ("amplitude_m",)
    both = tabulate_descriptors(summaries() + overrides(), "gap_0_03")
    assert set(varied_components(both)) == {"fill", "machine", "amplitude", "density"}
    alone = tabulate_descriptors(summaries(diameters=(10.0,), speeds=(600.0,)), "gap_0_03")
    assert varied_components(alone) == {"fill": ["fill_ratio"]}


def test_the_file_gives_the_same_object_back_and_is_no_pickle(own, tmp_path):
    path = tmp_path / "fingerprint_calibrated.json"
    own.write(path)
    content = json.loads(path.read_text())
    assert content["about"]["ranges"]["amplitude_m"] == pytest.approx([0.014, 0.024])
    with pytest.raises(pickle.UnpicklingError):
        pickle.loads(path.read_bytes())
    again = Fingerprint.read(path)
    for name, one in vars(own.predict(at(own, 12.0, 0.008, 0.13))).items():
        other = getattr(again.predict(at(again, 12.0, 0.008, 0.13)), name)
        if isinstance(one, Estimate):
            assert (other.value, *other.ends("scatter")) == pytest.approx((one.value, one.lower, one.upper), rel=1e-9)
        else:
            assert other == one


@pytest.mark.parametrize(("text", "message"), refusals("another_file_is_refused_in_one_line"))
def test_another_file_is_refused_in_one_line(tmp_path, text, message):
    path = tmp_path / "other.json"
    if text is not None:
        path.write_text(text)
    line = refusal(Fingerprint.read, path)
    assert message in line and str(path) in line


def test_too_few_fills_and_a_mill_without_any_power_are_refused(exact):
    with pytest.raises(ConfigError, match="2 fill ratios"):
        Fingerprint.fit(exact[exact["fill_ratio"].isin([0.04, 0.10])], VOLUME, 0.95)
    with pytest.raises(ConfigError, match="nothing is dissipated"):
        Fingerprint.fit(exact.assign(P=0.0), VOLUME, 0.95)


def test_what_has_no_curve_is_left_out_by_name_and_all_else_is_predicted(exact, tmp_path):
    """Balls that bounce straight up have no shear."""
    shear = ["Pt", "ratio", "Et", "Et_star", "ft_star"]
    straight = exact["fill_ratio"] == exact["fill_ratio"].min()
    table = exact.assign(**{name: exact[name].where(~straight, 0.0) for name in shear})
    Fingerprint.fit(table, VOLUME, 0.95).write(tmp_path / "fingerprint.json")
    found = Fingerprint.read(tmp_path / "fingerprint.json")
    assert set(found.about["no_curve"]) == set(shear)
    assert f"{straight.sum()} of {len(exact)} conditions" in found.about["no_curve"]["Pt"]
    told = found.predict(at(found, 15.0, 0.01, 0.11))
    whole = Fingerprint.fit(exact, VOLUME, 0.95).predict(at(found, 15.0, 0.01, 0.11))
    for name in ("wall_power_W", "normal_power_W", "weighted_normal_energy_J", "specific_frequency_hz"):
        assert getattr(told, name).value == pytest.approx(getattr(whole, name).value, rel=0.02)
    assert np.isnan([told.tangential_power_W.value, told.weighted_tangential_energy_J.upper]).all()
    with pytest.raises(ConfigError, match="weighted_tangential_energy_J has no curve"):
        found.check_known(DESCRIPTOR_SETS["weighted"])


@pytest.mark.parametrize(
    ("part", "key", "value"),
    [
        ("processes.P", "seeds", [None] * 16), ("processes.P", "values", [1.0]), ("processes.P", "sampling", [1.0]),
        ("processes.P", "components", {}), ("about", "volume_m3", None), ("about", "settings", {}),
        ("about", "density_kg_m3", "steel"), ("inputs", "fill_ratio", [0.0]),
    ],
)  # fmt: skip
def test_a_damaged_fingerprint_is_refused_in_one_line(own, tmp_path, part, key, value):
    own.write(tmp_path / "whole.json")
    content = json.loads((tmp_path / "whole.json").read_text())
    place = content
    for name in part.split("."):
        place = place[name]
    place[key] = value
    (tmp_path / "damaged.json").write_text(json.dumps(content))
    assert "damaged.json: not a whole fingerprint: " in refusal(Fingerprint.read, tmp_path / "damaged.json")


def test_zones_of_a_known_mill_lie_in_their_intervals(noisy):
    zones = find_zones(noisy).set_index("zone")
    maximum = zones.loc["normal_maximum"]
    assert maximum["lower"] <= 0.15 <= maximum["upper"]
    assert maximum["upper"] - maximum["lower"] > 0.005
    assert zones.loc["tangential_maximum", "value"] == pytest.approx(0.04)
    assert (zones["lower"] <= zones["upper"]).all() and (zones["found"] > 0.9).all()
    assert (zones["smallest"] <= zones["largest"]).all()


def test_a_sweep_of_random_conditions_is_predicted_as_each_alone(own):
    rng = np.random.default_rng(3)
    volume_ml = 1e6 * own.about["volume_m3"]
    table = pd.DataFrame({"speed_rpm": rng.uniform(200, 2000, 20), "ball_diameter_mm": rng.uniform(2, 20, 20)})
    table["mass_g"] = rng.uniform(0.01, 0.5, 20) * volume_ml * own.about["density_kg_m3"] * 1e-3
    found = predict(own, table.set_index(np.arange(40, 60)))
    assert list(found.index) == list(range(40, 60))
    for row, told in zip(table.to_dict("records"), found.to_dict("records"), strict=True):
        one = predict(own, row)
        assert told["balls"] == one.balls and told["outside"] == ", ".join(one.outside)
        for name in ("weighted_normal_energy_J", "specific_frequency_hz", "wall_power_W", "tangential_share"):
            band = getattr(one, name)
            ends = [told[name], told[f"{name}_lower"], told[f"{name}_upper"]]
            assert ends == pytest.approx([band.value, band.lower, band.upper], rel=1e-9, nan_ok=True)


AS_A_SWEEP = {"speed_rpm": 600, "ball_diameter_mm": 10, "fill_ratio": 0.2}


@pytest.mark.parametrize(("changes", "part"), refusals("a_condition_that_cannot_be_is_one_line"))
def test_a_condition_that_cannot_be_is_one_line(own, changes, part):
    row = AS_A_SWEEP | changes
    for given in (row, pd.DataFrame([row])):
        with pytest.raises(ConfigError, match=part):
            predict(own, given)


@pytest.mark.parametrize(
    ("ask", "part"),
    [
        (lambda own: predict(own, None), "conditions = None: must be a table, or a mapping such as"),
        (lambda own: own.predict(400), "condition = 400: must be a Condition"),
        (lambda own: predict(own, pd.DataFrame([[9, 9]], columns=["speed_rpm"] * 2)), "speed_rpm appears twice"),
        (lambda own: predict(own, AS_A_SWEEP | {"speed_rpm": 10}), "another unit? Write 600"),
        (lambda own: predict(own, AS_A_SWEEP | {"ball_diameter_mm": 0.01}), "another unit? Write 10"),
        (lambda own: own.condition(**AS_A_SWEEP, colour=3), "condition: colour = 3: unknown key"),
        (
            lambda own: own.condition(**AS_A_SWEEP | {"fill_ratio": 20}),
            "condition: fill_ratio = 20: must be a",
        ),
        (lambda own: own.condition(speed_rpm=10, ball_diameter_mm=10, number=9), "speed_rpm = 10: "),
        (lambda own: own.condition(speed_rpm=600, ball_diameter_mm=0.01, number=9), "another unit? Write 10"),
        (lambda own: predict(own, {"speed_rpm": 600, "ball_diameter_mm": 10, "number": 2.5}), "must be a whole number"),
        (lambda own: plot(own, ["Pm"]), "quantities: Pm is none of them"),
    ],
)
def test_what_is_no_condition_is_one_line(own, ask, part):
    assert part in refusal(ask, own)


def test_a_condition_has_one_speed_and_a_fingerprint_says_what_it_is_of(own):
    for speeds in ({}, {"speed_hz": 8.0, "speed_rpm": 480.0}):
        with pytest.raises(ConfigError, match="give one of speed_rpm, speed_hz"):
            own.condition(ball_diameter_m=0.01, fill_ratio=0.2, **speeds)
    assert repr(own).startswith(f"<Fingerprint of {own.about['mill']} with contact set ")
