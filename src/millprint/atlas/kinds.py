"""The kinds of mills of the atlas: planetary, mixer, drum and SPEX-like.

To add a kind, write what makes its groups from dimensions and dimensions from groups, and add a record to `KINDS`.
"""

import math
from collections.abc import Mapping
from typing import Any

from millprint.atlas.kind_groups import (
    CONTACT,
    FILLET,
    PACKED,
    RADIUS,
    REFERENCE_MM,
    Dimension,
    Group,
    Kind,
    Limit,
    Values,
    ball,
    cylinder,
    fill,
    froude,
    gap,
    layers,
    loss,
    rounding_mm,
    shape,
    softness,
    speed_hz,
    way,
)
from millprint.config.contact_set import ContactConfig
from millprint.config.errors import ConfigError
from millprint.config.mill import CylinderGeometry, MillConfig
from millprint.config.motion_kinds import PlanetaryMotion, RotationMotion, SwingMotion
from millprint.config.wording import close_to
from millprint.mill.gravity import GRAVITY


def axis_of(mill: MillConfig) -> str:
    """The axis of a round jar."""
    return mill.geometry.axis if isinstance(mill.geometry, CylinderGeometry) else ""


# ---- planetary ----
# A ball that goes round with the wall of the jar stays on it from 1 on: its acceleration by the jar's turning over that
# by the wheel's (critical speed ratio: Mio, Kano, Saito, Kaneko, Mater. Sci. Eng. A 332 (2002) 75). Beds slide back
# and fall up to about this; beyond, errors of the atlas are several times as large.
CENTRIFUGING = 1.5


def slip(groups: Mapping[str, Any], length: str = "length") -> Any:
    """Half the logarithm of the torque that friction at the walls can hold over that of the bed's weight.

    A bed slides along the shell where it is small. The ratio is mu_w (s + (s - 1) R / L) / (1 - d / 2R), from the
    pressure rho g h at a depth h: on the shell with s = (1 + u) / (1 - u), of a bed over the share u of the section,
    and on both ends with s - 1, their arm being R; within 13 % of the integrals. Centres of
    balls lie within R - d / 2. In a planetary mill the wheel takes the place of gravity.

    length: the group of L / R.
    """
    import numpy as np

    filled = groups["fill"] / PACKED
    shell = (1 + filled) / (1 - filled)
    held = groups["wall_static_friction"] * (shell + (shell - 1) / groups[length])
    return np.log(held / (1 - groups["ball"] / 2)) / 2


def _planetary_realised(groups: Values) -> dict[str, float]:
    sun = REFERENCE_MM / groups["jar"]
    return {
        "radius_mm": REFERENCE_MM, "height_mm": groups["height"] * REFERENCE_MM,
        "fillet_radius_mm": rounding_mm(groups), "sun_radius_mm": sun, "ratio": -groups["turns"],
        "speed_hz": speed_hz(groups["froude"], sun),
    }  # fmt: skip


def _planetary_recognised(mill: MillConfig) -> dict[str, float] | None:
    jar = cylinder(mill, "z", "bottom")
    if not isinstance(mill.motion, PlanetaryMotion) or jar is None:
        return None
    return jar | {"sun_radius_mm": mill.motion.sun_radius_mm, "ratio": mill.motion.ratio}


