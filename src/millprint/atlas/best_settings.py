"""The settings of a mill, within bounds, that give the most normal power to the mass of the balls at a limit of shear.

Normal power breaks; shear wears balls and walls (Archard: wear grows with the work of sliding), so a limit of shear
power is a limit of wear. The search is differential evolution (scipy.optimize) over values of the atlas; the optimum
is to be simulated once, since an optimum is where a model is most likely to flatter.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

from millprint.atlas.atlas_model import KindModel
from millprint.atlas.estimate_mill import MillEstimate, estimate, estimate_many
from millprint.atlas.kind_groups import Values
from millprint.config.errors import ConfigError

# Members of a generation for each setting, generations, seed; how much a thing that cannot be counts.
MEMBERS, GENERATIONS, SEED, IMPOSSIBLE = 12, 60, 0, 1e3


def best_settings(
    model: KindModel, condition: Values, bounds: Mapping[str, tuple[float, float]], most_shear_W_kg: float | None = None
) -> MillEstimate:
    """The condition with the most normal power per mass of balls, the settings of `bounds` within them.

    condition: dimensions and settings that are kept; most_shear_W_kg: of tangential power per mass of balls. Raises
    ConfigError, in one line, where the atlas knows nothing within the bounds.
    """
    # Imported here: slow to import.
    from scipy.optimize import differential_evolution

    names = list(bounds)

    def cost(places: np.ndarray) -> np.ndarray:
        return _cost(model, {**condition, **dict(zip(names, np.exp(places), strict=True))}, most_shear_W_kg)

    found = differential_evolution(
        cost, [tuple(np.log(bounds[name])) for name in names], popsize=MEMBERS, maxiter=GENERATIONS, rng=SEED,
        vectorized=True, updating="deferred", polish=False,
    )  # fmt: skip
    if found.fun >= IMPOSSIBLE:
        limit = "" if most_shear_W_kg is None else f" with at most {most_shear_W_kg:g} W/kg of shear"
        raise ConfigError(f"--within: the atlas knows no condition{limit} within these bounds; widen them")
    best = {**condition, **dict(zip(names, map(float, np.exp(found.x)), strict=True))}
    return estimate(model.kind, _whole(best), model)


def _whole(condition: dict[str, Any]) -> dict[str, Any]:
    """The condition with a whole number of balls."""
    return condition | {"number": np.round(condition["number"])}


def _cost(model: KindModel, condition: dict[str, Any], most_shear_W_kg: float | None) -> np.ndarray:
    """-log of the normal power per mass of balls (m,); IMPOSSIBLE and more beyond the limit, where the atlas says
    nothing, or where balls hardly hit."""
    condition = _whole(condition)
    logs, hits = estimate_many(model, condition)
    ball_kg = condition["density_kg_m3"] * np.pi / 6 * (condition["ball_diameter_mm"] / 1e3) ** 3
    mass = np.log(condition["number"] * ball_kg)
    cost = mass - logs["normal_power_W"]
    if most_shear_W_kg is not None:
        beyond = logs["tangential_power_W"] - mass - np.log(most_shear_W_kg)
        cost = np.where(beyond > 0, IMPOSSIBLE + beyond, cost)
    return np.where(hits, cost, 2 * IMPOSSIBLE)
