"""The set-ups that others measured, one record each.

Impacts of single spheres: the DEM, laws of partial slip and of plastic rebound, and what was measured.
"""

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from millprint.config.contact_set import ContactConfig
from millprint.config.errors import ConfigError
from millprint.config.mill import BoxGeometry, MillConfig
from millprint.config.setup_models import (
    FILES,
    IMPACT,
    SURFACE,
    AluminaImpactConfig,
    ElasticImpactConfig,
    ImpactConfig,
    SetupConfig,
    SetupFile,
)
from millprint.config.sweep import Case, DemConfig
from millprint.dem.laws.hertz import effective_modulus, impact
from millprint.dem.laws.record import ball_mass, damping_ratio
from millprint.dem.simulation import FewBalls, walls_for
from millprint.mill.vessel import Vessel, shape_vessel
from millprint.mill.walls import Walls
from millprint.validation.drums import SHORT, predict_bead_drum, predict_repose_drum
from millprint.validation.measured import CONTACT, PLACE_COLUMNS, Inputs, check_predictions, prediction
from millprint.validation.shaken import predict_leaf_spring, predict_shaken_box, predict_shaken_plate
from millprint.validation.tumbling import OTHER_CONTACT, predict_tumbling


@dataclass(frozen=True)
class Rebound:
    """Velocities of a sphere before and after an impact.

    normal, tangential: of the centre [m/s], the normal one positive towards the plate before and away from it after;
    spin: about the axis across both, positive for rolling along +x [rad/s]; radius [m].
    """

    normal_before: float
    tangential_before: float
    normal: float
    tangential: float
    spin: float
    radius: float

    @property
    def restitution(self) -> float:
        """Normal velocity after over before [-]."""
        return self.normal / self.normal_before

    @property
    def tangential_restitution(self) -> float:
        """Tangential velocity of the centre after over before [-]."""
        return self.tangential / self.tangential_before

    @property
    def angle_deg(self) -> float:
        """Rebound angle of the centre from the normal [deg]."""
        return math.degrees(math.atan2(self.tangential, self.normal))

    @property
    def surface_velocity(self) -> float:
        """Tangential velocity of the surface at the contact point after the impact [m/s]."""
        return self.tangential - self.radius * self.spin

    @property
    def surface_angle_deg(self) -> float:
        """Rebound angle of the contact point from the normal [deg]."""
        return math.degrees(math.atan2(self.surface_velocity, self.normal))


def largest_overlap(contact: ContactConfig, radius: float, speed: float) -> float:
    """Largest overlap of an elastic sphere and a plate, (15 m v^2 / (16 sqrt(R) E*))^(2/5) [m] (Hertz 1882).

    radius [m], speed along the normal [m/s].
    """
    return impact(*_mass_and_stiffness(contact, radius), speed)[0]


def impact_duration(contact: ContactConfig, radius: float, speed: float) -> float:
    """Duration of the elastic impact of a sphere on a plate, 2.9432 d / v with the largest overlap d [s] (Hertz 1882).

    radius [m], speed along the normal [m/s].
    """
    return impact(*_mass_and_stiffness(contact, radius), speed)[1]


def _mass_and_stiffness(contact: ContactConfig, radius: float) -> tuple[float, float]:
    """Mass of a sphere [kg], and Hertz's stiffness 4/3 E* sqrt(R) of its contact with a plate [N/m^(3/2)]."""
    return ball_mass(contact, radius), 4 / 3 * effective_modulus(contact) * math.sqrt(radius)


STEPS, SPRINGS = 2000, 300


