"""The simulations for fingerprints: of the sweeps, of a mill's own sweep, and of the large mill.

The Snakefile asks for them, so nothing that takes long is imported here.
"""

import math
from dataclasses import dataclass
from itertools import chain, count, islice

from millprint.config.conditions import Condition, spread
from millprint.config.mill import InsertConfig, MillConfig
from millprint.config.mill_sweep import MillsConfig, MillSweepConfig
from millprint.config.mixture import chosen_balls
from millprint.config.section import Section
from millprint.config.sweep import Case, balls_of
from millprint.config.workflow import WorkflowConfig

# Defaults of a sweep: at least this time [s].
DISCARD_S, WINDOW_S = 0.25, 0.8
# The first seed of the simulations that no fit sees; the seeds of a sweep begin at 0.
HELD_OUT_SEED = 1000
# Revolutions of the large run, of which the second half counts [-], and time for its balls to come to rest [s].
LARGE_TURNS, LARGE_SETTLE_S = 1.0, 0.1
# Turns from which a standard error of the powers can be estimated.
TURNS_WITH_ERROR = 2


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


def is_as_built(case: Case) -> bool:
    """Whether a case changes neither mill nor balls."""
    return case.amplitude_mm is None and case.density_kg_m3 is None


def has_chapters(config: WorkflowConfig, cases: dict[str, Case]) -> bool:
    """Whether the configuration has the chapters' sections, and its sweeps simulate the mill that they are about."""
    simulated = {case.mill for case in described_cases(config, cases).values()}
    return config.chapters is not None and config.mill in simulated


def described_cases(config: WorkflowConfig, cases: dict[str, Case]) -> dict[str, Case]:
    """The cases that give descriptors: without snapshots, and with the configured modulus and step.

    Amplitude and density are varied for the fingerprint of the run's own mill: such a case of another mill is left out.
    """
    return {
        path: case
        for path, case in cases.items()
        if case.speed_rpm > 0
        and case.snapshot_interval_s is None
        and case.young_modulus_gpa is None
        and case.time_step_s is None
        and (is_as_built(case) or case.mill == config.mill)
    }


def mapped_cases(config: WorkflowConfig, cases: dict[str, Case], contact: str) -> dict[float, str]:
    """Fill ratio to path of the cases that the heat maps of a contact set show: the first seed of each, if any."""
    maps = config.fingerprint.maps
    chosen: dict[float, str] = {}
    if maps is None:
        return chosen
    for path, case in described_cases(config, cases).items():
        if not is_as_built(case):
            continue
        place = (case.mill, case.contact, case.ball_diameter_mm, case.speed_rpm)
        if (
            place == (config.mill, contact, maps.ball_diameter_mm, maps.speed_rpm)
            and case.fill_ratio in maps.fill_ratios
        ):
            chosen.setdefault(case.fill_ratio, path)
    return dict(sorted(chosen.items()))


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


def conditions_of(sweep: MillSweepConfig) -> list[Condition]:
    """The conditions of a sweep that has fill ratios only; of lists, the star.

    That is the first speed with every size, and the first size with every speed, each at every fill ratio.
    """
    if sweep.conditions:
        return [(each.ball_diameter_mm, each.rpm, each.fill_ratio or 0.0) for each in sweep.conditions]
    speeds, sizes = sweep.speeds, sweep.balls
    settings = [*((sizes[0], speed) for speed in speeds), *((size, speeds[0]) for size in sizes[1:])]
    return [(*setting, fill) for setting in settings for fill in sweep.fills]


def durations_of(
    speed_rpm: float, discard_turns: float | None, window_turns: float | None, recorded: float = 1.0, turns: int = 3
) -> dict[str, float]:
    """Time before the averages begin and recorded time of a case [s], in whole turns where they are not given.

    recorded: factor on the recorded time, which is never shortened below TURNS_WITH_ERROR, and is at least `turns`
    turns where it is not given.
    """
    turn_s = 60 / speed_rpm
    discard = discard_turns or math.ceil(DISCARD_S / turn_s)
    if window_turns:
        window = max(min(TURNS_WITH_ERROR, window_turns), recorded * window_turns)
    else:
        window = max(turns, math.ceil(recorded * WINDOW_S / turn_s))
    return {"discard_s": discard * turn_s, "window_s": window * turn_s}


def seeds_of(sweep: MillSweepConfig, fewest: int) -> list[int]:
    """The seeds of a sweep, then the smallest others up to `fewest`."""
    further = (seed for seed in count() if seed not in sweep.seeds)
    return list(islice(chain(sweep.seeds, further), max(fewest, len(sweep.seeds))))


def _case(mill: MillConfig, settings: MillsConfig, sweep: MillSweepConfig, condition: Condition, seed: int) -> Case:
    """A condition of a mill at the precision of `settings`, with step and recorded time of its sweep."""
    (size, speed, fill), level = condition, settings.level
    return Case(
        mill=mill.name, contact=settings.contact_set, **balls_of(size), fill_ratio=fill, speed_rpm=speed, seed=seed,
        rayleigh_fraction=level.step * settings.rayleigh_fraction, settle_s=settings.settle_s,
        **durations_of(speed, sweep.discard_turns, sweep.window_turns, level.recorded, level.turns),
    )  # fmt: skip


def mill_cases(mill: MillConfig, settings: MillsConfig) -> list[Case]:
    """The cases of a mill's sweep at the precision of `settings`, ball size and speed by fill ratio and seed.

    Raises ConfigError as `sweep_of`.
    """
    sweep = sweep_of(mill)
    seeds = seeds_of(sweep, settings.level.seeds)
    return [_case(mill, settings, sweep, condition, seed) for condition in conditions_of(sweep) for seed in seeds]


def held_out_cases(mill: MillConfig, settings: MillsConfig) -> list[Case]:
    """Cases of a mill that its fingerprint does not see: `settings.held_out` new conditions, each with a new seed.

    Fill ratio and speed are spread evenly in logarithm over the ranges of the sweep, with any of its balls (the first
    points of a Sobol sequence); step and recorded time are the sweep's. Raises ConfigError as `sweep_of`.
    """
    sweep = sweep_of(mill)
    places = enumerate(spread(sweep, settings.held_out, HELD_OUT_SEED), start=HELD_OUT_SEED)
    return [_case(mill, settings, sweep, condition, seed) for seed, condition in places]


def large_case(small: MillConfig, large: MillConfig, factor: float, settings: MillsConfig) -> Case:
    """The large run of a scale-up: balls as they are, at the speed that keeps the energy of a collision.

    factor: length of the large mill over that of the small one [-]. Raises ValueError for settings without a scale-up,
    ConfigError for a charge that is not in the sweep of the small mill.
    """
    plan = settings.scale_up
    if plan is None:
        raise ValueError("mills.scale_up: is left out, so that there is no large run")
    speed = plan.speed_rpm * factor**RUN_WAY.power
    turn_s = 60 / speed
    sizes = small.sweep.balls if small.sweep else []
    balls = chosen_balls(plan.ball_diameter_mm, sizes, "mills.scale_up.ball_diameter_mm")
    return Case(
        mill=large.name, contact=settings.contact_set, **balls_of(balls),
        fill_ratio=plan.fill_ratio, speed_rpm=speed, seed=0, rayleigh_fraction=settings.rayleigh_fraction,
        settle_s=LARGE_SETTLE_S,
        discard_s=LARGE_TURNS / 2 * turn_s, window_s=LARGE_TURNS / 2 * turn_s, threads=plan.cores,
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
