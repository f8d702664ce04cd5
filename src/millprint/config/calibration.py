"""The section `calibration`: drop test and oscillating ball, simulated and measured (thesis Sec. 3.2.2)."""

import math
from typing import Annotated, ClassVar

from pydantic import Field, model_validator

from millprint.config.section import (
    Fraction,
    Name,
    NonNegative,
    Positive,
    ProjectFile,
    Section,
    Vector,
    first_repeated,
)

SIMULATED, MEASURED = "simulated", "measured"
FRICTION_PAIR = ("static_friction", "rolling_friction")


Coefficient = Annotated[float, Field(ge=1e-4, le=10)]
Bounds = tuple[Coefficient, Coefficient]


class DropTestConfig(Section):
    """A ball falls on a flat floor; its bounce gives the restitution (Eq. 3.19)."""

    # Ball diameter [mm].
    ball_diameter_mm: ClassVar[float] = 10.0
    # Heights over the floor of the simulated drops [mm].
    heights_mm: ClassVar[tuple[float, ...]] = (10.0, 20.0, 40.0)
    measured: ProjectFile | None = None
    """table of measured drops (drop_height_mm, bounce_height_mm), from the project's root"""


class ReleaseConfig(Section):
    """The jar lies on its side or stands on edge; a ball starts at its wall. Its z axis is horizontal by default."""

    down: Vector = (-1.0, 0.0, 0.0)
    """direction of gravity in the jar's own axes [-]"""
    across: Vector = (0.0, 1.0, 0.0)
    """direction from the jar's middle to the start, square to `down` [-]"""
    height_fraction: Fraction = 0.5
    """height of the start over the height of the turned jar [-]"""

    @model_validator(mode="after")
    def _directions_are_square(self) -> "ReleaseConfig":
        down, across = self.down, self.across
        sizes = math.hypot(*down) * math.hypot(*across)
        if sizes == 0:
            raise ValueError("down and across must not be zero")
        if abs(sum(a * b for a, b in zip(down, across, strict=True))) > 1e-6 * sizes:
            raise ValueError(f"across = {list(across)}: must be perpendicular to down = {list(down)}")
        return self


class ExperimentConfig(Section):
    """A track to which the friction pair is fitted: measured, or simulated with a known pair."""

    name: Name
    """name of the experiment"""
    contact: Name
    """contact set; only a simulated track uses its friction pair"""
    track: ProjectFile | None = None
    """measured track (time_s; across_mm, height_mm or both); simulated if left out"""
    track_mill: Name | None = None
    """mill of a simulated track; if left out, the mill of the fit"""
    mill: Name | None = None
    """mill in which the pair is fitted; if left out, the run's mill"""
    ball_diameter_mm: Positive = 10.0
    """ball diameter [mm]"""

    @model_validator(mode="after")
    def _one_source(self) -> "ExperimentConfig":
        if self.track and self.track_mill:
            raise ValueError("track and track_mill cannot both be given: a measured track is not simulated")
        return self

    def mills(self, run_mill: str) -> dict[str, str]:
        """Names of two mills: the one in which the pair is fitted, and the one in which a track is simulated."""
        mill = self.mill or run_mill
        return {"mill": mill, "track_mill": self.track_mill or mill}


class SwingConfig(Section):
    """How a ball is let go and followed, and how the friction pair of its track is searched, in every experiment."""

    release: ReleaseConfig = ReleaseConfig()
    # Integration step, or less by the Rayleigh time [s].
    time_step_s: ClassVar[float] = 5e-6
    duration_s: Positive = 3.0
    """length of a simulated track [s]"""
    # Frames of a simulated track [1/s].
    frames_per_second: ClassVar[float] = 60.0
    # Standard deviation of the error added to a simulated track, in each direction [mm], and its seed.
    noise_mm: ClassVar[float] = 0.3
    seed: ClassVar[int] = 0
    release_uncertainty_s: NonNegative = 0.02
    """largest time of the release, before or after time 0 of a track; 0 if it is known [s]"""
    static_friction: Bounds = (0.05, 2.0)
    """bounds of the static friction coefficient [-]"""
    rolling_friction: Bounds = (0.002, 0.2)
    """bounds of the rolling friction coefficient [-]"""
    # At least two generations of friction_fit.TOGETHER pairs in each half.
    search_simulations: int = Field(default=400, ge=64, le=5000)
    """simulations of the search: half over all, half around the best [-]"""
    profile_points: int = Field(default=4, ge=2, le=50)
    """points of a profile on either side of its estimate"""
    # Further pairs (static, rolling) to show next to the fit, as in Fig. 3.3 [-].
    varied: ClassVar[tuple[tuple[float, float], ...]] = ((0.15, 0.045), (0.6, 0.045), (0.3, 0.02), (0.3, 0.09))

    @model_validator(mode="after")
    def _bounds_rise(self) -> "SwingConfig":
        for key in ("static_friction", "rolling_friction"):
            low, high = getattr(self, key)
            if low >= high:
                raise ValueError(f"{key} = [{low:g}, {high:g}]: the first must be below the second")
        return self


class OscillationConfig(SwingConfig):
    """A ball swings along the wall of the jar until it rests; its track gives both friction coefficients (Fig. 3.3)."""

    experiments: list[ExperimentConfig] = Field(min_length=1)
    """tracks to fit"""

    @model_validator(mode="after")
    def _names_differ(self) -> "OscillationConfig":
        if twice := first_repeated(experiment.name for experiment in self.experiments):
            raise ValueError(f"experiments: two have the name {twice}")
        return self


class CalibrationConfig(Section):
    """Settings of the calibration stage."""

    # Probability of every confidence interval [-].
    interval: ClassVar[float] = 0.95
    drop_test: DropTestConfig = DropTestConfig()
    oscillation: OscillationConfig
