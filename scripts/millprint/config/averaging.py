"""Settings of the averaged Gaussian process: its possible members, fixed before any yield is used."""

from typing import Annotated, Literal

from pydantic import Field

from millprint.config.section import Fraction, NonNegative, Positive, Section

INPUTS = ("bpr", "molar_ratio", "time_h", "power_per_ball_mW", "tangential_share")
Scale = Literal["linear", "log"]
Scales = Annotated[list[Scale], Field(min_length=1)]
LinkName = Literal["identity", "logit", "avrami"]
Structure = Literal["product", "mains_product", "time_product", "trend_product", "mains_pairs"]


class InputScales(Section):
    """The scales on which each input is tried."""

    bpr: Scales = ["linear", "log"]
    """ball-to-powder mass ratio"""
    molar_ratio: Scales = ["linear"]
    """mol of MgH2 to mol of NaBO2.4H2O"""
    time_h: Scales = ["linear", "log"]
    """milling time"""
    power_per_ball_mW: Scales = ["log"]
    """power that one ball dissipates"""
    tangential_share: Scales = ["linear"]
    """tangential over total energy of a collision"""


class SmallestSpread(Section):
    """Smallest standard deviations by which inputs are scaled."""

    tangential_share: NonNegative = 0.05
    """smallest standard deviation to scale it by [-]"""


class LogNormal(Section):
    """A log-normal prior."""

    median: Positive
    """median"""
    log_deviation: Positive
    """standard deviation of the natural logarithm [-]"""


class Priors(Section):
    """Priors of the kernel's hyper-parameters, for inputs and targets of unit variance."""

    length_scale: LogNormal = LogNormal(median=2.5, log_deviation=0.7)
    """length scales [standard deviations of an input]"""
    variance: LogNormal = LogNormal(median=0.5, log_deviation=1.5)
    """variance of a term [variance of the target]"""
    noise: LogNormal = LogNormal(median=0.03, log_deviation=1.5)
    """variance of the noise [variance of the target]"""


class AveragingConfig(Section):
    """The library of the averaged Gaussian process: every combination of link, scales and structure."""

    links: Annotated[list[LinkName], Field(min_length=1)] = ["identity", "logit", "avrami"]
    """scales of the yield"""
    structures: Annotated[list[Structure], Field(min_length=1)] = [
        "product",
        "mains_product",
        "time_product",
        "trend_product",
        "mains_pairs",
    ]
    """sums of products of kernels"""
    scales: InputScales = InputScales()
    smallest_spread: SmallestSpread = SmallestSpread()
    priors: Priors = Priors()
    margin: Fraction = 0.005
    """distance of conversions from 0 and 1 under a bounded link [-]"""
    smallest_weight: Fraction = 0.002
    """members of a smaller weight are dropped [-]"""
