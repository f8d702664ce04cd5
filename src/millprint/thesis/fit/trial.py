"""Short simulations of one jar at the conditions of the fitted values."""

import itertools
from collections.abc import Callable

import numpy as np
import pandas as pd

from millprint.config.contact_set import ContactConfig
from millprint.config.fit import StageConfig, TrialConfig
from millprint.config.mill import MillConfig
from millprint.config.sweep import Case, DemConfig
from millprint.dem.run import simulate
from millprint.fingerprint.cycles import tabulate_cycles
from millprint.fingerprint.descriptors import tabulate_descriptors
from millprint.thesis.curves.published import read_published
from millprint.thesis.fit.published_targets import FITTED, computed_values, misfit, published_values, with_roles
from millprint.thesis.fit.shape import shaped


def trial_cases(mill: str, values: pd.DataFrame, settings: TrialConfig, stage: StageConfig) -> list[Case]:
    """The cases that give every fitted value: fill ratios, ball sizes and speeds as the value or the settings have."""
    places = set()
    for row in values[values["role"] == FITTED].to_dict("records"):
        single = np.isfinite(row["ball_diameter_mm"])
        diameters = [row["ball_diameter_mm"]] if single else settings.ball_diameters_mm
        speeds = [row["speed_rpm"]] if single else settings.speeds_rpm
        places |= set(itertools.product(diameters, [row["fill_ratio"]], speeds))
    common = {"mill": mill, "contact": settings.contact}
    common |= {name: getattr(settings, name) for name in ("time_step_s", "closure_max", "settle_s")}
    cases = []
    for (diameter, fill, speed), seed in itertools.product(sorted(places), range(stage.seeds)):
        place = {"ball_diameter_mm": diameter, "fill_ratio": fill, "speed_rpm": speed, "seed": seed}
        turns = {"discard_s": settings.discard_revolutions, "window_s": stage.revolutions}
        times = {name: count * 60.0 / speed for name, count in turns.items()}
        cases.append(Case(**common, **place, **times))
    return cases


def trial_of(
    mill: MillConfig, contact: ContactConfig, dem: DemConfig, settings: TrialConfig, published_paths: list[str]
) -> Callable[[dict[str, float], StageConfig], pd.DataFrame]:
    """What simulates a jar of given parameters, in a stage of the search, in place of the mill's.

    It returns the published values with those of the jar under the counting rule that fits best, whose name is in the
    column counting_rule. Raises ConfigError for a jar that cannot be built.
    """
    values = with_roles(published_values(read_published(*published_paths), settings.contact), settings.fitted)

    def trial(parameters: dict[str, float], stage: StageConfig) -> pd.DataFrame:
        jar = shaped(mill, parameters)
        cases = trial_cases(mill.name, values, settings, stage)
        summaries = [simulate(case, jar, contact, dem, title=case.path) for case in cases]
        return choose_rule(summaries, values, settings.counting_rules, mill.name, settings.contact)

    return trial


def choose_rule(summaries: list[dict], values: pd.DataFrame, rules: list[str], mill: str, contact: str) -> pd.DataFrame:
    """The values of summaries under the rule with the smallest misfit; powers do not depend on it."""
    cycles = tabulate_cycles(summaries)
    tables = [
        computed_values(values, tabulate_descriptors(summaries, rule), cycles, mill, contact).assign(counting_rule=rule)
        for rule in rules
    ]
    return min(tables, key=misfit)
