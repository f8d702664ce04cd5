"""The simulations that make the fingerprint of a mill: its sweep as cases."""

import math
from itertools import product

from millprint.config.mill import MillConfig
from millprint.config.mill_sweep import MillsConfig, MillSweepConfig
from millprint.config.sweep import Case
from millprint.config.workflow import WorkflowConfig
from millprint.fingerprint.similarity import RUN_WAY, WAYS

# Where a sweep gives no turns: at least so many, and as many as fill so long a time [s].
FEWEST_TURNS, DISCARD_S, WINDOW_S = 3, 0.25, 0.8


def sweep_of(mill: MillConfig) -> MillSweepConfig:
    """The sweep of a mill, or the one derived from it. Raises ConfigError for a mill whose shape does not hold."""
    if mill.sweep:
        return mill.sweep
    # Takes long to import, and few mills need it.
    from millprint.mill.default_sweep import default_sweep

    return default_sweep(mill)


def place_of_sweep(config: WorkflowConfig, name: str, source: str) -> str:
    """File and section that hold a mill's sweep, with which a message about it begins.

    The sweep of the run's mill may stand in the configuration, whose last file is `source`.
    """
    return f"{source}: sweep" if config.sweep and name == config.mill else f"config/mills/{name}.yaml: sweep"


def settings_of(sweep: MillSweepConfig) -> list[tuple[float, float]]:
    """Ball diameters [mm] with speeds [rpm]: the first speed with every size, the first size with every speed."""
    speeds, sizes = sweep.speeds, sweep.ball_diameters_mm
    return [*((sizes[0], speed) for speed in speeds), *((size, speeds[0]) for size in sizes[1:])]


def mill_cases(mill: MillConfig, settings: MillsConfig) -> list[Case]:
    """The cases of a mill's sweep, ball size and speed by fill ratio and seed; raises ConfigError as `sweep_of`."""
    sweep = sweep_of(mill)
    cases = []
    for diameter, speed in settings_of(sweep):
        turn_s = 60 / speed
        discard = sweep.discard_turns or math.ceil(DISCARD_S / turn_s)
        window = sweep.window_turns or max(FEWEST_TURNS, math.ceil(WINDOW_S / turn_s))
        for fill, seed in product(sweep.fill_ratios, sweep.seeds):
            cases.append(
                Case(
                    mill=mill.name, contact=settings.contact_set, ball_diameter_mm=diameter, fill_ratio=fill,
                    speed_rpm=speed, seed=seed, rayleigh_fraction=settings.rayleigh_fraction,
                    settle_s=settings.settle_s, discard_s=discard * turn_s, window_s=window * turn_s,
                )
            )  # fmt: skip
    return cases


def large_case(large: MillConfig, factor: float, settings: MillsConfig) -> Case:
    """The large run of a scale-up: balls as they are, at the speed that keeps the energy of a collision.

    factor: the length of the large mill over the small one's [-]. Raises ValueError for settings without a scale-up.
    """
    plan = settings.scale_up
    if plan is None:
        raise ValueError("mills.scale_up: is left out, so that there is no large run")
    speed = plan.speed_rpm * factor ** next(way.power for way in WAYS if way.name == RUN_WAY)
    turn_s = 60 / speed
    return Case(
        mill=large.name, contact=settings.contact_set, ball_diameter_mm=plan.ball_diameter_mm,
        fill_ratio=plan.fill_ratio, speed_rpm=speed, seed=0, rayleigh_fraction=settings.rayleigh_fraction,
        settle_s=plan.run_settle_s,
        discard_s=plan.run_turns / 2 * turn_s, window_s=plan.run_turns / 2 * turn_s, threads=plan.cores,
    )  # fmt: skip
