"""The search for settings of any mill that do what a condition of another does, and `millprint match --any`."""

import re

import numpy as np
import pytest

from millprint.atlas.design import design
from millprint.atlas.estimate_mill import check, estimate, is_known
from millprint.atlas.kinds import DRUM, KINDS, MIXER, PLANETARY, recognise
from millprint.atlas.search_mills import (
    ALIKE,
    EQUAL,
    Found,
    _as_set,
    fastest_of_kinds,
    listed_mills,
    makers_mills,
    nearest_settings,
    own_mill,
    ranked,
)
from millprint.cli import match_conditions, new_mill
from millprint.config.errors import ConfigError
from millprint.config.included import included_mills as config_mills
from millprint.config.included import load_mill
from millprint.estimate.estimates import Estimate, Interval
from millprint.run.files import read_table
from tests.conftest import ROOT
from tests.refusals import refusal, refusals
from tests.unit.made_atlas import made_model

BALLS = {
    "density_kg_m3": 7700.0, "young_modulus_gpa": 2.05, "restitution": 0.6, "static_friction": 0.4,
    "wall_static_friction": 0.5, "rolling_friction": 0.01,
}  # fmt: skip
CONDITION = {"ball_diameter_mm": 10.0, "number": 30.0, "speed_hz": 5.0}


@pytest.mark.parametrize("kind", KINDS.values(), ids=KINDS)
def test_what_is_known_of_many_is_what_is_known_of_each(kind):
    draw, conditions = np.random.default_rng(3), []
    for row in design(kind, "training", 60).to_dict("records"):
        factors = draw.lognormal(0, 0.4, 3)
        own = kind.condition_of(row)
        changed = dict(zip(("number", "speed_hz", "ball_diameter_mm"), factors, strict=True))
        conditions.append(own | {name: max(1.0, own[name] * factor) for name, factor in changed.items()})

    def fits(condition):
        try:
            check(kind, condition)
        except ConfigError:
            return False
        return True

    columns = {name: np.array([own[name] for own in conditions]) for name in conditions[0]}
    groups = {name: np.array([kind.groups_of(own)[name] for own in conditions]) for name in kind.names}
    expected = [fits(own) for own in conditions]
    # Balls larger than a jar are no condition at all.
    goes_in = columns["ball_diameter_mm"] < np.minimum(2 * columns["radius_mm"], columns["height_mm"])
    assert (is_known(kind, groups, columns["number"]) & goes_in).tolist() == expected
    assert 0.1 < np.mean(expected) < 0.95


def made_mills():
    return makers_mills(ROOT / "config/atlas/makers.tsv", list(KINDS.values()))


def test_a_maker_s_mill_has_a_jar_and_the_speed_that_its_maker_gives():
    """The table's own rows, read here once more: a jar of another machine is never put into one without."""
    table = read_table(ROOT / "config/atlas/makers.tsv")
    made = made_mills()
    assert {own["title"] for own in made} >= {"Retsch PM 100", "SPEX 8000 class", "Fritsch Pulverisette 7 premium line"}
    for own in made:
        rows = table[table["mill"] == own["title"]].set_index("quantity")["value"]
        assert own["dimensions"]["radius_mm"] == rows["radius_mm"]
        assert own["dimensions"]["height_mm"] == rows["height_mm"]
        (speed,) = (row for row in rows.index if row.startswith("speed"))
        assert own["fastest_hz"] == pytest.approx(rows[speed] / (60 if speed.endswith("rpm") else 1))
        # A machine of one speed has no other.
        assert own["slowest_hz"] == (0 if "max" in speed else own["fastest_hz"])
    of_kinds = fastest_of_kinds(made)
    assert of_kinds == pytest.approx({"planetary": 1100 / 60, "mixer": 30, "spex": 17.5})
    _, planetary = recognise(load_mill("planetary"))
    assert own_mill("own", PLANETARY, planetary, made)["fastest_hz"] == pytest.approx(650 / 60)
    assert own_mill("own", PLANETARY, planetary | {"height_mm": 70.0}, made)["fastest_hz"] is None


