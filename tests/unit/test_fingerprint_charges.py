"""A fingerprint of a charge of several ball sizes: apart from balls of one size in tables, intervals and sheets."""

from functools import cache

import pytest

from millprint.cases.of_mill import WAYS, enlarged, large_case
from millprint.config.charge import BallMixture, mixture_of
from millprint.config.checks import load_workflow
from millprint.config.errors import ConfigError
from millprint.config.fingerprint import MatchConfig, SearchConfig, TargetConfig
from millprint.config.included import load_mill
from millprint.config.mill_sweep import MillsConfig, ScaleUpConfig
from millprint.config.sweep import ball_count
from millprint.fingerprint.condition_search import match_targets, target_of
from millprint.fingerprint.descriptors import read_descriptors, tabulate_descriptors
from millprint.fingerprint.mill_collapse import tabulate_mill_collapse, tabulate_scale_up
from millprint.fingerprint.model import Fingerprint
from millprint.fingerprint.readers import charges_of
from millprint.observables.definitions import DESCRIPTOR_SETS, TARGET_DESCRIPTORS
from millprint.run.files import write_table
from millprint.thesis.scaling import fit_exponents, tabulate_counting_rules
from tests.refusals import refusal, refusals
from tests.unit.synthetic_mill import FILLS, VOLUME, summaries, summary

pytestmark = pytest.mark.usefixtures("close_figures")
THREE = BallMixture(name="three", sizes_mm=(12, 10, 6), numbers=(1, 1, 2))
MEAN_M = THREE.mean_diameter_mm / 1e3


def charged(speeds=(600.0, 1200.0), fills=FILLS) -> list[dict]:
    """Runs of only the charge."""
    return [summary(fill, speed_rpm=speed, mixture=THREE, error=0.002) for fill in fills for speed in speeds]


def fitted(runs: list[dict]) -> Fingerprint:
    return Fingerprint.fit(tabulate_descriptors(runs, "gap_0_03"), VOLUME, 0.95, charges_of(runs))


@cache
def one_size() -> Fingerprint:
    """A fingerprint of balls of 10 mm and of 5 mm, without the charge."""
    return fitted(summaries(error=0.002))


@cache
def charge_alone() -> Fingerprint:
    """A fingerprint of the charge, without balls of one size."""
    return fitted(charged())


@pytest.fixture(scope="module")
def both() -> Fingerprint:
    """Balls of 10 and 5 mm, and the charge."""
    return fitted(summaries(error=0.002) + charged())


def outside(fingerprint: Fingerprint, diameter_m: float, charge: str = "") -> tuple[str, ...]:
    condition = fingerprint.condition(speed_hz=12, ball_diameter_m=diameter_m, fill_ratio=0.1)
    return fingerprint.predict(condition, charge=charge).outside


def test_a_table_names_the_charge(tmp_path):
    table = tabulate_descriptors(summaries() + charged(), "gap_0_03")
    assert table.groupby("charge").size().to_dict() == {"": 4 * len(FILLS), "three": 2 * len(FILLS)}
    write_table(table, tmp_path / "descriptors.tsv")
    assert read_descriptors(tmp_path / "descriptors.tsv")["charge"].tolist() == table["charge"].tolist()
    # Without a restitution there is a table; without a power there is none.
    write_table(table.assign(restitution=None), tmp_path / "descriptors.tsv")
    assert read_descriptors(tmp_path / "descriptors.tsv")["restitution"].isna().all()
    write_table(table.assign(normal_power_W=None), tmp_path / "descriptors.tsv")
    with pytest.raises(ConfigError, match="normal_power_W"):
        read_descriptors(tmp_path / "descriptors.tsv")


@pytest.mark.slow
def test_a_prediction_for_other_balls_says_so(both):
    alone = charge_alone()
    assert outside(alone, MEAN_M, "three") == ()
    assert outside(alone, MEAN_M) == ("charge",)
    assert outside(one_size(), MEAN_M, "three") == ("charge",)
    assert outside(both, MEAN_M, "three") == () and outside(both, 0.007) == ()
    assert outside(both, 0.007, "three") == ("ball_diameter_m",)
    assert outside(both, MEAN_M, "four") == ("charge",)


