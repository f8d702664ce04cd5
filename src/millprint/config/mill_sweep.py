"""The conditions of a mill's fingerprint: its own `sweep`, of lists, a table or a design, and settings of all mills."""

import math
from collections.abc import Iterable
from itertools import product, starmap
from typing import Annotated, ClassVar, Literal, NamedTuple

from pydantic import AfterValidator, Field, model_validator

from millprint.config.charge import (
    MEASURES,
    PACKING_FRACTION,
    BallChoice,
    BallMixture,
    BallSize,
    ChargeSection,
    Number,
    SpeedSection,
    check_charges,
    diameter_of,
    named_fill,
)
from millprint.config.counting import RuleName
from millprint.config.errors import ConfigError
from millprint.config.fingerprint import SimulatedCondition, SpeedRange
from millprint.config.load import check_model
from millprint.config.rows import read_rows
from millprint.config.section import Fraction, Name, Positive, PositiveSpeed, ProjectFile, Section, Seed, first_repeated

Turns = Annotated[float, Field(ge=1, le=10_000)]
Speeds = Annotated[list[PositiveSpeed], Field(min_length=1)]
Design = Literal["star", "factorial", "space_filling"]
# Fill ratios that a curve needs.
FEWEST_FILLS = 3
# The lists of a sweep, and those that say how many balls, with the key of one condition.
LISTS = ("speeds_rpm", "speeds_hz", "ball_diameters_mm")
CHARGES = dict(zip(("fill_ratios", "numbers", "masses_g", "bulk_fillings"), MEASURES, strict=True))


PrecisionName = Literal["draft", "quick", "standard", "fine"]


class Precision(NamedTuple):
    """How exactly the sweep of a mill is simulated.

    step, recorded: factors on mills.rayleigh_fraction and on the recorded time; turns: recorded at least where the
    sweep does not say how many; seeds: starting positions at least; half_width: of the 95 % interval of a power's mean
    over these seeds, until which a window grows where the sweep does not say its turns [-]; None: it does not grow;
    longest: the longest window over the first one [-]; halfway: of lists, also the fill ratios halfway between
    neighbours, where a curve is known worst.
    """

    step: float
    recorded: float
    turns: int
    seeds: int
    half_width: float | None
    longest: int = 1
    halfway: bool = False


# Steps of 0.11 and of 0.08 of the Rayleigh time: descriptors stay within the scatter of seeds (docs/how_to/speed.md).
# Turns do not show that a motion may last in several ways; three seeds were the least whose bands held
# (docs/why/uncertainty.md). Of fewer than sixteen turns, no correlation is seen, and hardly a drift.
PRECISIONS: dict[PrecisionName, Precision] = {
    "draft": Precision(step=1.375, recorded=0.5, turns=3, seeds=1, half_width=None),
    "quick": Precision(step=1.375, recorded=0.5, turns=16, seeds=3, half_width=0.10, longest=4),
    "standard": Precision(step=1.0, recorded=1.0, turns=16, seeds=3, half_width=0.05, longest=4),
    "fine": Precision(step=1.0, recorded=2.0, turns=16, seeds=4, half_width=0.02, longest=8, halfway=True),
}


class ConditionSection(SpeedSection, ChargeSection):
    """One condition of a sweep."""

    ball_diameter_mm: BallSize
    """ball diameter [mm]; a charge of several sizes is `{name, sizes_mm, numbers}` or `{name, sizes_mm, shares}`"""


class TurnsSection(Section):
    """How long a condition is simulated."""

    discard_turns: Turns | None = None
    """revolutions of the mill before the averages begin; if left out 5, and 1 of a drum [-]"""
    window_turns: Turns | None = None
    """recorded revolutions of the mill, in a sweep at precision `standard`; by default at least 16, and 0.8 s, and as
    many as `mills.precision` needs, for a card as at `standard` [-]
    """


