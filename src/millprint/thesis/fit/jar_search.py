"""The search for a jar: spread over the ranges, then step by step from the best jar."""

import logging
from collections.abc import Callable
from functools import cache

import pandas as pd

from millprint.config.errors import ConfigError, SimulationError
from millprint.config.fit import FitConfig, ShapeConfig, StageConfig
from millprint.thesis.fit.published_targets import HELD_BACK, misfit
from millprint.thesis.fit.shape import JAR_PARAMETERS, on_grid

logger = logging.getLogger("millprint")

# A function that simulates a jar in a stage of the search: the published values with ours.
Trial = Callable[[dict[str, float], StageConfig], pd.DataFrame]
Jar = tuple[float, ...]


class Search:
    """The jars that were simulated, with their misfits. A jar is a tuple of JAR_PARAMETERS."""

    def __init__(self, settings: FitConfig, trial: Trial) -> None:
        self.settings, self.trial = settings, trial
        self.rows: list[dict] = []

    @cache  # noqa: B019 (a search lives as long as its job)
    def misfit(self, jar: Jar, stage: str) -> float:
        """The misfit of a jar in a stage [-]; inf for one that cannot be built or run. Each is simulated once."""
        parameters = dict(zip(JAR_PARAMETERS, jar, strict=True))
        try:
            table = self.trial(parameters, getattr(self.settings, stage))
        except (ConfigError, SimulationError) as error:
            logger.info("%s: %s", parameters, error)
            return float("inf")
        found = misfit(table)
        errors = table.dropna(subset="ours").set_index("name")["error_percent"]
        row = {"stage": stage, **parameters, "misfit": found, "counting_rule": table["counting_rule"].iloc[0]}
        row |= {"held_back_misfit": misfit(table[table["ours"].notna()], HELD_BACK)}
        self.rows.append(row | {f"{name}_percent": value for name, value in errors.items()})
        logger.info("%s %s: misfit %.3f", stage, parameters, found)
        return found

    def table(self) -> pd.DataFrame:
        """A row for every trial: stage, parameters, misfit [-], rule, and the error of each value [%]."""
        return pd.DataFrame(self.rows)

    def run(self, present: dict[str, float]) -> dict[str, float]:
        """The best jar of the search, which includes the present one."""
        screened = sorted(candidates(self.settings, present), key=lambda jar: self.misfit(jar, "screening"))
        best = min(screened[: self.settings.refining.jars], key=lambda jar: self.misfit(jar, "refining"))
        for _ in range(self.settings.rounds):
            around = [best, *neighbours(best, self.settings.shape)]
            better = min(around, key=lambda jar: self.misfit(jar, "refining"))
            if better == best:
                break
            best = better
        return dict(zip(JAR_PARAMETERS, best, strict=True))


def candidates(settings: FitConfig, present: dict[str, float]) -> list[Jar]:
    """The present jar, then a Sobol sequence over the ranges, every parameter on its grid."""
    # Slow to import, and the tables of a fit import this module.
    from scipy.stats import qmc

    ranges = [getattr(settings.shape, name) for name in JAR_PARAMETERS]
    # A power of two keeps the sequence balanced; what is too much is not simulated.
    places = qmc.Sobol(len(ranges), seed=settings.seed).random_base2((settings.screening.jars - 1).bit_length())
    scaled = qmc.scale(places, [allowed.low for allowed in ranges], [allowed.high for allowed in ranges])
    drawn = [tuple(map(on_grid, place, ranges)) for place in scaled[: settings.screening.jars - 1]]
    return list(dict.fromkeys([tuple(present[name] for name in JAR_PARAMETERS), *drawn]))


def neighbours(jar: Jar, shape: ShapeConfig) -> list[Jar]:
    """The jars one step down and one up in each parameter that stay in the ranges."""
    found = []
    for index, name in enumerate(JAR_PARAMETERS):
        allowed = getattr(shape, name)
        for step in (-allowed.step, allowed.step):
            value = round(jar[index] + step, 9)
            if allowed.low - 1e-9 <= value <= allowed.high + 1e-9:
                found.append((*jar[:index], value, *jar[index + 1 :]))
    return found
