"""The search for the best settings of a mill within bounds."""

import numpy as np
import pytest

from millprint.atlas.estimate_mill import estimate
from millprint.atlas.kinds import PLANETARY, recognise
from millprint.atlas.search_mills import best_settings
from millprint.config.errors import ConfigError
from millprint.config.included import load_mill
from tests.unit.made_atlas import made_model
from tests.unit.test_search_mills import BALLS, CONDITION

BOUNDS = {"number": (15.0, 150.0), "speed_hz": (3.0, 10.0), "ball_diameter_mm": (6.0, 18.0)}


def strengths(told):
    return [told.known[f"{name}_power_W"].value / told.charge_kg for name in ("normal", "tangential")]


@pytest.mark.parametrize("limit", [None, 40.0])
def test_no_drawn_condition_within_the_bounds_is_better(limit):
    """An oracle by chance: four hundred conditions within bounds and limit."""
    model, condition = made_model(PLANETARY), {**recognise(load_mill("planetary"))[1], **BALLS, **CONDITION}
    best = best_settings(model, condition, BOUNDS, limit)
    normal, shear = strengths(best)
    assert limit is None or shear <= 1.02 * limit
    assert all(low <= best.condition[name] <= high for name, (low, high) in BOUNDS.items())
    assert best.condition["number"] == round(best.condition["number"])
    draw, drawn = np.random.default_rng(0), []
    for _ in range(400):
        own = {name: float(np.exp(draw.uniform(*np.log(ends)))) for name, ends in BOUNDS.items()}
        own["number"] = round(own["number"])
        try:
            told = estimate(PLANETARY, condition | own, model)
        except ConfigError:
            continue
        power, rub = strengths(told)
        if told.hits > 0.5 and (limit is None or rub <= limit):
            drawn.append(power)
    assert len(drawn) > 20
    assert normal > 0.99 * max(drawn)


def test_bounds_of_which_the_atlas_knows_nothing_are_refused():
    condition = {**recognise(load_mill("planetary"))[1], **BALLS, **CONDITION}
    with pytest.raises(ConfigError, match="--within: the atlas knows no condition"):
        best_settings(made_model(PLANETARY), condition, {"speed_hz": (30.0, 40.0)})
