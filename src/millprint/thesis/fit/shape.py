"""Jars of one volume, by the parameters that the thesis does not give."""

import numpy as np

from millprint.config.errors import ConfigError
from millprint.config.fit import RangeConfig, ShapeConfig
from millprint.config.geometry import StadiumGeometry
from millprint.config.mill import MillConfig
from millprint.mill.shapes import stadium_facets
from millprint.mill.vessel import enclosed_volume

JAR_PARAMETERS = tuple(ShapeConfig.model_fields)

# Range of the end radius in the search, over the cube root of the volume; tolerance of the radius [mm].
NARROWEST, WIDEST, CLOSE_MM = 0.1, 3.0, 1e-4


def parameters_of(geometry: StadiumGeometry) -> dict[str, float]:
    """The parameters of a jar, by name."""
    own = {name: float(getattr(geometry, name)) for name in JAR_PARAMETERS if name != "straight_ratio"}
    return {"straight_ratio": geometry.straight_mm / geometry.end_radius_mm, **own}


def on_grid(value: float, allowed: RangeConfig) -> float:
    """The nearest value on the grid of a parameter."""
    last = int((allowed.high - allowed.low) / allowed.step + 1e-9)
    steps = np.clip(round((value - allowed.low) / allowed.step), 0, last)
    return float(np.round(allowed.low + allowed.step * steps, 9))


def volume_ml(geometry: StadiumGeometry) -> float:
    """Inner volume of the facetted jar [mL]."""
    return enclosed_volume(stadium_facets(geometry)) * 1e6


def shaped(mill: MillConfig, parameters: dict[str, float]) -> MillConfig:
    """The mill with a jar of these parameters, its end radius such that the facetted jar holds the mill's volume.

    Raises ConfigError where no end radius does.
    """
    # Slow to import, and the tables of a fit import this module.
    from scipy.optimize import brentq

    whole = {name: value for name, value in parameters.items() if name != "straight_ratio"}
    whole["facets_per_half_circle"] = int(whole["facets_per_half_circle"])
    size = mill.volume_ml ** (1 / 3) * 10

    def jar(radius: float) -> StadiumGeometry:
        sizes = {"end_radius_mm": radius, "straight_mm": radius * parameters["straight_ratio"]}
        return StadiumGeometry.model_validate({**mill.geometry.model_dump(), **whole, **sizes})

    def excess(radius: float) -> float:
        return volume_ml(jar(radius)) - mill.volume_ml

    narrowest = max(NARROWEST * size, 1.01 * parameters["fillet_radius_mm"])
    if excess(narrowest) > 0 or excess(WIDEST * size) < 0:
        described = ", ".join(f"{name} {value:g}" for name, value in parameters.items())
        raise ConfigError(f"fit.shape: no jar of {mill.volume_ml:g} mL has {described}")
    radius = brentq(excess, narrowest, WIDEST * size, xtol=CLOSE_MM)
    return mill.model_copy(update={"geometry": jar(round(radius, 3))})