class MillSweepConfig(TurnsSection):
    """The conditions of a mill's fingerprint: lists of speeds, balls and charges, or conditions one by one.

    Of lists, `design` says which conditions are simulated. Each condition is simulated with every seed.
    """

    speeds_rpm: Speeds | None = None
    """speeds of a mill that is set in rpm [rpm]"""
    speeds_hz: Speeds | None = None
    """speeds of a mill that is set in Hz [Hz]"""
    ball_diameters_mm: Annotated[list[BallSize], Field(min_length=1), AfterValidator(check_charges)] | None = None
    """ball diameters [mm]; a charge of several sizes is `{name, sizes_mm, numbers}` or `{name, sizes_mm, shares}`"""
    fill_ratios: Annotated[list[Fraction], Field(min_length=FEWEST_FILLS)] | None = None
    """ball volume over the nominal volume; or give `numbers`, `masses_g` or `bulk_fillings` [-]"""
    numbers: Annotated[list[Number], Field(min_length=FEWEST_FILLS)] | None = None
    """numbers of balls of one size, in place of fill_ratios"""
    masses_g: Annotated[list[Positive], Field(min_length=FEWEST_FILLS)] | None = None
    """masses of all balls, in place of fill_ratios [g]"""
    bulk_fillings: Annotated[list[Fraction], Field(min_length=FEWEST_FILLS)] | None = None
    """shares of the jar that the bed of balls takes, voids included, in place of fill_ratios [-]"""
    packing_fraction: Fraction = PACKING_FRACTION
    """share of that bed that is ball; an assumption, used with bulk_fillings only [-]"""
    design: Design = "star"
    """which conditions of the lists: `star`, the first speed with every ball size and the first ball size with every
    speed, at every fill ratio; `factorial`, all combinations; `space_filling`, `points` spread evenly between the ends
    of the lists, with any of the balls (a Sobol sequence)
    """
    points: Annotated[int, Field(ge=FEWEST_FILLS, le=100_000)] | None = None
    """number of conditions of `space_filling`"""
    table: ProjectFile | None = None
    """conditions in place of the lists: a table (TSV) with a column for each key of `conditions`"""
    conditions: Annotated[list[ConditionSection], Field(min_length=1)] | None = None
    """conditions in place of the lists, one by one"""
    seeds: Annotated[list[Seed], Field(min_length=1, max_length=100)] = [0]
    """seeds of the starting positions: each condition is simulated with every seed, and with more where
    `mills.precision` asks for more
    """

    @model_validator(mode="after")
    def _lists_or_conditions(self) -> "MillSweepConfig":
        given = [key for key in (*LISTS, *CHARGES) if getattr(self, key) is not None]
        own = [key for key in ("table", "conditions") if getattr(self, key) is not None]
        if len(own) > 1 or (own and given):
            raise ValueError(f"give {own[0]} or {', '.join([*own[1:], *given])}, not both")
        if not own:
            self._check_lists([key for key in given if key in CHARGES])
        if (self.design == "space_filling") != (self.points is not None):
            raise ValueError("points: the number of conditions belongs to `design: space_filling`, and only to it")
        if own and self.design != "star":
            raise ValueError(f"design = {self.design}: is of lists, and {own[0]} has its conditions already")
        if len(set(self.seeds)) < len(self.seeds):
            raise ValueError(f"seeds = {self.seeds}: a value appears twice")
        return self

    def _check_lists(self, charges: list[str]) -> None:
        """Raise ValueError unless each of speeds, balls and charges is listed once, and no value twice."""
        if (self.speeds_rpm is None) == (self.speeds_hz is None):
            raise ValueError("speeds: give either speeds_rpm or speeds_hz")
        if self.ball_diameters_mm is None:
            raise ValueError("ball_diameters_mm: this key is missing")
        if len(charges) != 1:
            raise ValueError(f"give one of {', '.join(CHARGES)}")
        if self.numbers and len(self.ball_diameters_mm) > 1:
            raise ValueError(
                "numbers: are of balls of one size; with several sizes give fill_ratios, masses_g or bulk_fillings, or "
                "each condition in a table"
            )
        for key in ("speeds_rpm", "speeds_hz", "ball_diameters_mm", *charges):
            values = getattr(self, key) or []
            if len(set(values)) < len(values):
                raise ValueError(f"{key} = {values}: a value appears twice")

    @property
    def speeds(self) -> list[float]:
        """The speeds [rpm]."""
        if self.conditions:
            return list(dict.fromkeys(each.rpm for each in self.conditions))
        return self.speeds_rpm or [60 * speed for speed in self.speeds_hz or []]

    @property
    def balls(self) -> list[float | BallMixture]:
        """The balls: diameters [mm], and charges of several sizes."""
        if self.conditions:
            return list(dict.fromkeys(each.ball_diameter_mm for each in self.conditions))
        return self.ball_diameters_mm or []

    @property
    def fills(self) -> list[float]:
        """The fill ratios, after `millprint.config.mill_sweep.with_fill_ratios` [-]."""
        if self.conditions:
            return list(dict.fromkeys(each.fill_ratio or 0.0 for each in self.conditions))
        return self.fill_ratios or []


class LikeMillConfig(SimulatedCondition):
    """A condition of another mill, which is the target."""

    mill: Name
    """that mill: a file in config/mills"""


class MatchMillsConfig(Section):
    """The conditions of one mill that come nearest to a condition of another: target `match`."""

    mill: Name
    """mill whose conditions are searched: a file in config/mills"""
    like: LikeMillConfig
    """the condition of another mill"""
    speeds_rpm: SpeedRange | None = None
    """range of possible speeds [rpm]; the simulated range if left out"""
    ball_diameters_mm: Annotated[list[BallChoice], Field(min_length=1)] | None = None
    """available balls [mm], and names of charges in the mill's sweep; the simulated ones if left out"""


