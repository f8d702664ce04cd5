"""Milling cards: the schema, numbers with intervals, texts for a paper, and reading back."""

import json
import re

import h5py
import numpy as np
import pytest
from jsonschema import Draft202012Validator
from jsonschema.exceptions import ValidationError
from tools.write_reference import card_schema_text

from millprint.card.build import Window, describe_runs, descriptors_of_totals, jackknife, spread
from millprint.card.card_files import bibtex, escape, latex_table, methods_paragraph
from millprint.card.card_model import CardFingerprint, MillingCard
from millprint.card.read import CardSettings, Runs, match_card, read_card
from millprint.config.errors import ConfigError
from millprint.config.fingerprint import SearchConfig
from millprint.config.sweep import ball_count
from millprint.run.numbers import NOT_KNOWN, plain, prefix_of, three
from tests.refusals import refusal
from tests.unit.synthetic_mill import (
    AMPLITUDE,
    DENSITY,
    ROLLING,
    VOLUME,
    WEIGHTED_OVER_MEAN,
    fingerprint,
    summary,
    true_curves,
)

GAP = 0.03


def values_at(fill_ratio: float, speed_hz: float, diameter: float = 0.01) -> dict[str, float]:
    """The descriptors of the synthetic mill, in closed form."""
    normal, tangential, frequency = true_curves(fill_ratio)
    balls, energy = ball_count(fill_ratio, VOLUME, diameter), DENSITY * speed_hz**2 * AMPLITUDE**2 * diameter**3
    powers = [balls * energy * speed_hz * own for own in (normal, tangential, ROLLING * normal)]
    return {
        "weighted_normal_energy_J": WEIGHTED_OVER_MEAN["normal"] * energy * normal / frequency,
        "weighted_tangential_energy_J": WEIGHTED_OVER_MEAN["tangential"] * energy * tangential / frequency,
        "weighted_normal_frequency_hz": speed_hz * frequency / WEIGHTED_OVER_MEAN["normal"],
        "weighted_tangential_frequency_hz": speed_hz * frequency / WEIGHTED_OVER_MEAN["tangential"],
        "normal_energy_J": energy * normal / frequency,
        "tangential_energy_J": energy * tangential / frequency,
        "specific_frequency_hz": speed_hz * frequency,
        "normal_power_W": powers[0],
        "tangential_power_W": powers[1],
        "rolling_power_W": powers[2],
        "wall_power_W": sum(powers),
        "tangential_share": powers[1] / (powers[0] + powers[1]),
    }


def card_content(fill_ratio: float = 0.10, speed_rpm: float = 700.0, gap_turns: float = GAP) -> dict:
    """The least that a card of another program has, of a condition of the synthetic mill; powder and programme too."""
    values, mass = values_at(fill_ratio, speed_rpm / 60), 96.8
    descriptors = {
        name: {"value": value, "unit": "-", "scatter": {"lower": 0.95 * value, "upper": 1.05 * value}}
        for name, value in values.items()
    }
    return {
        "format": "millprint milling card",
        "schema_version": 3,
        "name": "other",
        "title": "Mill of others: 50 % & more",
        "machine": {"name": "other_mill", "title": "Other_mill #1", "speed_rpm": speed_rpm},
        "jar": {"volume_ml": 125},
        "balls": {
            "sizes": [{"diameter_mm": 10, "number": ball_count(fill_ratio, VOLUME, 0.01)}],
            "mass_g": mass,
            "density_kg_m3": DENSITY,
            "fill_ratio": fill_ratio,
        },
        "powder": {"name": "NaBO2", "mass_g": mass / 30, "ball_to_powder_ratio": 30},
        "programme": {"duration_h": 10, "milling_h": 5, "cycle_min": 20, "pause_min": 10},
        "contact_set": {
            "name": "their_set",
            "source": "measured",
            "restitution": 0.3,
            "static_friction": 0.3,
            "rolling_friction": 0.045,
            "young_modulus_gpa": 2.05,
            "poisson_ratio": 0.235,
        },
        "fingerprint": {
            "counting_rule": "gap",
            "collisions_by": "surface",
            "collision_gap_turns": gap_turns,
            "probability": 0.95,
            "descriptors": descriptors,
        },
        "software": {"name": "otherprint", "version": "2"},
    }


