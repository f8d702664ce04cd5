"""DEM settings and sweeps: the simulated cases, their names, and what each changes."""

import itertools
from collections.abc import Mapping
from typing import Annotated, Any, ClassVar

from pydantic import AfterValidator, Field, ValidationError, model_validator

from millprint.config.charge import BallMixture, BallSize, check_charges, diameter_of, mixture_of, named_fill
from millprint.config.contact_set import ContactConfig
from millprint.config.counting import DEFAULT_RULES, CountingRule, check_names
from millprint.config.errors import ConfigError
from millprint.config.mill import MillConfig
from millprint.config.motion_kinds import MOTIONS, MotionSection
from millprint.config.section import Fraction, Name, NonNegative, Positive, Section, Seed, Speed

# The largest overlap that a run may allow, over the ball's radius [-]: see mill.wall_features.
OVERLAP_LIMIT = 0.2
# Turns after which the powers of most mills are steady, and the largest step before that was measured
# (docs/how_to/speed.md).
DISCARDED_TURNS = 5.0
RunUp = Annotated[float, Field(ge=0, le=0.2)]
Threads = Annotated[int, Field(ge=1, le=1024)]
# Small compared with any overlap: a disturbance shows how fast runs diverge, and its work is in no energy balance.
Disturbance = Annotated[float, Field(ge=0, le=1e-6)]


class DemConfig(Section):
    """Settings of every simulation unless a sweep overrides them."""

    time_step_s: Positive = 4e-6
    """integration step, for balls of 10 mm; smaller balls take a `rayleigh_fraction` of their sweep [s]"""
    rayleigh_fraction_max: Fraction = 0.2
    """largest step allowed, as a fraction of the Rayleigh time [-]"""
    settle_s: Positive = 0.25
    """time for the balls to come to rest before the mill starts [s]"""
    run_up_fraction: RunUp = 0.2
    """step until the averages begin, as a fraction of the Rayleigh time, up to four times the step of the recorded
    time; 0 is that step, which is taken as well where it is longer, and where there are snapshots [-]
    """
    discard_turns: NonNegative = DISCARDED_TURNS
    """turns of the mill before the averages begin [-]"""
    window_s: Positive = 1.0
    """time of motion that is recorded [s]"""
    # Not a key: only benchmarks take another number of samples of the energy ledger.
    ledger_samples_per_revolution: ClassVar[int] = 20
    counting_rules: Annotated[list[CountingRule], AfterValidator(check_names)] = Field(
        default=DEFAULT_RULES, min_length=1
    )
    """definitions of one collision; every run counts collisions by each of them"""
    overlap_max: Annotated[float, Field(gt=0, le=OVERLAP_LIMIT)] = 0.15
    """overlap over the ball's radius at which a run fails [-]"""
    restart_interval_s: NonNegative = 60.0
    """wall time between restart files, from which a stopped run continues [s]"""
    # Not in dumps: it says nothing about a simulation, and none runs again for it.
    runtime_max_h: Positive = Field(default=24.0, exclude=True)
    """longest time that a simulation requests from a cluster's queue; a longer one continues at its next attempt [h]"""
    # Powers stay within the scatter of seeds up to 0.9 % (docs/why/contact.md).
    closure_max: Fraction = 0.005
    """a run fails at this energy balance error, as a fraction of the wall work [-]"""
    threads: Threads = 1
    """threads inside one simulation, useful from some thousands of balls on; their number changes the rounding of
    results
    """

    @property
    def counts_by_facet(self) -> bool:
        """Whether a counting rule counts by facet, so that a contact has a row for each facet that it is on."""
        return any(rule.by == "facet" for rule in self.counting_rules)