@pytest.mark.slow
def test_a_charge_is_no_other_size_of_balls():
    """A charge with twice the power changes no exponent of the ball size."""
    runs, odd = (
        summaries(),
        [summary(fill, speed_rpm=s, mixture=THREE, factor=2.0) for fill in FILLS for s in (600, 1200)],
    )
    found = {}
    for name, chosen in {"alone": runs, "both": runs + odd}.items():
        table = fit_exponents(tabulate_descriptors(chosen, "gap_0_03"), tabulate_counting_rules(chosen), 0.95)
        own = table[(table["quantity"] == "power_per_ball_W") & (table["variable"] == "d")].iloc[0]
        collapse = tabulate_mill_collapse(tabulate_descriptors(chosen, "gap_0_03"), 0.95).iloc[0]
        found[name] = [own["exponent"], collapse["d"], collapse["omega"]]
    assert found["both"] == pytest.approx(found["alone"], rel=1e-9)


TWICE = BallMixture(name="twice", sizes_mm=(14, 8), numbers=(1, 3))
REQUEST = {"speeds_rpm": [600, 1200], "fill_ratios": [0.04, 0.40]}


@pytest.fixture(scope="module")
def unlike() -> Fingerprint:
    """Balls of one size, and two charges of which each dissipates more than the scaling has it: 1.5 and 3 times."""
    odd = {THREE: 1.5, TWICE: 3.0}
    return fitted(
        summaries(error=0.002)
        + [
            summary(fill, speed_rpm=speed, mixture=charge, factor=factor, error=0.002)
            for charge, factor in odd.items()
            for fill in FILLS[::2]
            for speed in (600.0, 1200.0)
        ]
    )


def described(fingerprint: Fingerprint, choice: float | str, **condition: float) -> dict[str, float]:
    diameter, charge = fingerprint.balls(choice)
    found = fingerprint.predict(fingerprint.condition(ball_diameter_m=diameter, **condition), charge=charge)
    return {name: getattr(found, name).value for name in TARGET_DESCRIPTORS} | {
        "wall_power_W": found.wall_power_W.value
    }


@pytest.mark.slow
def test_each_charge_keeps_what_is_its_own(unlike):
    """Departures of one charge are not carried to another, nor to balls of one size as large as its mean ball."""
    for choice, factor in ((10.0, 1.0), ("three", 1.5), ("twice", 3.0)):
        diameter, _ = unlike.balls(choice)
        known = summary(0.12, 1e3 * diameter, 900.0, factor=factor)["power_W"]
        balls = ball_count(0.12, VOLUME, diameter)
        power = described(unlike, choice, speed_hz=15.0, fill_ratio=0.12)["wall_power_W"]
        assert power / balls == pytest.approx(known["wall"] / balls, rel=0.03)
    mean_ball = unlike.condition(speed_hz=15.0, ball_diameter_m=unlike.charge_diameter_m("twice"), fill_ratio=0.12)
    alike = one_size().predict(mean_ball).wall_power_W.value
    assert unlike.predict(mean_ball).wall_power_W.value == pytest.approx(alike, rel=0.05)


def test_a_file_keeps_charges_apart(unlike, tmp_path):
    unlike.write(tmp_path / "fingerprint.json")
    again = Fingerprint.read(tmp_path / "fingerprint.json")
    assert again.kinds == ["", "three", "twice"] and again.choices() == [5.0, 10.0, "three", "twice"]
    condition = {"speed_hz": 15.0, "fill_ratio": 0.12}
    for choice in again.choices():
        # The file holds the values; their logarithms are the same to the last but one bit.
        assert described(again, choice, **condition) == pytest.approx(described(unlike, choice, **condition), rel=1e-9)


@pytest.mark.slow
def test_a_charge_is_found_again_from_its_descriptors(unlike):
    target = described(unlike, "twice", speed_hz=14.0, fill_ratio=0.12)
    target.pop("wall_power_W")
    request = MatchConfig(**REQUEST, targets=[{"name": "own", **target}], ball_diameters_mm=[5, 10, "three", "twice"])
    best = match_targets(request, [unlike]).iloc[0]
    assert best["charge"] == "twice" and best["distance"] < 1e-3 and best["outside"] == "nothing"
    assert best["ball_diameter_mm"] == pytest.approx(TWICE.mean_diameter_mm)
    assert best["speed_rpm"] == pytest.approx(840, rel=5e-3) and best["fill_ratio"] == pytest.approx(0.12, rel=5e-3)


