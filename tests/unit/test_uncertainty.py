"""Distributions, samples and intervals by contact parameters; what was done is kept."""

import numpy as np
import pandas as pd
import pytest

from millprint.cases.of_mill import uncertainty_cases, varied_case
from millprint.config.errors import ConfigError, SimulationError
from millprint.config.fingerprint import DISTRIBUTIONS, PARAMETERS, ParametersSection, UncertaintyConfig
from millprint.config.included import load_contact, load_mill
from millprint.config.mill_sweep import MillsConfig
from millprint.config.sweep import DemConfig
from millprint.config.workflow import WorkflowConfig
from millprint.dem.run import simulate
from millprint.fingerprint.bands import read_factors
from millprint.observables.definitions import CURVES
from millprint.run.files import read_table, write_json
from millprint.uncertainty import intervals, samples
from millprint.uncertainty.intervals import fit_emulators, interval_ends, measure, nearest_to
from millprint.uncertainty.samples import (
    check_contact,
    contact_space,
    contact_values,
    design_of,
    run_samples,
    space_of,
    uncertainty_faults,
    variable_of,
)
from tests.conftest import ROOT

EMAX = load_mill("emax")
CONTACTS = {name: load_contact(name) for name in ("calibrated", "steel")}
CALIBRATED = CONTACTS["calibrated"]
MILLS = MillsConfig(contact="calibrated")
RULE = "gap_0_02"


def test_quantiles_are_those_of_closed_forms():
    def quantile(share: float, **keys) -> float:
        section = DISTRIBUTIONS[keys["kind"]](source="a test", **keys)
        return float(variable_of("restitution", section, PARAMETERS["restitution"]).values(np.array([share]))[0])

    assert quantile(0.25, kind="uniform", low=0.2, high=0.6) == pytest.approx(0.3)
    assert quantile(0.5, kind="loguniform", low=0.1, high=0.9) == pytest.approx(0.3)
    assert quantile(0.5, kind="triangular", low=0.2, mode=0.4, high=0.6) == pytest.approx(0.4)
    assert quantile(0.125, kind="triangular", low=0.2, mode=0.4, high=0.6) == pytest.approx(0.3)
    assert quantile(0.5, kind="measured", value=0.5, standard_error=0.1) == pytest.approx(0.5)
    assert quantile(1.0, kind="measured", value=0.5, standard_error=0.3) == 1.0  # no ball gives energy back
    ends = [quantile(share, kind="measured", value=0.5, standard_error=0.1) for share in (0, 1)]
    assert ends == pytest.approx([0.2, 0.8])  # three deviations away
    # The ends of a measured interval are its quantiles, but for the cut at three deviations.
    assert quantile(0.025, kind="measured", lower=0.3, upper=0.4) == pytest.approx(0.3, abs=1e-3)
    assert quantile(0.975, kind="measured", lower=0.3, upper=0.4) == pytest.approx(0.4, abs=1e-3)


def test_the_defaults_hold_both_contact_sets_of_the_thesis():
    space = contact_space(ParametersSection())
    for contact in CONTACTS.values():
        check_contact(space, contact)
    assert all(section.source for _, section in ParametersSection().items())


def test_friction_on_the_wall_is_that_on_balls_unless_the_set_has_its_own():
    assert contact_values(CALIBRATED)["wall_static_friction"] == CALIBRATED.static_friction
    own = CALIBRATED.model_copy(update={"wall_static_friction": 0.5})
    assert contact_values(own)["wall_static_friction"] == 0.5


def test_a_larger_design_begins_with_the_smaller_and_fills_the_space():
    small, large = (design_of(EMAX, UncertaintyConfig(samples=n)) for n in (16, 32))
    pd.testing.assert_frame_equal(small, large.iloc[:16])
    assert large["fill_ratio"].between(0.06, 0.30).all() and large["seed"].is_unique
    # One sample in each sixteenth of the probability of each parameter.
    for variable in contact_space(ParametersSection()).variables:
        parts = np.floor(16 * variable.distribution.cdf(small[variable.name])).astype(int)
        assert sorted(parts) == list(range(16))


def test_nothing_is_extrapolated():
    space = space_of(EMAX, UncertaintyConfig())
    inside = pd.DataFrame([contact_values(CALIBRATED) | {"fill_ratio": 0.1}])
    assert space.places(inside).shape == (1, 6)
    with pytest.raises(ConfigError, match=r"fill_ratio = 0.5: outside the range 0.06 to 0.3"):
        space.places(inside.assign(fill_ratio=0.5))
    with pytest.raises(ConfigError, match=r"rolling_friction = 0.3: outside the range 0.005 to 0.09"):
        space.places(inside.assign(rolling_friction=0.3))


