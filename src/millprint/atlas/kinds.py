"""The kinds of mills of the atlas: their dimensions, the mill that these make, and its dimensionless groups.

A row of the atlas is a point in the groups of its kind: density and the size of the mill drop out, since stiffness and
gravity have groups of their own. A simulation realises a point at REFERENCE_MM; a mill of one's own is brought to its
point by `Kind.groups_of`.

To add a kind, write what makes its groups from dimensions and dimensions from groups, and add a record to `KINDS`.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from millprint.config.contact_set import ContactConfig
from millprint.config.errors import ConfigError
from millprint.config.mill import MillConfig
from millprint.config.wording import close_to

GRAVITY = 9.81
# Radius of the jar of every simulation [mm], and density of its balls [kg/m3]; both drop out.
REFERENCE_MM, REFERENCE_KG_M3 = 40.0, 7800.0
# Poisson's ratio of every simulation, which decides next to nothing.
POISSON = 0.25
# Rounding of an edge over the jar's radius that is taken for none [-].
SHARP = 0.05
# Balls of a condition, as far as the atlas goes.
FEWEST_BALLS, MOST_BALLS = 1, 400

Values = Mapping[str, float]


@dataclass(frozen=True)
class Dimension:
    """A dimension of a mill or a setting of its run: its name, ending with its unit, and what it is."""

    name: str
    means: str


@dataclass(frozen=True)
class Group:
    """A dimensionless group with its range in the atlas.

    formula: in symbols; reason: why it decides; drops_out: the limit in which it does not.
    """

    name: str
    symbol: str
    formula: str
    low: float
    high: float
    reason: str
    drops_out: str
    logarithmic: bool = True

    def at(self, share: float) -> float:
        """The value at a share of the range."""
        if self.logarithmic:
            return float(self.low * (self.high / self.low) ** share)
        return self.low + (self.high - self.low) * share

    def share(self, value: float) -> float:
        """The share of the range at which a value lies: `at` reversed."""
        if self.logarithmic:
            return math.log(value / self.low) / math.log(self.high / self.low)
        return (value - self.low) / (self.high - self.low)


# What every kind has, besides the dimensions of its mill.
SETTINGS = (
    Dimension("ball_diameter_mm", "diameter d of the balls [mm]"),
    Dimension("number", "number of balls [-]"),
    Dimension("speed_hz", "speed f of the mill, of the sun wheel or of the shaking [Hz]"),
    Dimension("density_kg_m3", "density of the balls [kg/m3]"),
    Dimension("young_modulus_gpa", "Young's modulus of the balls in the simulation, lowered as contact sets do [GPa]"),
    Dimension("restitution", "restitution e of the balls, with each other and with the wall [-]"),
    Dimension("static_friction", "friction of the balls with each other [-]"),
    Dimension("wall_static_friction", "friction of the balls with the wall [-]"),
    Dimension("rolling_friction", "rolling friction of the balls [-]"),
)
_CONTACT = (
    Group("restitution", "e", "e", 0.25, 0.95, "what a hit keeps of its energy", "never", logarithmic=False),
    Group("static_friction", "mu", "mu", 0.1, 0.8, "shear between balls, and how a bed is lifted",
          "one ball; mu large enough that nothing slides"),
    Group("wall_static_friction", "mu_w", "mu_w", 0.1, 0.8, "what the wall can carry along",
          "mu_w large enough that nothing slides"),
    Group("rolling_friction", "mu_r", "mu_r", 0.003, 0.06, "loss of balls that roll", "hits, not rolling, dissipate"),
)  # fmt: skip


def _softness(low: float = 2e-5) -> Group:
    return Group("softness", "rho v^2/E", "rho ((2 pi f A)^2 + 4 g R) / E", low, 2.5e-4,
                 "time in contact: it parts a rubbing contact into many, and so decides E*_t and f*_t, not power",
                 "for power and hits: balls as stiff as steel")  # fmt: skip


def _fill(low: float, high: float) -> Group:
    return Group("fill", "phi", "n pi d^3 / (6 V)", low, high,
                 "room of a ball before it meets another; the wall layers of the bed", "one ball")  # fmt: skip


def _ball(low: float, high: float) -> Group:
    return Group("ball", "d/R", "d / R", low, high, "balls over the radius of the jar: how many layers a bed has",
                 "d / R to 0: a continuum")  # fmt: skip


@dataclass(frozen=True)
class Kind:
    """A kind of mills.

    dimensions: of its mill; groups: in the order of tables and models; speed: the set speed in the unit of people.
    stroke_m: the length A whose speed 2 pi f A is that of the wall; mill: the content of a mill's file;
    own_groups: the groups of the mill and its speed, without fill, ball and contact; realised: dimensions and
    speed_hz from groups, at REFERENCE_MM; recognised: dimensions from a mill's file, or None for another kind.
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

    @property
    def names(self) -> list[str]:
        """The names of the groups."""
        return [group.name for group in self.groups]

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
            **{group.name: condition[group.name] for group in _CONTACT},
        }
        return {name: found[name] for name in self.names}

    def condition_of(self, groups: Values) -> dict[str, float]:
        """A condition with these groups but for its whole number of balls, at REFERENCE_MM and REFERENCE_KG_M3."""
        found = self.realised({name: float(groups[name]) for name in self.names})
        ball_mm = float(groups["ball"]) * REFERENCE_MM
        number = float(groups["fill"]) * self.volume_m3(found) / (math.pi / 6 * (ball_mm / 1e3) ** 3)
        found |= {"ball_diameter_mm": ball_mm, "number": max(FEWEST_BALLS, round(number))}
        found |= {group.name: float(groups[group.name]) for group in _CONTACT} | {"density_kg_m3": REFERENCE_KG_M3}
        return found | {"young_modulus_gpa": self._stress_pa(found) / float(groups["softness"]) / 1e9}

    def _stress_pa(self, condition: Values) -> float:
        """rho v^2 of a fast hit [Pa], with v^2 = (2 pi f A)^2 + 4 g R."""
        squared = (2 * math.pi * condition["speed_hz"] * self.stroke_m(condition)) ** 2
        return condition["density_kg_m3"] * (squared + 4 * GRAVITY * condition["radius_mm"] / 1e3)

    def mill_of(self, condition: Values, name: str = "atlas") -> MillConfig:
        """The mill of a condition."""
        volume_ml = 1e6 * self.volume_m3(condition)
        own = {"name": name, "title": self.title, "source": "a point of the atlas", "volume_ml": volume_ml}
        return MillConfig(**own, **self.content(condition))

    def contact_of(self, condition: Values, name: str = "atlas") -> ContactConfig:
        """The contact set of a condition."""
        own = {group.name: condition[group.name] for group in _CONTACT}
        return ContactConfig(
            name=name, source="a point of the atlas", density_kg_m3=condition["density_kg_m3"],
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


def _cylinder(mill: MillConfig, axes: str, ends: str) -> dict[str, float] | None:
    """Dimensions of a cylinder of the given axis and rounded ends, or None for another shape."""
    shape = mill.geometry
    if shape.kind != "cylinder" or shape.axis not in axes or mill.inserts or shape.smooth_ends or shape.centre_mm:
        return None
    if shape.fillet_radius_mm > 0 and shape.fillet_ends not in (ends, "none"):
        return None
    fillet = 0.0 if shape.fillet_ends == "none" else shape.fillet_radius_mm
    return {"radius_mm": shape.radius_mm, "height_mm": shape.height_mm, "fillet_radius_mm": fillet}


def _shape(values: Values, axis: str, ends: str) -> dict:
    return {
        "kind": "cylinder", "axis": axis, "radius_mm": values["radius_mm"], "height_mm": values["height_mm"],
        "fillet_radius_mm": values.get("fillet_radius_mm", 0.0), "fillet_ends": ends,
    }  # fmt: skip


_RADIUS = Dimension("radius_mm", "inner radius R of the jar [mm]")
_FILLET = Dimension("fillet_radius_mm", "radius of the rounding of the jar's edge; 0 for none [mm]")


def _rounding_mm(groups: Values) -> float:
    """Radius of the rounding of an edge at REFERENCE_MM: the smallest are none, and the largest are half spheres."""
    share = groups["rounding"]
    return REFERENCE_MM * (0.0 if share < SHARP else 1.0 if share > 1 - SHARP else share)


def _froude(condition: Values, length_mm: float) -> float:
    return (2 * math.pi * condition["speed_hz"]) ** 2 * length_mm / 1e3 / GRAVITY


def _speed(froude: float, length_mm: float) -> float:
    return math.sqrt(froude * GRAVITY / (length_mm / 1e3)) / (2 * math.pi)


# ---- planetary ----
def _planetary_realised(groups: Values) -> dict[str, float]:
    sun = REFERENCE_MM / groups["jar"]
    return {
        "radius_mm": REFERENCE_MM, "height_mm": groups["height"] * REFERENCE_MM,
        "fillet_radius_mm": _rounding_mm(groups), "sun_radius_mm": sun, "ratio": -groups["turns"],
        "speed_hz": _speed(groups["froude"], sun),
    }  # fmt: skip


def _planetary_recognised(mill: MillConfig) -> dict[str, float] | None:
    shape = _cylinder(mill, "z", "bottom")
    if mill.motion.kind != "planetary" or shape is None:
        return None
    return shape | {"sun_radius_mm": mill.motion.sun_radius_mm, "ratio": mill.motion.ratio}


PLANETARY = Kind(
    name="planetary",
    title="Planetary mill",
    dimensions=(
        _RADIUS,
        Dimension("height_mm", "inner height H of the jar [mm]"),
        _FILLET,
        Dimension("sun_radius_mm", "distance R_s of the jar's axis from the sun wheel's [mm]"),
        Dimension("ratio", "turns of the jar relative to the wheel, over the wheel's: -2 for what makers print as 1:-2"),
    ),
    groups=(
        _fill(0.03, 0.40),
        _ball(0.14, 0.60),
        Group("height", "H/R", "H / R", 0.9, 2.6, "share of the end walls, which rub", "H / R large"),
        Group("rounding", "r/R", "r / R", 0.0, 0.4, "where the lowest layer lies", "many layers of balls", False),
        Group("jar", "R/R_s", "R / R_s", 0.20, 0.85, "spin of the jar against the carrying round, which decides whether "
              "balls leave the wall", "never"),
        Group("turns", "k", "-ratio", 1.0, 3.2, "speed of the jar's wall past the balls, and Coriolis force", "never",
              False),
        Group("froude", "Fr", "(2 pi f)^2 R_s / g", 2.0, 120.0, "gravity against the carrying round",
              "Fr large: gravity is forgotten"),
        _softness(),
        *_CONTACT,
    ),
    stroke_m=lambda values: values["sun_radius_mm"] / 1e3,
    content=lambda values: {
        "geometry": _shape(values, "z", "bottom"),
        "motion": {"kind": "planetary", "sun_radius_mm": values["sun_radius_mm"], "ratio": values["ratio"]},
    },
    own_groups=lambda values: {
        "height": values["height_mm"] / values["radius_mm"],
        "rounding": values["fillet_radius_mm"] / values["radius_mm"],
        "jar": values["radius_mm"] / values["sun_radius_mm"],
        "turns": -values["ratio"],
        "froude": _froude(values, values["sun_radius_mm"]),
    },
    realised=_planetary_realised,
    recognised=_planetary_recognised,
    ends=1,
)  # fmt: skip


# ---- mixer ----
def _mixer_realised(groups: Values) -> dict[str, float]:
    stroke = groups["stroke"] * REFERENCE_MM
    return {
        "radius_mm": REFERENCE_MM, "height_mm": groups["length"] * REFERENCE_MM,
        "fillet_radius_mm": _rounding_mm(groups), "stroke_mm": stroke,
        "arc_radius_mm": stroke / groups["arc"], "speed_hz": _speed(groups["froude"], stroke),
    }  # fmt: skip


def _mixer_recognised(mill: MillConfig) -> dict[str, float] | None:
    shape, motion = _cylinder(mill, "xy", "both"), mill.motion
    if motion.kind != "swing" or shape is None or motion.terms or motion.multiple != 1:
        return None
    along = "xyz".index(mill.geometry.axis)
    arm = math.hypot(*motion.pivot_mm)
    upright = motion.axis[0] == 0 == motion.axis[1]
    if not arm or not upright or motion.pivot_mm[2] or abs(motion.pivot_mm[along]) > 1e-6 * arm:
        return None
    return shape | {"arc_radius_mm": arm, "stroke_mm": arm * math.radians(motion.amplitude_deg)}


MIXER = Kind(
    name="mixer",
    title="Mixer mill",
    dimensions=(
        _RADIUS,
        Dimension("height_mm", "inner length L of the lying jar, its ends included [mm]"),
        Dimension("fillet_radius_mm", "rounding of the ends: 0 for flat ends, as large as the radius for half spheres [mm]"),
        Dimension("stroke_mm", "how far the middle of the jar swings to each side, along its arc A [mm]"),
        Dimension("arc_radius_mm", "radius of the horizontal arc [mm]"),
    ),
    groups=(
        _fill(0.008, 0.40),
        _ball(0.18, 0.95),
        Group("length", "L/R", "L / R", 2.2, 6.0, "way from end to end", "never"),
        Group("rounding", "r/R", "r / R", 0.0, 1.0, "flat ends send a ball back, round ends send it to the side", "never",
              False),
        Group("stroke", "A/R", "A / R", 0.4, 3.0, "swing against the way from end to end: the rhythm", "never"),
        Group("arc", "A/R_a", "A / R_a", 0.06, 0.30, "turning of the jar, which throws balls outwards", "A / R_a to 0"),
        Group("froude", "Fr", "(2 pi f)^2 A / g", 2.0, 120.0, "gravity against the swing", "Fr large"),
        _softness(),
        *_CONTACT,
    ),
    stroke_m=lambda values: values["stroke_mm"] / 1e3,
    content=lambda values: {
        "speed_unit": "hz",
        "geometry": _shape(values, "x", "both"),
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
        "froude": _froude(values, values["stroke_mm"]),
    },
    realised=_mixer_realised,
    recognised=_mixer_recognised,
    ends=2,
)  # fmt: skip


# ---- drum ----
def _drum_speed(values: Values) -> float:
    """Speed over the critical one, at which a ball stays on the wall: sqrt(g / (R - d / 2)) / 2 pi."""
    reach = (values["radius_mm"] - values["ball_diameter_mm"] / 2) / 1e3
    return 2 * math.pi * values["speed_hz"] / math.sqrt(GRAVITY / reach)


def _drum_realised(groups: Values) -> dict[str, float]:
    reach = REFERENCE_MM * (1 - groups["ball"] / 2) / 1e3
    speed = groups["critical"] * math.sqrt(GRAVITY / reach) / (2 * math.pi)
    return {"radius_mm": REFERENCE_MM, "height_mm": groups["length"] * REFERENCE_MM, "speed_hz": speed}


def _drum_recognised(mill: MillConfig) -> dict[str, float] | None:
    shape, motion = _cylinder(mill, "xy", "none"), mill.motion
    if motion.kind != "rotation" or shape is None or shape.pop("fillet_radius_mm") or motion.ratio not in (1, -1):
        return None
    along = [abs(value) for value in motion.axis]
    turns_about_itself = not any(motion.pivot_mm) and along.index(max(along)) == "xyz".index(mill.geometry.axis)
    return shape if turns_about_itself and sum(along) == max(along) else None


DRUM = Kind(
    name="drum",
    title="Tumbling drum",
    dimensions=(_RADIUS, Dimension("height_mm", "inner length L of the drum, or of a slice with end walls [mm]")),
    groups=(
        _fill(0.10, 0.40),
        _ball(0.12, 0.45),
        Group("length", "L/R", "L / R", 0.5, 2.5, "share of the end walls, which rub and lift", "L / R large"),
        Group("critical", "N/N_c", "2 pi f sqrt((R - d/2) / g)", 0.35, 0.95, "how far balls are lifted", "never", False),
        _softness(1e-5),
        *_CONTACT,
    ),
    stroke_m=lambda values: values["radius_mm"] / 1e3,
    content=lambda values: {
        "geometry": _shape(values, "y", "none"), "motion": {"kind": "rotation", "axis": [0, 1, 0]},
    },
    own_groups=lambda values: {
        "length": values["height_mm"] / values["radius_mm"], "critical": _drum_speed(values),
    },
    realised=_drum_realised,
    recognised=_drum_recognised,
    ends=0,
)  # fmt: skip


# ---- SPEX-like shaker ----
def _spex_realised(groups: Values) -> dict[str, float]:
    stroke = groups["stroke"] * REFERENCE_MM
    return {
        "radius_mm": REFERENCE_MM, "height_mm": groups["length"] * REFERENCE_MM,
        "fillet_radius_mm": _rounding_mm(groups), "stroke_mm": stroke,
        "sideways_mm": groups["sideways"] * stroke, "arm_mm": stroke / groups["arc"],
        "speed_hz": _speed(groups["froude"], stroke),
    }  # fmt: skip


def _spex_recognised(mill: MillConfig) -> dict[str, float] | None:
    shape, motion = _cylinder(mill, "y", "both"), mill.motion
    if motion.kind != "swing" or shape is None or len(motion.terms) != 1 or motion.multiple != 1 or motion.phase_deg:
        return None
    (term,) = motion.terms
    arm = -motion.pivot_mm[2]
    lies_below = arm > 0 and motion.pivot_mm[0] == 0 == motion.pivot_mm[1]
    if not lies_below or motion.axis[1:] != (0, 0) or (term.axis, term.multiple, term.phase_deg) != ("x", 2, 0):
        return None
    stroke = arm * math.radians(motion.amplitude_deg)
    return shape | {"arm_mm": arm, "stroke_mm": stroke, "sideways_mm": term.amplitude_mm}


SPEX = Kind(
    name="spex",
    title="SPEX-like shaker",
    dimensions=(
        Dimension("radius_mm", "inner radius R of the vial [mm]"),
        Dimension("height_mm", "inner length L of the vial, its ends included [mm]"),
        _FILLET,
        Dimension("stroke_mm", "how far the vial moves to each side along its axis A [mm]"),
        Dimension("sideways_mm", "how far it moves to each side across it, twice as often B [mm]"),
        Dimension("arm_mm", "length of the arm that carries it [mm]"),
    ),
    groups=(
        _fill(0.008, 0.35),
        _ball(0.15, 0.75),
        Group("length", "L/R", "L / R", 2.2, 4.0, "way from end to end", "never"),
        Group("rounding", "r/R", "r / R", 0.0, 0.4, "flat ends send a ball back", "many balls", False),
        Group("stroke", "A/R", "A / R", 0.8, 2.2, "swing against the way from end to end: the rhythm", "never"),
        Group("sideways", "B/A", "B / A", 0.15, 0.7, "throws from the shell", "B / A to 0: a mixer mill"),
        Group("arc", "A/R_a", "A / R_a", 0.15, 0.45, "turning of the vial", "A / R_a to 0"),
        Group("froude", "Fr", "(2 pi f)^2 A / g", 8.0, 80.0, "gravity against the swing", "Fr large"),
        _softness(),
        *_CONTACT,
    ),
    stroke_m=lambda values: values["stroke_mm"] / 1e3,
    content=lambda values: {
        "speed_unit": "hz",
        "geometry": _shape(values, "y", "both"),
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
        "froude": _froude(values, values["stroke_mm"]),
    },
    realised=_spex_realised,
    recognised=_spex_recognised,
    ends=2,
)  # fmt: skip

KINDS = {kind.name: kind for kind in (PLANETARY, MIXER, DRUM, SPEX)}


def kind_named(name: str) -> Kind:
    """A kind by its name. Raises ConfigError, in one line, for one that the atlas does not have."""
    if name not in KINDS:
        raise ConfigError(f"{name}: no such kind of mill in the atlas{close_to(name, KINDS)}; it has {', '.join(KINDS)}")
    return KINDS[name]


def recognise(mill: MillConfig) -> tuple[Kind, dict[str, float]] | None:
    """The kind of a mill and its dimensions; None for a mill of none."""
    for kind in KINDS.values():
        found = kind.recognised(mill)
        if found is not None:
            return kind, found
    return None
