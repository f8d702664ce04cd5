"""The section `calibration`: drop test and oscillating ball, simulated and measured (thesis Sec. 3.2.2)."""

from typing import Annotated

from pydantic import Field, model_validator

from millprint.config.section import (
    Fraction,
    Name,
    NonNegative,
    Positive,
    ProjectFile,
    Section,
    Seed,
    Vector,
    first_repeated,
)

FEWEST_DROPS = 2
Coefficient = Annotated[float, Field(ge=1e-4, le=10)]
Bounds = tuple[Coefficient, Coefficient]


class DropTestConfig(Section):
    """A ball falls on a flat floor, its bounce gives the restitution (Eq. 3.19)."""

    ball_diameter_mm: Positive = Field(default=10.0, description="ball diameter [mm]")
    heights_mm: list[Positive] = Field(
        default=[10.0, 20.0, 40.0],
        min_length=FEWEST_DROPS,
        description="heights that simulated balls fall from, over the floor [mm]",
    )
    measured: ProjectFile | None = Field(
        default=None,
        description="table of measured drops (drop_height_mm, bounce_height_mm), from the project's root; none if "
        "left out",
    )


class ReleaseConfig(Section):
    """The jar lies on its side or stands on edge, and a ball is let go at its wall. By default its z axis is level."""

    down: Vector = Field(default=(-1.0, 0.0, 0.0), description="direction of gravity in the jar's own axes [-]")
    across: Vector = Field(
        default=(0.0, 1.0, 0.0),
        description="direction, square to `down`, from the jar's middle to where the ball starts [-]",
    )
    height_fraction: Fraction = Field(
        default=0.5, description="height of the ball's centre at the start over that of the jar as it lies [-]"
    )

    @model_validator(mode="after")
    def _directions_are_square(self) -> "ReleaseConfig":
        down, across = self.down, self.across
        sizes = [sum(component**2 for component in vector) ** 0.5 for vector in (down, across)]
        if min(sizes) == 0:
            raise ValueError("down and across must not be zero")
        if abs(sum(a * b for a, b in zip(down, across, strict=True))) > 1e-6 * sizes[0] * sizes[1]:
            raise ValueError(f"across = {list(across)}: must be square to down = {list(down)}")
        return self


class ExperimentConfig(Section):
    """One track to which the friction pair is fitted: measured, or made by a simulation with a known pair."""

    name: Name = Field(description="name of the experiment")
    contact: Name = Field(
        description="contact set whose restitution, density and elasticity are kept; its friction pair is the one to "
        "recover where the track is simulated"
    )
    track: ProjectFile | None = Field(
        default=None,
        description="table of the measured track (time_s, and across_mm, height_mm or both), from the project's root; "
        "left out, a track is simulated",
    )
    track_mill: Name | None = Field(
        default=None, description="mill in which a simulated track is made; the one that is fitted in if left out"
    )
    mill: Name | None = Field(default=None, description="mill in which the pair is fitted; the run's if left out")
    ball_diameter_mm: Positive = Field(default=10.0, description="ball diameter [mm]")

    @model_validator(mode="after")
    def _one_source(self) -> "ExperimentConfig":
        if self.track and self.track_mill:
            raise ValueError("track and track_mill cannot both be given: a measured track is not simulated")
        return self

    def mills(self, run_mill: str) -> dict[str, str]:
        """Names of the mill in which the pair is fitted and of that in which a simulated track is made."""
        mill = self.mill or run_mill
        return {"mill": mill, "track_mill": self.track_mill or mill}


class SwingConfig(Section):
    """How a ball is let go and followed, and how the friction pair of its track is searched, in every experiment."""

    release: ReleaseConfig = ReleaseConfig()
    time_step_s: Positive = Field(
        default=5e-6, description="integration step; shortened where the Rayleigh time asks for it [s]"
    )
    duration_s: Positive = Field(default=3.0, description="length of a simulated track [s]")
    frames_per_second: Annotated[float, Field(ge=10, le=1000)] = Field(
        default=60.0, description="frames of a simulated track in a second [1/s]"
    )
    noise_mm: NonNegative = Field(
        default=0.3,
        description="standard deviation of the error that is added to a simulated track, in both directions [mm]",
    )
    seed: Seed = Field(default=0, description="seed of that error")
    release_uncertainty_s: NonNegative = Field(
        default=0.02, description="how far the release may lie from time 0 of a track; 0 to take it as known [s]"
    )
    static_friction: Bounds = Field(default=(0.05, 2.0), description="bounds of the static friction coefficient [-]")
    rolling_friction: Bounds = Field(default=(0.002, 0.2), description="bounds of the rolling friction coefficient [-]")
    search_simulations: Annotated[int, Field(ge=20, le=5000)] = Field(
        default=400,
        description="simulations of the search, half of them in the whole range, half around what that finds [-]",
    )
    profile_points: Annotated[int, Field(ge=2, le=50)] = Field(
        default=4, description="values on either side of the estimate at which its profile is computed [-]"
    )
    varied: list[tuple[Coefficient, Coefficient]] = Field(
        default=[], description="further pairs (static, rolling) shown beside the fit, as in Fig. 3.3 [-]"
    )

    @model_validator(mode="after")
    def _bounds_rise(self) -> "SwingConfig":
        for key in ("static_friction", "rolling_friction"):
            low, high = getattr(self, key)
            if low >= high:
                raise ValueError(f"{key} = [{low:g}, {high:g}]: the first must be below the second")
        return self


class OscillationConfig(SwingConfig):
    """A ball swings along the jar's wall until it rests; its track gives both friction coefficients (Fig. 3.3)."""

    experiments: list[ExperimentConfig] = Field(min_length=1, description="tracks to fit")

    @model_validator(mode="after")
    def _names_differ(self) -> "OscillationConfig":
        if twice := first_repeated(experiment.name for experiment in self.experiments):
            raise ValueError(f"experiments: two have the name {twice}")
        return self


class CalibrationConfig(Section):
    """Settings of the calibration stage."""

    interval: Fraction = Field(default=0.95, description="probability of every confidence interval [-]")
    drop_test: DropTestConfig = DropTestConfig()
    oscillation: OscillationConfig
