"""Numbers with intervals: sums, parts and ratios; and the verdicts on them as truth tables."""

import math

import numpy as np
import pytest
from pydantic import TypeAdapter
from scipy.stats import norm, ttest_ind

from millprint.estimate.estimates import (
    INTERVALS,
    Estimate,
    Interval,
    columns_of,
    difference_of,
    mean_of,
    odds_of,
    parts_of,
    ratio_of,
    share_of,
    total,
)
from millprint.estimate.judge import AGREES, DIFFERS, OPEN, Allowed, Verdict, judge, judge_all
from tests.refusals import truths


def made(value: float, lower: float, upper: float, name: str = "scatter", **more) -> Estimate:
    return Estimate(value, "W", **{name: Interval(lower, upper)}, **more)


def test_an_estimate_keeps_its_intervals_apart_through_a_factor_and_a_rising_function():
    own = Estimate(2.0, "-", scatter=Interval(1.5, 3.0), contact=Interval(1.0, 4.0))
    assert own * 10.0 == Estimate(20.0, "-", scatter=Interval(15.0, 30.0), contact=Interval(10.0, 40.0))
    assert share_of(own) == Estimate(2 / 3, "-", scatter=Interval(0.6, 0.75), contact=Interval(0.5, 0.8))
    assert odds_of(share_of(own)).ends("contact") == pytest.approx(own.ends("contact"))
    assert odds_of(made(0.8, 0.5, 1.0)).ends("scatter") == (1.0, np.inf)
    assert (own.lower, own.upper, own.hull(), own.hull(["scatter"])) == (1.5, 3.0, own.contact, own.scatter)
    assert np.isnan(own.ends("shape")).all() and Estimate(2.0, "-").hull() == Interval(2.0, 2.0)
    with pytest.raises(KeyError):
        own.ends("value")


def test_columns_and_files_have_the_names_of_the_intervals():
    names = [columns_of("x", name)[0] for name in INTERVALS]
    assert names == ["x_lower", "x_mean_lower", "x_by_contact_lower", "x_by_shape_lower", "x_by_repeats_lower"]
    assert made(2, 1, 3).columns("x") == {"x": 2, "x_lower": 1, "x_upper": 3}
    written = TypeAdapter(Estimate).dump_python(made(2, 1, 3, how="measured", of=3), exclude_none=True)
    assert written == {"value": 2, "unit": "W", "scatter": {"lower": 1, "upper": 3}}


def test_normal_tangential_and_rolling_power_are_all_power():
    parts = {"normal": made(60, 50, 75), "tangential": made(30, 20, 60), "rolling": made(10, 0, 90)}
    assert total(list(parts.values())) == made(100, 70, 225)
    # 60 + 30 + 10 = 100 W, known to lie between 90 and 115 W: rolling is at most 115 - 50 - 20 = 45 W.
    found = parts_of(made(100, 90, 115), parts)
    assert found["rolling"] == made(10, 0, 45) and found["tangential"] == made(30, 20, 60)
    assert found["normal"] == made(60, 50, 75)
    # A whole that is known better than its parts; the value of a part stays in its band.
    tight = parts_of(made(100, 99, 101), {"a": made(60, 59, 61), "b": made(40, 10, 90)})
    assert tight["b"] == made(40, 38, 42)
    with pytest.raises(ValueError, match="normal, tangential do not add up"):
        parts_of(made(100, 90, 115), {name: parts[name] for name in ("normal", "tangential")})


@pytest.mark.parametrize("seed", range(20))
def test_a_part_is_never_larger_or_less_sure_than_its_whole_allows(seed):
    """Whatever the bands of the parts: no end of a part beyond the upper end, no band wider than the whole's room."""
    rng = np.random.default_rng(seed)
    values = rng.uniform(1, 100, 3)
    parts = {
        str(place): made(value, value * rng.uniform(0.01, 1), value * rng.uniform(1, 50))
        for place, value in enumerate(values)
    }
    whole = made(values.sum(), values.sum() * rng.uniform(0.3, 1), values.sum() * rng.uniform(1, 3))
    for name, part in parts_of(whole, parts).items():
        assert 0 <= part.lower <= part.value <= part.upper <= whole.upper
        assert parts[name].lower <= part.lower and part.upper <= parts[name].upper
        others = total([other for key, other in parts.items() if key != name])
        assert part.upper <= max(whole.upper - others.lower, part.value)