def test_a_contact_set_outside_the_distributions_is_refused_in_one_line():
    stiff = CALIBRATED.model_copy(update={"young_modulus_gpa": 205.0})
    with pytest.raises(ConfigError, match=r"young_modulus_gpa: 1 to 20.5 leaves out 205 of contact set") as error:
        check_contact(space_of(EMAX, UncertaintyConfig()), stiff)
    assert "\n" not in str(error.value)


SHORT = varied_case(EMAX, MILLS, UncertaintyConfig(rayleigh_fraction=0.1)).model_copy(
    update={"settle_s": 0.05, "discard_s": 0.1, "window_s": 0.2}
)


@pytest.mark.slow
def test_a_sample_is_the_simulation_of_its_values():
    samples = pd.DataFrame([{**contact_values(CALIBRATED), "fill_ratio": 0.05, "seed": 3}])
    slippery = samples.assign(static_friction=0.0, wall_static_friction=0.0)
    table = run_samples(SHORT, EMAX, CALIBRATED, DemConfig(), pd.concat([samples, slippery], ignore_index=True), RULE)
    case = SHORT.model_copy(update={"fill_ratio": 0.05, "seed": 3})
    alone = simulate(case, EMAX, CALIBRATED, DemConfig())
    assert table["normal_power_W"][0] == alone["power_W"]["normal"]
    assert table["filled_ratio"][0] == pytest.approx(12 * np.pi / 6 * 1e-6 / 125e-6)
    # Without friction on balls and wall nothing is dissipated by shear.
    assert table["tangential_power_W"][1] < 1e-6 * table["normal_power_W"][1]


def fake_samples(monkeypatch, stop_at: int | None = None) -> list:
    """Replace the simulation by one that only notes its sample; it is interrupted at one of them."""
    seen: list = []

    def describe(case, mill, contact, dem, values, rule) -> dict:
        if len(seen) == stop_at:
            raise KeyboardInterrupt
        seen.append(values)
        return {"Pn": values["restitution"] / 3, "empty": float("nan")}

    monkeypatch.setattr(samples, "_describe", describe)
    return seen


@pytest.mark.parametrize("change", ["settings", "samples", "damage"])
def test_rows_of_other_settings_or_of_a_damaged_file_are_not_used(monkeypatch, tmp_path, change):
    samples, done, case = design_of(EMAX, UncertaintyConfig(samples=8)), tmp_path / "0.done", SHORT
    fake_samples(monkeypatch)
    run_samples(case, EMAX, CALIBRATED, DemConfig(), samples, RULE, done)
    if change == "settings":
        case = case.model_copy(update={"window_s": 0.3})
    elif change == "samples":
        samples = samples.assign(restitution=samples["restitution"] / 2)
    else:
        done.write_bytes(done.read_bytes()[:-1] + b"x")
    seen = fake_samples(monkeypatch)
    run_samples(case, EMAX, CALIBRATED, DemConfig(), samples, RULE, done)
    assert seen == samples.to_dict("records")


def test_an_unknown_column_and_a_failing_sample_are_named():
    samples = pd.DataFrame([{"bounciness": 0.5}])
    with pytest.raises(ValueError, match="bounciness"):
        run_samples(SHORT, EMAX, CALIBRATED, DemConfig(), samples, RULE)
    with pytest.raises(SimulationError, match=r"sample 0 \(fill_ratio = 0.0001\): fill ratio 0.0001"):
        run_samples(SHORT, EMAX, CALIBRATED, DemConfig(), pd.DataFrame([{"fill_ratio": 1e-4}]), RULE)


def test_an_interval_is_widened_to_the_samples_near_its_fill_ratio():
    # The middle between 0.1 and 0.2, by ratio, is 0.141.
    assert nearest_to(0.1, [0.1, 0.2], np.array([0.08, 0.14, 0.142, 0.3])).tolist() == [True, True, False, False]
    moved = np.array([-0.9, 0.6, 0.0, -2.0, 2.0])
    near = np.array([True, True, True, False, False])
    # Of three samples the smallest and the largest stand for the shares 1/4 and 3/4.
    assert interval_ends((-0.5, 0.5), moved, near, 0.5) == pytest.approx((-0.9, 0.6))
    # Halfway between the order statistics: the share 3/8 of (m + 1) = 4 is the 1.5th, and 5/8 the 2.5th.
    assert interval_ends((0.1, 0.1), moved, near, 0.25) == pytest.approx((-0.45, 0.3))
    # The emulator says nothing beyond all samples.
    assert interval_ends((-5, 5), moved, ~near & False, 0.5) == (-2, 2)


