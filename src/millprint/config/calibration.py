"""The sections `calibration` (drop test and oscillating ball, thesis section 3.3) and `fit` (shape of the jar)."""

import math
from typing import ClassVar, NamedTuple

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
    has_direction,
)

SIMULATED, MEASURED = "simulated", "measured"
FRICTION_PAIR = ("static_friction", "rolling_friction")


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
        sizes = math.hypot(*has_direction(down)) * math.hypot(*has_direction(across))
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
    # Bounds of both coefficients in the search [-].
    static_friction: ClassVar[tuple[float, float]] = (0.05, 2.0)
    rolling_friction: ClassVar[tuple[float, float]] = (0.002, 0.2)
    # At least two generations of friction_fit.TOGETHER pairs in each half.
    search_simulations: int = Field(default=400, ge=64, le=5000)
    """simulations of the search: half over all, half around the best [-]"""
    profile_points: int = Field(default=4, ge=2, le=50)
    """points of a profile on either side of its estimate"""
    # Further pairs (static, rolling) to show next to the fit, as in Fig. 3.3 [-].
    varied: ClassVar[tuple[tuple[float, float], ...]] = ((0.15, 0.045), (0.6, 0.045), (0.3, 0.02), (0.3, 0.09))


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


class Stage(NamedTuple):
    """One stage of the search: jars that are simulated or kept, recorded turns of the mill, and seeds, from 0 on."""

    jars: int
    revolutions: int
    seeds: int = 1


class Whole(NamedTuple):
    """Conditions of chapter 3: sizes, fill ratios at the first and the last speed, and every speed at one fill ratio.

    revolutions: recorded turns, by the ball diameter.
    """

    fill_ratios: tuple[float, ...] = (0.04, 0.06, 0.08, 0.10, 0.12, 0.16, 0.17, 0.20, 0.30, 0.40)
    speeds_rpm: tuple[float, ...] = (600.0, 800.0, 1000.0, 1200.0)
    every_speed_at: float = 0.08
    revolutions: tuple[tuple[float, int], ...] = ((10.0, 30), (5.0, 12))


class JarSearch(Section):
    """The values that a jar is compared with, and the simulations of the search."""

    contact: str = "calibrated"
    """contact set of the published values"""
    fitted: list[str] = ["Pt_f0.06", "Pn_f0.10", "Pn_f0.17", "normal_d10_n1200", "tangential_d10_n1200", "f_f0.17"]
    """fitted values, at most half of each kind; all were known when the jar of emax.yaml was chosen, see there"""
    counting_rules: list[str] = [
        "lifetimes_by_facet", "gap_0_01_by_facet", "gap_0_02_by_facet", "gap_0_03_by_facet", "gap_0_04_by_facet",
    ]  # fmt: skip
    """rules of dem.counting_rules to choose from, without thresholds"""
    ball_diameters_mm: list[float] = [10.0, 5.0]
    """ball diameters that curves average over, fewer than in the sweeps [mm]"""
    speeds_rpm: list[float] = [1200.0]
    """speeds that curves average over [rpm]"""
    time_step_s: float = 4e-6
    """integration step [s]"""
    settle_s: float = 0.2
    """time for the balls to come to rest [s]"""
    discard_revolutions: int = 6
    """first revolutions, left out of the averages"""
    power_error_max: float | None = 0.05
    """as in a sweep: a window begins anew while a power still rises, as the tangential power of 5 mm balls does for
    some thirty turns at fill ratios of 0.04 and 0.06; None: windows do not grow [-]
    """
    longest: int = 4
    """length up to which a window grows, over its first one [-]"""
    closure_max: float = 0.02
    """in place of dem.closure_max, for the coarse step [-]"""
    screening: Stage = Stage(jars=48, revolutions=10)
    """jars over the whole ranges, by a Sobol sequence"""
    refining: Stage = Stage(jars=5, revolutions=12)
    """the best jars again, the steps from them, and the sensitivity"""
    rounds: int = 2
    """rounds of steps up and down in every parameter, while one is better"""
    seed: int = 0
    """seed of the Sobol sequence"""
    equal_jars: int = 4
    """jars of those that fit equally well that are simulated at every condition of `whole`: the first of the table"""
    whole: Whole = Whole()
    """conditions of chapter 3 for each jar of that set"""


QUICK = JarSearch(
    fitted=["normal_d10_n1200"],
    counting_rules=["lifetimes_by_facet", "gap_0_03_by_facet"],
    ball_diameters_mm=[10.0],
    settle_s=0.1,
    discard_revolutions=2,
    screening=Stage(jars=2, revolutions=2),
    refining=Stage(jars=1, revolutions=2),
    rounds=1,
    equal_jars=2,
    whole=Whole(fill_ratios=(0.08,), speeds_rpm=(1200.0,), revolutions=((10.0, 2),)),
    power_error_max=None,
)


class FitConfig(Section):
    """A fit of a mill, its geometry a stadium, to values of data.published."""

    mill: Name
    """the mill that is fitted; a run of another mill fits nothing"""
    equal_jars: ProjectFile | None = None
    """table of the chosen jar and of jars and counting rules that fit equally well, as the target `fit` writes it;
    claims of chapter 3 are judged by all of them
    """
    quick: bool = False
    """whether two jars are enough, for a test of the workflow"""

    @property
    def search(self) -> JarSearch:
        """The settings of the search."""
        return QUICK if self.quick else JarSearch()
