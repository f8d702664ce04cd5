"""The contact cases (tests/physics/cases/*.yaml) as validated models: what is set up, swept and bounded."""

import itertools
from collections.abc import Iterator
from copy import deepcopy
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from pydantic import Field, field_validator, model_validator

from millprint.config.contact_set import ContactConfig
from millprint.config.errors import ConfigError
from millprint.config.load import check_model, read_yaml
from millprint.config.section import Name, NonNegative, Positive, Section
from tests.physics.closed_forms import CLOSED_FORMS

FOLDER = Path(__file__).parent / "cases"
Vector = Annotated[tuple[float, ...], Field(min_length=3, max_length=3)]


class Ball(Section):
    """One ball at the start; its velocity as a vector, or as a speed and an angle."""

    radius_mm: Positive = Field(description="radius [mm]")
    position_mm: Vector = Field(description="position of the centre; the wall is the plane z = 0 [mm]")
    velocity_m_s: Vector | None = Field(None, description="velocity [m/s]")
    speed_m_s: NonNegative | None = Field(None, description="speed, with angle_deg in place of velocity_m_s [m/s]")
    angle_deg: float | None = Field(None, ge=0, lt=90, description="angle from -z towards +x [degrees]")
    spin_rad_s: Vector = Field((0.0, 0.0, 0.0), description="angular velocity [rad/s]")

    @model_validator(mode="after")
    def _one_way_to_give_the_velocity(self) -> "Ball":
        given = (self.velocity_m_s is not None, self.speed_m_s is not None, self.angle_deg is not None)
        if given not in ((True, False, False), (False, True, True)):
            raise ValueError("give velocity_m_s, or speed_m_s and angle_deg")
        return self

    @property
    def velocity(self) -> tuple[float, ...]:
        """Velocity (3,) [m/s]."""
        if self.velocity_m_s is not None:
            return self.velocity_m_s
        angle = np.radians(self.angle_deg)
        return (self.speed_m_s * np.sin(angle), 0.0, -self.speed_m_s * np.cos(angle))


class Bound(Section):
    """The largest error allowed, of the largest component of a quantity."""

    rel: Positive | None = Field(None, description="over the largest component of the closed form [-]")
    abs: Positive | None = Field(None, description="in the unit of the quantity")

    @model_validator(mode="after")
    def _one_of_two(self) -> "Bound":
        if (self.rel is None) == (self.abs is None):
            raise ValueError("give rel or abs")
        return self

    def allowed(self, expected: np.ndarray) -> float:
        """The largest error allowed from the expected value."""
        return self.abs if self.rel is None else self.rel * float(np.abs(expected).max())


class Check(Section):
    """A closed form, and a bound for every quantity that it gives."""

    form: str = Field(description="name of a closed form (tests/physics/closed_forms.py)")
    bounds: dict[str, Bound] = Field(min_length=1)

    @field_validator("form")
    @classmethod
    def _known(cls, form: str) -> str:
        if form not in CLOSED_FORMS:
            raise ValueError(f"unknown closed form; known: {', '.join(sorted(CLOSED_FORMS))}")
        return form

    @model_validator(mode="after")
    def _bounds_are_those_of_the_form(self) -> "Check":
        gives = set(CLOSED_FORMS[self.form].gives)
        if gives != set(self.bounds):
            raise ValueError(f"{self.form} gives {', '.join(sorted(gives))}: each needs a bound, and nothing else does")
        return self


class ContactCase(Section):
    """One set-up with one value of each swept quantity."""

    name: Name = Field(description="name of the case, equal to the file's name")
    title: str = Field(description="what happens")
    source: str = Field(description="where the case and its closed form come from")
    material: ContactConfig = Field(description="material of the balls and of the wall")
    balls: tuple[Ball, ...] = Field(min_length=1)
    wall: bool = Field(description="whether the plane z = 0 is a wall, above which the balls are")
    gravity_m_s2: NonNegative = Field(0.0, description="gravity along -z [m/s2]")
    seated: bool = Field(False, description="whether the one ball starts pressed in as far as its weight does")
    step_s: Positive = Field(description="integration step [s]")
    duration_s: Positive = Field(description="simulated time [s]")
    sweep: dict[str, list[Any]] = Field({}, description="path of a key (as balls.0.angle_deg): its values")
    checks: tuple[Check, ...] = Field(min_length=1)
    balance: Positive = Field(description="bound of the energy balance at any time, over the energy at the start [-]")

    @property
    def radius(self) -> np.ndarray:
        """Radii (n,) [m]."""
        return np.array([ball.radius_mm for ball in self.balls]) / 1e3

    @property
    def mass(self) -> np.ndarray:
        """Masses (n,) [kg]."""
        return self.material.density_kg_m3 * 4 / 3 * np.pi * self.radius**3

    @property
    def inertia(self) -> np.ndarray:
        """Moments of inertia (n,) of solid spheres [kg m2]."""
        return 0.4 * self.mass * self.radius**2

    @property
    def position(self) -> np.ndarray:
        """Positions at the start (n, 3) [m]."""
        return np.array([ball.position_mm for ball in self.balls]) / 1e3

    @property
    def velocity(self) -> np.ndarray:
        """Velocities at the start (n, 3) [m/s]."""
        return np.array([ball.velocity for ball in self.balls])

    @property
    def spin(self) -> np.ndarray:
        """Angular velocities at the start (n, 3) [rad/s]."""
        return np.array([ball.spin_rad_s for ball in self.balls])


def set_path(content: dict, path: str, value: object, source: str) -> None:
    """Overwrite the value at a dotted path of a mapping; raises ConfigError where nothing is there to overwrite."""
    *parents, last = (int(step) if step.isdigit() else step for step in path.split("."))
    place = content
    try:
        for step in parents:
            place = place[step]
        known = range(len(place)) if isinstance(place, list) else place
        if last not in known:
            raise KeyError(last)
    except (KeyError, IndexError, TypeError):
        raise ConfigError(f"{source}: sweep.{path}: no such key in the case; the base value must be there") from None
    place[last] = value


def _label(key: str, value: object, values: list) -> str:
    """A swept value in a test's name; a whole mapping by its place in the sweep."""
    shown = f"#{values.index(value)}" if isinstance(value, dict) else value
    return f"{key.removeprefix('material.')}={shown}"


def load_cases(path: Path) -> Iterator[tuple[str, ContactCase]]:
    """Every point of the sweep of a file, as (label, case). Raises ConfigError for whatever does not hold."""
    content = read_yaml(path)
    base = check_model(content, ContactCase, str(path))
    if base.name != path.stem:
        raise ConfigError(f"{path}: name = {base.name!r}: must equal the file's name, {path.stem!r}")
    for values in itertools.product(*base.sweep.values()):
        point = deepcopy(content)
        for key, value in zip(base.sweep, values, strict=True):
            set_path(point, key, value, str(path))
        label = "-".join(_label(key, value, base.sweep[key]) for key, value in zip(base.sweep, values, strict=True))
        yield label or "once", check_model(point, ContactCase, str(path))
