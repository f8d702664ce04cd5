"""The section `cohesion` of a contact set: how much balls and walls stick."""

import math
from typing import Annotated

from pydantic import Field, model_validator

from millprint.config.section import Section

WorkOfAdhesion = Annotated[float, Field(ge=0, le=1e6)]
Pull = Annotated[float, Field(ge=0, le=1e6)]


class CohesionConfig(Section):
    """Surfaces that stick: a constant pull while two bodies touch (Derjaguin, Muller and Toporov 1975)."""

    ball_ball_J_m2: WorkOfAdhesion | None = None
    """work of adhesion w of two balls, with a pull of 2 pi w R* [J/m2]; no pull if left out"""
    ball_wall_J_m2: WorkOfAdhesion | None = None
    """work of adhesion of a ball and a wall, with R* the ball's radius [J/m2]; no pull if left out"""
    ball_ball_N: Pull | None = None
    """pull between two balls of any size, in place of the work of adhesion [N]"""
    ball_wall_N: Pull | None = None
    """pull between a ball and a wall, in place of the work of adhesion [N]"""

    @model_validator(mode="after")
    def _one_number_for_a_pair(self) -> "CohesionConfig":
        for pair in ("ball_ball", "ball_wall"):
            if None not in (getattr(self, f"{pair}_J_m2"), getattr(self, f"{pair}_N")):
                raise ValueError(f"{pair}_J_m2, {pair}_N: give one of them, an energy per area or a force")
        return self

    def pull_N(self, pair: str, radius_m: float) -> float:
        """The pull of a `pair`, ball_ball or ball_wall, of reduced radius [m]."""
        force, energy = getattr(self, f"{pair}_N"), getattr(self, f"{pair}_J_m2")
        return float(force if force is not None else 2 * math.pi * (energy or 0.0) * radius_m)
