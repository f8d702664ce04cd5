"""The atlas of mills: groups, refusals, the model and its file, and the command that asks it."""

import itertools
import json
import math
import subprocess
import sys
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from millprint.atlas.atlas_model import FITTED, FORMAT, MARKS, PREDICTED, Width, combined, inputs_of, read_model
from millprint.atlas.beside_simulation import BESIDE, LARGE, atlas_rows
from millprint.atlas.design import HELD_OUT, design, rows_of
from millprint.atlas.estimate_mill import check, estimate, estimate_many, exponents
from millprint.atlas.fit_atlas import Fit, Rows, fit_kind, fit_robust, fit_surface, fit_width, growth, without_own
from millprint.atlas.fit_atlas import rows_of as fit_rows_of
from millprint.atlas.kind_groups import PACKED, loss
from millprint.atlas.kinds import KINDS, MIXER, PLANETARY, balls_of, recognise, slip
from millprint.cli import estimate_condition
from millprint.config.counting import DEFAULT_RULE
from millprint.config.included import included_mills, load_contact, load_mill
from millprint.config.workflow import AtlasConfig
from millprint.estimate.estimates import Estimate, Interval
from millprint.figures.atlas_figures import plot_map
from millprint.fingerprint.descriptors import tabulate_descriptors
from millprint.fingerprint.mill_sheet import SHEET, Row
from millprint.fingerprint.model import NO_IMPACTS, Fingerprint
from millprint.mill.vessel import build_vessel
from millprint.observables.definitions import DESCRIPTORS
from millprint.run.files import read_table, write_json
from tests.conftest import ROOT
from tests.refusals import refusal, refusals
from tests.unit.synthetic_mill import still, summary

HELD_OUT_FILE = str(ROOT / "config/atlas/held_out.tsv")
BALLS = {
    "ball_diameter_mm": 10.0, "number": 50.0, "speed_hz": 6.5, "density_kg_m3": 7700.0, "young_modulus_gpa": 2.05,
    "restitution": 0.6, "static_friction": 0.4, "wall_static_friction": 0.5, "rolling_friction": 0.01,
}  # fmt: skip
KIND = pytest.mark.parametrize("kind", KINDS.values(), ids=KINDS)
# Lengths, in how a mill is given.
LENGTH = "_mm"


def conditions(kind, count):
    return [kind.condition_of(row) for row in design(kind, "training", count).to_dict("records")]


@KIND
def test_groups_do_not_depend_on_size_or_density(kind):
    """A mill three times as large, of balls half as dense, at a speed and stiffness in proportion: the same point."""
    for condition in conditions(kind, 8):
        larger = {name: value * (3.0 if name.endswith(LENGTH) else 1.0) for name, value in condition.items()}
        larger["speed_hz"] /= math.sqrt(3.0)
        larger["density_kg_m3"] /= 2
        larger["young_modulus_gpa"] *= 3.0 / 2
        assert kind.groups_of(larger) == pytest.approx(kind.groups_of(condition), rel=1e-12)
        assert kind.scales(larger)["energy"] == pytest.approx(kind.scales(condition)["energy"] * 3.0**4 / 2, rel=1e-12)


@KIND
def test_a_condition_has_the_groups_that_it_is_made_from(kind):
    for row in design(kind, "training", 8).to_dict("records"):
        found = kind.groups_of(kind.condition_of(row))
        assert found == pytest.approx({name: row[name] for name in kind.names}, rel=1e-9)


@KIND
def test_volume_is_that_of_the_built_vessel(kind):
    """Facets lie inside of round walls, by less than one percent of the volume with 48 of them."""
    for condition in conditions(kind, 4):
        mill = kind.mill_of(condition)
        assert build_vessel(mill).volume_m3 == pytest.approx(kind.volume_m3(condition), rel=0.015)