def partial_slip(
    contact: ContactConfig, radius: float, normal: float, tangential: float, steps: int = STEPS, springs: int = SPRINGS
) -> Rebound:
    """Rebound of a sphere, without spin at first, from a plate of its own material (Maw, Barber and Fawcett 1976).

    By the method of dimensionality reduction (Lyashenko and Popov, Sci. Rep. 5, 8479, 2015): independent springs at x
    over the contact's diameter, pressed by d - x^2 / R; the stiffness of each is E* dx along the normal, G* dx across,
    with G* = 4 G / (2 (2 - nu)), and each slides separately at mu times its normal force. For Mindlin's contact the
    result is exact. The normal force is damped as in our law, the tangential force is not.

    radius [m]; normal, tangential: speeds before the impact [m/s].
    """
    modulus, poisson = contact.value_of("young_modulus_gpa") * 1e9, contact.value_of("poisson_ratio")
    stiffness = effective_modulus(contact)
    shear = modulus / ((2 - poisson) * (1 + poisson))
    mass = ball_mass(contact, radius)
    friction = contact.value_of("static_friction", normal)
    damping = -2 * math.sqrt(5 / 6) * damping_ratio(contact.value_of("restitution", normal))
    # A little wider than the largest contact.
    half = 1.02 * math.sqrt(radius * largest_overlap(contact, radius, normal))
    place = (np.arange(springs) + 0.5) * half / springs
    gap, width = place**2 / radius, 2 * half / springs
    step = impact_duration(contact, radius, normal) / steps
    drawn = np.zeros(springs)
    approach, along, spin = normal, tangential, 0.0
    overlap = 0.5 * step * approach
    while overlap > 0:
        pressed = np.maximum(overlap - gap, 0.0)
        # A spring that has left the plate loses its displacement.
        drawn = np.where(pressed > 0, drawn + (along - radius * spin) * step, 0.0)
        limit = friction * stiffness / shear * pressed
        drawn = np.clip(drawn, -limit, limit)
        drag = shear * width * drawn.sum()
        root = math.sqrt(radius * overlap)
        push = 4 / 3 * stiffness * root * overlap + damping * math.sqrt(2 * stiffness * root * mass) * approach
        approach -= push / mass * step
        along -= drag / mass * step
        spin += 2.5 * drag / (mass * radius) * step
        overlap += approach * step
    return Rebound(normal, tangential, -approach, along, spin, radius)


# Length of the run in durations of the elastic impact; damping makes an impact longer.
DURATIONS = 4.0
# Width of the box in radii; only its floor is ever near the sphere.
WIDTH_RADII = 200.0
# Reference lines.
SLIDING, PARTIAL = "full sliding (Walton 1993)", "partial slip (Maw, Barber and Fawcett 1976)"


def _plate(radius: float) -> tuple[Vessel, Walls]:
    side = 1e3 * WIDTH_RADII * radius
    box = BoxGeometry(kind="box", x_mm=side, y_mm=side, z_mm=max(side / 10, 1.0))
    vessel = shape_vessel(box, "impact", solid=False)
    return vessel, walls_for(vessel, radius, 0.1 * radius, WIDTH_RADII * radius / 20)


class Plate:
    """A plate for impacts of spheres of one radius [m]."""

    def __init__(self, radius: float) -> None:
        self.radius = radius
        self.vessel, self.walls = _plate(radius)

    def hit(self, contact: ContactConfig, normal: float, tangential: float, steps: int, spin: float = 0.0) -> Rebound:
        """One impact at velocities [m/s] towards and along the plate, with a spin [rad/s], in `steps` steps a duration.

        Raises SimulationError as `FewBalls.run`.
        """
        duration = impact_duration(contact, self.radius, normal)
        low = self.vessel.bounds[0][2]
        world = FewBalls(
            self.vessel, contact, [0.0, 0.0, low + self.radius], [tangential, 0.0, -normal], [0.0, spin, 0.0],
            self.radius, step=duration / steps, skin=0.1 * self.radius, walls=self.walls,
        )  # fmt: skip
        world.run(DURATIONS * duration)
        (vx, _, vz), (_, turn, _) = world.balls.velocity[0], world.balls.angular_velocity[0]
        return Rebound(normal, tangential, float(vz), float(vx), float(turn), self.radius)