PLANETARY = Kind(
    name="planetary",
    title="Planetary mill",
    dimensions=(
        RADIUS,
        Dimension("height_mm", "inner height H of the jar [mm]", 3, 5000),
        FILLET,
        Dimension("sun_radius_mm", "distance R_s of the jar's axis from the sun wheel's [mm]", 10, 5000),
        Dimension("ratio", "turns of the jar relative to the wheel over the wheel's, -2 for 1:-2", -20, 20),
    ),
    groups=(
        fill(0.03, 0.40),
        ball(0.14, 0.60),
        Group("height", "H/R", "H / R", 0.9, 2.6, "share of the end walls, which rub"),
        Group("rounding", "r/R", "r / R", 0.0, 0.4, "where the lowest layer lies", False),
        Group("jar", "R/R_s", "R / R_s", 0.20, 0.85, "spin of the jar against the carrying, which decides whether "
              "balls leave the wall"),
        Group("turns", "k", "-ratio", 1.0, 3.2, "speed of the jar's wall past the balls, and Coriolis force", False),
        Group("froude", "Fr", "(2 pi f)^2 R_s / g", 2.0, 120.0, "gravity against the carrying round"),
        softness(),
        *CONTACT,
    ),
    stroke_m=lambda values: values["sun_radius_mm"] / 1e3,
    travel_m=lambda values: (values["sun_radius_mm"] + values["radius_mm"]) / 1e3,
    content=lambda values: {
        "geometry": shape(values, "z", "bottom"),
        "motion": {"kind": "planetary", "sun_radius_mm": values["sun_radius_mm"], "ratio": values["ratio"]},
    },
    own_groups=lambda values: {
        "height": values["height_mm"] / values["radius_mm"],
        "rounding": values["fillet_radius_mm"] / values["radius_mm"],
        "jar": values["radius_mm"] / values["sun_radius_mm"],
        "turns": -values["ratio"],
        "froude": froude(values, values["sun_radius_mm"]),
    },
    realised=_planetary_realised,
    recognised=_planetary_recognised,
    ends=1,
    derived=(
        layers,
        # Accelerations: of the jar's own turning over the wheel's, and of a ball that goes round with the jar's wall.
        lambda groups: groups["turns"] ** 2 * groups["jar"] / 2,
        lambda groups: (groups["turns"] - 1) ** 2 * groups["jar"] / 2,
        loss,
        lambda groups: slip(groups, "height"),
    ),
    limits=(
        Limit("(k - 1)^2 (R - d/2) / R_s", "the jar's own turning holds the balls on its wall", CENTRIFUGING,
              lambda groups: (groups["turns"] - 1) ** 2 * groups["jar"] * (1 - groups["ball"] / 2)),
    ),
)  # fmt: skip


# ---- mixer ----
def _mixer_realised(groups: Values) -> dict[str, float]:
    stroke = groups["stroke"] * REFERENCE_MM
    return {
        "radius_mm": REFERENCE_MM, "height_mm": groups["length"] * REFERENCE_MM,
        "fillet_radius_mm": rounding_mm(groups), "stroke_mm": stroke,
        "arc_radius_mm": stroke / groups["arc"], "speed_hz": speed_hz(groups["froude"], stroke),
    }  # fmt: skip


def _mixer_recognised(mill: MillConfig) -> dict[str, float] | None:
    jar, motion = cylinder(mill, "xy", "both"), mill.motion
    if not isinstance(motion, SwingMotion) or jar is None or motion.terms or motion.multiple != 1:
        return None
    along = "xyz".index(axis_of(mill))
    arm = math.hypot(*motion.pivot_mm)
    upright = motion.axis[0] == 0 == motion.axis[1]
    if not arm or not upright or motion.pivot_mm[2] or abs(motion.pivot_mm[along]) > 1e-6 * arm:
        return None
    return jar | {"arc_radius_mm": arm, "stroke_mm": arm * math.radians(motion.amplitude_deg)}


MIXER = Kind(
    name="mixer",
    title="Mixer mill",
    speed_unit="hz",
    dimensions=(
        RADIUS,
        Dimension("height_mm", "inner length L of the lying jar, its ends included [mm]", 3, 5000),
        Dimension("fillet_radius_mm", "rounding of the ends: 0 if flat, the radius for half spheres [mm]", 0, 2000),
        Dimension("stroke_mm", "how far the middle of the jar swings to each side, along its arc A [mm]", 1, 1000),
        Dimension("arc_radius_mm", "radius of the horizontal arc [mm]", 5, 5000),
    ),
    groups=(
        fill(0.008, 0.40),
        ball(0.18, 0.95),
        Group("length", "L/R", "L / R", 2.2, 6.0, "way from end to end"),
        Group("rounding", "r/R", "r / R", 0.0, 1.0, "flat ends send a ball back, round ones aside", False),
        Group("stroke", "A/R", "A / R", 0.4, 3.0, "swing against the way from end to end: the rhythm"),
        Group("arc", "A/R_a", "A / R_a", 0.06, 0.30, "turning of the jar, which throws balls outwards"),
        Group("froude", "Fr", "(2 pi f)^2 A / g", 2.0, 120.0, "gravity against the swing"),
        softness(),
        *CONTACT,
    ),
    stroke_m=lambda values: values["stroke_mm"] / 1e3,
    content=lambda values: {
        "geometry": shape(values, "x", "both"),
        "motion": {
            "kind": "swing", "axis": [0, 0, 1], "pivot_mm": [0, -values["arc_radius_mm"], 0],
            "amplitude_deg": math.degrees(values["stroke_mm"] / values["arc_radius_mm"]),
        },
    },
    own_groups=lambda values: {
        "length": values["height_mm"] / values["radius_mm"],
        "rounding": values["fillet_radius_mm"] / values["radius_mm"],
        "stroke": values["stroke_mm"] / values["radius_mm"],
        "arc": values["stroke_mm"] / values["arc_radius_mm"],
        "froude": froude(values, values["stroke_mm"]),
    },
    realised=_mixer_realised,
    recognised=_mixer_recognised,
    ends=2,
    derived=(lambda groups: layers(groups, "length"), gap, way, lambda groups: loss(groups, "length")),
)  # fmt: skip


