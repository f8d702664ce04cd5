"""Inverse mode: the thesis's 1698 rpm, and conditions that are found again from their own descriptors."""

import json
import math
from pathlib import Path

import numpy as np
import pytest

from millprint.api import read_fingerprint
from millprint.cli.commands import main as millprint
from millprint.config.errors import ConfigError
from millprint.config.fingerprint import MatchConfig
from millprint.estimate.estimates import Estimate, Interval, columns_of, ratio_of
from millprint.fingerprint.bands import checked_factors
from millprint.fingerprint.condition_search import match_targets, rank_conditions, verdict_on
from millprint.fingerprint.descriptors import tabulate_descriptors
from millprint.fingerprint.match_words import match
from millprint.fingerprint.model import Fingerprint
from millprint.observables.condition import Condition
from millprint.observables.definitions import descriptors_of, scaled_quantities
from millprint.run.files import read_table
from millprint.thesis.scaling import invert_speed, nearest_speed
from tests.conftest import PRINTED
from tests.refusals import truths
from tests.unit.factor_samples import factors_of
from tests.unit.synthetic_mill import AMPLITUDE, DENSITY, VOLUME, fingerprint, summaries

CURVES = {name: float(PRINTED[f"3.curve.0.10.{name}"]) for name in ("Pn", "Pt", "f")}
PRINTED_SPEED = float(PRINTED["3.inverse.speed"])
TARGET = {"normal_energy_J": 2.21e-4, "tangential_energy_J": 5.00e-4, "specific_frequency_hz": 400.0}


def at(diameter: float) -> Condition:
    """A condition of the thesis's mill at fill 0.10, at any speed."""
    return Condition(0.10, 1.0, diameter, DENSITY, AMPLITUDE)


def allowed(speeds_rpm, fill_ratios, diameters_mm, ranked=5, **other) -> MatchConfig:
    return MatchConfig(
        targets=[{"name": "target", **TARGET}],
        speeds_rpm=speeds_rpm,
        fill_ratios=fill_ratios,
        ball_diameters_mm=diameters_mm,
        ranked=ranked,
        **other,
    )


@pytest.fixture(scope="module")
def curves() -> Fingerprint:
    return fingerprint()


def target_at(mill: Fingerprint, **condition: float) -> dict[str, float]:
    known = mill.predict(mill.condition(**condition))
    return {name: getattr(known, name).value for name in TARGET}


def test_the_thesis_speed_keeps_the_energies_and_loses_the_frequency():
    table = invert_speed(TARGET, CURVES, at(0.005), VOLUME).set_index("kept")
    assert round(table.loc["normal energy", "speed_rpm"]) == PRINTED_SPEED
    assert table.loc["both energies", "speed_rpm"] == pytest.approx(PRINTED_SPEED, rel=2e-3)
    assert table.loc["both energies", "balls"] == 191
    assert abs(table.loc["both energies", "normal_energy_J_residual_percent"]) < 0.2
    # The specific frequency is that of 600 rpm times 2 sqrt 2: not kept, against the text of Sec. 3.3.4.
    assert table.loc["both energies", "specific_frequency_hz_residual_percent"] == pytest.approx(182.8, abs=0.5)
    assert table.loc["specific frequency", "speed_rpm"] == pytest.approx(600, rel=1e-12)