@KIND
def test_a_mill_of_a_kind_is_recognised_with_its_dimensions(kind):
    (condition,) = conditions(kind, 1)
    found, dimensions = recognise(kind.mill_of(condition))
    assert found is kind
    assert dimensions == pytest.approx({own.name: condition[own.name] for own in kind.dimensions})


def test_a_bed_loses_more_with_more_layers_and_with_less_restitution():
    """Twice the layers are as (1 - e^2) twice as large, and one layer of e = 0 loses all."""
    bed = {"fill": np.array([0.1, 0.2, 0.1]), "ball": 0.4, "length": 4.0, "restitution": np.sqrt([0.8, 0.8, 0.6])}
    plain, layered, lossy = loss(bed, "length")
    assert layered == pytest.approx(lossy)
    assert layered > plain
    assert loss(bed | {"fill": 0.1, "restitution": 0.0}, "length") == pytest.approx(0.0)


def test_friction_holds_a_bed_by_the_pressure_on_the_walls():
    """Torques over the section of a bed, up to an angle to each side of its lowest line, integrated."""
    for half, length in itertools.product((0.95, 1.3, 1.6, 1.82), (0.5, 2.5)):
        angle, height = np.linspace(-half, half, 2001), np.linspace(math.cos(half), 1, 20_001)
        width, depth = 2 * np.sqrt(1 - height**2), height - math.cos(half)
        shell = np.trapezoid(np.cos(angle) - math.cos(half), angle)
        held = 0.3 * (shell + 2 / length * np.trapezoid(depth * width, height)) / np.trapezoid(height * width, height)
        fill = PACKED * np.trapezoid(width, height) / math.pi
        bed = {"fill": fill, "ball": 0.4, "length": length, "wall_static_friction": 0.3}
        assert np.exp(2 * slip(bed)) == pytest.approx(held / 0.8, rel=0.13)


def test_included_mills_are_recognised():
    found = {name: known[0].name for name in included_mills() if (known := recognise(load_mill(name)))}
    assert {"planetary", "mixer", "spex", "drum"} == {name for name in found if name == found[name]}
    assert not {"emax", "attritor", "vibratory", "bead_drum", "slice_mill", "drum_90cm"} & set(found)


@KIND
def test_held_out_mills_are_no_training_mills_and_lie_in_the_ranges(kind):
    held_out = rows_of(kind.name, HELD_OUT, 0, 1000, HELD_OUT_FILE)
    assert len(held_out) == 100
    np.testing.assert_allclose(held_out[kind.names].head(3), design(kind, HELD_OUT, 3)[kind.names], rtol=1e-9)
    training = design(kind, "training", 1500)
    assert not set(held_out["froude" if "froude" in kind.names else "critical"]) & set(training[kind.names[3]])
    for group in kind.groups:
        shares = group.share(held_out[group.name].to_numpy())
        assert shares.min() >= -1e-9
        assert shares.max() <= 1 + 1e-9


@pytest.mark.parametrize("asked", [0, 25, 30])
def test_the_batches_of_a_part_have_as_many_rows_as_are_asked(asked):
    settings = AtlasConfig(planetary=30, mixer=asked, drum=0, spex=0)
    rows = {part: [] for part in settings.parts}
    for (kind, part, _), (first, count) in settings.batches(25).items():
        assert 0 < count <= 25
        rows[kind, part] += range(first, first + count)
    assert rows == {part: list(range(count)) for part, count in settings.parts.items()}


def test_mills_that_were_asked_train_the_next_model_and_are_held_out_no_more():
    table = read_table(ROOT / "config/atlas/simulations.tsv")
    for kind in (PLANETARY, MIXER):
        held_out, asked = (set(design(kind, part, 50)["froude"]) for part in (HELD_OUT, "asked_1"))
        assert not held_out & asked
        parts = {part: set(fit_rows_of(table, kind, part).table["part"]) for part in (HELD_OUT, "training")}
        assert parts[HELD_OUT] == {HELD_OUT} and {"training", "asked_1", "asked_2"} <= parts["training"]
        assert HELD_OUT not in parts["training"]


