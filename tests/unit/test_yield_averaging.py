"""The averaged Gaussian process: gradients, closed forms, stored models; and where it may be asked."""

from typing import ClassVar

import numpy as np
import pandas as pd
import pytest
from scipy.stats import multivariate_normal, norm

from millprint.config.yields import INPUTS, PredictionConfig, Priors
from millprint.run.files import read_json
from millprint.thesis.yields.averaging import (
    LINKS,
    AveragedModel,
    Candidate,
    evidence_weights,
    fit_averaged,
    to_conversion,
)
from millprint.thesis.yields.estimators import FIT_JITTER, MEAN_VARIANCE, fit_process, kernel_of, posterior_of, prior_of
from millprint.thesis.yields.experiments import Mill, described_settings
from millprint.thesis.yields.features import describe
from millprint.thesis.yields.groups import regime_rows
from millprint.thesis.yields.new_conditions import (
    DESCRIPTORS,
    MillCurves,
    correlation_warnings,
    domain_warnings,
    nearest_correlation,
)
from millprint.thesis.yields.stored_models import load_any, save_averaged, training_rows
from tests.unit.yield_settings import (
    CASES,
    CURVES,
    MILL,
    REFERENCE,
    SCALES,
    all_runs,
    fit_member,
    parts,
    settings,
    thesis_yields,
)

STRUCTURES = thesis_yields()["averaging"]["structures"]


def fitted() -> tuple[AveragedModel, pd.DataFrame]:
    rows, _ = parts()
    config = settings().averaging
    return fit_averaged(rows, rows["yield_percent"].to_numpy(float), config), rows


def covariance_of(structure: str, logs: np.ndarray, inputs: np.ndarray) -> np.ndarray:
    """The covariance (n, n) of a structure, entry by entry, with the variance of the mean and without noise."""
    count = len(INPUTS)
    factors = {
        "product": [range(count)],
        "mains_product": [*([k] for k in range(count)), range(count)],
        "time_product": [[INPUTS.index("time_h")], range(count)],
        "trend_product": [*([k] for k in range(count)), range(count)],
    }[structure]
    lengths, variances = np.exp(logs[:count]), np.exp(logs[count:-1])

    def of(left: np.ndarray, right: np.ndarray) -> float:
        total = MEAN_VARIANCE
        for variance, own in zip(variances, factors, strict=True):
            if structure == "trend_product" and len(own) == 1:
                total += variance * left[own[0]] * right[own[0]]
            else:
                total += variance * np.exp(-0.5 * sum(((left[k] - right[k]) / lengths[k]) ** 2 for k in own))
        return total

    return np.array([[of(left, right) for right in inputs] for left in inputs])


@pytest.mark.parametrize("structure", STRUCTURES)
def test_posterior_is_the_likelihood_of_its_kernel_times_the_prior(structure):
    """The value, which keeps parts of the covariance from call to call, against densities that know nothing of it."""
    generator = np.random.default_rng(4)
    inputs, target = generator.normal(size=(9, len(INPUTS))), generator.normal(size=9)
    kernel, priors = kernel_of(structure), settings().averaging.priors
    prior = prior_of(kernel, priors)
    posterior = posterior_of(inputs, target, kernel, priors)
    for spread in (0.0, 0.4, 0.8):
        logs = prior[0] + spread * generator.normal(size=len(prior[0]))
        covariance = covariance_of(structure, logs, inputs) + (np.exp(logs[-1]) + FIT_JITTER) * np.eye(len(target))
        # The density of the prior without its constants.
        own = (norm(*prior).logpdf(logs) - norm(*prior).logpdf(prior[0])).sum()
        density = multivariate_normal(cov=covariance).logpdf(target) + own
        assert posterior.negative_log(logs)[0] == pytest.approx(-density, rel=1e-9)


def test_evidence_is_the_integral_over_the_noise_where_nothing_else_is_free():
    """With length scales and the variance fixed by narrow priors, the evidence is one integral over the noise."""
    priors = settings().averaging.priors
    narrow = Priors(
        *(prior._replace(log_deviation=width) for prior, width in zip(priors, (1e-3, 1e-3, 0.4), strict=True))
    )
    generator = np.random.default_rng(0)
    inputs, kernel = generator.normal(size=(30, len(INPUTS))), kernel_of("product")
    target = inputs[:, 0] + 0.2 * generator.normal(size=30)
    _, evidence = fit_process(inputs, target / target.std(), kernel, narrow)
    prior = prior_of(kernel, narrow)
    posterior = posterior_of(inputs, target / target.std(), kernel, narrow)
    noise = prior[0][-1] + np.linspace(-3, 3, 601)
    # The integral over the narrow priors is 1. The value lacks the constant of the density of the noise's.
    constant = norm(*prior).logpdf(prior[0])[-1]
    heights = [constant - posterior.negative_log(np.append(prior[0][:-1], at))[0] for at in noise]
    exact = np.log(np.trapezoid(np.exp(np.array(heights) - max(heights)), noise)) + max(heights)
    assert evidence == pytest.approx(exact, abs=0.05)