@pytest.fixture
def written(tmp_path):
    """A function that writes a card's content and returns its path."""

    def write(content: dict):
        path = tmp_path / "card.json"
        path.write_text(json.dumps(content))
        return path

    return write


def test_a_card_of_another_program_meets_the_schema_and_is_read(written):
    content = card_content()
    Draft202012Validator(json.loads(card_schema_text())).validate(content)
    card = read_card(written(content))
    assert card.balls.number == 24 and card.heat is None
    # What is written again is the same card.
    assert read_card(written(card.model_dump(mode="json"))) == card


@pytest.mark.parametrize("part", ["machine", "fingerprint", "software", "schema_version", "format"])
def test_the_schema_and_the_reader_refuse_a_card_without_a_part(written, part):
    content = card_content()
    del content[part]
    with pytest.raises(ValidationError):
        Draft202012Validator(json.loads(card_schema_text())).validate(content)
    line = refusal(read_card, written(content))
    assert "card.json" in line and part in line


@pytest.mark.parametrize("version", [1, 0, "2", None, True])
def test_a_card_of_another_version_is_refused_in_one_line(written, version):
    line = refusal(read_card, written(card_content() | {"schema_version": version}))
    assert "card.json: schema_version = " in line and "must be 3" in line


@pytest.mark.parametrize("text", ["{", "[1]", '{"format": "millprint fingerprint 1"}', "\x00"])
def test_a_file_that_is_no_card_is_refused_in_one_line(tmp_path, text):
    (tmp_path / "no.json").write_text(text)
    assert "no.json" in refusal(read_card, tmp_path / "no.json")


def windows(rng: np.random.Generator, seeds: int, turns: int) -> list[Window]:
    """Windows of independent turns, all of one condition."""
    found = []
    for _ in range(seeds):
        normal, tangential = rng.gamma(20, 0.05, turns), rng.gamma(15, 0.1, turns)
        squares = [rng.gamma(10, 0.01, turns), rng.gamma(8, 0.02, turns)]
        counts = [rng.poisson(mean, turns) for mean in (80, 130, 40)]
        found.append(Window(np.column_stack([normal, tangential, ROLLING * normal, *squares, *counts]), 0.1, 24, True))
    return found


def whole(window: Window) -> dict[str, float]:
    totals = window.totals.sum(axis=0)
    return {
        name: float(value)
        for name, value in descriptors_of_totals(totals, len(window.totals) * window.revolution_s, window.balls).items()
    }


@pytest.mark.slow
@pytest.mark.parametrize(("seeds", "turns"), [(1, 8), (2, 8), (3, 4)])
def test_the_interval_by_scatter_holds_a_new_simulation(seeds, turns):
    rng, draws = np.random.default_rng(1), 600
    hits = dict.fromkeys(whole(windows(rng, 1, turns)[0]), 0)
    for _ in range(draws):
        known, new = windows(rng, seeds, turns), whole(windows(rng, 1, turns)[0])
        values = [whole(window) for window in known]
        widths = spread(known, values, [{}] * seeds, 0.95)
        for name, half in widths.items():
            middle = np.mean([np.log(own[name]) for own in values])
            hits[name] += abs(np.log(new[name]) - middle) <= half.new
    shares = {name: count / draws for name, count in hits.items()}
    assert all(0.92 <= share <= 0.995 for share in shares.values()), shares