class SweepConfig(Section):
    """A block of cases: every combination of its lists."""

    name: Name
    """name of the sweep"""
    mills: list[Name] | None = None
    """mills; the top-level mill if left out"""
    contacts: list[Name] = Field(min_length=1)
    """contact sets"""
    ball_diameters_mm: Annotated[list[BallSize], AfterValidator(check_charges)] = Field(min_length=1)
    """ball diameters [mm]; a charge of several sizes is `{name, sizes_mm, numbers}` or `{name, sizes_mm, shares}`"""
    fill_ratios: list[Fraction] = Field(min_length=1)
    """ball volume over jar volume [-]"""
    speeds_rpm: list[Speed] = Field(min_length=1)
    """mill speeds [rpm]"""
    seeds: list[Seed] = Field(min_length=1)
    """seeds of the starting positions"""
    young_moduli_gpa: list[Positive] | None = None
    """Young's moduli instead of the contact set's [GPa]"""
    amplitudes_mm: list[Positive] | None = None
    """radii of the mill's circle or sun wheel in place of the mill's own [mm]"""
    densities_kg_m3: list[Positive] | None = None
    """densities of the balls instead of the contact set's [kg/m3]"""
    time_steps_s: list[Positive] | None = Field(default=None, min_length=1)
    """integration steps instead of dem.time_step_s; several are compared, one is only simulated [s]"""
    rayleigh_fraction: Fraction | None = None
    """step as a fraction of each case's own Rayleigh time, instead of dem.time_step_s [-]"""
    rayleigh_fraction_max: Fraction | None = None
    """instead of dem.rayleigh_fraction_max [-]"""
    closure_max: Fraction | None = None
    """instead of dem.closure_max [-]"""
    settle_s: Positive | None = None
    """instead of dem.settle_s [s]"""
    discard_s: NonNegative | None = None
    """time of motion before the averages begin, instead of dem.discard_turns [s]"""
    discard_turns: NonNegative | None = None
    """instead of dem.discard_turns [-]"""
    window_s: Positive | None = None
    """instead of dem.window_s [s]"""
    power_error_max: Fraction | None = None
    """the window grows until half of the 95 % interval of the mean power, also of its normal and tangential part, is
    below this; it begins anew while one of these powers still rises or falls [-]
    """
    window_max_s: Positive | None = None
    """longest window if power_error_max requires more than window_s [s]"""
    snapshot_interval_s: Positive | None = None
    """time between snapshots of every ball; none are recorded if left out [s]"""
    disturbances_m: list[Disturbance] | None = None
    """every ball is displaced by this distance, in a random direction, at the start of the recorded window; 0 for
    the reference run [m]
    """

    @model_validator(mode="after")
    def _a_study_of_convergence_varies_one_thing(self) -> "SweepConfig":
        if self.discard_s is not None and self.discard_turns is not None:
            raise ValueError("discard_s and discard_turns cannot both be given in one sweep")
        if self.time_steps_s and self.rayleigh_fraction:
            raise ValueError("time_steps_s and rayleigh_fraction cannot both be given in one sweep")
        # A modulus has a stable step of its own, so that a fraction of the Rayleigh time belongs with it.
        excluded: dict[str, tuple[str, ...]] = {"young_moduli_gpa": ("amplitudes_mm", "densities_kg_m3")}
        if self.compares_steps:
            excluded = {"time_steps_s": ("young_moduli_gpa", "amplitudes_mm", "densities_kg_m3"), **excluded}
        for study, others in excluded.items():
            for other in others:
                if getattr(self, study) and getattr(self, other):
                    raise ValueError(f"{study} and {other} cannot both be given in one sweep")
        if (self.compares_steps or self.young_moduli_gpa) and 0 in self.speeds_rpm:
            raise ValueError("speeds_rpm = 0: a mill at rest has no descriptors to compare steps or moduli by")
        if self.power_error_max and 0 in self.speeds_rpm:
            raise ValueError("speeds_rpm = 0: a mill at rest has no power; leave out power_error_max, or the speed")
        charges = [mixture.name for size in self.ball_diameters_mm if (mixture := mixture_of(size))]
        if (self.compares_steps or self.young_moduli_gpa) and charges:
            raise ValueError(
                f"ball_diameters_mm: charge {charges[0]}: steps and moduli are compared for balls of one size; give "
                "the size of its smallest ball, which needs the shortest step"
            )
        return self

    @property
    def compares_steps(self) -> bool:
        """Whether the sweep compares several time steps."""
        return len(set(self.time_steps_s or [])) > 1