@pytest.mark.parametrize(("kind", "change", "parts"), refusals("atlas_condition"))
def test_impossible_and_unknown_conditions_are_refused_in_one_line(kind, change, parts):
    own = KINDS[kind]
    _, built = recognise(load_mill(kind))
    line = refusal(check, own, {**built, **BALLS, **change})
    assert all(part in line for part in parts), line


# ---- the model ----
def made_rows(count=90, seed=0):
    """Rows of the mixer whose logarithms are a known function of the groups, with a known noise."""
    table = design(MIXER, "training", count)
    inputs = inputs_of(MIXER, table)
    rng = np.random.default_rng(seed)
    truth = {name: inputs[:, number] + 0.4 * np.sin(3 * inputs[:, 1]) for number, name in enumerate(FITTED)}
    fitted = {name: value + rng.normal(0, 0.05, count) for name, value in truth.items()}
    found = combined(fitted)
    scales = [MIXER.scales(MIXER.condition_of(row)) for row in table.to_dict("records")]
    values = {name: np.exp(found[name]) * [own[PREDICTED[name]] for own in scales] for name in PREDICTED}
    table = table.assign(**values, motion="", version="1", processor_s=1.0)
    noise = dict.fromkeys(FITTED, np.full(count, 0.05))
    return Rows(inputs, np.full(count, True), fitted, noise, table, np.full(count, True)), truth


@pytest.fixture(scope="module")
def made():
    rows, truth = made_rows()
    return fit_kind(MIXER, rows), rows, truth


def test_parts_of_the_power_add_up_to_it(made):
    model, rows, _ = made
    found = {name: np.exp(value) for name, (value, _) in model.logarithms(rows.inputs).items()}
    parts = sum(found[f"{name}_power_W"] for name in ("normal", "tangential", "rolling"))
    np.testing.assert_allclose(parts, found["wall_power_W"], rtol=1e-9)


def test_the_model_finds_a_known_function(made):
    model, _, _ = made
    new, truth = made_rows(200)
    later = slice(90, None)
    found = model.fitted(new.inputs[later])
    for name in FITTED:
        assert np.std(found[name] - truth[name][later]) < 0.5 * np.std(truth[name])


def test_the_deviation_of_a_row_is_that_of_a_fit_without_it():
    """The closed form of the residuals that are left out, against solving without the row, by hand."""
    rows, _ = made_rows(40)
    values, noise = rows.fitted["power"], rows.noise["power"]
    fit = Fit.of(rows.inputs, values, noise**2, None, 20)
    amplitude, *lengths, further = np.exp(fit.theta)
    others = np.arange(40) != 7
    z = np.sqrt(5 * (((rows.inputs[:, None] - rows.inputs[None]) / lengths) ** 2).sum(axis=2))
    covariance = fit.spread**2 * (amplitude * (1 + z + z**2 / 3) * np.exp(-z) + further * np.eye(40))
    covariance += np.diag(noise**2)
    trend = fit.linear[0] + rows.inputs @ fit.linear[1:]
    solved = np.linalg.solve(covariance[np.ix_(others, others)], (values - trend)[others])
    assert values[7] - fit.deviations[7] == pytest.approx(trend[7] + covariance[7, others] @ solved, abs=1e-8)


def test_the_surface_is_that_of_the_fit():
    rows, _ = made_rows(40)
    values, noise = rows.fitted["power"], rows.noise["power"]
    surface, theta = fit_surface(rows.inputs, values, noise, np.arange(40))
    fit, known = fit_robust(rows.inputs, values, noise)
    np.testing.assert_allclose(theta, fit.theta)
    np.testing.assert_allclose(surface.at(rows.inputs, rows.inputs), fit.at(rows.inputs)[0], atol=1e-9)
    assert (surface.noise >= known).all()