@pytest.mark.parametrize("kept", ["normal_energy_J", "tangential_energy_J", "specific_frequency_hz"])
def test_a_single_descriptor_is_kept_exactly(kept):
    nearest = nearest_speed(TARGET, CURVES, at(0.007), [kept])
    assert nearest.ball_diameter_m == 0.007
    found = descriptors_of(nearest, scaled_quantities(CURVES))
    assert found[kept] == pytest.approx(TARGET[kept], rel=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize(("speed", "diameter", "fill"), [(10.0, 0.01, 0.10), (18.0, 0.005, 0.17), (12.5, 0.008, 0.06)])
def test_a_condition_is_found_again_from_its_descriptors(curves, speed, diameter, fill):
    target = target_at(curves, speed_hz=speed, ball_diameter_m=diameter, fill_ratio=fill)
    best = rank_conditions(target, [curves], allowed((300, 1980), (0.04, 0.40), (5, 8, 10))).iloc[0]
    assert best["distance"] < 1e-3
    assert best["ball_diameter_mm"] == pytest.approx(diameter * 1e3)
    assert best["fill_ratio"] == pytest.approx(fill, rel=5e-3)
    assert best["speed_rpm"] == pytest.approx(speed * 60, rel=5e-3)


@pytest.mark.slow
def test_shear_shares_are_alike_where_tangential_over_normal_power_is(curves):
    condition = curves.condition(speed_hz=12.0, ball_diameter_m=0.008, fill_ratio=0.12)
    settings = {"speeds_rpm": [300, 1980], "ball_diameters_mm": [8]}
    best = match(curves, condition, curves, descriptors="shear_share", **settings).iloc[0]
    assert best["distance"] < 1e-3 and best["met"] == "weighted_normal_energy_J, tangential_share"
    found = match(curves, condition, curves, descriptors="shear_share", **settings, fill_ratios=[0.3, 0.3]).iloc[0]
    of_found, of_wanted = found["tangential_share"], curves.predict(condition).tangential_share.value
    odds = of_found / (1 - of_found) * (1 - of_wanted) / of_wanted
    assert abs(np.log(odds)) > 0.1 and found["tangential_share_ratio"] == pytest.approx(odds)
    # Nothing but the odds and E*n decides: at the fill ratio that is given the speed is that of the same E*n.
    assert found["weighted_normal_energy_J_ratio"] == pytest.approx(1, rel=1e-2)
    assert found["distance"] == pytest.approx(abs(np.log(odds)) / np.sqrt(2), rel=1e-2)


def test_ranking_stays_in_the_allowed_range_and_is_sorted(curves):
    table = rank_conditions(TARGET, [curves], allowed((480, 540), (0.06, 0.20), (5, 10), ranked=3))
    assert table["speed_rpm"].between(480 - 1e-9, 540 + 1e-9).all()
    assert table["fill_ratio"].between(0.06, 0.20).all()
    assert list(table["rank"]) == list(range(1, len(table) + 1)) and len(table) <= 3
    assert table["distance"].is_monotonic_increasing
    assert np.isfinite(table.filter(like="_ratio").to_numpy()).all()


def test_no_common_fill_ratio_gives_an_empty_ranking(curves):
    table = rank_conditions(TARGET, [curves], allowed((480, 540), (0.5, 0.6), (10,)))
    assert table.empty and "distance" in table


def test_a_target_that_leaves_a_descriptor_open_is_met_in_the_others(curves):
    target = {name: TARGET[name] for name in ("normal_energy_J", "tangential_energy_J")}
    best = rank_conditions(target, [curves], allowed((480, 1200), (0.04, 0.40), (8,))).iloc[0]
    assert best["distance"] < 1e-3 and "specific_frequency_hz_ratio" not in best
    assert best["met"] == "normal_energy_J, tangential_energy_J" and best["verdict"] == "agrees"


@pytest.mark.slow
def test_the_density_of_the_balls_can_be_chosen(curves):
    """Lighter balls of the right density are told from those at hand."""
    light = {"speed_hz": 12.0, "ball_diameter_m": 0.01, "fill_ratio": 0.10, "density_kg_m3": 4000.0}
    known = curves.predict(curves.condition(**light))
    request = allowed((714, 726), (0.099, 0.101), (10,), densities_kg_m3=[3900.0, 4000.0, 7700.0])
    best = rank_conditions(target_at(curves, **light), [curves], request).iloc[0]
    assert best["density_kg_m3"] == 4000.0 and best["outside"] == "nothing"
    assert best["wall_power_W"] == pytest.approx(known.wall_power_W.value, rel=1e-3)


def test_conditions_beyond_the_simulations_are_marked(curves):
    table = rank_conditions(TARGET, [curves], allowed((1500, 1800), (0.06, 0.20), (5, 20)))
    # What was never simulated is neither met nor missed, however narrow or wide the bands.
    assert set(table["verdict"]) == {"open"} and set(table["met"]) == {"nothing"}
    assert table["outside"].str.contains("speed_hz").all()
    assert table.loc[table["ball_diameter_mm"] == 20.0, "outside"].str.contains("ball_diameter_m").all()
    far = curves.condition(speed_hz=60.0, ball_diameter_m=0.01, fill_ratio=0.10)
    table = match(curves, far, curves, ball_diameters_mm=[5])
    assert set(table["outside"]) == {"nothing"} and set(table["verdict"]) == {"open"}


@pytest.fixture(scope="module")
def file(curves, tmp_path_factory) -> str:
    path = tmp_path_factory.mktemp("mill") / "fingerprint_calibrated.json"
    curves.write(path)
    return str(path)


REQUEST = {"speeds_rpm": [300, 1200], "fill_ratios": [0.04, 0.40], "ball_diameters_mm": [5, 8, 10]}


@pytest.mark.slow
def test_the_command_line_finds_a_known_condition(curves, file, tmp_path, capsys):
    target = target_at(curves, speed_hz=15.0, ball_diameter_m=0.008, fill_ratio=0.12)
    *energies, frequency = (f"{target[name]:.10g}" for name in TARGET)
    options = ["--speeds", "300", "1200", "--balls", "5", "8", "10", "--out", str(tmp_path / "ranked.tsv")]
    millprint(["match", file, "--energies", *energies, "--frequency", frequency, *options])
    best = read_table(tmp_path / "ranked.tsv").iloc[0]
    assert best["ball_diameter_mm"] == 8
    assert best["speed_rpm"] == pytest.approx(900, rel=5e-3)
    assert best["fill_ratio"] == pytest.approx(0.12, rel=5e-3)
    printed = capsys.readouterr().out.splitlines()
    assert printed[0].startswith("target: met on emax: balls of 8 mm, fill 0.12, ")
    assert next(line for line in printed if line.startswith("1 ")).split()[:3] == ["1", "8", "0.120"]


@pytest.mark.slow
def test_the_powder_that_gives_the_target_is_chosen(curves):
    """Of two contact sets, the one that the target came from."""
    strong = Fingerprint.fit(tabulate_descriptors(summaries(contacts=("steel",), factor=1.4), "gap_0_03"), VOLUME, 0.95)
    target = target_at(strong, speed_hz=12.0, ball_diameter_m=0.01, fill_ratio=0.10)
    table = rank_conditions(target, [curves, strong], allowed((300, 1200), (0.04, 0.40), (10,)))
    assert table["contact"].iloc[0] == "steel"


@pytest.mark.slow
def test_another_counting_rule_cannot_be_compared(curves, file, tmp_path):
    content = json.loads(Path(file).read_text())
    content["about"]["collision_gap_turns"] = 0.01
    other = tmp_path / "other.json"
    other.write_text(json.dumps(content))
    like = {"fingerprint": str(other), "speed_rpm": 700, "ball_diameter_mm": 10, "fill_ratio": 0.15}
    request = MatchConfig(**REQUEST, targets=[{"name": "other", "like": like}], descriptors="per_collision")
    with pytest.raises(
        ConfigError, match=r"gap of 0\.01 turns, those of emax/calibrated by surface with .* 0\.03 turns"
    ):
        match_targets(request, [curves])
    # Weighted descriptors need no rule.
    best = match_targets(request.model_copy(update={"descriptors": "weighted"}), [curves]).iloc[0]
    assert best["speed_rpm"] == pytest.approx(700, rel=5e-3) and best["fill_ratio"] == pytest.approx(0.15, rel=5e-3)
    assert "normal_energy_J" not in best and "weighted_normal_energy_J" in best


@pytest.fixture(scope="module")
def analysed(curves, tmp_path_factory) -> str:
    """The same fingerprint with the factors of contact parameters, as a file."""
    further = {"contact": checked_factors(factors_of(), "contact", curves.about, "contact.json")}
    path = tmp_path_factory.mktemp("analysed") / "fingerprint.json"
    curves.with_further(further).write(path)
    return str(path)


@pytest.mark.slow
def test_a_match_with_another_mill_has_the_intervals_of_the_ratio(curves, file, analysed, tmp_path, capsys):
    like = {"fingerprint": analysed, "speed_rpm": 700, "ball_diameter_mm": 10, "fill_ratio": 0.12}
    request = MatchConfig(**REQUEST, targets=[{"name": "other", "like": like}], descriptors="per_collision")
    own = Fingerprint.read(analysed)
    best = match_targets(request, [own]).iloc[0]
    of_target = own.predict(own.condition(speed_hz=700 / 60, ball_diameter_m=0.01, fill_ratio=0.12)).normal_energy_J
    name = "normal_energy_J"
    scatter, contact = (Interval(*best[columns_of(name, own)]) for own in ("scatter", "contact"))
    found = Estimate(best[name], "J", scatter=scatter, contact=contact)
    expected = ratio_of(found, of_target)
    assert best[f"{name}_ratio"] == pytest.approx(best[name] / of_target.value)
    assert [best[f"{name}_ratio_lower"], best[f"{name}_ratio_upper"]] == pytest.approx([expected.lower, expected.upper])
    assert best[columns_of(f"{name}_ratio", "contact")].tolist() == pytest.approx(
        [expected.contact.lower, expected.contact.upper]
    )
    # One that was not analysed leaves the ratio's interval by contact parameters open.
    assert not list(match_targets(request, [curves]).filter(like="ratio_by"))


def band(value: float, factor: float) -> Estimate:
    """An estimate with a band of the mean from value / factor to value factor."""
    return Estimate(value, "J", mean=Interval(value / factor, value * factor))


@pytest.mark.parametrize(("value", "factor", "wanted", "room", "word"), truths("verdicts_on_two_bands"))
def test_the_verdict_is_from_the_bands_of_both_mills(value, factor, wanted, room, word):
    found = band(value, factor) if factor else Estimate(value, "J")
    assert verdict_on(ratio_of(found, band(wanted, room)), 30.0).word == word


@pytest.mark.slow
def test_the_words_the_table_and_the_bands_of_a_match_agree(capsys, tmp_path):
    """Pairs of included mills of each verdict, from the middle of what was simulated of each."""
    seen = set()
    for like, mill in (("mixer", "spex"), ("spex", "mixer"), ("spex", "planetary"), ("planetary", "drum")):
        about = read_fingerprint(like).about["ranges"]
        middle = {name: math.sqrt(low * high) for name, (low, high) in about.items()}
        setting = [f"{middle['speed_hz']}Hz", f"{1e3 * middle['ball_diameter_m']}", f"{middle['fill_ratio']}"]
        out = tmp_path / f"{like}_{mill}.tsv"
        millprint(["match", mill, "--like", like, *setting, "--out", str(out), "--hours", "5"])
        printed = capsys.readouterr().out.splitlines()
        rows = read_table(out)
        for name in ("weighted_normal_energy_J", "weighted_tangential_energy_J"):
            low, high = (rows[column] for column in columns_of(f"{name}_ratio", "mean"))
            met = (low >= 1 / 1.3) & (high <= 1.3)
            assert list(met) == [name in each.split(", ") for each in rows["met"]]
        agrees = [each == "weighted_normal_energy_J, weighted_tangential_energy_J" for each in rows["met"]]
        assert agrees == list(rows["verdict"] == "agrees")
        heads = {"agrees": "met on", "open": "not known on", "differs": "not met on"}
        best = rows[rows["verdict"] == "agrees"].head(1) if any(agrees) else rows.head(1)
        seen.add(best["verdict"].iloc[0])
        assert printed[1].startswith(f"as_{like}: {heads[best['verdict'].iloc[0]]} {mill}")
        (time,) = [line for line in printed if line.startswith("5 h there is ")]
        assert float(time.split()[4]) == pytest.approx(5 * best["time_ratio"].iloc[0], rel=1e-2)
        table = printed[-len(rows) - 1 :]
        assert table[0].split()[0] == "#" and max(map(len, table)) <= 120
    assert seen == set(heads)


def test_time_makes_up_for_power(curves):
    """The same mill at another fill: the same dose takes the longer, the less power a kilogram of balls has."""
    at = [curves.condition(speed_hz=15.0, ball_diameter_m=0.01, fill_ratio=fill) for fill in (0.10, 0.20)]
    keys = {"fill_ratios": [0.1999, 0.2001], "speeds_rpm": [900, 900.1], "ball_diameters_mm": [10]}
    row = match(curves, at[0], curves, **keys).iloc[0]
    found = [curves.predict(each) for each in at]
    per_ball = [each.wall_power_W.value / each.balls for each in found]
    assert row["time_ratio"] == pytest.approx(per_ball[0] / per_ball[1], rel=1e-2)
    assert row["time_ratio_mean_lower"] < row["time_ratio"] < row["time_ratio_mean_upper"]


def test_what_is_held_dear_is_met_first(curves):
    target = target_at(curves, speed_hz=15.0, ball_diameter_m=0.01, fill_ratio=0.12)
    target |= {"tangential_energy_J": 3 * target["tangential_energy_J"]}
    request = allowed((300, 1200), (0.04, 0.40), (10,))
    alike, first = (
        rank_conditions(target, [curves], request.model_copy(update={"first": name})).iloc[0]
        for name in (None, "normal_energy_J")
    )
    away = [abs(math.log(row["normal_energy_J_ratio"])) for row in (alike, first)]
    assert away[1] < 0.2 * away[0]
    with pytest.raises(ConfigError, match="first = weighted_normal_energy_J: must be one of normal_energy_J"):
        rank_conditions(target, [curves], request.model_copy(update={"first": "weighted_normal_energy_J"}))
