"""Doses by hand, kinetics recovered from made-up yields, and a user's table with its faults."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy.optimize import curve_fit
from scipy.stats import f as f_distribution

from millprint.cli.commands import main as millprint
from millprint.config.errors import ConfigError
from millprint.dose.kinetics import (
    AXES,
    HITS,
    MODELS,
    NO_EFFECT,
    NORMAL,
    TANGENTIAL,
    TOTAL,
    aicc,
    doses,
    fit_kinetics,
    fit_law,
    own_doses,
    said_of_dose,
    shear_worth,
)
from millprint.thesis.regimes import curve_of, powder_of_ball, screening_doses
from tests.unit.synthetic_mill import fingerprint

ROOT = Path(__file__).parents[2]
BALL = (0.01, 7700.0)


def made_up(law: str, axis: str, *parameters: float, noise: float = 0.0) -> pd.DataFrame:
    """24 runs whose axes are independent of each other, with yields by a law over one of them."""
    random = np.random.default_rng(3)
    table = pd.DataFrame({name: random.uniform(1, 20, 24) for name in AXES})
    table["case"] = [str(number) for number in range(24)]
    table[TANGENTIAL] = 0.6 * table[TOTAL]
    values = MODELS[law].law(table[axis].to_numpy(), *parameters)
    return table.assign(yield_percent=values + noise * random.standard_normal(24))


def test_the_dose_of_a_ball_by_hand():
    """A steel ball of 10 mm has 4.03 g; at a ratio of 10 it shares 0.403 g, and dissipates 400 * 721 uJ a second."""
    one = pd.Series([1.0])
    powder = powder_of_ball(10 * one, *BALL)
    assert powder[0] == pytest.approx(0.40317, rel=1e-4)
    found = doses(221e-6 * one, 500e-6 * one, 400 * one, 5 * one, powder).iloc[0]
    assert found[HITS] == pytest.approx(400 * 5 * 3600 / 0.40317, rel=1e-4)
    assert found[NORMAL] == pytest.approx(found[HITS] * 221e-9)
    assert found[TANGENTIAL] == pytest.approx(found[HITS] * 500e-9)
    assert found[TOTAL] == pytest.approx(found[HITS] * 721e-9)


def test_twice_the_powder_halves_the_dose_of_the_screening_runs():
    table = screening_doses(ROOT / "config/data/screening.tsv", *BALL).set_index("case")
    assert table.loc["14", TOTAL] / table.loc["20", TOTAL] == pytest.approx(30 / 50)
    assert table.loc["6", TOTAL] / table.loc["4", TOTAL] == pytest.approx(20 / 5)


def test_the_laws_by_hand():
    dose = np.array([1.0, 2.0, 4.0])
    for law, parameters, exponents in (
        ("first order", (0.5,), [0.5, 1, 2]),
        ("Avrami", (0.5, 2.0), [0.25, 1, 4]),
        # Nothing happens up to three eighths of the largest dose.
        ("threshold", (0.5, 0.375), [0, 0.25, 1.25]),
    ):
        assert MODELS[law].law(dose, *parameters) == pytest.approx(100 * (1 - np.exp(-np.array(exponents))))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("law", "axis", "parameters"),
    [("first order", TOTAL, (0.1,)), ("Avrami", "time_h", (0.1, 2.5)), ("threshold", NORMAL, (0.15, 0.3))],
)
def test_the_law_and_the_axis_of_made_up_yields_are_found(law, axis, parameters):
    runs = made_up(law, axis, *parameters, noise=1.0)
    if axis == TOTAL:
        # Tangential dose is a fixed part of it here, and so cannot be told apart.
        runs[TANGENTIAL] = np.random.default_rng(8).uniform(1, 20, len(runs))
    table = fit_kinetics(runs)
    best = table.iloc[0]
    assert (best["x"], best["model"]) == (axis, law)
    assert best["k"] == pytest.approx(parameters[0], rel=0.05)
    if law == "Avrami":
        assert best["n"] == pytest.approx(parameters[1], rel=0.1)
    if law == "threshold":
        assert best["x0"] == pytest.approx(parameters[1] * runs[axis].max(), rel=0.1)
    assert table["weight"].sum() == pytest.approx(1.0)
    assert table["delta_aicc"].is_monotonic_increasing and best["delta_aicc"] == 0
    curve = curve_of(best, runs[axis].max())
    assert np.interp(runs[axis], curve["x"], curve["yield_percent"]) == pytest.approx(
        MODELS[law].law(runs[axis].to_numpy(), *parameters), abs=4
    )


@pytest.mark.slow
def test_yields_without_a_cause_have_no_effect_as_the_best():
    runs = made_up("first order", TOTAL, 0.1)
    runs["yield_percent"] = 50 + np.random.default_rng(1).standard_normal(len(runs))
    table = fit_kinetics(runs)
    best = table.iloc[0]
    assert best["model"] == NO_EFFECT and best["r2"] == 0
    assert best["rmse_pp"] == pytest.approx(runs["yield_percent"].std(ddof=0))
    # Akaike's weights by hand; the scatter is a parameter too.
    assert best["aicc"] == pytest.approx(aicc(24 * runs["yield_percent"].var(ddof=0), 24, 2))
    likelihood = np.exp(-(table["aicc"] - best["aicc"]) / 2)
    assert table["weight"].tolist() == pytest.approx((likelihood / likelihood.sum()).tolist())


def test_of_several_starts_the_best_fit_is_kept():
    """From a start at which all yields are 100 % the slope is 0, so that its fit stays there."""
    doses, model = np.arange(1.0, 25.0), MODELS["Avrami"]
    yields = model.law(doses / doses.mean(), 0.8, 1.5)
    stuck = fit_law(doses, yields, replace(model, starts=((500.0, 19.0),)))
    values, squares = fit_law(doses, yields, replace(model, starts=((500.0, 19.0), (0.5, 1.0), (900.0, 19.0))))
    assert stuck[1] == pytest.approx(((100 - yields) ** 2).sum()) and squares < 1e-6 * stuck[1]
    np.testing.assert_allclose(values, (0.8, 1.5), rtol=1e-5)


def test_aicc_by_hand_and_without_enough_runs():
    assert aicc(40.0, 10, 2) == pytest.approx(10 * np.log(4) + 4 + 12 / 7)
    assert aicc(40.0, 4, 2) == pytest.approx(4 * np.log(10) + 4 + 12)
    assert np.isinf(aicc(1.0, 4, 3))


def test_the_pair_that_dose_does_not_explain_is_told_with_its_shear():
    runs = made_up("first order", TOTAL, 0.1).head(6)
    runs = runs.assign(**{TOTAL: [1.0, 2, 4, 4.4, 8, 16], TANGENTIAL: [0.5, 1, 1, 2.2, 4, 8]})
    runs["yield_percent"] = [10.0, 20, 60, 30, 62, 80]
    said = said_of_dose(runs, fit_kinetics(runs), "tests")
    assert "runs 2 and 3: 4 and 4.4 kJ/g, but 60 and 30 %, with 25 and 50 % of it tangential." in said
    apart = said_of_dose(runs.assign(**{TOTAL: [1.0, 2, 4, 8, 16, 32]}), fit_kinetics(runs), "tests")
    assert "No two runs have doses within 25 %" in apart
    rows = [("threshold", TOTAL, 10.0, 0.6, 0.8), ("Avrami", "time_h", 13.0, 0.3, 0.5), (NO_EFFECT, "", 40.0, 0.1, 0.0)]
    table = pd.DataFrame(rows, columns=["model", "x", "aicc", "weight", "r2"])
    said = said_of_dose(runs, table.assign(delta_aicc=table["aicc"] - 10), "tests")
    assert "The smallest AICc has threshold over" in said and "(weight 0.60), 30.0 below no effect" in said
    assert "dose is better than time by 3.0" in said


@pytest.mark.parametrize(("yields", "why"), [([50.0] * 4, "at least 5"), ([50.0] * 6, "all are 50")])
def test_too_few_or_equal_yields_are_refused(yields, why):
    runs = made_up("first order", TOTAL, 0.1).head(len(yields)).assign(yield_percent=yields)
    with pytest.raises(ConfigError, match=why):
        fit_kinetics(runs)


@pytest.mark.slow
@pytest.mark.parametrize("worth", [5.0, 1.0])
def test_the_worth_of_shear_is_found_within_its_interval(monkeypatch, worth):
    # A hundred fits: two starts in place of nine are enough here.
    monkeypatch.setitem(MODELS, "Avrami", replace(MODELS["Avrami"], starts=((0.5, 1.0), (0.5, 3.0))))
    runs, random = made_up("first order", TOTAL, 0.1), np.random.default_rng(4)
    normal, tangential = random.uniform(1, 20, (2, len(runs)))
    dose = normal + worth * tangential
    yields = MODELS["Avrami"].law(dose / dose.mean(), 0.6, 1.2) + random.standard_normal(len(runs))
    runs = runs.assign(**{NORMAL: normal, TANGENTIAL: tangential, TOTAL: normal + tangential, "yield_percent": yields})
    found = shear_worth(runs)
    assert found.lower < worth < found.upper and found.lower < found.worth < found.upper
    assert found.upper / found.lower < 2 and (found.gain_aicc > 0) == (worth != 1)
    # At both ends the sum of squares is S_min (1 + F / (N - p)), by scipy's fit of k and n, with w the third of p.
    least, *ends = (_squares_left(normal + own * tangential, yields) for own in (found.worth, found.lower, found.upper))
    assert found.law == "Avrami"
    assert ends == pytest.approx(2 * [least * (1 + f_distribution.ppf(0.95, 1, 21) / 21)], rel=0.01)


def _squares_left(dose: np.ndarray, yields: np.ndarray) -> float:
    reduced = dose / dose.mean()
    found, _ = curve_fit(lambda x, rate, order: 100 * (1 - np.exp(-((rate * x) ** order))), reduced, yields, (0.6, 1.2))
    return float(np.sum((yields - 100 * (1 - np.exp(-((found[0] * reduced) ** found[1])))) ** 2))


OWN = pd.DataFrame({
    "case": ["a", "b"], "mill": "emax", "powder_mass_g": [2.0, 4.0], "time_h": [1.0, 2.0],
    "fill_ratio": 0.1, "speed_rpm": 600.0, "ball_diameter_mm": 10.0,
})  # fmt: skip


@pytest.fixture(scope="module")
def known():
    own = fingerprint()
    return {own.about["mill"]: own}


def test_own_runs_have_the_dose_of_their_power(known, tmp_path):
    """Dose times powder is power times time; twice the powder for twice the time has seen the same."""
    OWN.assign(mill=next(iter(known))).to_csv(tmp_path / "runs.tsv", sep="\t", index=False)
    table = own_doses(tmp_path / "runs.tsv", known)
    energy = (table["wall_power_W"] * OWN["time_h"] * 3600).to_numpy()
    assert (table[TOTAL] * OWN["powder_mass_g"] * 1e3).to_numpy() == pytest.approx(energy, rel=1e-6)
    assert table[HITS][0] == pytest.approx(table[HITS][1])


@pytest.mark.parametrize(
    ("column", "value", "part"),
    [
        ("speed_rpm", 10.0, "case a: speed_rpm = 10: .* another unit\\? Write 600"),
        ("ball_diameter_mm", 0.01, "case a: ball_diameter_mm = 0.01: .* another unit\\? Write 10"),
        ("fill_ratio", 20.0, "case a = 20: must be under 1; write 0.2 for 20 %"),
        ("powder_mass_g", 1e-300, "powder_mass_g, case a = 1e-300: must be between 1e-06 and 1e[+]09"),
    ],
)
def test_the_likely_mistake_in_a_table_of_runs_is_named(known, tmp_path, column, value, part):
    OWN.assign(mill=next(iter(known)), **{column: value}).to_csv(tmp_path / "runs.tsv", sep="\t", index=False)
    with pytest.raises(ConfigError, match=part):
        own_doses(tmp_path / "runs.tsv", known)


@pytest.mark.slow
def test_a_mill_is_named_where_its_fingerprint_is_known(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    runs = OWN.assign(mill="planetary", speed_rpm=400.0, ball_diameter_mm=10.0, fill_ratio=0.2)
    runs.to_csv("runs.tsv", sep="\t", index=False)
    assert not millprint(["dose", "runs.tsv", "planetary"]) and "planetary" in capsys.readouterr().out
    assert millprint(["dose", "runs.tsv", "planetry"]) == 1
    assert "did you mean planetary?" in capsys.readouterr().err


@pytest.mark.slow
def test_one_command_prints_doses_kinetics_and_a_verdict(known, tmp_path, capsys):
    ((mill, own),) = known.items()
    own.write(tmp_path / "fingerprint.json")
    runs = pd.concat([OWN.head(1)] * 6, ignore_index=True).assign(case=list("abcdef"), mill=mill)
    runs = runs.assign(time_h=[1, 2, 4, 6, 8, 10], yield_percent=[9, 18, 33, 45, 55, 63])
    runs.to_csv(tmp_path / "runs.tsv", sep="\t", index=False)
    paths = [str(tmp_path / name) for name in ("runs.tsv", "fingerprint.json")]
    millprint(["dose", *paths, "--out", str(tmp_path / "d.tsv")])
    assert "first order" in capsys.readouterr().out and len(pd.read_csv(tmp_path / "d.tsv", sep="\t")) == 6
    # Doses do not need what kinetics need.
    runs.assign(yield_percent=40).to_csv(tmp_path / "runs.tsv", sep="\t", index=False)
    assert millprint(["dose", *paths]) == 0
    assert capsys.readouterr().out.endswith(
        "no kinetics: column yield_percent: all are 40; kinetics need yields that differ\n"
    )