def test_few_rows_far_off_do_not_bend_the_surface():
    """A tenth of the rows is wrong by a factor of twenty."""
    rows, truth = made_rows(300)
    own, new = slice(0, 150), slice(150, None)
    wrong = np.arange(150) % 10 == 3
    values = rows.fitted["power"][own] + 3.0 * wrong * np.sign(np.sin(np.arange(150)))
    inputs, noise = rows.inputs[own], rows.noise["power"][own]
    fits = fit_robust(inputs, values, noise)[0], Fit.of(inputs, values, noise**2, None, 25)
    robust, plain = (np.abs(fit.at(rows.inputs[new])[0] - truth["power"][new]) for fit in fits)
    assert np.median(robust) < 0.5 * np.median(plain)


def test_lengths_are_searched_with_the_first_rows_and_values_with_all(monkeypatch):
    from millprint.atlas import fit_atlas

    rows, truth = made_rows(200)
    values, noise = rows.fitted["power"], rows.noise["power"]
    fewer = slice(0, 80)
    expected = fit_robust(rows.inputs[fewer], values[fewer], noise[fewer])[0]
    monkeypatch.setattr(fit_atlas, "SEARCHED", 80)
    found = fit_robust(rows.inputs, values, noise)[0]
    np.testing.assert_array_equal(found.theta, expected.theta)
    off = [np.abs(fit.at(rows.inputs[80:])[0] - truth["power"][80:]).mean() for fit in (found, expected)]
    assert off[0] < off[1]


def test_a_row_that_is_left_out_has_no_part_in_its_own_value():
    rows, _ = made_rows(60)
    values, noise = rows.fitted["power"], rows.noise["power"]
    theta = fit_surface(rows.inputs, values, noise, np.arange(60))[1]
    moved = values + 2.0 * (np.arange(60) == 7)
    one, two = (without_own(rows.inputs, own, noise, theta)[0] for own in (values, moved))
    assert one[7] == two[7]
    assert one[8] != two[8]


def test_errors_of_slopes_grow_where_the_process_says_too_little():
    """Errors of three of its deviations triple its intervals, and small ones leave them."""
    errors, one = np.random.default_rng(5).normal(size=4000), np.ones(4000)
    for times in (0.5, 3.0):
        told = growth(times * errors * math.sqrt(1.25), 0.5 * one, 0 * errors, one)
        assert told == pytest.approx(max(1.0, times), rel=0.05)


def test_the_file_of_a_model_predicts_as_the_model(tmp_path, made):
    model, rows, _ = made
    path = tmp_path / "model.json"
    write_json({"format": FORMAT, "kinds": {"mixer": model.plain() | {"about": {}}}}, path)
    again = read_model(path)["mixer"].logarithms(rows.inputs)
    for name, (value, width) in model.logarithms(rows.inputs).items():
        np.testing.assert_allclose(again[name][0], value, atol=2e-5)
        np.testing.assert_allclose(again[name][1], width, rtol=1e-5)


@pytest.mark.parametrize(("change", "parts"), refusals("atlas_file"))
def test_a_file_that_is_no_atlas_is_refused_in_one_line(tmp_path, made, change, parts):
    content = {"format": FORMAT, "kinds": {"mixer": made[0].plain() | {"about": {}}}}
    if "format" in change:
        content |= change
    else:
        content["kinds"]["mixer"] |= change
    write_json(content, tmp_path / "model.json")
    line = refusal(read_model, tmp_path / "model.json")
    assert all(part in line for part in parts), line


def test_widths_hold_nine_of_ten_new_errors():
    """Errors whose size grows with an input, of rows that the widths have not seen."""
    rng = np.random.default_rng(1)
    inputs = rng.uniform(size=(600, 3))
    errors = rng.normal(size=600) * np.exp(2 * inputs[:, 0])
    width = fit_width(inputs[:200], errors[:200])
    held = np.abs(errors[200:]) < width.at(inputs[200:])
    assert 0.85 < held.mean() < 0.95
    assert 0.4 < (np.abs(errors[200:]) < width.typical(inputs[200:])).mean() < 0.6
    assert width.at(np.array([[1.0, 0.5, 0.5]])) > 3 * width.at(np.array([[0.0, 0.5, 0.5]]))