def sliding(contact: ContactConfig, radius: float, normal: float, tangential: float) -> Rebound | None:
    """Rebound of a sphere without initial spin that slides throughout (Walton 1993); None if it would not.

    The impulse along the plate is mu (1 + e) m v, so that the tangential restitution is 1 - mu (1 + e) v / w. It slides
    throughout if w > 7/2 mu (1 + e) v. radius [m]; normal v, tangential w: speeds before the impact [m/s].
    """
    restitution = contact.value_of("restitution", normal)
    change = contact.value_of("static_friction", normal) * (1 + restitution) * normal
    if tangential < 3.5 * change:
        return None
    return Rebound(normal, tangential, restitution * normal, tangential - change, 2.5 * change / radius, radius)


def variants(contact: ContactConfig, settings: ImpactConfig) -> list[ContactConfig]:
    """The contact set, and those at every corner of the intervals of restitution and friction."""
    ranges = {
        "restitution": settings.restitution or (contact.restitution,),
        "static_friction": settings.static_friction or (contact.static_friction,),
    }
    corners = [dict(zip(ranges, values, strict=True)) for values in product(*ranges.values())]
    changed = [contact.model_copy(update=corner) for corner in corners]
    return [contact, *(each for each in changed if each != contact)]


def _row(quantity: str, unit: str, ids: dict[float, str], x: float, values: list[float]) -> dict:
    """A row with the first value as the prediction and the span of all as its interval."""
    varied = len(values) > 1
    return prediction(
        quantity, unit, values[0], id=ids.get(x, ""), x=x, lower=min(values) if varied else math.nan,
        upper=max(values) if varied else math.nan, interval=CONTACT if varied else "",
    )  # fmt: skip


def _all_places(given: Iterable[float], places: pd.Series) -> list[float]:
    return sorted({*map(float, given), *places})


# How each quantity is computed. The sign of the spin is as in the source: forward rolling is negative.
READ: tuple[Callable[[Rebound], float], ...] = (
    lambda hit: hit.tangential_restitution,
    lambda hit: -hit.spin,
    lambda hit: hit.angle_deg,
    lambda hit: hit.surface_angle_deg,
)
QUANTITIES = {name: (unit, read) for (name, unit), read in zip(IMPACT.items(), READ, strict=True)}


def predict_alumina_impact(inputs: Inputs) -> pd.DataFrame:
    """Set-up 3: tangential restitution, spin and rebound angles over the angle of incidence, at one speed."""
    settings: AluminaImpactConfig = inputs.settings
    contact, plate = inputs.contact, Plate(settings.radius_mm * 1e-3)
    ids = {quantity: inputs.ids_of(quantity) for quantity in QUANTITIES}
    rows = []
    for angle in _all_places(settings.angles_deg, inputs.places["x"]):
        normal = settings.speed_m_s * math.cos(math.radians(angle))
        tangential = settings.speed_m_s * math.sin(math.radians(angle))
        hits = [plate.hit(each, normal, tangential, settings.steps_per_impact) for each in variants(contact, settings)]
        lines = {
            PARTIAL: partial_slip(contact, plate.radius, normal, tangential),
            SLIDING: sliding(contact, plate.radius, normal, tangential),
        }
        for quantity, (unit, read) in QUANTITIES.items():
            rows.append(_row(quantity, unit, ids[quantity], angle, [read(hit) for hit in hits]))
            for model, hit in lines.items():
                if hit is not None:
                    rows.append(prediction(quantity, unit, read(hit), x=angle, model=model))
    return pd.DataFrame(rows)