@pytest.mark.slow
@pytest.mark.parametrize("seeds", [3, 4, 6])
def test_both_bands_hold_seeds_that_lock_onto_different_motions(seeds):
    """Three lasting motions that hardly vary from turn to turn: only the seeds tell how far a run may lie."""
    rng, draws, hits = np.random.default_rng(5), 400, np.zeros(2)
    motions = np.array([0.8, 1.0, 1.2])

    def locked() -> Window:
        turns = rng.choice(motions) * (1 + 1e-4 * rng.standard_normal(20))
        return Window(np.column_stack([*[turns] * 5, *[np.full(20, 80.0)] * 3]), 0.1, 24, True)

    for _ in range(draws):
        known, new = [locked() for _ in range(seeds)], whole(locked())["wall_power_W"]
        values = [whole(window) for window in known]
        middle = np.mean([np.log(own["wall_power_W"]) for own in values])
        half = spread(known, values, [{}] * seeds, 0.95)["wall_power_W"]
        hits += [abs(np.log(new) - middle) <= half.new, abs(np.log(30 * motions).mean() - middle) <= half.mean]
    # Three seeds of one and the same motion, one draw in nine, know of no other.
    alike = 3.0 ** (1 - seeds)
    assert (hits / draws >= 0.9 * (1 - alike)).all(), hits / draws


def test_seeds_that_differ_more_than_their_windows_widen_the_interval():
    rng = np.random.default_rng(2)
    alike = windows(rng, 2, 8)
    other = Window(alike[1].totals * [3, 3, 3, 9, 9, 1, 1, 1], 0.1, 24, True)
    narrow, wide = (
        spread(both, [whole(window) for window in both], [{}, {}], 0.95) for both in (alike, [alike[0], other])
    )
    assert wide["wall_power_W"].new > 4 * narrow["wall_power_W"].new
    assert wide["specific_frequency_hz"].new == pytest.approx(narrow["specific_frequency_hz"].new)


@pytest.mark.filterwarnings("error")
def test_turns_without_an_impact_leave_the_bands_that_they_tell_nothing_of():
    """All collisions are in the first turn, so that without it there are none."""
    (window,) = windows(np.random.default_rng(3), 1, 8)
    quiet = window.totals * [[1.0] * 8, *[[1, 1, 1, 1, 1, 0, 0, 0]] * 7]
    slid = quiet * [[1.0] * 8, *[[0, 1, 1, 0, 1, 0, 0, 0]] * 7]
    for totals, lost in ((quiet, "normal_energy_J"), (slid, "weighted_normal_frequency_hz")):
        found, _ = jackknife(Window(totals, 0.1, 24, True))
        assert lost not in found and np.isfinite(list(found.values())).all() and "tangential_power_W" in found


def test_one_turn_of_one_seed_has_no_interval():
    (window,) = windows(np.random.default_rng(3), 1, 1)
    assert jackknife(window) == ({}, 0)
    assert spread([window], [whole(window)], [{}], 0.95) == {}


@pytest.mark.parametrize(
    ("value", "text"),
    [(0.0, "0"), (30.0, "30.0"), (6.687, "6.69"), (0.9996, "1.00"), (1234.5, "1230"), (2.5e-5, "2.50e-05")],
)
def test_numbers_have_three_digits(value, text):
    assert three(value) == text


def test_units_have_prefixes():
    factor, unit = prefix_of(2.2e-4, "J")
    assert unit == "µJ" and factor == pytest.approx(1e6)
    # As it is rounded.
    assert [prefix_of(value, "W") for value in (999.4, 999.6, 1e3)] == [(1.0, "W"), (1e-3, "kW"), (1e-3, "kW")]
    assert [prefix_of(value, "J")[1] for value in (1e-6, 9.9951e-7, 1e-12, 1e12)] == ["µJ", "µJ", "nJ", "MJ"]
    assert prefix_of(12.0, "kJ/g") == (1.0, "kJ/g") and plain(96.77) == "96.8" and plain(30.0) == "30"


def test_what_is_not_finite_has_neither_digits_nor_a_prefix():
    assert [three(value) for value in (np.nan, np.inf, -np.inf)] == [NOT_KNOWN, "inf", "-inf"]
    assert prefix_of(np.nan, "W") == prefix_of(-np.inf, "W") == (1.0, "W")