@pytest.mark.parametrize("link", ["identity", "logit", "avrami"])
def test_the_evidence_is_that_of_the_yields_by_the_slope_of_the_whole_transformation(link):
    rows, _ = parts()
    config, yields = settings().averaging, rows["yield_percent"].to_numpy(float)
    member = fit_member(Candidate(link, SCALES, "product"), rows, yields, config)
    process, conversion = member.process, to_conversion(yields, config.margin)
    _, of_target = fit_process(process.inputs, process.target, process.kernel, config.priors)
    low, high = ((LINKS[link].forward(conversion + step) - member.mean) / member.spread for step in (-1e-6, 1e-6))
    assert member.log_evidence == pytest.approx(of_target + np.log((high - low) / 2e-6).sum(), rel=1e-6)


@pytest.mark.parametrize("name", ["identity", "logit", "avrami"])
def test_links_have_their_inverse_and_their_slope(name):
    link, conversion = LINKS[name], np.array([0.02, 0.3, 0.63, 0.95])
    np.testing.assert_allclose(link.inverse(link.forward(conversion)), conversion, rtol=1e-12)
    slope = (link.forward(conversion + 1e-7) - link.forward(conversion - 1e-7)) / 2e-7
    np.testing.assert_allclose(np.exp(link.log_slope(conversion)), slope, rtol=1e-5)


def test_avrami_link_makes_kinetics_a_straight_line_in_log_time():
    time = np.array([1.0, 3.0, 10.0])
    conversion = 1 - np.exp(-((0.1 * time) ** 0.7))
    slope = np.diff(LINKS["avrami"].forward(conversion)) / np.diff(np.log(time))
    np.testing.assert_allclose(slope, 0.7)
    assert to_conversion(np.array([0.0, 50.0, 100.0]), 0.005).tolist() == [0.005, 0.5, 0.995]


def test_deviation_of_a_prediction_is_the_diagonal_of_the_posterior_and_its_noise():
    rows, _ = parts()
    yields = rows["yield_percent"].to_numpy(float)
    process = fit_member(Candidate("identity", SCALES, "trend_product"), rows, yields, settings().averaging).process
    inputs = process.inputs[:6] + 0.3
    mean, covariance = process.posterior(inputs)
    one, deviation = process.predict(inputs)
    np.testing.assert_allclose(one, mean, rtol=1e-12)
    np.testing.assert_allclose(deviation**2, np.diag(covariance) + process.noise, rtol=1e-9)


def test_weights_are_posterior_probabilities():
    weights = evidence_weights(np.array([0.0, np.log(3.0), -50.0]), 0.01)
    np.testing.assert_allclose(weights, [0.25, 0.75, 0.0], rtol=1e-12)


def test_quantiles_of_one_identity_member_are_those_of_a_normal():
    rows, test = parts()
    member = fit_member(
        Candidate("identity", SCALES, "product"), rows, rows["yield_percent"].to_numpy(float), settings().averaging
    )
    model = AveragedModel([member], np.array([1.0]))
    mean, deviation = member.latent(describe(test).to_numpy())
    levels = np.array([0.1, 0.5, 0.9])
    normal = 100 * np.clip(mean[:, None] + deviation[:, None] * norm.ppf(levels), 0, 1)
    np.testing.assert_allclose(model.quantiles(test, levels), normal, atol=1e-6)
    np.testing.assert_allclose(model.predict(test), 100 * mean, rtol=1e-10)


def test_a_second_fit_and_the_stored_model_are_the_same(tmp_path):
    (model, rows), (again, _) = fitted(), fitted()
    _, test = parts()
    for number, each in enumerate((model, again)):
        save_averaged(each, rows, settings().averaging.margin, str(tmp_path / f"{number}.json"))
    assert (tmp_path / "0.json").read_bytes() == (tmp_path / "1.json").read_bytes()
    loaded = load_any(str(tmp_path / "0.json"))
    assert isinstance(loaded, AveragedModel)
    np.testing.assert_allclose(loaded.predict(test), model.predict(test), rtol=1e-12)
    np.testing.assert_allclose(loaded.intervals(test, [0.9])[:, 0].T, model.intervals(test, [0.9])[:, 0].T, rtol=1e-9)
    assert training_rows(str(tmp_path / "0.json"))["case"].tolist() == rows["case"].tolist()
    assert model.weights.sum() == pytest.approx(1)
    assert set(read_json(tmp_path / "0.json")["versions"]) == {"numpy", "scipy"}


TOLERANCE = settings().prediction.curve_tolerance

# The energies of 600 rpm at a fill ratio of 10 %, with the frequency of 1000 rpm.
MIXED = {"normal_energy_uJ": 221.0, "tangential_energy_uJ": 500.0, "specific_frequency_hz": 667.0}


