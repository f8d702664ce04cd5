"""The mill scaled up at the same fill ratio: what a ball-step costs where the state no longer fits into a core's cache.

The jar grows in every length, balls and motion stay. Millprint alone runs it.
"""

from dataclasses import replace
from typing import Any

import numpy as np

from millprint.bench.cases import Jar, Setup, make_setup, settle
from millprint.config.bench import BenchConfig
from millprint.config.contact import ContactConfig
from millprint.config.geometry import CylinderGeometry, StadiumGeometry
from millprint.config.mill import MillConfig
from millprint.dem.packing import pack_from_below
from millprint.errors import ConfigError


def scaled_lengths(values: dict[str, Any], scale: float) -> dict[str, Any]:
    """A geometry's keys with every length multiplied, those of parts inside it too."""
    scaled = {}
    for key, value in values.items():
        if isinstance(value, dict):
            scaled[key] = scaled_lengths(value, scale)
        elif key.endswith("_mm") and value is not None:
            scaled[key] = (np.array(value) * scale).tolist()
        else:
            scaled[key] = value
    return scaled


def scaled_mill(mill: MillConfig, factor: float) -> MillConfig:
    """The mill with a jar of `factor` times the volume [-].

    Raises ConfigError for a jar that is no stadium or cylinder, or has inserts.
    """
    if not isinstance(mill.geometry, StadiumGeometry | CylinderGeometry) or mill.inserts:
        raise ConfigError(
            f"config/mills/{mill.name}.yaml: geometry.kind = {mill.geometry.kind!r}: the bench's large case needs a "
            "stadium or a cylinder, without inserts"
        )
    geometry = type(mill.geometry).model_validate(scaled_lengths(mill.geometry.model_dump(), factor ** (1 / 3)))
    return mill.model_copy(update={"geometry": geometry, "volume_ml": mill.volume_ml * factor})


def large_setup(config: BenchConfig, mill: MillConfig, contact: ContactConfig) -> Setup:
    """The large case: the jar's volume grows as the balls' does from the case that it is compared with."""
    large, small = config.large, config.case_named(config.large.compared_with)
    factor = large.balls * large.ball_diameter_mm**3 / (small.balls * small.ball_diameter_mm**3)
    jar = Jar(f"{mill.name}_large", scaled_mill(mill, factor))
    setup = make_setup(config, contact, jar, large.balls, large.ball_diameter_mm)
    return replace(setup, settle_s=large.settle_s)


def large_start(setup: Setup, threads: int = 1) -> np.ndarray:
    """Positions (n, 3) [m] of balls at rest, packed densely from the floor of the jar up and settled from there.

    So dense that they need not fall far to be at rest: a looser start would still be falling when the mill sets off,
    with fewer contacts and so at too low a cost.
    """
    packed = pack_from_below(setup.jar.vessel, setup.diameter_m, setup.balls, seed=0)
    return settle(setup, seed=0, packed=packed, threads=threads)