def test_the_methods_paragraph_has_the_cards_numbers(written):
    content = card_content()
    card = read_card(written(content))
    text = methods_paragraph(card)
    values = card.fingerprint.descriptors
    for expected in (
        "700 rpm", "24 balls of 10 mm", "96.8 g", "3.23 g of NaBO2", "ratio of 30", "10 h in cycles of 20 min",
        "5 h of milling", "otherprint 2", f"{GAP:g} turns", "restitution 0.3", three(values.wall_power_W.value),
        three(values.specific_frequency_hz.value),
    ):  # fmt: skip
        assert expected in text, expected
    content["machine"]["speed_rpm"] = 350.0
    assert "350 rpm" in methods_paragraph(read_card(written(content)))
    # Without powder there is no dose, and no sentence on it.
    bare = MillingCard(**{**card_content(), "powder": None, "programme": None})
    assert "powder" not in methods_paragraph(bare)


def test_of_several_motions_the_texts_have_the_numbers_of_each(written):
    content = card_content()
    assert "in brackets" in methods_paragraph(read_card(written(content)))
    for name, own in content["fingerprint"]["descriptors"].items():
        content["fingerprint"]["descriptors"][name] = {
            "value": own["value"], "unit": "W", "motions": [1.5 * own["value"], 0.1 * own["value"]]
        }  # fmt: skip
    card = read_card(written(content))
    power = card.fingerprint.descriptors.wall_power_W
    factor, _ = prefix_of(power.value, power.unit)
    for text in (methods_paragraph(card), latex_table(card)):
        assert three(factor * power.value) not in text and "in brackets" not in text
        assert all(three(factor * share * power.value) in text for share in (1.5, 0.1))


def test_a_card_has_the_numbers_of_each_lasting_motion_and_the_runs_of_the_first(tmp_path):
    runs = [summary(0.10, seed=seed, noise=noise, error=1e-4) for seed, noise in enumerate((2.0, 0.0, 0.001))]
    paths = [str(tmp_path / f"{seed}.h5") for seed in range(3)]
    for path in paths:
        with h5py.File(path, "w") as file:
            file.create_group("collisions")
    found, _, against, first = describe_runs(Runs(runs, paths), CardSettings(counting_rule="gap_0_03"), None)
    powers = [own["power_W"]["wall"] for own in runs]
    assert found.wall_power_W.values == pytest.approx((np.mean(powers[1:]), powers[0]))
    assert first.paths == paths[1:] and "several motions last" in against[-1]
    # Alike in all motions: what does not depend on the power.
    assert found.tangential_share.values == pytest.approx([found.tangential_share.value] * 2)
    found, _, _, first = describe_runs(Runs(runs[1:], paths[1:]), CardSettings(counting_rule="gap_0_03"), None)
    assert found.wall_power_W.motions is None and first.paths == paths[1:]


def test_the_speed_is_shown_in_the_unit_of_the_mill_and_one_ball_is_one(written):
    content = card_content(speed_rpm=1500.0)
    content["machine"]["speed_unit"] = "hz"
    content["balls"]["sizes"][0]["number"] = 1
    card = read_card(written(content))
    for text in (methods_paragraph(card), latex_table(card)):
        assert "25 Hz" in text and "rpm" not in text and "1 ball of 10 mm" in text


def test_latex_prints_every_sign_as_it_is():
    assert escape(r"a_b & 5 % {x} $y^2 #~\ <") == (
        r"a\_b \& 5 \% \{x\} \$y\textasciicircum{}2 \#\textasciitilde{}\textbackslash{} \textless{}"
    )


def test_the_latex_table_is_whole(written):
    text = latex_table(read_card(written(card_content())))
    assert text.count(r"\begin{") == text.count(r"\end{") == 2
    body = text[text.index(r"\toprule") :]
    # No bare sign of LaTeX: each row has the cells of its columns, and ends.
    rows = [line for line in body.splitlines() if line.endswith(r"\\")]
    for row in rows:
        cells = len(re.findall(r"(?<!\\)&", row)) + 1
        assert cells == (2 if "multicolumn" in row else 6), row
    assert r"Other\_mill \#1" in text and r"50 \% \& more" in text
    assert not re.search(r"(?<!\\)%", body)


