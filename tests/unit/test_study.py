"""The study of a mill's settings: its variants, the rule of its verdict on made-up runs, its line, its files."""

import re

import numpy as np
import pytest

from millprint.cases.of_mill import mill_cases, study_variants
from millprint.config.errors import ConfigError
from millprint.config.fingerprint import StudyConfig
from millprint.config.included import load_contact, load_mill
from millprint.config.mill_sweep import MillsConfig
from millprint.config.sweep import DemConfig, mill_of
from millprint.dem.laws.registry import step_scale
from millprint.estimate.judge import AGREES, DIFFERS, OPEN
from millprint.fingerprint.study import (
    changes_of_halves,
    check_study,
    conclude,
    judge_change,
    study_row,
    tabulate_study,
)
from millprint.mill.vessel import build_vessel
from tests.unit.synthetic_mill import summary

STUDY = StudyConfig()
VARIANTS = (("reference", 1.0), ("time_step", 0.5), ("time_step", 2.0), ("stiffness", 3.0), ("facets", 2.0))


CALIBRATED = load_contact("calibrated")
MILLS = MillsConfig(contact="calibrated", precision="standard")


def made_run(seed: int, noise: float, drift: float = 0.0) -> dict:
    """A run whose powers are 1 + noise times those of the mill, and rise by `drift` of the mean over its window."""
    made = summary(seed=seed, noise=noise)
    for name, energies in made["per_revolution"].items():
        ramp = 1 + drift * np.linspace(-0.5, 0.5, len(energies))
        made["per_revolution"][name] = list(np.mean(energies) * ramp)
    return made | {"young_modulus_pa": 2.05e9, "time_step_s": 2e-6, "processor_s": 1.0}


def made_study(spread=0.005, effects=(), seeds=6, drift=0.0, random=1):
    """Runs of VARIANTS; effects: relative change of the powers of a setting's variants."""
    rng, effects = np.random.default_rng(random), dict(effects)
    return {
        variant: [
            made_run(seed, effects.get(variant[0], 0.0) + spread * rng.standard_normal(), drift + 0.01 * rng.normal())
            for seed in range(seeds)
        ]
        for variant in VARIANTS
    }


def checks_of(runs: dict, sweep_seeds: int = 1, study: StudyConfig = STUDY) -> list:
    table = tabulate_study([study_row(*variant, 0.0, group, "gap_0_03") for variant, group in runs.items()])
    halves = changes_of_halves([run for group in runs.values() for run in group])
    return check_study(table, halves, sweep_seeds, study)


def concluded(study: StudyConfig = STUDY, sweep_seeds=1, **changes) -> dict:
    return conclude("mine", checks_of(made_study(**changes), sweep_seeds, study), study)


def test_settings_that_change_nothing_agree():
    found = concluded()
    assert found["verdict"] == AGREES
    assert found["settings"] == dict.fromkeys(("time_step", "stiffness", "facets", "window", "seeds"), AGREES)
    assert found["line"].startswith("mine: the sweep agrees with finer settings: time step, stiffness, facets,")
    assert "change no descriptor by more than 5 %" in found["line"] and "\n" not in found["line"]


def test_a_setting_that_changes_a_descriptor_is_named_with_what_to_do():
    found = concluded(effects={"stiffness": 0.2})
    assert found["verdict"] == DIFFERS
    assert found["settings"]["stiffness"] == DIFFERS and found["settings"]["time_step"] == AGREES
    assert "differs from finer settings: 3 times the stiffness, " in found["line"] and "+20 ± " in found["line"]
    assert "raise young_modulus_gpa of the contact set" in found["line"]


def test_scatter_that_hides_a_change_is_open_and_says_how_many_seeds_would_show_it():
    found = concluded(spread=0.05, seeds=4, sweep_seeds=100)
    assert found["verdict"] == OPEN and found["settings"]["seeds"] == AGREES
    assert "is open: the scatter between seeds hides a change of 5 %" in found["line"]
    needed = max(check["seeds"] or 0 for check in found["checks"])
    assert needed > 4
    more = concluded(spread=0.05, seeds=4 * needed, sweep_seeds=100)
    assert more["verdict"] == AGREES


def test_a_window_in_which_the_power_still_rises_differs():
    """A rise by 30 % of the mean over the window: the halves differ by some 15 %."""
    found = concluded(drift=0.3)
    assert found["settings"]["window"] == DIFFERS and found["settings"]["stiffness"] == AGREES
    assert re.search(r"window, \w+ power \+1[5-8] ± ", found["line"]) and "raise sweep.discard_turns" in found["line"]