class Case(Section):
    """One simulation. Its path is `MILL/CONTACT/NAME`, such as emax/calibrated/d10_f0.10_n600_s0.

    Its condition is in SI; what it changes of mill and contact set has the keys and units of these.
    """

    mill: Name
    contact: Name
    ball_diameter_m: float
    mixture: BallMixture | None = None
    fill_ratio: float
    speed_hz: float
    seed: int
    young_modulus_gpa: float | None = None
    amplitude_mm: float | None = None
    density_kg_m3: float | None = None
    facets: int | None = None
    time_step_s: float | None = None
    rayleigh_fraction: float | None = None
    rayleigh_fraction_max: float | None = None
    closure_max: float | None = None
    threads: int | None = None
    settle_s: float
    discard_s: float
    window_s: float
    power_error_max: float | None = None
    window_max_s: float | None = None
    snapshot_interval_s: float | None = None
    disturbance_m: float | None = None

    @property
    def name(self) -> str:
        """The name of the case's folder: its condition, what it changes of mill and contact set, and its seed."""
        changed = {
            "y": self.young_modulus_gpa,
            "a": self.amplitude_mm,
            "rho": self.density_kg_m3,
            "facets": self.facets,
            "dt": self.time_step_s,
            "e": self.disturbance_m,
        }
        changes = "".join(f"_{letters}{value:g}" for letters, value in changed.items() if value is not None)
        balls = self.mixture.name if self.mixture else f"d{1e3 * self.ball_diameter_m:g}"
        return f"{balls}_f{named_fill(self.fill_ratio)}_n{60 * self.speed_hz:g}{changes}_s{self.seed}"

    @property
    def sizes_m(self) -> tuple[float, ...]:
        """The diameters of the balls [m]: one, or those of the mixture."""
        return tuple(size / 1e3 for size in self.mixture.sizes_mm) if self.mixture else (self.ball_diameter_m,)

    @property
    def path(self) -> str:
        """The case's folder below results/dem."""
        return f"{self.mill}/{self.contact}/{self.name}"


# The lists of a sweep whose every combination is a case, by the case's key; the last varies fastest.
_VARIED = {
    "mill": "mills",
    "contact": "contacts",
    "balls": "ball_diameters_mm",
    "fill_ratio": "fill_ratios",
    "speed_rpm": "speeds_rpm",
    "young_modulus_gpa": "young_moduli_gpa",
    "amplitude_mm": "amplitudes_mm",
    "density_kg_m3": "densities_kg_m3",
    "time_step_s": "time_steps_s",
    "disturbance_m": "disturbances_m",
    "seed": "seeds",
}


def expand_sweep(sweep: SweepConfig, dem: DemConfig, mill: str) -> list[Case]:
    """Every case of a sweep, of the default `mill` where it names none, with its own durations or those of `dem`."""
    given = {key: getattr(sweep, key) for key in SweepConfig.model_fields if key in Case.model_fields}
    given |= {key: getattr(dem, key) for key in ("settle_s", "window_s") if given[key] is None}
    lists = [getattr(sweep, key) or [mill if key == "mills" else None] for key in _VARIED.values()]
    combined = (dict(zip(_VARIED, values, strict=True)) for values in itertools.product(*lists))
    return [
        Case(**own, **balls_of(balls), speed_hz=speed_rpm / 60, **(given | _discarded(sweep, dem, speed_rpm / 60)))
        for balls, speed_rpm, own in ((values.pop("balls"), values.pop("speed_rpm"), values) for values in combined)
    ]


def _discarded(sweep: SweepConfig, dem: DemConfig, speed_hz: float) -> dict[str, float]:
    """The time before the averages begin; none for a mill at rest, whose balls have settled."""
    if sweep.discard_s is not None:
        return {"discard_s": sweep.discard_s}
    turns = dem.discard_turns if sweep.discard_turns is None else sweep.discard_turns
    return {"discard_s": turns / speed_hz if speed_hz else 0.0}