def test_bibtex_cites_what_the_card_rests_on(written):
    content = card_content()
    text = bibtex(read_card(written(content)))
    keys = re.findall(r"^@\w+\{([^,]+),", text, re.MULTILINE)
    assert len(set(keys)) == len(keys) and {"otherprint", "cundall1979", "contact:their-set"} <= set(keys)
    assert text.count("{") == text.count("}")
    assert "garrido2026" not in keys and "taylor1934" not in keys
    content["machine"]["source"] = "Thesis Sec. 3.2"
    content["reference"] = "@article{own,\n title = {x}\n}"
    text = bibtex(read_card(written(content)))
    assert "garrido2026" in text and "@article{own," in text


@pytest.mark.slow
def test_a_card_of_a_simulated_setting_finds_that_setting(written):
    """The synthetic mill predicts the card exactly: the ranking ends where the card was made."""
    card, mill = read_card(written(card_content(0.10, 700.0))), fingerprint()
    _, table, (first, *further) = match_card(card, mill)
    best = table.iloc[0]
    assert best["fill_ratio"] == pytest.approx(0.10, rel=0.03) and best["speed_rpm"] == pytest.approx(700, rel=0.02)
    for name, chosen in (("weighted_normal_energy_J", "weighted"), ("normal_energy_J", "per_collision")):
        own = match_card(card, mill, SearchConfig(descriptors=chosen))[1].iloc[0]
        assert own[f"{name}_ratio"] == pytest.approx(1, abs=0.02)
        assert own[f"{name}_ratio_lower"] < 0.96 and own[f"{name}_ratio_upper"] > 1.04
    # The same powder, the same power: the same time, that of the card unless another is given.
    assert best["milling_h"] == pytest.approx(5, rel=0.06)
    assert match_card(card, mill, hours=8)[1]["milling_h"].iloc[0] == pytest.approx(8, rel=0.06)
    assert "balls of 10 mm" in first and any(line.startswith("5 h there is ") for line in further)


@pytest.mark.slow
def test_a_card_that_no_setting_meets_is_said_so(written):
    content = card_content(gap_turns=GAP)
    for name in ("weighted_normal_energy_J", "weighted_tangential_energy_J"):
        quantity = content["fingerprint"]["descriptors"][name]
        content["fingerprint"]["descriptors"][name] = {"value": 1e3 * quantity["value"], "unit": "J"}
    card, mill = read_card(written(content)), fingerprint()
    # A card without bands leaves it open at best.
    _, table, (line, *_) = match_card(card, mill)
    assert f"{card.name}: not known on" in line and set(table["verdict"]) == {"open"}
    _, _, (line,) = match_card(card, mill, SearchConfig(fill_ratios=[0.9, 0.95]))
    assert "none of the requested fill ratios" in line


@pytest.mark.slow
def test_collisions_counted_by_another_gap_are_refused_in_one_line(written):
    card = read_card(written(card_content(gap_turns=0.9)))
    with pytest.raises(ConfigError, match=r"gap of 0\.9 turns") as caught:
        match_card(card, fingerprint(), SearchConfig(descriptors="per_collision"))
    # Energy-weighted descriptors need no rule.
    assert match_card(card, fingerprint())[1].iloc[0]["fill_ratio"] == pytest.approx(0.10, rel=0.03)
    assert len(str(caught.value).splitlines()) == 1


@pytest.mark.parametrize("said", ["few turns", "few turns: 3 of 9", "few turns: 3 of 9: simulate longer: or not"])
def test_words_on_motion_of_other_programs_are_read_as_they_are(said):
    """Of their parts, the first two are told."""
    told = CardFingerprint.model_construct(motion=[said]).against
    assert "few turns" in told and ("3 of 9" in told) == ("3 of 9" in said) and "simulate" not in told