def synthetic_samples(settings: UncertaintyConfig) -> pd.DataFrame:
    """Samples of a mill whose every quantity is 5 restitution^-1 fill^0.5."""
    samples = design_of(EMAX, settings)
    value = 5 / samples["restitution"] * samples["fill_ratio"] ** 0.5
    fixed = {"mill": "emax", "contact": "calibrated", "counting_rule": RULE, "balls": 100 * samples["fill_ratio"]}
    fixed |= {"filled_ratio": samples["fill_ratio"], "speed_hz": 10.0, "ball_diameter_m": 0.01}
    fixed |= {"density_kg_m3": 7700.0, "amplitude_m": 0.017}
    quantities = dict.fromkeys(CURVES, value) | {f"{name}_se": 1e-3 * value for name in CURVES}
    return samples.assign(**fixed, **quantities)


def test_what_not_every_mill_has_is_left_out_where_it_is_nought_and_the_rest_is_refused(monkeypatch):
    monkeypatch.setattr(intervals.Emulator, "fit", lambda places, logs, error, seed: logs[0])
    settings = UncertaintyConfig(samples=16)
    samples, space = synthetic_samples(settings), space_of(EMAX, settings)
    assert {*fit_emulators(samples, space, 0)} == {*CURVES}
    assert {*fit_emulators(samples.assign(Pr=0.0), space, 0)} == {*CURVES} - {"Pr"}
    with pytest.raises(ConfigError, match="samples: Pn = 0: must be above 0"):
        fit_emulators(samples.assign(Pn=0.0), space, 0)


@pytest.mark.slow
def test_tables_and_factors_of_a_known_mill(tmp_path):
    settings = UncertaintyConfig(samples=64, base_samples=128, draws=4)
    space = space_of(EMAX, settings)
    samples = synthetic_samples(settings)
    found = measure(samples, space, [0.1, 0.2], CALIBRATED, [CONTACTS["steel"]], settings)
    # Quantiles of 0.30 / e for e uniform between 0.2 and 0.95, or the samples next to the fill ratio if beyond.
    quantiles = 0.30 / (0.2 + 0.75 * np.array([0.975, 0.025]))
    upper_half = samples["fill_ratio"] > np.sqrt(0.1 * 0.2)
    ratios = [0.30 / samples.loc[near, "restitution"] for near in (~upper_half, upper_half)]
    ends = np.array([[min(quantiles[0], near.min()), max(quantiles[1], near.max())] for near in ratios])
    rows = found.intervals[found.intervals["quantity"] == "Pn"]
    assert rows["value"].to_numpy() == pytest.approx(5 / 0.3 * np.sqrt([0.1, 0.2]), rel=0.01)
    assert rows[["lower_factor", "upper_factor"]].to_numpy() == pytest.approx(ends, rel=0.03)
    powers = found.intervals[found.intervals["quantity"] == "normal_power_W"]
    scale = 7700 * 10**3 * 0.017**2 * 0.01**3
    assert powers["value"].to_numpy() == pytest.approx(np.array([10, 20]) * scale * rows["value"].to_numpy())
    indices = found.indices[(found.indices["quantity"] == "f") & (found.indices["fill_ratio"] == 0.2)]
    assert indices.set_index("parameter")["first"].to_dict() == pytest.approx(
        {name: float(name == "restitution") for name in PARAMETERS}, abs=0.05
    )
    assert found.emulator["q2"].min() > 0.999
    # What the runs say, which is also the least scatter: the function itself has none.
    assert found.emulator["run_error"].to_numpy() == pytest.approx(1e-3)
    assert found.emulator["scatter"].to_numpy() == pytest.approx(1e-3, rel=0.05)
    steel = found.sets.set_index(["quantity", "fill_ratio"]).loc[("Pt", 0.1)]
    assert steel["factor"] == pytest.approx(0.30 / 0.68, rel=0.01) and steel["inside"]
    write_json(found.factors.model_dump(mode="json", exclude_none=True), tmp_path / "contact.json")
    about = {"mill": "emax", "contact": "calibrated", "counting_rule": RULE}
    read = read_factors(str(tmp_path / "contact.json"), "contact", about)
    assert read.factors["En"].lower == pytest.approx(ends[:, 0], rel=0.03)
    assert read.parameters["restitution"]["source"] and read.samples == 64


