"""What each measured set-up predicts: names and units of its quantities, and what they depend on."""

from typing import NamedTuple

from millprint.config.setup_models import (
    AluminaImpactConfig,
    BeadDrumConfig,
    ElasticImpactConfig,
    ReposeDrumConfig,
    SetupConfig,
    TumblingConfig,
)
from millprint.config.shaken_models import LeafSpringConfig, ShakenBoxConfig, ShakenPlateConfig

POWER, RINGS, TOE, SHOULDER = "power", "complete rings of centrifuging balls", "toe angle", "shoulder angle"
TURN_ENERGY = "energy a revolution"
FLOW_SPEED, SURFACE_ANGLE = "speed down the slope", "angle of the surface"
STILL_PLACE = "place at which the speed is zero"
REPOSE = "angle of repose"
IMPACT = {
    "tangential restitution": "-",
    "spin after the impact": "rad/s",
    "rebound angle of the centre": "deg",
    "rebound angle of the contact point": "deg",
}
LOST, SWING = "energy lost a period over 4 m (A w)^2", "amplitude over ball diameter"
PLATE_POWER, PLATE_MEAN = "power over m g V", "mean power over m g V from 6 to 30 g"
LOSS_EXPONENT = "exponent of the loss factor over the acceleration"
SURFACE = "tangential over mu times normal velocity after the impact"


class Asked(NamedTuple):
    """A quantity that can be asked: its unit, and the x that it depends on; empty for a single number."""

    unit: str
    x: str = ""


def with_number(quantity: str, number: int, settings: TumblingConfig) -> str:
    """A quantity of a tumbling mill, with the number of balls unless it is the first of the set-up."""
    return quantity if number == settings.numbers[0] else f"{quantity}, {number} balls"


def quantities_of(setup: SetupConfig) -> dict[str, Asked]:
    """The quantities of a set-up by name."""
    if isinstance(setup, TumblingConfig):
        return _of_tumbling(setup)
    if isinstance(setup, AluminaImpactConfig):
        return {name: Asked(unit, "angle of incidence from the normal [deg]") for name, unit in IMPACT.items()}
    if isinstance(setup, ElasticImpactConfig):
        return {SURFACE: Asked("-", "tangential over mu times normal velocity before the impact [-]")}
    if isinstance(setup, BeadDrumConfig):
        place = "place along the normal of the surface, from the axis [m]"
        return {FLOW_SPEED: Asked("m/s", place), SURFACE_ANGLE: Asked("deg"), STILL_PLACE: Asked("m")}
    known: dict[type[SetupConfig], dict[str, Asked]] = {
        ReposeDrumConfig: {REPOSE: Asked("deg")},
        ShakenBoxConfig: {LOST: Asked("-", "amplitude over free gap, A / G [-]")},
        LeafSpringConfig: {SWING: Asked("-", "time [s]")},
        ShakenPlateConfig: {
            PLATE_POWER: Asked("-", "peak acceleration of the plate [g]"),
            PLATE_MEAN: Asked("-"),
            LOSS_EXPONENT: Asked("-"),
        },
    }
    return known[type(setup)]


def _of_tumbling(setup: TumblingConfig) -> dict[str, Asked]:
    # At a single speed, what is measured is the energy of a revolution.
    if len(setup.speeds) == 1:
        return {TURN_ENERGY: Asked("J/rev")}
    x = "speed [rpm]" if setup.critical_speed_rpm is None else "speed [% of the critical speed]"
    units = {POWER: "W", RINGS: "rings", TOE: "deg", SHOULDER: "deg"}
    return {
        with_number(name, number, setup): Asked(unit, x) for number in setup.numbers for name, unit in units.items()
    }
