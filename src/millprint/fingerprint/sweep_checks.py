"""Checks before a job starts: speeds compared with real machines (mill.speed_limits), and recorded counting rules."""

import math
import operator
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Literal

from millprint.cases.of_mill import place_of_sweep
from millprint.config.errors import ConfigError
from millprint.config.mill import MillConfig
from millprint.config.sweep import Case, mill_of
from millprint.config.wording import other_unit
from millprint.config.workflow import WorkflowConfig
from millprint.mill.bodies import Body
from millprint.mill.speed_limits import Bound, Pace, paces

# Units in which a mill's speed is given.
PER_HZ = {"rpm": 60.0, "Hz": 1.0}


@dataclass(frozen=True)
class SpeedSetting:
    """A speed [Hz] of a mill, with the YAML file and key that set it, and the unit of that key, rpm or Hz.

    ball_m: the smallest diameter of its balls.
    """

    place: str
    unit: str
    mill: MillConfig
    speed_hz: float
    ball_m: float

    @property
    def line(self) -> str:
        """File, key and value: the beginning of a message."""
        return f"{self.place} = {self.speed_hz * PER_HZ[self.unit]:g}"

    def up_to(self, speed_hz: float) -> str:
        """A bound [Hz] in the unit of the key, rounded down to three digits so that the rounded value is accepted."""
        bound = speed_hz * PER_HZ[self.unit]
        digit = 10.0 ** (math.floor(math.log10(bound)) - 2)
        return f"{math.floor(bound / digit) * digit:g} {self.unit}"


def speed_settings(
    config: WorkflowConfig,
    mills: Mapping[str, MillConfig],
    own_sweeps: Mapping[str, Sequence[Case]],
    cases: Mapping[str, Case],
    source: str,
) -> list[SpeedSetting]:
    """Every speed of the sweeps, of the mills' own sweeps and of the large run, once for each key and mill.

    own_sweeps: cases of each mill's own sweep; source: the file of the sweeps. Raises ConfigError for an amplitude
    that a mill's motion lacks.
    """
    settings = [_of_sweeps(case, mills[case.mill], source) for case in cases.values()]
    for name, own in own_sweeps.items():
        sweep = mills[name].sweep
        key, unit = ("speeds_hz", "Hz") if sweep and sweep.speeds_hz else ("speeds_rpm", "rpm")
        # Of conditions one by one, which may be thousands, the fastest says it.
        one_by_one = bool(sweep and sweep.conditions)
        place = f"{place_of_sweep(config, name, source)}: {'conditions: speed_rpm' if one_by_one else key}"
        speeds = smallest_balls(own)
        told = [max(speeds)] if one_by_one else speeds
        settings += [SpeedSetting(place, unit, mills[name], speed, speeds[speed]) for speed in told]
    plan = config.mills.scale_up
    if plan is not None:
        place = f"{source}: mills.scale_up.speed_rpm"
        settings.append(SpeedSetting(place, "rpm", mills[plan.mill], plan.speed_rpm / 60, 0.0))
    # Of one line, the smallest balls stay.
    kept = {setting.line: setting for setting in sorted(settings, key=lambda setting: -setting.ball_m)}
    return [kept[line] for line in dict.fromkeys(setting.line for setting in settings)]


def _of_sweeps(case: Case, mill: MillConfig, source: str) -> SpeedSetting:
    try:
        mill = mill_of(case, mill)
    except ConfigError as error:
        raise ConfigError(f"{source}: {error}") from None
    amplitude = "" if case.amplitude_mm is None else f" with amplitudes_mm = {case.amplitude_mm:g}"
    return SpeedSetting(
        f"{source}: sweeps: mill {case.mill}{amplitude}: speeds_rpm", "rpm", mill, case.speed_hz, min(case.sizes_m)
    )