@pytest.mark.parametrize("kind", KINDS.values(), ids=lambda kind: kind.name)
def test_speeds_are_as_a_mill_is_set_and_within_its_bounds(kind):
    step = 0.1 if kind.speed_unit == "hz" else 1 / 60
    rng = np.random.default_rng(0)
    for slowest, width in zip(rng.uniform(0, 20, 200), rng.choice([0.0, 0.3, 5.0], 200) * step, strict=True):
        within = slowest, slowest + width
        set_hz = _as_set(kind, rng.uniform(0, 30, 50), within)
        assert (set_hz >= within[0]).all() and (set_hz <= within[1]).all()
        if width > 2 * step:
            assert np.round(set_hz / step) * step == pytest.approx(set_hz, rel=1e-9)


def test_no_mill_is_faster_than_its_maker_says_and_what_is_assumed_is_told(capsys):
    match_conditions.main(["--any", "--like", "mixer", "25Hz", "10", "number=6", "--ranked", "30"])
    told = capsys.readouterr().out
    speeds = re.findall(r"^ *(SPEX 8000 class|Retsch MM class|Retsch PM 100) .*? ([\d.]+) (?:Hz|rpm) ", told, re.M)
    most = {"SPEX 8000 class": 17.5, "Retsch MM class": 30, "Retsch PM 100": 650}
    assert len(speeds) > 2 and all(float(speed) <= most[title] for title, speed in speeds)
    assert {float(speed) for title, speed in speeds if title.startswith("SPEX")} == {17.5}
    assert "SPEX 8000 class: assumed fillet_radius_mm" in told