def bistable_samples(settings: UncertaintyConfig) -> pd.DataFrame:
    """Samples of a mill that jumps between two motions where friction is high, which no smooth emulator follows."""
    samples, rng = synthetic_samples(settings), np.random.default_rng(1)
    jump = (samples["static_friction"] > 0.3) & (samples["wall_static_friction"] < 0.5)
    factor = np.where(jump, 2.5, 1.0) * np.exp(0.1 * rng.standard_normal(len(samples)))
    return samples.assign(**{name: samples[name] * factor for name in CURVES})


@pytest.mark.slow
def test_an_interval_holds_its_own_samples_and_lies_where_they_lie(tmp_path):
    """Those of a smooth mill are in the test of its tables."""
    settings = UncertaintyConfig(samples=64, base_samples=64, draws=4)
    fills = [0.06, 0.1, 0.17, 0.3]
    samples = bistable_samples(settings)
    found = measure(samples, space_of(EMAX, settings), fills, CALIBRATED, [], settings)
    write_json(found.factors.model_dump(mode="json", exclude_none=True), tmp_path / "contact.json")
    rows = found.intervals[found.intervals["quantity"] == "Pt"].set_index("fill_ratio")
    for fill, row in rows.iterrows():
        near = samples["Pt"][np.abs(np.log(samples["filled_ratio"] / fill)) < 0.05]
        assert len(near) and near.between(row["lower"] / 1.05, row["upper"] * 1.05).all()
    assert rows["upper"].max() < 1.3 * samples["Pt"].max() and rows["lower"].min() > samples["Pt"].min() / 1.3
    # A fingerprint whose own curve lies elsewhere takes the ends over, and not their ratio to the emulator's value.
    about = {"mill": "emax", "contact": "calibrated", "counting_rule": RULE}
    read = read_factors(str(tmp_path / "contact.json"), "contact", about)
    own = {name: 1.9 * np.array(values) for name, values in read.sampled.values.items()}
    moved = read.onto(own)
    ends = own["Pt"] * moved.at(np.array(fills))["Pt"]
    assert ends[0] == pytest.approx(np.minimum(rows["lower"], own["Pt"]), rel=1e-9)
    assert ends[1] == pytest.approx(np.maximum(rows["upper"], own["Pt"]), rel=1e-9)
    assert moved.sampled is None and moved.onto({}) is moved


@pytest.mark.slow
def test_intervals_of_simulated_samples_hold_them_and_reach_no_further():
    """The first 48 samples of the Emax: 14 to 73 balls of 10 mm at 600 rpm, 0.8 s each."""
    samples = read_table(ROOT / "tests/data/contact_samples.tsv", text=["mill", "contact", "counting_rule"])
    settings, fills = UncertaintyConfig(samples=len(samples), base_samples=32, draws=4), [0.06, 0.1, 0.17, 0.3]
    found = measure(samples, space_of(EMAX, settings), fills, CALIBRATED, [], settings)
    for row in found.intervals[found.intervals["unit"] == "-"].itertuples():
        logs = np.log(samples[row.quantity])
        near = logs[np.abs(np.log(samples["filled_ratio"] / row.fill_ratio)) < 0.1]
        # The emulator's scatter, and what a quantity changes by within a tenth of the fill ratio.
        rounding = 2 * row.scatter + 0.1
        assert near.between(np.log(row.lower) - rounding, np.log(row.upper) + rounding).all(), row
        assert np.log(row.upper) < logs.max() + 0.25 and np.log(row.lower) > logs.min() - 0.25, row
        assert row.lower <= row.value <= row.upper


def test_faults_of_the_whole_run_are_found_before_it():
    content = {"mill": "emax", "dem": {"rayleigh_fraction_max": 0.05}}
    narrow = {"kind": "measured", "value": 0.6, "standard_error": 0.02, "source": "a drop test"}
    content["uncertainty"] = {"mills": ["emax"], "parameters": {"restitution": narrow}}
    config = WorkflowConfig(**content)
    faults = list(uncertainty_faults(config, {"emax": EMAX}, CONTACTS, "my.yaml"))
    assert len(faults) == 2 and all(fault.startswith("my.yaml: uncertainty.") for fault in faults)
    assert "at most 0.05" in faults[0] and "leaves out 0.3 of contact set calibrated" in faults[1]
    cases = uncertainty_cases(config, {"emax": EMAX})
    assert [case.fill_ratio for case in cases] == [0.06, 0.30] and {case.young_modulus_gpa for case in cases} == {20.5}
    assert not list(uncertainty_faults(WorkflowConfig(mill="emax"), {"emax": EMAX}, CONTACTS, "my.yaml"))