class ScaleUpConfig(Section):
    """A mill enlarged by geometric similarity, and what it costs to simulate: target `scale_up`."""

    mill: Name
    """mill that is enlarged: a file in config/mills"""
    volume_l: Annotated[float, Field(gt=0, le=10_000)]
    """nominal volume of the large mill [L]"""
    ball_diameter_mm: BallChoice
    """balls of the small mill [mm], or the name of a charge of several sizes in its sweep"""
    fill_ratio: Fraction
    """fill ratio of both mills [-]"""
    speed_rpm: PositiveSpeed
    """speed of the small mill [rpm]"""
    # Revolutions for which the cost is estimated [-].
    revolutions: ClassVar[float] = 10.0


class MillsConfig(Section):
    """Settings of results/mills: the fingerprints of any mills, by their own sweeps."""

    box: Annotated[list[Name], Field(min_length=1)] = [
        "emax",
        "planetary",
        "spex",
        "mixer",
        "vibratory",
        "attritor",
        "drum",
    ]
    """mills of the target `mills`"""
    contact: Name | None = None
    """contact set of their balls: a file in config/contacts; the first of `contacts` if left out"""
    counting_rule: RuleName | None = None
    """name of the rule of dem.counting_rules that counts; `fingerprint.counting_rule` if left out"""
    precision: PrecisionName = "quick"
    """how exactly each power of a condition is known, as half of the 95 % interval of its mean: `quick` 10 %,
    `standard` 5 %, `fine` 2 %; a simulation goes on until it is, to eight times its first window at most, unless the
    sweep says its turns. `quick` and `standard` simulate at least three seeds, `quick` with steps of 1.375 times
    `rayleigh_fraction`, `fine` four, and of lists also the fill ratios halfway between neighbours, where a curve is
    known worst; `draft` is one short simulation of each, for a first look, after which many bands are not known
    """
    rayleigh_fraction: Fraction = 0.08
    """step over each case's own Rayleigh time at precision `standard`; 0.08 is 2e-6 s for 5 mm balls of a softened set
    [-]
    """
    settle_s: Positive = 0.2
    """time for the balls to come to rest before the mill starts [s]"""
    held_out: Annotated[int, Field(ge=0, le=64)] = 8
    """simulations of new conditions, not used in the fingerprint, to count how often its bands hold"""
    first_case_only: bool = False
    """simulate only the first case of each mill of the box, for a smoke test"""
    match: MatchMillsConfig | None = None
    """search for one mill's conditions nearest to a condition of another; none if left out"""
    scale_up: ScaleUpConfig | None = None
    """a large mill; none if left out"""

    @property
    def level(self) -> Precision:
        """The factors of the precision."""
        return PRECISIONS[self.precision]

    @property
    def contact_set(self) -> str:
        """The contact set of the balls. Raises ValueError if neither this section nor the configuration has it."""
        if self.contact is None:
            raise ValueError("mills.contact: is left out, and there are no `contacts` to take the first of")
        return self.contact

    @property
    def rule(self) -> str:
        """The counting rule. Raises ValueError if neither this section nor the configuration has it."""
        if self.counting_rule is None:
            raise ValueError("mills.counting_rule: is left out, and there is no `fingerprint.counting_rule` to take")
        return self.counting_rule

    @property
    def named(self) -> list[str]:
        """Every mill that the section names."""
        matched = [self.match.mill, self.match.like.mill] if self.match else []
        return [*self.box, *matched, *([self.scale_up.mill] if self.scale_up else [])]

    @property
    def named_balls(self) -> list[tuple[str, str, list[float | str]]]:
        """Every key that names balls of a mill: the key, the mill, and the balls as diameters [mm] or charges."""
        found: list[tuple[str, str, list[float | str]]] = []
        if own := self.match:
            found.append(("mills.match.like.ball_diameter_mm", own.like.mill, [own.like.ball_diameter_mm]))
            found.append(("mills.match.ball_diameters_mm", own.mill, list(own.ball_diameters_mm or [])))
        if plan := self.scale_up:
            found.append(("mills.scale_up.ball_diameter_mm", plan.mill, [plan.ball_diameter_mm]))
        return found


# Digits of the settings of a design, enough for the names of its cases.
DIGITS = 5