def described(curves: pd.DataFrame = CASES, mill: Mill = MILL, **changes) -> pd.DataFrame:
    """One condition with the descriptors that the curves give."""
    setting = {"bpr": 30, "molar_ratio": 10, "time_h": 12.5, "speed_rpm": 700, "fill_ratio": 0.08}
    return described_settings(pd.DataFrame([setting | {"ball_diameter_mm": 10} | changes]), curves, mill)


def test_every_run_is_a_setting_of_the_mill():
    rows = pd.concat([all_runs(), regime_rows(CASES, REFERENCE)])
    assert CURVES.warnings(rows, TOLERANCE) == [""] * 31


@pytest.mark.parametrize("speed", [560, 700, 990])
@pytest.mark.parametrize("fill", [0.06, 0.075, 0.13, 0.17])
def test_what_the_curves_give_is_possible_and_what_they_do_not_is_not(speed, fill):
    row = described(speed_rpm=speed, fill_ratio=fill)
    assert CURVES.warnings(row, TOLERANCE) == [""]
    for name in DESCRIPTORS:
        assert CURVES.warnings(row.assign(**{name: 1.6 * row[name]}), TOLERANCE) != [""]


def test_energies_of_one_speed_with_the_frequency_of_another_are_refused():
    row = described(bpr=50, time_h=20).assign(**MIXED)
    (told,) = CURVES.warnings(row, TOLERANCE)
    assert told.startswith("descriptors that emax does not have at once") and "specific_frequency_hz" in told
    assert ";" not in told and "\n" not in told


def test_a_ball_size_or_a_speed_that_the_mill_does_not_have_is_refused():
    assert CURVES.warnings(described(ball_diameter_mm=7), TOLERANCE) != [""]
    assert CURVES.warnings(described(speed_rpm=1400), TOLERANCE) != [""]
    other = MillCurves("emax", CASES, MILL.density, MILL.amplitude, (7.0, 10.0), (540.0, 1500.0))
    assert other.warnings(described(ball_diameter_mm=7), TOLERANCE) == [""]
    assert other.warnings(described(speed_rpm=1400), TOLERANCE) == [""]
    # Smaller balls at a higher speed have these energies with this frequency.
    assert other.warnings(described().assign(**MIXED), TOLERANCE) == [""]


def test_a_descriptor_within_the_band_of_its_curve_is_possible():
    row = described()
    off = row.assign(specific_frequency_hz=1.25 * row["specific_frequency_hz"])
    assert CURVES.warnings(off, TOLERANCE) != [""]
    band = {f"{name}{end}": CASES[name] * (1 + step) for name in ("Pn", "Pt", "f") for end, step in BAND.items()}
    wide = MillCurves("emax", CASES.assign(**band), MILL.density, MILL.amplitude, (10.0,), (540.0, 1000.0))
    assert wide.warnings(off, TOLERANCE) == [""]


BAND = {"_lower": -0.2, "_upper": 0.25}


def one_member() -> tuple[AveragedModel, pd.DataFrame]:
    rows = all_runs()
    yields = rows["yield_percent"].to_numpy(float)
    member = fit_member(Candidate("avrami", SCALES, "product"), rows, yields, settings().averaging)
    return AveragedModel([member], np.array([1.0])), rows


def test_the_correlation_is_one_at_a_run_and_that_of_the_kernel_elsewhere():
    model, rows = one_member()
    np.testing.assert_allclose(nearest_correlation(model, rows, rows), 1)
    member = model.members[0]
    only, lengths = rows.iloc[[0]], np.exp(member.process.logs[:5])
    # One length scale further in the molar ratio, which is on a linear scale.
    step = lengths[1] * member.standard.deviation[1]
    moved = only.assign(molar_ratio=only["molar_ratio"] + step)
    assert nearest_correlation(model, only, moved)[0] == pytest.approx(np.exp(-0.5))
    far = only.assign(molar_ratio=only["molar_ratio"] + 20 * step)
    assert nearest_correlation(model, only, far)[0] < 1e-6
    (told,) = correlation_warnings(model, only, far, 0.5)
    assert told == "correlation = 0.00 with the yield of the nearest run is below 0.5"


def test_a_gap_inside_every_range_is_refused_by_the_correlation():
    """Each condition is within its trained range, and no run is near."""
    model, rows = one_member()
    corner = rows[(rows["bpr"] < 50) | (rows["time_h"] < 20)]
    limits = settings().prediction
    left_out = rows[(rows["bpr"] == 50) & (rows["time_h"] == 20)]
    assert domain_warnings(model, rows, left_out, limits, CURVES) == ["", "", ""]

    class Strict(PredictionConfig):
        correlation_min: ClassVar[float] = 0.99

    told = domain_warnings(model, corner, left_out, Strict(**limits.model_dump()), CURVES)
    assert all(text.startswith("correlation = ") for text in told)