def balls_of(size: float | BallMixture) -> dict[str, float | BallMixture | None]:
    """The keys of a case that an element of `ball_diameters_mm` gives."""
    return {"ball_diameter_m": diameter_of(size) / 1e3, "mixture": mixture_of(size)}


def as_tabulated(case: Mapping[str, Any]) -> dict[str, float]:
    """Ball diameter [mm], fill ratio and speed [rpm] of a stored case, as tables and pages have them."""
    # Without the last digits, which the factors change: a speed of 500 rpm is 500.
    diameter_mm, speed_rpm = (
        float(f"{value:.13g}") for value in (1e3 * case["ball_diameter_m"], 60 * case["speed_hz"])
    )
    return {"ball_diameter_mm": diameter_mm, "fill_ratio": case["fill_ratio"], "speed_rpm": speed_rpm}


def threads_of(case: Case, dem: DemConfig) -> int:
    """The threads of a case: its own number, or that of `dem`."""
    return case.threads or dem.threads


def ball_count(fill_ratio: float, volume_m3: float, diameter_m: float) -> int:
    """Number of balls, the rounded volume ratio (thesis Table 3.4)."""
    return round(fill_ratio * volume_m3 / (3.141592653589793 / 6 * diameter_m**3))


def overridden(case: Case, mill: MillConfig, contact: ContactConfig) -> tuple[MillConfig, ContactConfig]:
    """The mill and the contact set of a case, with the values that the case changes.

    Raises ConfigError as `mill_of`, and for a Young's modulus of a contact law that has none.
    """
    if case.young_modulus_gpa is not None:
        contact.value_of("young_modulus_gpa")
    given = {"density_kg_m3": case.density_kg_m3, "young_modulus_gpa": case.young_modulus_gpa}
    changed = contact.model_copy(update={name: value for name, value in given.items() if value is not None})
    return mill_of(case, mill), changed


def mill_of(case: Case, mill: MillConfig) -> MillConfig:
    """The mill as a case runs it, with the case's own amplitude and number of facets if it has them.

    Raises ConfigError for an amplitude of a mill whose motion has no radius A of a circle, for facets of a vessel that
    is not round or comes from a file, and for either out of bounds.
    """
    changed: dict[str, Section] = {}
    if case.amplitude_mm is not None:
        changed["motion"] = _with_amplitude(case.amplitude_mm, mill)
    if case.facets is not None:
        changed["geometry"] = _with_facets(case.facets, mill)
    return mill.model_copy(update=changed) if changed else mill


def _with_facets(facets: int, mill: MillConfig) -> Section:
    """The vessel of a mill with another number of flat facets around it."""
    shape = mill.geometry
    if shape.facets_key is None:
        raise ConfigError(f"mill {mill.name}: facets = {facets}: the geometry is a {shape.kind}, which has no facets")
    try:
        return type(shape).model_validate({**shape.model_dump(), shape.facets_key: facets})
    except ValidationError as error:
        raise ConfigError(
            f"mill {mill.name}: {shape.facets_key} = {facets}: {error.errors()[0]['msg'].lower()}"
        ) from None


def _with_amplitude(amplitude_mm: float, mill: MillConfig) -> MotionSection:
    law, key = mill.motion, mill.motion.record.amplitude_key
    if key is None:
        kinds = ", ".join(kind for kind, record in MOTIONS.items() if record.amplitude_key)
        raise ConfigError(
            f"sweeps: amplitudes_mm = {amplitude_mm:g}: the motion of mill {mill.name} is a {law.kind}, which has no "
            f"amplitude to set; a sweep over amplitudes needs one of {kinds}"
        )
    try:
        return type(law).model_validate({**law.model_dump(), key: amplitude_mm})
    except ValidationError as error:
        raise ConfigError(
            f"sweeps: amplitudes_mm = {amplitude_mm:g} of mill {mill.name}: {error.errors()[0]['msg'].lower()}"
        ) from None
