"""Set-ups of drums in which a bed of balls flows."""

from typing import Annotated

from pydantic import Field, model_validator

from millprint.config.mill import MillConfig
from millprint.config.section import Fraction, Name, Positive, PositiveSpeed, Seed
from millprint.config.setups.base import Interval, SetupConfig
from millprint.config.sweep import Case, DemConfig, SweepConfig, expand_sweep


class DrumOfBallsConfig(SetupConfig):
    """A drum in which a bed of balls flows: one size, one fill ratio, one speed."""

    mill: Name
    """the drum, or a slice of it: a file in config/mills"""
    ball_diameter_mm: Positive
    """ball diameter [mm]"""
    fill_ratio: Fraction
    """ball volume over the volume of the drum [-]"""
    speed_rpm: PositiveSpeed
    """speed of the drum [rpm]"""
    rayleigh_fraction: Fraction = 0.2
    """step over the Rayleigh time [-]"""
    closure_max: Fraction = 0.02
    """a run fails at this energy balance error over the wall work, which is small in a slow drum [-]"""
    settle_s: Positive = 0.2
    """time for the balls to come to rest before the drum starts [s]"""
    discard_s: Positive
    """time of motion before the averages begin [s]"""
    window_s: Positive
    """time of motion that is averaged [s]"""
    snapshot_interval_s: Positive = 0.02
    """time between snapshots [s]"""
    blocks: Annotated[int, Field(ge=2, le=100)] = 4
    """blocks of the window, whose scatter gives the interval at fixed contact parameters"""
    surface_share: Fraction = 0.5
    """the surface is fitted over this share of the radius on both sides of the axis [-]"""

    @property
    def mill_name(self) -> str | None:
        """The drum, or the slice that predicts."""
        return self.mill

    @property
    def run_files(self) -> tuple[str, ...]:
        """The snapshots."""
        return ("run.h5",)

    def sweep(self, name: str, mill: str, contacts: list[str], seeds: list[int]) -> SweepConfig:
        """Simulations of one drum at the settings of this section."""
        return SweepConfig(
            name=name, mills=[mill], contacts=contacts, ball_diameters_mm=[self.ball_diameter_mm],
            fill_ratios=[self.fill_ratio], speeds_rpm=[self.speed_rpm], seeds=seeds,
            rayleigh_fraction=self.rayleigh_fraction, rayleigh_fraction_max=self.rayleigh_fraction,
            closure_max=self.closure_max, settle_s=self.settle_s, discard_s=self.discard_s, window_s=self.window_s,
            snapshot_interval_s=self.snapshot_interval_s,
        )  # fmt: skip


class BeadDrumConfig(DrumOfBallsConfig):
    """Set-up 4: speed over depth in a long drum of glass beads, from two slices of it (Alizadeh et al. 2013)."""

    contact: Name = "glass_beads"
    further_contacts: list[Name] = ["glass_beads_clean"]
    """contact sets that bound it; the interval by contact parameters spans them"""
    mill: Name = "bead_drum"
    short_mill: Name = "bead_drum_short"
    """a shorter slice: it shows that the length is enough, and runs with every contact set"""
    ball_diameter_mm: Positive = 3.0
    fill_ratio: Fraction = 0.1962
    speed_rpm: PositiveSpeed = 11.6
    discard_s: Positive = 1.55
    window_s: Positive = 2.08
    half_width_diameters: Positive = 1.5
    """half the width, along the surface, of the part about the axis in which speeds are averaged [ball diameters]"""
    half_height_diameters: Positive = 0.5
    """half its height [ball diameters]"""

    @property
    def further_mills(self) -> list[str]:
        """The shorter slice."""
        return [self.short_mill]

    @property
    def sweeps(self) -> list[SweepConfig]:
        """The long slice with the contact set that predicts, the short one with all."""
        return [
            self.sweep("long", self.mill, [self.contact], [0]),
            self.sweep("short", self.short_mill, self.contact_names, [0]),
        ]


class ReposeDrumConfig(DrumOfBallsConfig):
    """Set-up 7: angle of repose in a short drum, its ends included, of spheres without known friction."""

    contact: Name = "generic_spheres"
    mill: Name = "repose_drum"
    ball_diameter_mm: Positive = 5.95
    fill_ratio: Fraction = 0.23916
    speed_rpm: PositiveSpeed = 20.99
    discard_s: Positive = 1.43
    window_s: Positive = 1.43
    seeds: list[Seed] = Field(default=[0, 1], min_length=2)
    """seeds of the starting positions; their scatter is a part of the interval"""
    slice_mm: Positive = 30.0
    """length of the slices in which contact parameters are varied, with smooth ends [mm]"""
    samples: Annotated[int, Field(ge=2, le=1000)] = 8
    """slices, each with different contact parameters, drawn evenly at random from these intervals"""
    restitution: Interval = (0.2, 0.95)
    """restitution [-]"""
    static_friction: Interval = (0.08, 0.8)
    """static friction, of balls and of ball and wall [-]"""
    rolling_friction: Interval = (0.005, 0.09)
    """rolling friction, in its logarithm [-]"""

    @model_validator(mode="after")
    def _intervals_rise(self) -> "ReposeDrumConfig":
        for key, most in (("restitution", 1.0), ("static_friction", 100.0), ("rolling_friction", 100.0)):
            low, high = getattr(self, key)
            if not 0 < low < high <= most:
                raise ValueError(f"{key} = {[low, high]}: two numbers above 0 and up to {most:g}, the smaller first")
        return self

    @property
    def sweeps(self) -> list[SweepConfig]:
        """The whole drum."""
        return [self.sweep("whole", self.mill, [self.contact], self.seeds)]

    def simulated_inside(self, mill: MillConfig) -> list[Case]:
        """The slices, one with the set that predicts: each has its share of the drum's balls."""
        (whole,) = self.sweeps
        share = self.slice_mm / getattr(mill.geometry, "height_mm", self.slice_mm)
        shorter = whole.model_copy(update={"seeds": [0], "fill_ratios": [self.fill_ratio * share]})
        return list(expand_sweep(shorter, DemConfig(), mill.name)) * (self.samples + 1)