def with_fill_ratios(sweep: MillSweepConfig, volume_ml: float, density_kg_m3: float, place: str) -> MillSweepConfig:
    """The sweep with fill ratios only, and its conditions one by one where they are not a star of lists.

    volume_ml: nominal volume of the jar; density: of the balls. Raises ConfigError, in one line that begins with
    `place` or the table, for balls that fill the jar, fewer than three fill ratios, and a condition given twice.
    """
    if sweep.conditions or sweep.table:
        given = sweep.conditions or read_conditions(sweep.table or "")
        found = [_filled(each, volume_ml, density_kg_m3, sweep.table or place) for each in given]
        return _one_by_one(sweep, found, sweep.table or place)
    key = next(key for key in CHARGES if getattr(sweep, key))
    size = (sweep.ball_diameters_mm or [])[0]
    about = {"packing_fraction": sweep.packing_fraction, "ball_diameter_mm": size, "speed_rpm": 1}
    charges = [ConditionSection(**about, **{CHARGES[key]: value}) for value in getattr(sweep, key)]
    fills = [_filled(each, volume_ml, density_kg_m3, place).fill_ratio for each in charges]
    lists = sweep.model_copy(update={key: None, "fill_ratios": fills})
    if sweep.design == "star":
        return lists if key != "fill_ratios" else sweep
    if sweep.design == "factorial":
        return _one_by_one(sweep, starmap(condition, product(lists.balls, lists.speeds, fills)), place)
    return _one_by_one(sweep, spread(lists, sweep.points or 0, seed=0, digits=DIGITS), place)


def read_conditions(path: str) -> list[ConditionSection]:
    """The conditions of a table. Raises ConfigError, a line for each fault, as `read_rows` and `check_model`."""
    rows = enumerate(read_rows(path), start=1)
    return [check_model(row, ConditionSection, f"{path}: row {number}") for number, row in rows]


def spread(sweep: MillSweepConfig, number: int, seed: int, digits: int = 17) -> list[ConditionSection]:
    """Conditions spread evenly in logarithm over the ranges of a sweep, with any of its balls (a Sobol sequence).

    seed: seed of the scrambling; digits: significant digits of speeds and fill ratios. Raises ConfigError if scipy is
    not installed.
    """
    if number == 0:
        return []
    # Imported here: slow to import, and needed by few runs.
    try:
        from scipy.stats import qmc
    except ModuleNotFoundError:
        raise ConfigError(
            "mills.held_out, and design: space_filling, need scipy in the environment of Snakemake: install it there, "
            "or set mills.held_out to 0 and give lists or a table"
        ) from None

    low, high = ([math.log(end(ends)) for ends in (sweep.fills, sweep.speeds)] for end in (min, max))
    shares = qmc.Sobol(3, scramble=True, rng=seed).random_base2(max(0, number - 1).bit_length())[:number]
    found = []
    for own in shares:
        fill, speed = (math.exp(a + (b - a) * share) for a, b, share in zip(low, high, own[:2], strict=True))
        size = sweep.balls[int(own[2] * len(sweep.balls))]
        found.append(condition(size, float(f"{speed:.{digits}g}"), float(f"{fill:.{digits}g}")))
    return found


def condition(balls: float | BallMixture, speed_rpm: float, fill_ratio: float) -> ConditionSection:
    """One condition of a sweep, from elements of its lists."""
    return ConditionSection(ball_diameter_mm=balls, speed_rpm=speed_rpm, fill_ratio=fill_ratio)


def _filled(section: ConditionSection, volume_ml: float, density_kg_m3: float, place: str) -> ConditionSection:
    """A condition with its fill ratio in place of another measure."""
    try:
        fill = section.fill_in(volume_ml, diameter_of(section.ball_diameter_mm), density_kg_m3)
    except ValueError as error:
        raise ConfigError(f"{place}: {error}") from None
    speed = {"speed_hz": section.speed_hz, "speed_rpm": section.speed_rpm}
    return ConditionSection(ball_diameter_mm=section.ball_diameter_mm, fill_ratio=fill, **speed)


def _one_by_one(sweep: MillSweepConfig, conditions: Iterable[ConditionSection], place: str) -> MillSweepConfig:
    """A sweep of these conditions with the seeds and durations of another."""
    found = list(conditions)
    named = (
        f"balls of {_named(each)}, fill ratio {named_fill(each.fill_ratio or 0)}, {each.rpm:g} rpm" for each in found
    )
    if twice := first_repeated(named):
        raise ConfigError(f"{place}: two conditions are the same: {twice}; for a repetition give `seeds`")
    if len(fills := {each.fill_ratio for each in found}) < FEWEST_FILLS:
        raise ConfigError(f"{place}: has {len(fills)} fill ratios; a fingerprint needs {FEWEST_FILLS} at least")
    kept = {key: getattr(sweep, key) for key in ("seeds", "discard_turns", "window_turns")}
    return MillSweepConfig(conditions=found, **kept)


def _named(condition: ConditionSection) -> str:
    size = condition.ball_diameter_mm
    return size.name if isinstance(size, BallMixture) else f"{size:g} mm"
