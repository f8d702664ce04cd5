"""The description of a fingerprint: its mill, its balls and the conditions that were simulated."""

from collections.abc import Mapping

import pandas as pd

from millprint.config.mixture import BallMixture
from millprint.fingerprint.descriptors import CHARGE, OF_RULE, as_built
from millprint.fingerprint.processes import kinds_of
from millprint.fingerprint.readers import WALL
from millprint.observables.condition import VARIABLES

# Properties of the runs that a fingerprint stores, those that its contact law has.
SHARED = ("restitution", "static_friction", "collision_gap_turns", "density_kg_m3", "amplitude_m")
NO_CHARGES: Mapping[str, BallMixture] = {}
SETTING = ["ball_diameter_m", "speed_hz"]


def describe(
    descriptors: pd.DataFrame, volume_m3: float, probability: float, charges: Mapping[str, BallMixture] = NO_CHARGES
) -> dict:
    """The data of a fingerprint: mill, balls, counting rule, settings of the mill as built, simulated ranges.

    charges: charges of several sizes by name. If there are any, each setting names its charge, and `charges` lists the
    sizes. `kinds` are the kinds of balls (ONE_SIZE and charges) if there are several.
    """
    built, kinds = as_built(descriptors), kinds_of(descriptors[CHARGE])
    first = built.iloc[0]
    columns = ["speed_hz", "ball_diameter_m", *([CHARGE] if charges else [])]
    settings = built[columns].drop_duplicates().sort_values([*SETTING, *columns[2:]])
    mixed = {
        name: {
            "ball_diameter_m": charge.mean_diameter_mm / 1e3,
            "sizes_m": [size / 1e3 for size in charge.sizes_mm],
            "fractions": charge.fractions,
        }
        for name, charge in charges.items()
    }
    return {
        **{name: first[name] for name in ("mill", "contact", *OF_RULE)},
        **{name: float(first[name]) for name in SHARED if pd.notna(first[name])},
        "volume_m3": float(volume_m3),
        "probability": float(probability),
        "settings": settings.to_dict("list"),
        **({"charges": mixed} if mixed else {}),
        **({"kinds": kinds} if kinds else {}),
        **{name: float(first[name]) for name, of_balls in WALL.items() if abs(first[name] - first[of_balls]) > 0},
        "ranges": {name: [float(descriptors[name].min()), float(descriptors[name].max())] for name in VARIABLES},
    }