@pytest.mark.slow
def test_a_charge_of_another_mill_can_be_the_target(unlike, tmp_path):
    unlike.write(tmp_path / "other.json")
    like = {
        "fingerprint": str(tmp_path / "other.json"),
        "speed_rpm": 800,
        "ball_diameter_mm": "three",
        "fill_ratio": 0.1,
    }
    # The charge of one mill, with balls of one size in the other, which has no charge.
    mill, target = one_size(), TargetConfig(name="other", like=like)
    request = MatchConfig(**REQUEST, targets=[target], ball_diameters_mm=[5, 8, 10])
    table = match_targets(request, [mill])
    assert "charge" not in table and len(table)
    for chosen, names in DESCRIPTOR_SETS.items():
        wanted = target_of(target, [mill], SearchConfig(descriptors=chosen)).wanted
        assert {name: each.value for name, each in wanted.items()} == {
            name: pytest.approx(value)
            for name, value in described(unlike, "three", speed_hz=800 / 60, fill_ratio=0.1).items()
            if name in names
        }


@pytest.mark.slow
def test_balls_of_which_nothing_is_known_are_refused_in_one_line(unlike):
    alone = charge_alone()
    for mill, choice, words in (
        (alone, 10.0, "balls of 10 mm: emax was only simulated with charges of several sizes"),
        (alone, "graded", "charge = graded: the fingerprint of emax has three"),
        (one_size(), "three", "charge = three: the fingerprint of emax is of balls of one size"),
    ):
        request = MatchConfig(
            **REQUEST, targets=[{"name": "a", "specific_frequency_hz": 400}], ball_diameters_mm=[choice]
        )
        with pytest.raises(ConfigError, match=words):
            match_targets(request, [mill])
    # What one of two mills knows is asked of that one.
    request = MatchConfig(
        **REQUEST, targets=[{"name": "a", "specific_frequency_hz": 400}], ball_diameters_mm=[8, "three"]
    )
    table = match_targets(request.model_copy(update={"ranked": 100}), [alone, one_size()])
    assert set(zip(table["charge"], table["ball_diameter_mm"].round(3), strict=True)) == {
        ("", 8.0),
        ("three", round(THREE.mean_diameter_mm, 3)),
    }


def test_a_charge_grows_as_a_whole(unlike):
    """By similarity every size grows alike, and so every scaled number stays."""
    plan = ScaleUpConfig(
        mill="emax", volume_l=8 * VOLUME * 1e3, ball_diameter_mm="twice", fill_ratio=0.1, speed_rpm=600
    )
    table = tabulate_scale_up(unlike, 2.0, plan, 2e-6, 40.0).set_index("way")
    assert (table["charge"] == "twice").all()
    assert table["sizes_mm"].to_dict() == {way.name: "28, 16" if way.balls_grow else "14, 8" for way in WAYS}
    assert table.loc["similar", "ball_diameter_mm"] == pytest.approx(2 * TWICE.mean_diameter_mm)
    assert table.loc["similar", "balls"] == pytest.approx(table.loc["energy", "balls"] / 8, abs=0.5)
    assert "charge" not in table["outside"].to_string()
    number = tabulate_scale_up(unlike, 2.0, plan.model_copy(update={"ball_diameter_mm": 10.0}), 2e-6, 40.0)
    assert "charge" not in number and "sizes_mm" not in number


def test_the_large_run_has_the_charge_of_the_small_mill():
    small = load_mill("bond_mill")
    plan = {"mill": "bond_mill", "volume_l": 40, "ball_diameter_mm": "bond", "fill_ratio": 0.1, "speed_rpm": 70}
    settings = MillsConfig(contact="steel", scale_up=plan)
    large, factor = enlarged(small, 40, "large")
    case = large_case(small, large, factor, settings)
    assert case.mixture == mixture_of(small.sweep.ball_diameters_mm[0])
    assert case.name.startswith("bond_f0.10_")


@pytest.mark.parametrize(("key", "section", "words"), refusals("a_charge_that_no_sweep_has_is_refused_before_a_run"))
def test_a_charge_that_no_sweep_has_is_refused_before_a_run(key, section, words):
    like = {"mill": "bond_mill", "speed_rpm": 70, "ball_diameter_mm": "bond", "fill_ratio": 0.2}
    match = {"mill": "spex", "like": like | section.pop("like", {})} | section
    content = {"name": "x", "mill": "spex", "contacts": ["steel"], "mills": {"box": ["spex"], "match": match}}
    line = refusal(load_workflow, content, [])
    assert line.startswith(f"configuration: mills.{key} = ") and words in line
