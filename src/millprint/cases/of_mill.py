"""The simulations of one mill: of its sweep, new ones, of a study of its settings, and of the enlarged mill.

The Snakefile imports this, so nothing that takes long is imported here.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import chain, count, islice, pairwise
from typing import NamedTuple

from millprint.config.charge import chosen_balls
from millprint.config.contact_set import ContactConfig
from millprint.config.errors import ConfigError
from millprint.config.fingerprint import StudyConfig, UncertaintyConfig
from millprint.config.mill import InsertConfig, MillConfig
from millprint.config.mill_sweep import (
    ConditionSection,
    MillsConfig,
    MillSweepConfig,
    Precision,
    TurnsSection,
    condition,
    spread,
)
from millprint.config.motion_kinds import Agitation
from millprint.config.section import Section
from millprint.config.sweep import DISCARDED_TURNS, Case, DemConfig, balls_of, mill_of
from millprint.config.workflow import WorkflowConfig
from millprint.dem.laws.registry import step_scale

# Revolutions of the large run, of which the second half counts [-], and time for its balls to come to rest [s].
LARGE_TURNS, LARGE_SETTLE_S = 1.0, 0.1


@dataclass(frozen=True)
class Way:
    """A way to run the large mill, at L^power times the small mill's speed; balls_grow: whether balls are enlarged."""

    name: str
    keeps: str
    power: float
    balls_grow: bool = False


# The way of the large run: chemistry depends on the energy of a collision.
RUN_WAY = Way("energy", "energy of a collision, balls as they are", -1.0)
WAYS = (
    Way("similar", "everything scaled, balls enlarged", -0.5, balls_grow=True),
    RUN_WAY,
    Way("power", "power of a ball, balls as they are", -2 / 3),
    Way("acceleration", "acceleration of the wall, balls as they are", -0.5),
    Way("frequency", "collisions of a ball in a second, balls as they are", 0.0),
)


def large_case(small: MillConfig, large: MillConfig, factor: float, settings: MillsConfig) -> Case:
    """The large run of a scale-up: balls as they are, at the speed that keeps the energy of a collision.

    factor: length of the large mill over that of the small one [-]. Raises ValueError for settings without a scale-up,
    ConfigError for a charge that is not in the sweep of the small mill.
    """
    plan = settings.scale_up
    if plan is None:
        raise ValueError("mills.scale_up: is left out, so that there is no large run")
    speed_hz = plan.speed_rpm * factor**RUN_WAY.power / 60
    turn_s = 1 / speed_hz
    sizes = small.sweep.balls if small.sweep else []
    balls = chosen_balls(plan.ball_diameter_mm, sizes, "mills.scale_up.ball_diameter_mm")
    return Case(
        mill=large.name, contact=settings.contact_set, **balls_of(balls),
        fill_ratio=plan.fill_ratio, speed_hz=speed_hz, seed=0, rayleigh_fraction=settings.rayleigh_fraction,
        settle_s=LARGE_SETTLE_S,
        discard_s=LARGE_TURNS / 2 * turn_s, window_s=LARGE_TURNS / 2 * turn_s,
    )  # fmt: skip


def enlarged(mill: MillConfig, volume_l: float, name: str) -> tuple[MillConfig, float]:
    """The mill with `volume_l` [L] in place of its volume, all lengths of shape and motion scaled, and the factor L."""
    factor = (volume_l * 1e3 / mill.volume_ml) ** (1 / 3)
    large = mill.model_copy(
        update={
            "name": name,
            "title": f"{mill.title}, enlarged to {volume_l:g} L",
            "volume_ml": volume_l * 1e3,
            "geometry": _larger(mill.geometry, factor),
            "motion": _larger(mill.motion, factor),
            "inserts": [_larger_insert(insert, factor) for insert in mill.inserts],
            "sweep": None,
        }
    )
    return large, factor


def _larger_insert(insert: InsertConfig, factor: float) -> InsertConfig:
    motion = insert.motion and _larger(insert.motion, factor)
    return insert.model_copy(update={"geometry": _larger(insert.geometry, factor), "motion": motion})


def _larger(part: Section, factor: float) -> Section:
    """A geometry or a motion with every length multiplied; one from a file by its `scale`."""
    if hasattr(part, "scale"):
        return part.model_copy(update={"scale": part.scale * factor})
    return type(part).model_validate(_lengths(part.model_dump(), factor))