def smallest_balls(cases: Iterable[Case]) -> dict[float, float]:
    """The speeds of cases [Hz], each with the smallest diameter of its balls [m], whose critical speed is lowest."""
    found: dict[float, float] = {}
    for case in cases:
        found[case.speed_hz] = min(*case.sizes_m, found.get(case.speed_hz, math.inf))
    return found


def with_paces(
    settings: Sequence[SpeedSetting], bodies: Mapping[str, Sequence[Body]]
) -> list[tuple[SpeedSetting, Pace]]:
    """Each setting with the pace of each body of its mill; bodies: of every mill, by the mill's name."""
    known: dict[str, list[Pace]] = {}
    pairs = []
    for setting in settings:
        # All speeds of one key have the same mill and amplitude.
        if setting.place not in known:
            known[setting.place] = paces(setting.mill, bodies[setting.mill.name])
        pairs += [(setting, pace) for pace in known[setting.place]]
    return pairs


def check_speeds(speeds: Sequence[tuple[SpeedSetting, Pace]]) -> None:
    """Raise ConfigError with a line for each speed at which a wall would be faster than in any machine."""
    faults = _lines(speeds, "most")
    if faults:
        raise ConfigError("\n".join(faults))


def speed_warnings(speeds: Sequence[tuple[SpeedSetting, Pace]]) -> list[str]:
    """A line for each speed that is unusually high for a mill of its kind, or too low to mill."""
    slow = {
        setting.line: f"{setting.line}: {pace.at_speed(setting.speed_hz)}; {pace.bounds.least.reason}"
        for setting, pace in speeds
        if pace.bounds.least and pace.acceleration > 0 and setting.speed_hz < pace.speed_at(pace.bounds.least)
    }
    return [*_lines(speeds, "usual"), *slow.values()]


def _lines(speeds: Sequence[tuple[SpeedSetting, Pace]], which: Literal["usual", "most"]) -> list[str]:
    """A line for each setting with a body beyond one of its bounds; names only the first such body."""
    lines: dict[str, str] = {}
    for setting, pace in speeds:
        bound: Bound = getattr(pace.bounds, which)
        largest = pace.speed_at(bound, setting.ball_m)
        if setting.speed_hz > largest:
            fault = f"{pace.at_speed(setting.speed_hz)}; {bound.reason.format(speed=setting.up_to(largest))}"
            usual = pace.speed_at(pace.bounds.usual, setting.ball_m) * PER_HZ[setting.unit]
            asked = other_unit(setting.speed_hz * PER_HZ[setting.unit], setting.unit, partial(operator.gt, usual))
            lines.setdefault(setting.line, f"{setting.line}: {fault}{asked and f'; {asked}'}")
    return list(lines.values())


def fingerprint_faults(config: WorkflowConfig, source: str) -> Iterator[str]:
    """A line for each fault, with file, key, value and what to write; none if everything is valid."""
    recorded = [rule.name for rule in config.dem.counting_rules]
    chosen = {
        "fingerprint.counting_rule": [config.fingerprint.counting_rule],
        "mills.counting_rule": [config.mills.rule],
        "convergence.counting_rules": config.convergence.counting_rules,
        "dose.spectra.counting_rules": config.dose.spectra.counting_rules,
    }
    yield from unknown_faults(chosen, recorded, "dem.counting_rules", source)
    thresholds = {rule.name for rule in config.dem.counting_rules if rule.has_threshold}
    for key in ("fingerprint.counting_rule", "mills.counting_rule"):
        for name in thresholds.intersection(chosen[key]):
            yield (
                f"{source}: {key} = {name}: has a threshold, so that energy per collision times frequency would not be "
                "the power; choose a rule with only gap_turns"
            )


def unknown_faults(chosen: dict[str, list[str]], known: list[str], where: str, source: str) -> Iterator[str]:
    """A line for each name, by the key that has it, that is not one of `known`; where: the key that lists those."""
    for key, names in chosen.items():
        for name in names:
            if name not in known:
                yield f"{source}: {key} = {name}: must be one of {where} ({', '.join(known)})"