def test_density_and_speed_have_the_exponents_of_their_scales(made):
    """Of a function without Froude number and stiffness: power and energy go with the density, power with f^3."""
    rows, _ = made_rows()
    kept = [number for number, name in enumerate(MIXER.names) if name not in ("froude", "softness")]
    plain = rows.inputs[:, kept[0]]
    fitted = dict.fromkeys(FITTED, plain)
    model = fit_kind(MIXER, replace(rows, fitted=fitted))
    condition = MIXER.condition_of(rows.table.iloc[3])
    found = exponents(MIXER, condition, model)
    assert found["wall_power_W"]["speed_hz"].value == pytest.approx(3, abs=0.1)
    assert found["wall_power_W"]["density_kg_m3"].value == pytest.approx(1, abs=0.1)
    assert found["weighted_normal_energy_J"]["speed_hz"].value == pytest.approx(2, abs=0.1)


def test_what_is_told_worse_than_the_mark_is_to_be_simulated(made):
    """Of errors whose median is the mark, a hundredth less and more; the interval is twice as wide as half of them."""
    model, rows, _ = made
    condition = MIXER.condition_of(rows.table.iloc[3])
    flat = np.zeros(rows.inputs.shape[1] + 1)
    for name, mark in MARKS.items():
        for factor, unsure in ((0.99, False), (1.01, True)):
            own = replace(model, widths={**model.widths, name: Width(flat, 2 * mark, factor * mark)})
            found = estimate(MIXER, condition, own)
            assert (name in found.unsure) is unsure
            asked = [line for line in estimate_condition.told(found) if estimate_condition.UNSURE in line]
            assert any(estimate_condition.TOLD[name] in line for line in asked) is unsure


def test_balls_too_soft_or_stiff_are_told_as_at_the_end_of_the_range(made):
    model, rows, _ = made
    condition = MIXER.condition_of(rows.table.iloc[3])
    stiff = estimate(MIXER, condition | {"young_modulus_gpa": 1e3 * condition["young_modulus_gpa"]}, model)
    assert stiff.notes
    assert stiff.groups["softness"] == next(own.low for own in MIXER.groups if own.name == "softness")


@pytest.mark.slow
def test_mills_of_equal_groups_do_the_same():
    """Twice the size, half the density, speed in proportion: numbers over their scales, within scatter."""
    from millprint.atlas.design import simulate_row

    # Some balls, few seconds.
    small = next(each for each in conditions(MIXER, 40) if 8 <= each["number"] <= 20)
    large = {name: value * (2.0 if name.endswith(LENGTH) else 1.0) for name, value in small.items()}
    large |= {"speed_hz": small["speed_hz"] / math.sqrt(2), "density_kg_m3": small["density_kg_m3"] / 2}
    assert large["young_modulus_gpa"] == small["young_modulus_gpa"]
    found = [simulate_row(MIXER, each, seed) for seed, each in enumerate((small, large))]
    scales = [MIXER.scales(each) for each in (small, large)]
    for name, error in (("wall_power_W", "wall_power_relative_se"),
                        ("weighted_normal_energy_J", "weighted_normal_energy_relative_se"),
                        ("weighted_tangential_energy_J", "weighted_tangential_energy_relative_se")):  # fmt: skip
        first, second = (row[name] / own[PREDICTED[name]] for row, own in zip(found, scales, strict=True))
        scatter = math.hypot(*(row[error] for row in found))
        assert abs(math.log(first / second)) < 4 * scatter + 0.01