def _lengths(value: object, factor: float, is_length: bool = False) -> object:
    if isinstance(value, dict):
        return {key: _lengths(item, factor, key.endswith("_mm")) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_lengths(item, factor, is_length) for item in value]
    return value * factor if is_length and isinstance(value, int | float) else value


# Default of a sweep: recorded for at least this time [s].
WINDOW_S = 0.8
TUMBLED_TURNS = 1.0
# The first seed of the simulations that no fit sees; the seeds of a sweep begin at 0.
HELD_OUT_SEED = 1000
# Turns from which a standard error of the powers can be estimated.
TURNS_WITH_ERROR = 2
# Factors on the time step (the largest under 1 decides), on Young's modulus, and on the number of facets around the
# vessel (the smallest over 1 decides) [-].
FACTORS = {"step_factors": (0.5, 2.0), "modulus_factors": (0.3, 3.0), "facet_factors": (0.5, 2.0)}
# The largest balance error of a variant: large, so that a coarse variant is compared and not refused.
CLOSURE_MAX = 0.5
# As many seeds as a study could need to find some that no other simulation has.
MOST_SEEDS = 1000
# A sample fails at this energy balance error over the wall work [-]; the most fill ratios of intervals.
SAMPLE_CLOSURE_MAX, MOST_FILLS = 0.02, 24


def sweep_of(mill: MillConfig) -> MillSweepConfig:
    """The sweep of a mill, or the one derived from it. Raises ConfigError for a mill with an invalid shape."""
    if mill.sweep:
        return mill.sweep
    # Imported here: slow to import, and few mills need it.
    from millprint.mill.default_sweep import default_sweep

    return default_sweep(mill)


def place_of_sweep(config: WorkflowConfig, name: str, source: str) -> str:
    """File and section of a mill's sweep, for the beginning of a message about it.

    The sweep of the run's mill may be in the configuration, whose last file is `source`.
    """
    return f"{source}: sweep" if config.sweep and name == config.mill else f"config/mills/{name}.yaml: sweep"


def conditions_of(sweep: MillSweepConfig, halfway: bool = False) -> list[ConditionSection]:
    """The conditions of a sweep that has fill ratios only; of lists, the star.

    That is the first speed with every size, and the first size with every speed, each at every fill ratio, and if
    `halfway` also at the geometric mean of each two neighbours, to four digits.
    """
    if sweep.conditions:
        return sweep.conditions
    speeds, sizes = sweep.speeds, sweep.balls
    settings = [*((sizes[0], speed) for speed in speeds), *((size, speeds[0]) for size in sizes[1:])]
    fills = sorted(sweep.fills)
    between = [float(f"{math.sqrt(low * high):.4g}") for low, high in pairwise(fills)] if halfway else []
    return [condition(*setting, fill) for setting in settings for fill in (*sweep.fills, *between)]


def discarded_turns(mill: MillConfig, own: TurnsSection) -> float:
    """Turns before the averages begin: its own, or DISCARDED_TURNS; TUMBLED_TURNS of a drum, which turns its bed over.

    The powers of most conditions of seven mills are steady by then. A window that grows begins anew where they are not.
    """
    tumbled = mill.motion.record.vessel is Agitation.TUMBLED
    return own.discard_turns or (TUMBLED_TURNS if tumbled else DISCARDED_TURNS)


def durations_of(
    speed_hz: float, discard_turns: float, window_turns: float | None, recorded: float = 1.0, turns: int = 3
) -> dict[str, float]:
    """Time before the averages begin and recorded time of a case [s], the latter in whole turns where it is not given.

    recorded: factor on the recorded time, which is never shortened below TURNS_WITH_ERROR, and is at least `turns`
    turns where it is not given.
    """
    turn_s = 1 / speed_hz
    if window_turns:
        window = max(min(TURNS_WITH_ERROR, window_turns), recorded * window_turns)
    else:
        window = max(turns, math.ceil(recorded * WINDOW_S / turn_s))
    return {"discard_s": discard_turns * turn_s, "window_s": window * turn_s}


