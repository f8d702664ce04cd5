"""Settings of the averaged Gaussian process: its possible members, declared before any of their scores was computed.

The default library follows from kinetics, not from scores. Choices that this argument leaves open
are averaged:

- Conversion saturates, since the powder runs out. So the yield enters under a link that ends at 0 and at 100 %:
  Avrami's, under which y = 1 - exp(-(k t)^n) is a straight line in ln t, or the logit, under which log-logistic
  kinetics y = 1 / (1 + (k t)^-n) is one. The yield itself (`identity`) has no such end.
- Time enters as its logarithm, since both laws add it to that of the rate constant, ln k + ln t. On a linear
  scale the yield would rise between 15 and 20 h as fast as between 5 and 10 h.
- The logarithm of the ball-to-powder ratio belongs to a rate constant that is a power of it, the ratio itself to one
  that changes less and less. The argument does not say which, so both are kept.
- The kernels are one product, or this and a term for each input, for time only, or a straight line in each input,
  which for time is Avrami's exponent. `mains_pairs` (15 variances for 27 runs) is gone: all runs together gave each
  of its members a smaller weight than the smallest that is kept.

Priors, margin and the other scales are those of the earlier library, which had the identity link, linear time and
`mains_pairs` as well. That one was fixed after some 130 kernels had been compared by leave-one-out, so the authors of
this one had seen scores of the earlier library, too. No score of this one had been computed when it was written down,
and it stays whatever its score turns out to be.
"""

from typing import Annotated, ClassVar, Literal, NamedTuple

from pydantic import Field

from millprint.config.section import Section, completed

Scale = Literal["linear", "log"]
Scales = Annotated[list[Scale], Field(min_length=1)]
Input = Literal["bpr", "molar_ratio", "time_h", "power_per_ball_mW", "tangential_share"]
SCALES: dict[Input, list[Scale]] = {
    "bpr": ["linear", "log"],
    "molar_ratio": ["linear"],
    "time_h": ["log"],
    "power_per_ball_mW": ["log"],
    "tangential_share": ["linear"],
}
INPUTS = tuple(SCALES)
LinkName = Literal["identity", "logit", "avrami"]
Structure = Literal["product", "mains_product", "time_product", "trend_product"]


class LogNormal(NamedTuple):
    """A log-normal prior: its median, and the standard deviation of the natural logarithm [-]."""

    median: float
    log_deviation: float


class Priors(NamedTuple):
    """Priors of the kernel's hyper-parameters, for inputs and targets of unit variance.

    length_scale: two steps of a three-level factor [standard deviations of an input]; variance: of a term [variance of
    the target]; noise: its variance [variance of the target].
    """

    length_scale: LogNormal = LogNormal(2.5, 0.7)
    variance: LogNormal = LogNormal(0.5, 1.5)
    noise: LogNormal = LogNormal(0.03, 1.5)


class AveragingConfig(Section):
    """The library of the averaged Gaussian process: every combination of link, scales and structure."""

    links: Annotated[list[LinkName], Field(min_length=1)] = ["logit", "avrami"]
    """scales of the yield"""
    structures: Annotated[list[Structure], Field(min_length=1)] = [
        "product",
        "mains_product",
        "time_product",
        "trend_product",
    ]
    """sums of products of kernels"""
    scales: Annotated[dict[Input, Scales], completed(SCALES)] = SCALES
    """scales on which each input is tried, in place of those that the kinetics give [-]"""
    # An input that varies less is divided by this [-].
    smallest_spread: ClassVar[dict[str, float]] = {"tangential_share": 0.05}
    priors: ClassVar[Priors] = Priors()
    # Under a bounded link, conversions are kept this far from 0 and 1 [-].
    margin: ClassVar[float] = 0.005
    # Members of a smaller weight are dropped [-].
    smallest_weight: ClassVar[float] = 0.002
