"""What a kind of mills is in the atlas: dimensions, the mill that these make, and its dimensionless groups.

A row of the atlas is a point in the groups of its kind: density and the size of the mill drop out, since stiffness and
gravity have groups of their own. A simulation realises a point at REFERENCE_MM; a mill of one's own is brought to its
point by `Kind.groups_of`.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from millprint.config.contact_set import ContactConfig
from millprint.config.load import check_model
from millprint.config.mill import CylinderGeometry, MillConfig
from millprint.mill.gravity import GRAVITY

# Radius of the jar of every simulation [mm], and density of its balls [kg/m3]; both drop out.
REFERENCE_MM, REFERENCE_KG_M3 = 40.0, 7800.0
# The name of the mill and the contact set of every simulation.
ATLAS = "atlas"
# Poisson's ratio of every simulation, which decides next to nothing.
POISSON = 0.25
# Share of a bed that is ball [-].
PACKED = 0.6
# Rounding of an edge over the jar's radius that is taken for none [-].
SHARP = 0.05
# A group may be out of its range by this share of the range; groups that the speed decides.
BEYOND, OF_SPEED = 0.01, ("froude", "critical")
# Balls of a condition, as far as the atlas goes.
FEWEST_BALLS, MOST_BALLS = 1, 400

Values = Mapping[str, float]


@dataclass(frozen=True)
class Dimension:
    """A dimension of a mill or a setting of its run: its name, ending with its unit, what it is, and the least and the
    most that can be meant."""

    name: str
    means: str
    least: float
    most: float


@dataclass(frozen=True)
class Group:
    """A dimensionless group with its range in the atlas.

    formula: in symbols; reason: why it decides.
    """

    name: str
    symbol: str
    formula: str
    low: float
    high: float
    reason: str
    logarithmic: bool = True

    def at(self, share: float) -> float:
        """The value at a share of the range."""
        if self.logarithmic:
            return float(self.low * (self.high / self.low) ** share)
        return self.low + (self.high - self.low) * share

    def share(self, values: Any) -> Any:
        """The share of the range at which values lie, numbers or arrays: `at` reversed."""
        # Imported here, and below: the parser of the command needs the names of the dimensions only.
        import numpy as np

        if self.logarithmic:
            return np.log(values / self.low) / math.log(self.high / self.low)
        return (values - self.low) / (self.high - self.low)


# What every kind has, besides the dimensions of its mill.
SETTINGS = (
    Dimension("ball_diameter_mm", "diameter d of the balls [mm]", 0.5, 200),
    Dimension("number", "number of balls [-]", 1, 100_000),
    Dimension("speed_hz", "speed f of the mill, of the sun wheel or of the shaking [Hz]", 0.05, 100),
    Dimension("density_kg_m3", "density of the balls [kg/m3]", 500, 20_000),
    Dimension(
        "young_modulus_gpa",
        "Young's modulus of the balls in the simulation, lowered as contact sets do [GPa]",
        1e-5,
        1000,
    ),
    Dimension("restitution", "restitution e of the balls, with each other and with the wall [-]", 0.01, 1),
    Dimension("static_friction", "friction of the balls with each other [-]", 0, 2),
    Dimension("wall_static_friction", "friction of the balls with the wall [-]", 0, 2),
    Dimension("rolling_friction", "rolling friction of the balls [-]", 0, 1),
)
CONTACT = (
    Group("restitution", "e", "e", 0.25, 0.95, "what a hit keeps of its energy", logarithmic=False),
    Group("static_friction", "mu", "mu", 0.1, 0.8, "shear between balls, and how a bed is lifted"),
    Group("wall_static_friction", "mu_w", "mu_w", 0.1, 0.8, "what the wall can carry along"),
    Group("rolling_friction", "mu_r", "mu_r", 0.003, 0.06, "loss of balls that roll"),
)


def softness(low: float = 2e-5) -> Group:
    """Stress of a hit over the stiffness of the balls."""
    reason = "time in contact: it parts a rubbing contact into many, and so decides E*_t and f*_t, not power"
    return Group("softness", "rho v^2/E", "rho ((2 pi f A)^2 + 4 g R) / E", low, 2.5e-4, reason)


def fill(low: float, high: float) -> Group:
    """Volume of the balls over that of the jar."""
    reason = "room of a ball before it meets another; the wall layers of the bed"
    return Group("fill", "phi", "n pi d^3 / (6 V)", low, high, reason)


def ball(low: float, high: float) -> Group:
    """Size of the balls."""
    return Group("ball", "d/R", "d / R", low, high, "balls over the radius of the jar: how many layers a bed has")


@dataclass(frozen=True)
class Limit:
    """What several groups decide together: a number `of` groups that is at most `most`; formula and reason in words."""

    formula: str
    reason: str
    most: float
    of: Callable[[Mapping[str, Any]], Any]


@dataclass(frozen=True)
class Kind:
    """A kind of mills.

    dimensions: of its mill; groups: in the order of tables and models. stroke_m: the length A whose speed 2 pi f A is
    that of the wall; content: motion and geometry as a mill's file has them; own_groups: the groups of the mill and its
    speed, without fill, ball and contact; realised: dimensions and speed_hz from groups, at REFERENCE_MM; recognised:
    dimensions from a mill's file, or None for another kind; ends: how many ends of the jar are rounded; derived: inputs
    of the model that physics suggests, besides the groups (m,) that they are computed from; limits: beyond which the
    atlas says nothing, besides the ranges of groups; speed_unit: rpm or hz, as makers give it; travel_m: half the
    travel of the wall along an axis, but for a factor that all mills of the kind share, where it is not the stroke;
    discarded_turns, fewest_turns: of a simulation, before its window and in it.
    """

    name: str
    title: str
    dimensions: tuple[Dimension, ...]
    groups: tuple[Group, ...]
    stroke_m: Callable[[Values], float]
    content: Callable[[Values], dict]
    own_groups: Callable[[Values], dict[str, float]]
    realised: Callable[[Values], dict[str, float]]
    recognised: Callable[[MillConfig], dict[str, float] | None]
    ends: int
    derived: tuple[Callable[[Mapping[str, Any]], Any], ...] = ()
    limits: tuple["Limit", ...] = ()
    speed_unit: str = "rpm"
    travel_m: Callable[[Values], float] | None = None
    discarded_turns: int = 4
    fewest_turns: int = 10

    @property
    def names(self) -> list[str]:
        """The names of the groups."""
        return [group.name for group in self.groups]

    def knows(self, dimensions: Values) -> bool:
        """Whether groups that only dimensions decide lie in their ranges: any other mill is beyond at every speed."""
        found = self.own_groups({**dimensions, "speed_hz": 1.0, "ball_diameter_mm": 0.0})
        fixed = [group for group in self.groups if group.name in found and group.name not in OF_SPEED]
        return all(-BEYOND <= group.share(found[group.name]) <= 1 + BEYOND for group in fixed)

    def volume_m3(self, dimensions: Values) -> float:
        """Inner volume of the jar [m3]: a cylinder, each rounded end less by its edge."""
        radius, height = dimensions["radius_mm"] / 1e3, dimensions["height_mm"] / 1e3
        fillet = dimensions.get("fillet_radius_mm", 0.0) / 1e3
        # Over the height r of a rounding, the radius is (R - r) + sqrt(r^2 - u^2).
        core = radius - fillet
        rounded = math.pi * (core**2 * fillet + math.pi / 2 * core * fillet**2 + 2 / 3 * fillet**3)
        return math.pi * radius**2 * (height - self.ends * fillet) + self.ends * rounded

    def groups_of(self, condition: Values) -> dict[str, float]:
        """The groups of a condition: dimensions of the mill and all of SETTINGS."""
        ball_m = condition["ball_diameter_mm"] / 1e3
        balls = condition["number"] * math.pi / 6 * ball_m**3
        found = {
            "fill": balls / self.volume_m3(condition),
            "ball": condition["ball_diameter_mm"] / condition["radius_mm"],
            **self.own_groups(condition),
            "softness": self._stress_pa(condition) / (1e9 * condition["young_modulus_gpa"]),
            **{group.name: condition[group.name] for group in CONTACT},
        }
        return {name: found[name] for name in self.names}

    def condition_of(self, groups: Values) -> dict[str, float]:
        """A condition with these groups but for its whole number of balls, at REFERENCE_MM and REFERENCE_KG_M3."""
        found = self.realised({name: float(groups[name]) for name in self.names})
        ball_mm = float(groups["ball"]) * REFERENCE_MM
        number = float(groups["fill"]) * self.volume_m3(found) / (math.pi / 6 * (ball_mm / 1e3) ** 3)
        found |= {"ball_diameter_mm": ball_mm, "number": max(FEWEST_BALLS, round(number))}
        found |= {group.name: float(groups[group.name]) for group in CONTACT} | {"density_kg_m3": REFERENCE_KG_M3}
        return found | {"young_modulus_gpa": self._stress_pa(found) / float(groups["softness"]) / 1e9}

    def _stress_pa(self, condition: Values) -> float:
        """rho v^2 of a fast hit [Pa], with v^2 = (2 pi f A)^2 + 4 g R."""
        squared = (2 * math.pi * condition["speed_hz"] * self.stroke_m(condition)) ** 2
        return condition["density_kg_m3"] * (squared + 4 * GRAVITY * condition["radius_mm"] / 1e3)

    def mill_of(self, condition: Values) -> MillConfig:
        """The mill of a condition. Raises ConfigError, a line for each fault, for one that cannot be."""
        volume_ml = 1e6 * self.volume_m3(condition)
        own = {"name": ATLAS, "title": self.title, "source": "a point of the atlas", "volume_ml": volume_ml}
        own |= {"speed_unit": self.speed_unit}
        return check_model(own | self.content(condition), MillConfig, self.name)

    def contact_of(self, condition: Values) -> ContactConfig:
        """The contact set of a condition."""
        own = {group.name: condition[group.name] for group in CONTACT}
        return ContactConfig(
            name=ATLAS, source="a point of the atlas", density_kg_m3=condition["density_kg_m3"],
            young_modulus_gpa=condition["young_modulus_gpa"], poisson_ratio=POISSON, **own,
        )  # fmt: skip

    def scales(self, condition: Values) -> dict[str, float]:
        """What the numbers of a condition are measured in: energy m (2 pi f A)^2 [J], frequency f [Hz], power [W].

        The energy is that of a ball with twice the speed of the wall; the power is of all balls.
        """
        mass = condition["density_kg_m3"] * math.pi / 6 * (condition["ball_diameter_mm"] / 1e3) ** 3
        energy = mass * (2 * math.pi * condition["speed_hz"] * self.stroke_m(condition)) ** 2
        speed = condition["speed_hz"]
        return {"energy": energy, "frequency": speed, "power": condition["number"] * energy * speed, "none": 1.0}


def layers(groups: Mapping[str, Any], height: str = "") -> Any:
    """The logarithm of the layers of balls on the shell, 2 phi R / d, or from end to end, phi L / d."""
    import numpy as np

    return np.log(groups["fill"] / groups["ball"] * (groups[height] if height else 2.0)) / 3


def loss(groups: Mapping[str, Any], height: str = "") -> Any:
    """The logarithm of what a bed loses at a hit, as of a gas of balls: (1 - e^2) times its layers."""
    import numpy as np

    return np.log(1 - groups["restitution"] ** 2) / 3 + layers(groups, height)


def way(groups: Mapping[str, Any]) -> Any:
    """The way of a bed or a ball from end to end over the stroke, (L - d - L phi / 0.6) / A, in thirds."""
    import numpy as np

    free = groups["length"] * (1 - groups["fill"] / PACKED) - groups["ball"]
    return np.maximum(free / groups["stroke"], 0.05) / 3


def gap(groups: Mapping[str, Any]) -> Any:
    """The logarithm of the same: balls of a narrow way follow a power of it, those of a long one its time of flight."""
    import numpy as np

    return np.log(3 * way(groups)) / 2


def within_limits(kind: Kind, groups: Mapping[str, Any]) -> Any:
    """Whether conditions (m,) with these groups are within the limits of the kind."""
    import numpy as np

    allowed = [np.asarray(limit.of(groups)) <= limit.most for limit in kind.limits]
    return np.all(allowed, axis=0) if allowed else np.full(len(groups["fill"]), True)


def cylinder(mill: MillConfig, axes: str, ends: str) -> dict[str, float] | None:
    """Dimensions of a cylinder of the given axis and rounded ends, or None for another shape."""
    shape = mill.geometry
    if (
        not isinstance(shape, CylinderGeometry)
        or shape.axis not in axes
        or mill.inserts
        or shape.smooth_ends
        or shape.centre_mm
    ):
        return None
    if shape.fillet_radius_mm > 0 and shape.fillet_ends not in (ends, "none"):
        return None
    fillet = 0.0 if shape.fillet_ends == "none" else shape.fillet_radius_mm
    return {"radius_mm": shape.radius_mm, "height_mm": shape.height_mm, "fillet_radius_mm": fillet}


def shape(values: Values, axis: str, ends: str) -> dict:
    """The geometry of a cylinder, as a mill's file has it."""
    return {
        "kind": "cylinder", "axis": axis, "radius_mm": values["radius_mm"], "height_mm": values["height_mm"],
        "fillet_radius_mm": values.get("fillet_radius_mm", 0.0), "fillet_ends": ends,
    }  # fmt: skip


RADIUS = Dimension("radius_mm", "inner radius R of the jar [mm]", 3, 2000)
FILLET = Dimension("fillet_radius_mm", "radius of the rounding of the jar's edge; 0 for none [mm]", 0, 2000)


def rounding_mm(groups: Values) -> float:
    """Radius of the rounding of an edge at REFERENCE_MM: the smallest are none, and the largest are half spheres."""
    share = groups["rounding"]
    return REFERENCE_MM * (0.0 if share < SHARP else 1.0 if share > 1 - SHARP else share)


def froude(condition: Values, length_mm: float) -> float:
    """The Froude number (2 pi f)^2 L / g."""
    return (2 * math.pi * condition["speed_hz"]) ** 2 * length_mm / 1e3 / GRAVITY


def speed_hz(froude: float, length_mm: float) -> float:
    """The speed of a Froude number."""
    return math.sqrt(froude * GRAVITY / (length_mm / 1e3)) / (2 * math.pi)
