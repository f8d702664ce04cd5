"""What `make bench` runs (bench.yaml): timings against LAMMPS, and means of the same motion from both codes."""

from typing import Annotated, Literal

from pydantic import Field, model_validator

from millprint.config.contact_set import ContactConfig
from millprint.config.mill import BoxGeometry, CylinderGeometry
from millprint.config.section import (
    Count,
    Fraction,
    Name,
    NonNegative,
    Positive,
    PositiveSpeed,
    Section,
    first_repeated,
)


class BenchCase(Section):
    """Balls of one size, timed in the mill's own jar and in the cylinder."""

    balls: Count
    """number of balls [-]"""
    ball_diameter_mm: Positive
    """their diameter [mm]"""
    driven_s: Positive
    """time of the mill's motion that is timed [s]"""

    @property
    def name(self) -> str:
        """The case without its jar, such as `24x10mm`."""
        return f"{self.balls}x{self.ball_diameter_mm:g}mm"


class LammpsLaw(Section):
    """The contact law in the terms of LAMMPS."""

    damping: Literal["tsuji", "coeff_restitution"]
    """its damping model"""
    rolling_stiffness_n_m: Positive
    """spring of the rolling model `sds` [N/m]"""
    rolling_damping_ns_m: NonNegative
    """dashpot of the rolling model `sds` [N s/m]"""
    matched: bool
    """with millprint's tangential damping and lever of rolling, and friction about the normal"""


class LammpsConfig(Section):
    """What LAMMPS needs beyond the case."""

    skin_m: Positive
    """neighbour skin [m]"""
    timed: LammpsLaw
    compared: LammpsLaw


class PhysicsLaw(Section):
    """The contact set with some coefficients changed."""

    name: Name
    """name of the law in the table"""
    restitution: float | None = Field(default=None, gt=0, le=1)
    """in place of the contact set's value [-]"""
    rolling_friction: NonNegative | None = None
    """in place of the contact set's value [-]"""
    differs: str
    """in what the two codes' laws still differ"""

    def contact(self, base: ContactConfig) -> ContactConfig:
        """The contact set of this law."""
        changes = {key: getattr(self, key) for key in ("restitution", "rolling_friction")}
        return base.model_copy(update={key: value for key, value in changes.items() if value is not None})


class PhysicsConfig(Section):
    """The comparison of means in a box."""

    box: BoxGeometry
    balls: Count
    """number of balls [-]"""
    ball_diameter_mm: Positive
    """their diameter [mm]"""
    seeds: Annotated[int, Field(ge=2, le=100_000)]
    """runs of each code, each from another start [-]"""
    discard_s: NonNegative
    """time of motion before the means begin [s]"""
    window_s: Positive
    """time of motion averaged over [s]"""
    laws: list[PhysicsLaw] = Field(min_length=1)
    """contact laws to compare"""


class TumblingConfig(Section):
    """Power of a drum with lifters from both codes: `make bench DRUMS=1`."""

    mill: Name
    """a file in config/mills: a lifter_drum with square lifters, its axis along y"""
    contact: Name
    """contact set: a file in config/contacts"""
    ball_diameter_mm: Positive
    """diameter of the balls [mm]"""
    fill_ratio: Fraction
    """ball volume over the nominal volume [-]"""
    speeds_rpm: Annotated[list[PositiveSpeed], Field(min_length=1, max_length=12)]
    """speeds of the drum [rpm]"""
    seeds: Annotated[int, Field(ge=2, le=100)]
    """runs of each code at each speed, each from another start [-]"""
    rayleigh_fraction: Fraction
    """step of both codes over the Rayleigh time [-]"""
    settle_s: Positive
    """time for the balls to come to rest [s]"""
    discard_turns: Annotated[int, Field(ge=1, le=1000)]
    """turns before the means begin [-]"""
    window_turns: Annotated[int, Field(ge=1, le=1000)]
    """turns averaged over [-]"""


class QuickConfig(Section):
    """Sizes of the quick benchmark."""

    time_share: Positive = Field(le=1)
    """fraction of the driven, discarded and averaged times [-]"""
    repetitions: Annotated[int, Field(ge=3, le=100_000)]
    """interleaved repetitions of every timing [-]"""
    seeds: Annotated[int, Field(ge=2, le=100_000)]
    """runs of each code in the comparison of means [-]"""


class BenchConfig(Section):
    """The timed cases, the comparison of means, and how they are run."""

    mill: Name
    """mill whose jar is timed and whose motion every case has: a file in config/mills"""
    contact: Name
    """contact set: a file in config/contacts"""
    speed_rpm: Positive
    """speed of the mill [rpm]"""
    time_step_s: Positive
    """integration step, reduced a little so that it divides a revolution [s]"""
    settle_s: Positive
    """time for the balls to come to rest before the common start [s]"""
    repetitions: Annotated[int, Field(ge=3, le=100_000)]
    """interleaved repetitions of every timing [-]"""
    cylinder: CylinderGeometry
    cases: list[BenchCase] = Field(min_length=1)
    """the timed cases"""
    lammps: LammpsConfig
    physics: PhysicsConfig
    drums: Annotated[list[TumblingConfig], Field(min_length=1)]
    quick: QuickConfig

    def quickened(self) -> "BenchConfig":
        """The quick benchmark: shortened cases."""
        share, physics = self.quick.time_share, self.physics
        means = {"discard_s": physics.discard_s * share, "window_s": physics.window_s * share}
        return self.model_copy(
            update={
                "repetitions": self.quick.repetitions,
                "cases": [case.model_copy(update={"driven_s": case.driven_s * share}) for case in self.cases],
                "physics": physics.model_copy(update={"seeds": self.quick.seeds, **means}),
            }
        )

    @model_validator(mode="after")
    def _names_differ(self) -> "BenchConfig":
        for names in ([case.name for case in self.cases], [law.name for law in self.physics.laws]):
            if twice := first_repeated(names):
                raise ValueError(f"{twice} appears twice; each case and each law is named once")
        return self

    @model_validator(mode="after")
    def _jars_are_those_of_lammps(self) -> "BenchConfig":
        """Check that LAMMPS has the same jars: an upright cylinder without fillets, and a box, both on z = 0."""
        cylinder = self.cylinder
        if cylinder.axis != "z" or cylinder.fillet_radius_mm:
            raise ValueError("cylinder: must have axis = z and fillet_radius_mm = 0, as LAMMPS's has")
        for name, shape in (("cylinder", cylinder), ("physics.box", self.physics.box)):
            if shape.centre_mm is not None:
                raise ValueError(f"{name}.centre_mm: must be left out, so that the jar stands where LAMMPS's does")
        return self