def predict_elastic_impact(inputs: Inputs) -> pd.DataFrame:
    """Set-up 9: tangential over mu times normal velocity of the contact point, after against before."""
    settings: ElasticImpactConfig = inputs.settings
    contact, plate = inputs.contact, Plate(settings.radius_mm * 1e-3)
    normal, ids, rows = settings.normal_speed_m_s, inputs.ids_of(SURFACE), []
    for slope in _all_places(settings.slopes, inputs.places["x"]):
        values = []
        for each in variants(contact, settings):
            scale = each.value_of("static_friction", normal) * normal
            values.append(plate.hit(each, normal, slope * scale, settings.steps_per_impact).surface_velocity / scale)
        rows.append(_row(SURFACE, "-", ids, slope, values))
        scale = contact.value_of("static_friction", normal) * normal
        for model, solve in ((PARTIAL, partial_slip), (SLIDING, sliding)):
            if (hit := solve(contact, plate.radius, normal, slope * scale)) is not None:
                rows.append(prediction(SURFACE, "-", hit.surface_velocity / scale, x=slope, model=model))
    return pd.DataFrame(rows)


@dataclass(frozen=True)
class Kind:
    """How set-ups of a kind are predicted.

    predict: the predictions from their inputs, a table with PREDICTION_COLUMNS; variants: beginnings of the names of
    models that change one thing of ours and may explain a miss (`validation.verdicts`).
    """

    predict: Callable[[Inputs], pd.DataFrame]
    variants: tuple[str, ...] = ()


PREDICTED = {
    "tumbling": Kind(predict_tumbling, (OTHER_CONTACT,)),
    "oblique_impact": Kind(predict_alumina_impact, (PARTIAL,)),
    "elastic_impact": Kind(predict_elastic_impact, (PARTIAL,)),
    "bead_drum": Kind(predict_bead_drum, (SHORT,)),
    "repose_drum": Kind(predict_repose_drum),
    "shaken_box": Kind(predict_shaken_box),
    "leaf_spring": Kind(predict_leaf_spring),
    "shaken_plate": Kind(predict_shaken_plate),
}


def setup_named(name: str) -> SetupFile:
    """The file of a set-up. Raises ConfigError for a name that none has."""
    if name not in FILES:
        raise ConfigError(f"validation.setups: unknown set-up {name!r}; known: {', '.join(FILES)}")
    return FILES[name]


def predict(
    name: str,
    settings: SetupConfig,
    mill: MillConfig | None,
    contacts: dict[str, ContactConfig],
    dem: DemConfig,
    cases: dict[str, Case],
    runs: str | Path,
    measured: pd.DataFrame,
    folder: str | Path = "",
    other_codes: pd.DataFrame | None = None,
) -> pd.DataFrame:
    """The predictions of a set-up, checked; `measured` are points as of `measured_points`, the others as of `Inputs`.

    A set-up gets the measured places, but not the values. Raises ConfigError as `setup_named`, and for a measured
    quantity that the set-up does not predict.
    """
    setup = setup_named(name)
    places = measured.loc[measured["setup"] == name, list(PLACE_COLUMNS)]
    inputs = Inputs(settings, mill, contacts, dem, cases, Path(runs), places, Path(folder), other_codes)
    table = check_predictions(PREDICTED[setup.kind].predict(inputs), name)
    known = dict.fromkeys(table["quantity"])
    for id, quantity in zip(places["id"], places["quantity"], strict=True):
        if quantity not in known:
            place = f"validation.measured: column quantity, id {id} = {quantity!r}"
            raise ConfigError(f"{place}: set-up {name} predicts {', '.join(known)}")
    return table


def assumption_table(
    name: str, settings: SetupConfig, mill: MillConfig | None, contacts: dict[str, ContactConfig]
) -> list[dict[str, Any]]:
    """A row for each assumption of a set-up: setup, what, value, source."""
    setup = setup_named(name)
    rows = [(each.what, each.value, each.source) for each in setup.assumptions]
    if mill is not None:
        rows.append((f"mill {mill.name}", mill.title, mill.source))
    for contact in contacts.values():
        values = contact.model_dump(exclude={"name", "source"}, exclude_defaults=True)
        role = "predicts" if contact.name == settings.contact else "interval"
        rows += [
            (f"{key}, contact set {contact.name} ({role})", value if key == "kind" else f"{value:g}", contact.source)
            for key, value in values.items()
        ]
    return [
        {"setup": name, "what": what, "value": value, "source": " ".join(source.split())}
        for what, value, source in rows
    ]