def test_the_ratio_of_two_mills_has_the_interval_of_two_independent_ones():
    """Against a million draws of two log-normal quantities; and in closed form where one of them is known exactly."""

    def around(value, half):
        return Interval(value * np.exp(-half), value * np.exp(half))

    one = Estimate(2.0, "W", scatter=around(2.0, 0.3), contact=Interval(1.0, 5.0))
    other = Estimate(5.0, "W", scatter=around(5.0, 0.4), contact=Interval(4.0, 10.0), shape=Interval(4.0, 6.0))
    ratio = ratio_of(one, other)
    width = norm.ppf(0.975)
    generator = np.random.default_rng(1)
    drawn = 0.4 * np.exp((0.3 * generator.standard_normal(10**6) - 0.4 * generator.standard_normal(10**6)) / width)
    assert (ratio.value, ratio.lower, ratio.upper) == pytest.approx(
        (0.4, *np.quantile(drawn, [0.025, 0.975])), rel=5e-3
    )
    assert ratio.shape is None
    # Each end of a lopsided interval has its own way: below, ours down and the other's up.
    assert ratio.contact.lower == pytest.approx(0.4 * np.exp(-np.hypot(np.log(2), np.log(2))))
    assert ratio.contact.upper == pytest.approx(0.4 * np.exp(np.hypot(np.log(2.5), np.log(1.25))))
    exact = ratio_of(one, made(5.0, 5.0, 5.0))
    assert (exact.lower, exact.upper) == pytest.approx((one.lower / 5, one.upper / 5))
    assert exact.contact is None


@pytest.mark.parametrize(
    ("values", "least", "lower"),
    [
        ([1.0, 2.0, 3.0], -math.inf, 2 - 2.484),
        ([1.0, 10.0], 0.0, 0.0),  # the interval would begin at -52
        ([1.0, 10.0], -math.inf, 5.5 - 12.706 * 4.5),
        ([9.0, 10.0], 0.0, 9.5 - 12.706 * 0.5),
        ([-2.0, 1.0], 0.0, -0.5),  # noise about 0: the mean stays in its own interval
    ],
)
def test_the_interval_of_a_mean_ends_at_the_smallest_value_that_can_be(values, least, lower):
    mean = mean_of(values, "W", least=least)
    assert mean.repeats.lower == pytest.approx(lower, abs=1e-3) and mean.repeats.holds(mean.value)
    # Two such intervals together, too.
    both = mean.having({"contact": mean.repeats}).together(least)
    expected = mean.value - math.sqrt(2) * (mean.value - mean.repeats.lower)
    assert both.lower == pytest.approx(max(expected, min(mean.value, least)))


def test_independent_intervals_together_and_a_single_value():
    both = Estimate(10.0, "W", repeats=Interval(7.0, 13.0), contact=Interval(6.0, 10.0)).together()
    assert (both.lower, both.upper) == (5.0, 13.0)
    assert mean_of([1.0], "W") == Estimate(1.0, "W", of=1)


def test_the_interval_of_a_difference_is_that_of_welchs_test():
    one, other = np.array([1.0, 2.0, 3.0, 4.5, 2.5]), np.array([5.0, 9.0, 6.0, 20.0])
    found, known = difference_of(one, other, "W"), ttest_ind(one, other, equal_var=False).confidence_interval(0.95)
    assert (found.value, *found.ends("repeats")) == pytest.approx((2.6 - 10, known.low, known.high))
    assert difference_of(one[:2] * 0 + 3, other[:2] * 0 + 1, "W").repeats == Interval(2.0, 2.0)


INF = math.inf


@pytest.mark.parametrize(("lower", "upper", "allowed", "told"), truths("claims_of_a_range"))
def test_a_claim_of_a_range_holds_if_the_whole_interval_does(lower, upper, allowed, told):
    allowed = Allowed(**allowed)
    middle = lower if upper == INF else (lower + upper) / 2
    for of, expected in ((5, tuple(told)), (None, tuple(told)), (4, (OPEN, "too few repeats"))):
        assert judge(made(middle, lower, upper, "repeats", of=of), allowed) == expected
    for value in (lower, upper):
        assert judge(Estimate(value, "W"), allowed).agrees == allowed.holds(value)


@pytest.mark.parametrize("ends", [(math.nan, 1.0), (1.0, math.nan), (math.nan, math.nan)])
def test_what_is_not_a_number_decides_nothing(ends):
    own = made(1.0, *ends)
    for claim in (Allowed(0.0, 2.0), Allowed(5.0), made(1.0, 0.0, 2.0), Estimate(9.0, "W")):
        assert judge(own, claim).word == OPEN
        assert judge(Estimate(math.nan, "W"), claim).word == OPEN
    for claim in (Allowed(*ends), made(9.0, *ends)):
        assert judge(made(1.0, 0.0, 2.0), claim).word == OPEN
    # A known interval of a value that is not told decides on a range.
    assert judge(made(math.nan, 1.0, 2.0), Allowed(0.0, 3.0)).word == AGREES