def test_a_sweep_with_too_few_seeds_is_told_how_many_it_needs():
    """10 % between seeds: 1.96 x 10 / sqrt(n) is within 5 % from about 16 seeds on."""
    found = concluded(spread=0.1, seeds=40)
    assert found["settings"]["seeds"] == DIFFERS
    needed = [check["seeds"] for check in found["checks"] if check["setting"] == "seeds" and check["seeds"]]
    assert 11 < max(needed) < 23
    assert f"give sweep.seeds {max(needed)} seeds" in found["line"]
    assert concluded(spread=0.1, seeds=40, sweep_seeds=40)["settings"]["seeds"] == AGREES


def test_only_refinements_decide():
    """A coarser step that changes much says that the step cannot be doubled, not that it is too long."""
    runs = made_study()
    runs[("time_step", 2.0)] = [made_run(seed, 0.4) for seed in range(6)]
    checks = checks_of(runs)
    assert conclude("mine", checks, STUDY)["verdict"] == AGREES
    assert any(check.verdict == DIFFERS and check.factor == 2.0 for check in checks)


def test_a_change_as_large_as_the_tolerance_is_rarely_taken_for_good_and_rarely_for_bad():
    """At the tolerance itself both errors are possible: the first in 5 %, the second in 5 % over 20 comparisons."""
    rng, number = np.random.default_rng(2), 4000
    drawn = [(5.0 + rng.normal(), float(np.sqrt(rng.chisquare(20) / 20))) for _ in range(number)]
    found = [judge_change(*each, 20, 20, STUDY).word for each in drawn]
    assert found.count(AGREES) / number == pytest.approx(0.05, abs=0.015)
    assert found.count(DIFFERS) / number == pytest.approx(0.0025, abs=0.0025)


def test_one_seed_decides_nothing():
    assert judge_change(0.0, float("nan"), 0, 5, STUDY).word == OPEN


def test_variants_change_one_setting_of_one_condition():
    mill = load_mill("planetary")
    variants = study_variants(mill, CALIBRATED, MILLS, DemConfig(), STUDY, {})
    assert [(v.setting, v.factor) for v in variants] == [
        ("reference", 1.0), ("time_step", 0.5), ("time_step", 2.0), ("stiffness", 0.3), ("stiffness", 3.0),
        ("facets", 0.5), ("facets", 2.0),
    ]  # fmt: skip
    reference = variants[0].cases
    assert [case.seed for case in reference] == [0, 1, 2, 3, 4, 5]
    assert (reference[0].speed_hz, reference[0].ball_diameter_m, reference[0].fill_ratio) == (5, 0.01, 0.2)
    # The sweep has the same case, so that it is simulated once.
    assert reference[0] in mill_cases(mill, MILLS)
    rayleigh = step_scale(CALIBRATED, 0.005)
    assert variants[1].cases[0].time_step_s == pytest.approx(0.5 * 0.08 * rayleigh, rel=1e-3)
    assert variants[4].cases[0].young_modulus_gpa == pytest.approx(6.15)
    assert [variant.cases[0].facets for variant in variants[5:]] == [24, 96]
    names = [case.path for variant in variants for case in variant.cases]
    assert len(set(names)) == len(names)


def test_a_step_that_is_not_allowed_and_facets_that_a_shape_lacks_are_left_out():
    mill = load_mill("planetary")
    box = mill.model_copy(
        update={"geometry": mill.model_validate({**mill.model_dump(), "geometry": BOX}).geometry, "volume_ml": 250}
    )
    variants = study_variants(box, CALIBRATED, MILLS, DemConfig(rayleigh_fraction_max=0.1), STUDY, {})
    assert [(v.setting, v.factor) for v in variants][1:] == [("time_step", 0.5), ("stiffness", 0.3), ("stiffness", 3.0)]


BOX = {"kind": "box", "x_mm": 60, "y_mm": 60, "z_mm": 69.4}


def test_facets_of_a_case_are_those_of_its_walls():
    mill = load_mill("drum")
    (reference, *_), *_ = (v.cases for v in study_variants(mill, CALIBRATED, MILLS, DemConfig(), STUDY, {}))
    changed = reference.model_copy(update={"facets": 24})
    assert len(build_vessel(mill_of(changed, mill)).facets) == 24 + 2
    assert mill_of(reference, mill) is mill
    with pytest.raises(ConfigError, match=r"mill drum: facets = 2: .*greater than or equal to 3"):
        mill_of(reference.model_copy(update={"facets": 2}), mill)
    box = mill.model_validate({**mill.model_dump(), "geometry": BOX})
    with pytest.raises(ConfigError, match="the geometry is a box, which has no facets"):
        mill_of(changed, box)


def test_a_mill_whose_walls_have_no_facets_says_so():
    runs = {variant: group for variant, group in made_study().items() if variant[0] != "facets"}
    found = conclude("mine", checks_of(runs), STUDY)
    assert found["verdict"] == AGREES and found["settings"]["facets"] == OPEN
    assert found["line"].endswith("; facets not run")