def windows_of(mill: MillConfig, speed_hz: float, own: TurnsSection, level: Precision) -> dict[str, float]:
    """The keys of a case that say how long it takes: `durations_of`, and until when a window may grow."""
    discard = discarded_turns(mill, own)
    durations = durations_of(speed_hz, discard, own.window_turns, level.recorded, level.turns)
    if level.half_width is None or own.window_turns:
        return durations
    # The mean over the seeds is known better than that of one run.
    half = level.half_width * math.sqrt(level.seeds)
    return durations | {"power_error_max": half, "window_max_s": level.longest * durations["window_s"]}


def seeds_of(sweep: MillSweepConfig, fewest: int) -> list[int]:
    """The seeds of a sweep, then the smallest others up to `fewest`."""
    further = (seed for seed in count() if seed not in sweep.seeds)
    return list(islice(chain(sweep.seeds, further), max(fewest, len(sweep.seeds))))


def _case(mill: MillConfig, settings: MillsConfig, sweep: MillSweepConfig, given: ConditionSection, seed: int) -> Case:
    """A condition of a mill at the precision of `settings`, with step and recorded time of its sweep."""
    level = settings.level
    return Case(
        mill=mill.name, contact=settings.contact_set, **balls_of(given.ball_diameter_mm), fill_ratio=given.fill_ratio,
        speed_hz=given.hz, seed=seed,
        rayleigh_fraction=level.step * settings.rayleigh_fraction, settle_s=settings.settle_s,
        **windows_of(mill, given.hz, sweep, level),
    )  # fmt: skip


def mill_cases(mill: MillConfig, settings: MillsConfig) -> list[Case]:
    """The cases of a mill's sweep at the precision of `settings`, ball size and speed by fill ratio and seed.

    Raises ConfigError as `sweep_of`.
    """
    sweep = sweep_of(mill)
    seeds = seeds_of(sweep, settings.level.seeds)
    conditions = conditions_of(sweep, settings.level.halfway)
    return [_case(mill, settings, sweep, condition, seed) for condition in conditions for seed in seeds]


def held_out_cases(mill: MillConfig, settings: MillsConfig) -> list[Case]:
    """Cases of a mill that its fingerprint does not see: `settings.held_out` new conditions, each with a new seed.

    Fill ratio and speed are spread evenly in logarithm over the ranges of the sweep, with any of its balls (the first
    points of a Sobol sequence); step and recorded time are the sweep's. Raises ConfigError as `sweep_of`.
    """
    sweep = sweep_of(mill)
    places = enumerate(spread(sweep, settings.held_out, HELD_OUT_SEED), start=HELD_OUT_SEED)
    return [_case(mill, settings, sweep, condition, seed) for seed, condition in places]


class Variant(NamedTuple):
    """Runs that differ from the sweep in one setting: `reference`, `time_step`, `stiffness` or `facets`.

    factor: of the setting, over the sweep's [-]; value: the setting itself, in the unit of its key.
    """

    setting: str
    factor: float
    value: float
    cases: list[Case]


def study_variants(
    mill: MillConfig,
    contact: ContactConfig,
    mills: MillsConfig,
    dem: DemConfig,
    study: StudyConfig,
    taken: Mapping[str, Case],
) -> list[Variant]:
    """The reference and its variants at the first speed, the first balls and the middle fill ratio of the sweep.

    taken: cases of other sweeps by path, which run with their own settings; their seeds are not used again. A step
    over dem.rayleigh_fraction_max and a number of facets that the shape cannot have are left out as well.
    Raises ConfigError as `sweep_of`.
    """
    first = reference_case(mill, mills)
    changes = [("reference", 1.0, 0.0, {}), *_changes(first, mill, contact, dem, study)]
    wanted = [first.model_copy(update=changed) for *_, changed in changes]

    def is_free(seed: int) -> bool:
        cases = [case.model_copy(update={"seed": seed}) for case in wanted]
        return all(taken.get(case.path, case) == case for case in cases)

    seeds = list(islice(filter(is_free, seeds_of(sweep_of(mill), MOST_SEEDS)), study.seeds))
    return [
        Variant(setting, factor, value, [case.model_copy(update={"seed": seed}) for seed in seeds])
        for (setting, factor, value, _), case in zip(changes, wanted, strict=True)
    ]