def test_rows_of_the_shipped_table_are_not_simulated_again(tmp_path, monkeypatch):
    """Its six digits are of the same rows; a row of another version, or of other groups, is simulated."""
    from millprint.atlas import design

    table = read_table(ROOT / "config/atlas/simulations.tsv")
    rows = rows_of("mixer", "asked_1", 0, 100, HELD_OUT_FILE)
    asked = []
    monkeypatch.setattr(design, "simulate_row", lambda kind, condition, seed: asked.append(seed) or {})
    found = design.simulate_rows(rows, tmp_path / "done", "atlas", table)
    assert not asked
    assert found["wall_power_W"].notna().sum() > 90
    own = (table["kind"] == "mixer") & (table["part"] == "asked_1")
    table.loc[own & (table["row"] == 3), "version"] = "0"
    table.loc[own & (table["row"] == 5), "froude"] *= 1.001
    design.simulate_rows(rows, tmp_path / "done", "atlas", table)
    assert asked == [3, 5]


def test_training_rows_that_teach_little_are_skipped(tmp_path, monkeypatch):
    """Beyond the limit of the kind, and where the atlas has balls that roll; held-out mills are always simulated."""
    from millprint.atlas import design
    from millprint.atlas.kind_groups import within_limits

    monkeypatch.setattr(design, "simulate_row", lambda kind, condition, seed: {"motion": "simulated"})
    atlas = read_model(ROOT / "config/atlas/model.json")
    for part, first in (("training", 800), ("held_out", 0)):
        rows = rows_of("planetary", part, first, 40, HELD_OUT_FILE)
        found = design.simulate_rows(rows, tmp_path / "done", "atlas", None, atlas)
        likely = atlas["planetary"].probability(inputs_of(PLANETARY, rows)) >= design.LEAST_HITS
        wanted = within_limits(PLANETARY, rows) & likely | (part == "held_out")
        assert ((found["motion"] == "simulated") == wanted).all()
        assert wanted.any() and (wanted.all() == (part == "held_out"))


def test_balls_that_never_part_are_a_row_with_power(monkeypatch):
    from millprint.atlas import design

    summary = {"power_W": {"wall": 2.0}, "per_revolution": {"wall_J": [1.0, 1.1] * 8}, "revolutions": 16.0}
    summary["collisions"] = [{"name": DEFAULT_RULE, "count": 0}]
    monkeypatch.setattr(design, "simulate", lambda *given: summary)
    (condition,) = conditions(MIXER, 1)
    row = design.simulate_row(MIXER, condition, 0)
    assert (row["wall_power_W"], row["motion"], row["recorded_turns"]) == (2.0, "no impacts", 16)
    assert 0 < row["wall_power_relative_se"] < 0.02


@pytest.mark.parametrize(("options", "parts"), refusals("atlas_options"))
def test_options_that_do_not_belong_together_are_refused_in_one_line(options, parts):
    line = refusal(estimate_condition.main, ["mixer", *options])
    assert all(part in line for part in parts), line


def test_rows_beyond_a_limit_train_and_are_not_judged():
    """A planetary jar that turns fast enough to be a centrifuge."""
    table = read_table(ROOT / "config/atlas/simulations.tsv")
    rows = fit_rows_of(table, PLANETARY, "training")
    turns, jar, ball = (rows.table[name] for name in ("turns", "jar", "ball"))
    beyond = (turns - 1) ** 2 * jar * (1 - ball / 2) > 1.5
    assert 0.02 < beyond.mean() < 0.2
    assert (rows.within == ~beyond).all()
    assert len(rows.asked()) == (~beyond).sum()