# ---- drum ----
def _drum_speed(values: Values) -> float:
    """Speed over the critical one, at which one that does not slide goes round: sqrt(g / (R - d / 2)) / 2 pi."""
    import numpy as np

    reach = (values["radius_mm"] - values["ball_diameter_mm"] / 2) / 1e3
    return 2 * math.pi * values["speed_hz"] / np.sqrt(GRAVITY / reach)


def _drum_realised(groups: Values) -> dict[str, float]:
    reach = REFERENCE_MM * (1 - groups["ball"] / 2) / 1e3
    speed = groups["critical"] * math.sqrt(GRAVITY / reach) / (2 * math.pi)
    return {"radius_mm": REFERENCE_MM, "height_mm": groups["length"] * REFERENCE_MM, "speed_hz": speed}


def _drum_recognised(mill: MillConfig) -> dict[str, float] | None:
    jar, motion = cylinder(mill, "xy", "none"), mill.motion
    if (
        not isinstance(motion, RotationMotion)
        or jar is None
        or jar.pop("fillet_radius_mm")
        or motion.ratio not in (1, -1)
    ):
        return None
    along = [abs(value) for value in motion.axis]
    turns_about_itself = not any(motion.pivot_mm) and along.index(max(along)) == "xyz".index(axis_of(mill))
    return jar if turns_about_itself and sum(along) == max(along) else None


DRUM = Kind(
    name="drum",
    title="Tumbling drum",
    dimensions=(RADIUS, Dimension("height_mm", "inner length L of the drum, or of a slice [mm]", 3, 5000)),
    groups=(
        fill(0.08, 0.40),
        ball(0.12, 0.45),
        Group("length", "L/R", "L / R", 0.5, 2.5, "share of the end walls, which rub and lift"),
        Group("critical", "N/N_c", "2 pi f sqrt((R - d/2) / g)", 0.35, 0.95, "lift of the balls", False),
        softness(8e-6),
        *CONTACT,
    ),
    stroke_m=lambda values: values["radius_mm"] / 1e3,
    content=lambda values: {
        "geometry": shape(values, "y", "none"), "motion": {"kind": "rotation", "axis": [0, 1, 0]},
    },
    own_groups=lambda values: {
        "length": values["height_mm"] / values["radius_mm"], "critical": _drum_speed(values),
    },
    realised=_drum_realised,
    recognised=_drum_recognised,
    ends=0,
    derived=(layers, loss, slip),
    # A bed turns over twice or more in a turn, which is long.
    discarded_turns=1,
    fewest_turns=8,
)  # fmt: skip


# ---- SPEX-like shaker ----
def _spex_realised(groups: Values) -> dict[str, float]:
    stroke = groups["stroke"] * REFERENCE_MM
    return {
        "radius_mm": REFERENCE_MM, "height_mm": groups["length"] * REFERENCE_MM,
        "fillet_radius_mm": rounding_mm(groups), "stroke_mm": stroke,
        "sideways_mm": groups["sideways"] * stroke, "arm_mm": stroke / groups["arc"],
        "speed_hz": speed_hz(groups["froude"], stroke),
    }  # fmt: skip