def test_a_repeat_that_failed_is_a_miss():
    def judged(failed, lower, upper):
        return judge(made(lower, lower, upper, "repeats", of=5, failed=failed), Allowed(upper=2.78))

    assert [judged(failed, 1, 2).word for failed in (0, 1)] == [AGREES, OPEN]
    assert [judged(failed, 9, 12).word for failed in (0, 1)] == [DIFFERS, DIFFERS]
    assert judged(1, 1, 12).word == OPEN and judged(5, INF, INF) == (DIFFERS, "5 of 5 repeats failed")
    assert judge(None, Allowed()) == judge(None, made(1, 0, 2)) == (OPEN, "not run")


@pytest.mark.parametrize(("predicted", "measured", "said"), truths("claims_of_a_value"))
def test_a_claim_of_a_value_compares_both_intervals(predicted, measured, said):
    one, other = made(*predicted, "mean", how="predicted"), made(*measured, "repeats", how="measured")
    assert str(judge(one, other, widest=10.0)) == said


@pytest.mark.parametrize(
    ("scatter", "measured", "word"),
    [
        # 18.4 W is what some of the simulations give, and 12.7 W, the mean, none of them.
        (None, (18.4, 17.1, 19.6), OPEN),
        (None, (13.7, 10, 17.5), OPEN),
        (None, (200, 190, 210), OPEN),
        (Interval(1.0, 25.0), (18.4, 17.1, 19.6), OPEN),
        (Interval(1.0, 25.0), (40, 35, 45), DIFFERS),
        # A band about the mean that does not hold the motion of the fewest simulations.
        (Interval(5.5, 24.3), (1.4, 1.33, 1.47), OPEN),
        # Whichever motion lasts.
        (Interval(1.0, 25.0), (9, 1, 19), AGREES),
    ],
)
@pytest.mark.parametrize("widest", [30.0, INF])
def test_of_several_motions_only_what_holds_for_all_is_decided(scatter, measured, word, widest):
    predicted = Estimate(12.7, "W", motions=(18.3, 1.4), scatter=scatter, how="predicted")
    found = judge(predicted, made(*measured, "repeats", how="measured"), widest=widest)
    assert found.word == word and (word != OPEN or "18.3 W or 1.4 W" in found.reason)


def test_what_has_no_interval_is_no_interval_of_no_width():
    assert judge(Estimate(12.7, "W"), made(18.4, 17.1, 19.6, "repeats"), widest=10.0).word == OPEN
    assert str(Estimate(12.7, "W")) == "12.7 W" and str(Estimate(12.7, "W", motions=(18.3, 1.4))) == "18.3 or 1.4 W"
    doubled = Estimate(12.7, "W", motions=(18.3, 1.4)) * 2
    assert doubled.values == (36.6, 2.8)


@pytest.mark.parametrize(
    ("estimate", "claim", "word"),
    [
        (made(10, 9, 11), Estimate(10.5, "W"), AGREES),
        (made(10, 9, 11), Estimate(11.5, "W"), DIFFERS),
        (Estimate(10.5, "W"), made(10, 9, 11), AGREES),
        (Estimate(11.5, "W"), made(10, 9, 11), DIFFERS),
        (Estimate(10.0, "W"), Estimate(10.0, "W"), OPEN),
        (made(10, 9, 11, "contact"), Estimate(10.0, "W"), OPEN),
        (made(math.nan, 9, 11), made(10, 9, 11), OPEN),
        (made(-1, -2, 0), made(10, 9, 11), DIFFERS),
    ],
)
def test_the_only_known_interval_decides(estimate, claim, word):
    assert judge(estimate, claim, by=("scatter",)).word == word


def test_what_rests_on_several_claims_is_only_as_sure_as_the_least_sure():
    yes, maybe, no = (Verdict(word, word) for word in (AGREES, OPEN, DIFFERS))
    assert judge_all([yes, yes]) == yes and judge_all([yes, maybe]) == maybe
    assert judge_all([maybe, no, yes]) == no and judge_all([]) == (OPEN, "not run")


def test_a_value_without_a_limit_differs_without_a_factor():
    """A ratio of powers is infinite where no ball is hit."""
    told = Estimate(2.0, "").having({"scatter": Interval(1.0, 3.0)})
    assert judge(told, Estimate(math.inf, "")) == (DIFFERS, "the intervals are apart")