def reference_case(mill: MillConfig, mills: MillsConfig) -> Case:
    """The first case of a mill's sweep, at the middle fill ratio; of an even number of them the lower one."""
    sweep = sweep_of(mill)
    fills = sorted(sweep.fills)
    middle = fills[(len(fills) - 1) // 2]
    return next(case for case in mill_cases(mill, mills) if case.fill_ratio == middle)


def _changes(
    case: Case, mill: MillConfig, contact: ContactConfig, dem: DemConfig, study: StudyConfig
) -> list[tuple[str, float, float, dict[str, float]]]:
    """Setting, factor and value of each variant, and the keys of the case that it changes."""
    stiffness = contact.young_modulus_gpa or 0.0
    scale = step_scale(contact, min(case.sizes_m) / 2)
    fraction = case.rayleigh_fraction or 0.0
    loose = {"closure_max": CLOSURE_MAX}
    changes: list[tuple[str, float, float, dict[str, float]]] = []
    for factor in FACTORS["step_factors"]:
        if factor * fraction <= dem.rayleigh_fraction_max:
            # Few digits, for the name of the case.
            step = float(f"{factor * fraction * scale:.4g}")
            changes.append(("time_step", factor, step, loose | {"time_step_s": step}))
    # A law without this modulus has no such variant.
    for factor in FACTORS["modulus_factors"] if stiffness else []:
        # Each modulus has its own stable step, the same fraction of its scale.
        modulus = float(f"{factor * stiffness:.6g}")
        changes.append(("stiffness", factor, modulus, loose | {"young_modulus_gpa": modulus}))
    own = facets_of(mill)
    for factor in FACTORS["facet_factors"] if own else []:
        facets = round(factor * own)
        try:
            mill_of(case.model_copy(update={"facets": facets}), mill)
        except ConfigError:
            continue
        if facets != own:
            changes.append(("facets", factor, facets, {"facets": facets}))
    return changes


def facets_of(mill: MillConfig) -> int:
    """The number of flat facets around a vessel; 0 for one that is not round, or comes from a file."""
    key = mill.geometry.facets_key
    return getattr(mill.geometry, key) if key else 0


def varied_case(mill: MillConfig, settings: MillsConfig, uncertainty: UncertaintyConfig) -> Case:
    """The case that is varied: the first ball size and the first speed of the mill's sweep.

    It has a separate time step and, because only its samples are compared, a recorded time without the turns that the
    precision of a sweep asks for.
    """
    first, sweep = mill_cases(mill, settings)[0], sweep_of(mill)
    own: dict[str, float | None] = {"power_error_max": None, "window_max_s": None, "closure_max": SAMPLE_CLOSURE_MAX}
    own["rayleigh_fraction"] = uncertainty.rayleigh_fraction
    discard = discarded_turns(mill, sweep)
    return first.model_copy(update={**own, **durations_of(first.speed_hz, discard, sweep.window_turns)})


def fill_ratios_of(mill: MillConfig, uncertainty: UncertaintyConfig) -> list[float]:
    """The fill ratios at which intervals are given, from the section or from the mill's sweep, MOST_FILLS at most."""
    fills = sorted(sweep_of(mill).fills)
    return uncertainty.fill_ratios or [*fills[:: -(-len(fills) // MOST_FILLS)][:-1], fills[-1]]


def mean_samples(mill: MillConfig, settings: MillsConfig, uncertainty: UncertaintyConfig) -> list[Case]:
    """A case of mean size and stiffness for each sample of a job; the samples spread evenly between the ends."""
    fills, (softest, stiffest) = fill_ratios_of(mill, uncertainty), uncertainty.parameters.young_modulus_gpa.given_range
    change = {"fill_ratio": (min(fills) + max(fills)) / 2}
    if softest is not None and stiffest is not None:
        change["young_modulus_gpa"] = (softest + stiffest) / 2
    mean = varied_case(mill, settings, uncertainty).model_copy(update=change)
    return [mean] * -(-uncertainty.samples // uncertainty.jobs)


def uncertainty_cases(config: WorkflowConfig, mills: dict[str, MillConfig]) -> list[Case]:
    """The smallest and the largest charge of each mill in the section, with the stiffest balls, which take longest."""
    settings = config.uncertainty
    if not settings.mills:
        return []

    _, stiffest = settings.parameters.young_modulus_gpa.given_range
    found = []
    for name in settings.mills:
        case = varied_case(mills[name], config.mills, settings)
        fills = fill_ratios_of(mills[name], settings)
        change = {"young_modulus_gpa": stiffest}
        found += [case.model_copy(update={"fill_ratio": fill, **change}) for fill in (fills[0], fills[-1])]
    return found