def test_a_fingerprint_is_shown_beside_the_atlas(capsys, monkeypatch):
    """The included mixer mill: what was simulated over what the atlas says, with a large difference named.

    It has 10 balls at 18 and 27 Hz, and curves between.
    """
    words, count = ("; simulated ", "; by its curves ", "; extrapolated "), len(estimate_condition.TOLD)
    for number, speed, said in ((10, 18, words[0]), (6, 18, words[1]), (10, 25, words[1]), (10, 30, words[2])):
        asked = f"mixer --balls 10 --charge number={number} --speed {speed}Hz --simulated".split()
        estimate_condition.main(asked)
        shown = capsys.readouterr().out
        assert [shown.count(word) for word in words] == [count if word == said else 0 for word in words]
    for outside, large in (((), count), (("fill_ratio",), 0)):
        monkeypatch.setattr(Fingerprint, "predict", lambda self, condition, outside=outside: SimpleNamespace(
            known=dict.fromkeys(estimate_condition.TOLD, Estimate(1e6, "W", scatter=Interval(9e5, 1.1e6))),
            outside=outside))  # fmt: skip
        estimate_condition.main(asked)
        assert capsys.readouterr().out.count("A LARGE DIFFERENCE") == large


def test_a_fingerprint_of_a_mill_in_which_nothing_hits_is_shown_too(capsys, monkeypatch):
    known = dict.fromkeys(estimate_condition.TOLD, Estimate(math.nan, "J")) | {"wall_power_W": Estimate(1.0, "W")}
    monkeypatch.setattr(Fingerprint, "predict", lambda *_: SimpleNamespace(known=known, outside=()))
    estimate_condition.main(["mixer", "--balls", "10", "--charge", "number=10", "--speed", "18Hz", "--simulated"])
    assert "; simulated " in capsys.readouterr().out


def test_where_nothing_hits_the_fingerprint_tells_only_the_power_beside_the_atlas(monkeypatch, tmp_path, capsys):
    """Five balls in the included mixer mill as if they hit nothing, and seven that do: six are between."""
    volume_m3 = 1e-6 * load_mill("mixer").volume_ml
    runs = [make(count * np.pi / 6 * 0.01**3 / volume_m3, 10.0, 1080.0)
            for count, make in ((5, still), (7, summary), (10, summary))]  # fmt: skip
    own = Fingerprint.fit(tabulate_descriptors(runs, "gap_0_03"), volume_m3, 0.95)
    monkeypatch.setattr(estimate_condition, "_fingerprint", lambda *_: own)
    for count, known, unknown in ((5, 1, 4), (6, 0, 5), (7, 5, 0)):
        estimate_condition.main(f"mixer --balls 10 --charge number={count} --speed 18Hz --simulated".split())
        shown = capsys.readouterr().out
        assert shown.count("; simulated ") == known and shown.count("; not known") == unknown
        assert (NO_IMPACTS in shown) == (unknown > 0)


@pytest.mark.parametrize(
    ("mill", "balls", "factor", "verdicts"),
    [
        ("mixer", 6, 1.0, ["agrees"] * 3),
        ("mixer", 6, 3.0, ["differs: simulated 3 times more"] * 3),
        ("mixer", 500, 1.0, []),  # more balls than go into the jar
        ("emax", 6, 1.0, []),  # of no kind
    ],
)
def test_the_page_shows_the_simulation_beside_the_atlas(mill, balls, factor, verdicts):
    contact, own = load_contact("calibrated"), load_mill(mill)
    settings = {"ball_diameter_mm": 10.0, "number": 6.0, "speed_hz": 25.0, **balls_of(contact)}
    told = estimate(MIXER, {**recognise(load_mill("mixer"))[1], **settings}).known
    condition = {"ball diameter": 10.0, "speed": 1500.0, "balls": balls}
    sheet = [Row("condition", name, value) for name, value in condition.items()]
    for name in BESIDE:
        value = factor * told[name].value
        sheet.append(Row("descriptors", DESCRIPTORS[name].title, value, 0.99 * value, 1.01 * value))
    rows = atlas_rows(own, contact, pd.DataFrame(sheet, columns=SHEET))
    assert len(rows) == len(verdicts) and all(map(str.startswith, rows["text"], verdicts))
    assert rows["text"].str.endswith(LARGE).all() or factor == 1
    assert rows["value"].tolist() == [told[name].value for name in BESIDE][: len(rows)]