def _spex_recognised(mill: MillConfig) -> dict[str, float] | None:
    jar, motion = cylinder(mill, "y", "both"), mill.motion
    if (
        not isinstance(motion, SwingMotion)
        or jar is None
        or len(motion.terms) != 1
        or motion.multiple != 1
        or motion.phase_deg
    ):
        return None
    (term,) = motion.terms
    arm = -motion.pivot_mm[2]
    lies_below = arm > 0 and motion.pivot_mm[0] == 0 == motion.pivot_mm[1]
    if not lies_below or motion.axis[1:] != (0, 0) or (term.axis, term.multiple, term.phase_deg) != ("x", 2, 0):
        return None
    stroke = arm * math.radians(motion.amplitude_deg)
    return jar | {"arm_mm": arm, "stroke_mm": stroke, "sideways_mm": term.amplitude_mm}


SPEX = Kind(
    name="spex",
    title="SPEX-like shaker",
    speed_unit="hz",
    dimensions=(
        Dimension("radius_mm", "inner radius R of the vial [mm]", 3, 2000),
        Dimension("height_mm", "inner length L of the vial, its ends included [mm]", 3, 5000),
        FILLET,
        Dimension("stroke_mm", "how far the vial moves to each side along its axis A [mm]", 1, 1000),
        Dimension("sideways_mm", "how far it moves to each side across it, twice as often B [mm]", 1, 1000),
        Dimension("arm_mm", "length of the arm that carries it [mm]", 5, 5000),
    ),
    groups=(
        fill(0.008, 0.35),
        ball(0.15, 0.75),
        Group("length", "L/R", "L / R", 2.2, 4.0, "way from end to end"),
        Group("rounding", "r/R", "r / R", 0.0, 0.4, "flat ends send a ball back", False),
        Group("stroke", "A/R", "A / R", 0.8, 2.2, "swing against the way from end to end: the rhythm"),
        Group("sideways", "B/A", "B / A", 0.15, 0.7, "throws from the shell"),
        Group("arc", "A/R_a", "A / R_a", 0.15, 0.45, "turning of the vial"),
        Group("froude", "Fr", "(2 pi f)^2 A / g", 8.0, 80.0, "gravity against the swing"),
        softness(),
        *CONTACT,
    ),
    stroke_m=lambda values: values["stroke_mm"] / 1e3,
    content=lambda values: {
        "geometry": shape(values, "y", "both"),
        "motion": {
            "kind": "swing", "axis": [1, 0, 0], "pivot_mm": [0, 0, -values["arm_mm"]],
            "amplitude_deg": math.degrees(values["stroke_mm"] / values["arm_mm"]),
            "terms": [{"axis": "x", "amplitude_mm": values["sideways_mm"], "multiple": 2}],
        },
    },
    own_groups=lambda values: {
        "length": values["height_mm"] / values["radius_mm"],
        "rounding": values["fillet_radius_mm"] / values["radius_mm"],
        "stroke": values["stroke_mm"] / values["radius_mm"],
        "sideways": values["sideways_mm"] / values["stroke_mm"],
        "arc": values["stroke_mm"] / values["arm_mm"],
        "froude": froude(values, values["stroke_mm"]),
    },
    realised=_spex_realised,
    recognised=_spex_recognised,
    ends=2,
    derived=(lambda groups: layers(groups, "length"), gap, way, lambda groups: loss(groups, "length")),
)  # fmt: skip

KINDS = {kind.name: kind for kind in (PLANETARY, MIXER, DRUM, SPEX)}


def kind_named(name: str) -> Kind:
    """A kind by its name. Raises ConfigError, in one line, for one that the atlas does not have."""
    if name not in KINDS:
        raise ConfigError(
            f"{name}: no such kind of mill in the atlas{close_to(name, KINDS)}; it has {', '.join(KINDS)}"
        )
    return KINDS[name]


def balls_of(contact: ContactConfig) -> dict[str, float]:
    """The settings that a contact set gives. Raises ConfigError for one without restitution or modulus."""
    names = ("restitution", "static_friction", "rolling_friction", "young_modulus_gpa")
    values = {name: contact.value_of(name) for name in names}
    wall = contact.at_wall.value_of("static_friction")
    return {**values, "wall_static_friction": wall, "density_kg_m3": contact.density_kg_m3}


def recognise(mill: MillConfig) -> tuple[Kind, dict[str, float]] | None:
    """The kind of a mill and its dimensions; None for a mill of none."""
    for kind in KINDS.values():
        found = kind.recognised(mill)
        if found is not None:
            return kind, found
    return None