def test_a_mill_of_one_s_own_is_as_fast_as_makers_mills_or_as_its_owner_says(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    new_mill.main(["mixer", "--no-picture", "--set", "radius_mm=10", "height_mm=34", "fillet_radius_mm=10"])
    capsys.readouterr()
    asked = ["--any", "mine.yaml", "--like", "mixer", "30Hz", "15", "number=2"]

    def fastest():
        told = capsys.readouterr().out
        return max(map(float, re.findall(r"([\d.]+) Hz ", told))), "mine.yaml: fastest speed not known" in told

    match_conditions.main(asked)
    speed, is_told = fastest()
    assert speed <= 30 and is_told
    match_conditions.main([*asked, "--speeds", "31Hz", "45Hz"])
    speed, is_told = fastest()
    assert speed >= 31 and not is_told


def test_each_mill_is_listed_once_and_only_where_the_atlas_knows_its_dimensions():
    """A drum of three radii in length is beyond it at any speed; the Bond mill is in both tables."""
    found = listed_mills(made_mills(), list(config_mills()), list(KINDS.values()))
    titles = [own["title"] for own in found]
    assert "Bond mill" in titles and load_mill("bond_mill").title not in titles and load_mill("drum").title in titles
    assert not {"Drum of Alizadeh et al.", load_mill("repose_drum").title} & set(titles)
    _, drum = recognise(load_mill("drum"))
    assert DRUM.knows(drum) and not DRUM.knows(drum | {"height_mm": 3 * drum["radius_mm"]})


def planetary():
    _, dimensions = recognise(load_mill("planetary"))
    return made_model(PLANETARY), dimensions


def test_a_mill_finds_its_own_condition():
    model, dimensions = planetary()
    wanted = estimate(PLANETARY, {**dimensions, **BALLS, **CONDITION}, model)
    best, *_ = nearest_settings("own", model, dimensions, BALLS, [10.0], wanted)
    assert best.distance < 1e-6
    assert best.estimate.condition == pytest.approx(wanted.condition)
    # It is the same point of the atlas, with the same error.
    assert all(own.ends("scatter") == pytest.approx((1, 1)) for own in (*best.ratios.values(), best.strength))
    assert best.verdict(30).word == "agrees"
    smaller, *_ = nearest_settings("own", model, dimensions, BALLS, [9.0], wanted)
    assert all(own.ends("scatter")[0] < own.value < own.ends("scatter")[1] for own in smaller.ratios.values())
    # A setting is one that a mill can be given.
    assert best.estimate.condition["number"] == round(best.estimate.condition["number"])
    rpm = 60 * best.estimate.condition["speed_hz"]
    assert rpm == pytest.approx(round(rpm))


def test_of_what_is_equally_near_the_shortest_comes_first_after_what_is_surely_near():
    model, dimensions = planetary()
    wanted = estimate(PLANETARY, {**dimensions, **BALLS, **CONDITION}, model)
    (own,) = nearest_settings("own", model, dimensions, BALLS, [10.0], wanted)
    wide = dict.fromkeys(ALIKE, Estimate(1.0, "-", scatter=Interval(0.4, 2.5)))

    def made(title, distance, strength):
        return Found(title, own.estimate, wide, Estimate(strength, "-"), distance)

    found = [made("slow", 0.001, 0.01), made("far", 2 * EQUAL, 9.0), made("fast", 0.9 * EQUAL, 3.0), own]
    assert [each.title for each in ranked(found, 30)] == ["own", "fast", "slow", "far"]


def test_no_drawn_condition_is_nearer_than_the_found_one():
    """An oracle by chance: two hundred conditions of the other mill, of the sizes that were searched."""
    model, dimensions = planetary()
    _, mixer = recognise(load_mill("mixer"))
    wanted = estimate(MIXER, {**mixer, **BALLS, "ball_diameter_mm": 10.0, "number": 6.0, "speed_hz": 20.0},
                      made_model(MIXER, 3))  # fmt: skip
    found = nearest_settings("planetary", model, dimensions, BALLS, [8.0, 10.0, 12.0], wanted, (0.0, 9.0))
    assert [own.distance for own in found] == sorted(own.distance for own in found)
    assert all(own.estimate.condition["speed_hz"] <= 9.0 for own in found)
    draw, drawn = np.random.default_rng(4), []
    for _ in range(200):
        own = {"ball_diameter_mm": float(draw.choice([8.0, 10.0, 12.0])), "number": float(draw.integers(5, 200)),
               "speed_hz": float(draw.uniform(2.7, 9.0))}  # fmt: skip
        try:
            told = estimate(PLANETARY, {**dimensions, **BALLS, **own}, model)
        except ConfigError:
            continue
        if told.hits > 0.5:
            apart = [np.log(told.known[name].value / wanted.known[name].value) for name in ALIKE]
            drawn.append(float(np.sqrt(np.mean(np.square(apart)))))
    assert len(drawn) > 50
    assert found[0].distance < min(drawn) + 0.02


def test_the_command_lists_settings_of_mills_with_verdicts(capsys):
    match_conditions.main(["--any", "mixer", "--like", "mixer", "25Hz", "10", "number=6", "--balls", "10"])
    *head, columns, row = capsys.readouterr().out.splitlines()
    assert "90 % intervals" in " ".join(head)
    assert {"mill", "balls", "E*n", "E*t", "verdict"} <= set(columns.split())
    assert "mixer" in row and " Hz" in row and row.split()[-1] in ("agrees", "differs", "open")
    asked = ["--any", "mixer", "--like", "mixer", "25Hz", "10", "number=6", "--balls", "10"]
    match_conditions.main([*asked, "--speeds", "15Hz", "20Hz", "--hours", "8"])
    *_, columns, slower = capsys.readouterr().out.splitlines()
    assert "h for 8" in columns and 15 <= float(slower.split(" Hz")[0].split()[-1]) <= 20


@pytest.mark.parametrize(("arguments", "parts"), refusals("match_any"))
def test_what_no_search_can_answer_is_refused_in_one_line(arguments, parts):
    line = refusal(match_conditions.main, arguments)
    assert all(part in line for part in parts), line
