"""What a match is to meet, and the one verdict on it, from the bands of both mills."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from millprint.config.charge import Quantity
from millprint.estimate.estimates import Estimate, Interval, odds_of, ratio_of
from millprint.estimate.judge import NO_INTERVAL, OPEN, Allowed, Verdict, judge, judge_all
from millprint.fingerprint.predicted_values import Prediction
from millprint.observables.condition import Condition
from millprint.observables.definitions import POWER, SHARE

# Variables of a condition in sentences and tables.
VARIABLE_WORDS = {
    "fill_ratio": "fill",
    "speed_hz": "speed",
    "ball_diameter_m": "ball size",
    "density_kg_m3": "density",
    "amplitude_m": "amplitude",
}


@dataclass(frozen=True)
class Target:
    """What a match asks for, and what else is known of the condition that it is to be like.

    wanted: descriptors with their intervals; asked: those that are to be met; power_W_kg: power of the walls over the
    mass of the balls, for which milling time makes up; probability: of the intervals; outside: variables of the
    condition that were not simulated.
    """

    wanted: Mapping[str, Estimate]
    asked: tuple[str, ...]
    power_W_kg: Estimate = field(default=Estimate(math.nan, "W/kg"))
    probability: float | None = None
    outside: tuple[str, ...] = ()

    @classmethod
    def of_numbers(cls, given: Mapping[str, float]) -> "Target":
        """A target of numbers, all of which are asked for."""
        return cls({name: Estimate(value, "-") for name, value in given.items()}, tuple(given))

    @property
    def values(self) -> dict[str, float]:
        """The values that are asked for."""
        return {name: self.wanted[name].value for name in self.asked}

    def ratio(self, name: str, found: Estimate, probability: float) -> Estimate:
        """A descriptor over the wanted one, as `over`; of a share, its odds."""
        one, other = (odds_of(each) if name == SHARE.name else each for each in (found, self.wanted[name]))
        return self.over(one, other, probability)

    def over(self, found: Estimate, wanted: Estimate, probability: float) -> Estimate:
        """found / wanted [-]: of a number, with the intervals of what is found; else of both, as `ratio_of`.

        Intervals of different probabilities make none.
        """
        if self.probability is None:
            return replace(found * (1 / wanted.value), unit="-")
        if not math.isclose(self.probability, probability):
            return Estimate(found.value / wanted.value, "-")
        return ratio_of(found, wanted)


def comparable(name: str, value: Quantity) -> Quantity:
    """What of a descriptor is put over that of the target: of a share its odds, since 0.97 of 0.75 is not near."""
    return value / (1 - value) if name == SHARE.name else value


def power_of_mass(prediction: Prediction, condition: Condition[float]) -> Estimate:
    """Power of the walls over the mass of the balls [W/kg]."""
    ball_kg = condition.density_kg_m3 * math.pi / 6 * condition.ball_diameter_m**3
    return replace(prediction.known[POWER] * (1 / (prediction.balls * ball_kg or math.nan)), unit="W/kg")


def interval_of(ratio: Estimate) -> Interval | None:
    """The interval that decides: of the mean of very many simulations, which is what hours of milling are."""
    return ratio.mean or ratio.scatter


def verdict_on(ratio: Estimate, near_percent: float) -> Verdict:
    """Whether found over wanted is 1 to within `near_percent`: equivalence, not a difference that nobody saw.

    It agrees if the whole interval of the ratio is from 1 / (1 + p) to 1 + p, differs if none of it is, and is open
    otherwise, or if no interval is known.
    """
    if (interval := interval_of(ratio)) is None:
        return Verdict(OPEN, NO_INTERVAL)
    factor = 1 + near_percent / 100
    return judge(replace(ratio, mean=interval), Allowed(1 / factor, factor), by=("mean",))


def variables_in_words(names: tuple[str, ...]) -> str:
    """Variables of a condition: "speed, ball size"."""
    return ", ".join(VARIABLE_WORDS.get(name, name) for name in names)


def whole_verdict(verdicts: Mapping[str, Verdict], outside: tuple[str, ...], of_target: tuple[str, ...]) -> Verdict:
    """The verdict on a condition: open at best where it, or the condition that it is to be like, was not simulated."""
    said = [
        Verdict(OPEN, f"{what}: {variables_in_words(names)} not simulated")
        for what, names in (("this condition", outside), ("the target", of_target))
        if names
    ]
    return judge_all([*verdicts.values(), *said])