def test_a_map_has_the_numbers_of_the_estimates(made):
    model, rows, _ = made
    condition = MIXER.condition_of(rows.table.iloc[3])
    number, speed = np.array([1.0, 1.1]) * condition["number"], np.array([1.0, 0.9]) * condition["speed_hz"]
    logs, hits = estimate_many(model, {**condition, "number": number, "speed_hz": speed})
    assert hits.all()
    for place in range(2):
        own = estimate(MIXER, condition | {"number": number[place], "speed_hz": speed[place]}, model).known
        assert [math.exp(logs[name][place]) for name in PREDICTED] == pytest.approx(
            [own[name].value for name in PREDICTED], rel=1e-9
        )
    figure = plot_map(model, condition, {"number": (number[0] / 2, number[0]), "speed_hz": (5.0, 10.0)})
    assert [axis.get_xlabel() for axis in figure.axes] == ["number of balls [-]"] * 2


@pytest.mark.slow
def test_an_optimum_is_simulated_once(capsys):
    within = ["--within", "number=2:12", "--within", "speed_hz=15:30", "--most-shear", "200"]
    estimate_condition.main(["mixer", "--balls", "10", "--charge", "number=6", "--speed", "25Hz", *within])
    said = capsys.readouterr().out
    assert "the most normal power per mass of balls" in said
    assert said.count("within ") + said.count("OUTSIDE ") >= 5


# ---- what ships ----


def test_the_shipped_table_is_of_the_design_and_not_of_held_out_mills():
    table = read_table(ROOT / "config/atlas/simulations.tsv")
    for (name, part), own in table.groupby(["kind", "part"]):
        kind = KINDS[name]
        drawn = rows_of(name, part, 0, int(own["row"].max()) + 1, HELD_OUT_FILE).set_index("row").loc[own["row"]]
        np.testing.assert_allclose(own[kind.names], drawn[kind.names], rtol=2e-5, atol=1e-9)
    model = json.loads((ROOT / "config/atlas/model.json").read_text())["kinds"]
    training = table[(table["part"] != HELD_OUT) & ~table["motion"].fillna("").str.startswith(("failed", "not"))]
    for name, own in model.items():
        assert own["about"]["simulations"] == len(own["centres"]) == (training["kind"] == name).sum()


@pytest.mark.slow
@KIND
def test_the_atlas_is_of_the_present_physics(kind):
    """Cheap rows simulated again: the power of most is within four standard errors, as other processors round
    differently, and a few motions last in several ways.

    Not of soft balls: at the largest overlap that is allowed, rounding decides whether a row fails.
    """
    from millprint.atlas.design import simulate_row, version_of

    table = read_table(ROOT / "config/atlas/simulations.tsv")
    own = table[(table["kind"] == kind.name) & table["motion"].isna() & (table["softness"] < 1e-4)]
    own = own.nsmallest(4, "processor_s")
    assert set(own["version"]) == {version_of(kind)}
    off = []
    for row in own.to_dict("records"):
        again = simulate_row(kind, kind.condition_of(row), int(row["row"]))
        apart = abs(math.log(again["wall_power_W"] / row["wall_power_W"]))
        off.append(apart / (4 * math.sqrt(2) * row["wall_power_relative_se"] + 0.02))
    assert np.median(off) < 1


def test_the_command_imports_nothing_slow():
    """What takes longer to import than an answer may take."""
    code = (
        "import sys; from millprint.cli.estimate_condition import main;"
        "main(['mixer', '--balls', '10', '--charge', 'number=8', '--speed', '25Hz']);"
        "print(*sorted({'pandas', 'sklearn', 'numba', 'matplotlib', 'h5py'} & set(sys.modules)))"
    )
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert found.stdout.splitlines()[-1] == ""
    assert "8 balls of 10 mm" in found.stdout
