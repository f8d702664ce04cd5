"""What every set-up of the validation has; and shaken boxes: on a drive, on a leaf spring, and a pendulum."""

from typing import ClassVar

from millprint.config.mill import MillConfig
from millprint.config.section import Section
from millprint.config.sweep import Case, SweepConfig

Interval = tuple[float, float]


class SetupConfig(Section):
    """Settings of a set-up: its contact sets, its mill if it has one, and its simulations."""

    # The files that the prediction reads of each simulation.
    run_files: ClassVar[tuple[str, ...]] = ("summary.json",)
    # Tables of its own simulations in its own folder, which another rule writes before the prediction.
    own_tables: ClassVar[tuple[str, ...]] = ()

    contact: str
    """contact set of the prediction: a file in config/contacts"""
    further_contacts: list[str] = []
    """contact sets that are equally likely; the interval by contact parameters spans them all"""

    def without_intervals(self) -> "SetupConfig":
        """The set-up without the simulations that only its intervals need."""
        return self.model_copy(update={"further_contacts": []})

    @property
    def mill_name(self) -> str | None:
        """The mill, a file in config/mills; None for a set-up without one."""
        return getattr(self, "mill", None)

    @property
    def contact_names(self) -> list[str]:
        """Every contact set of the set-up, the one that predicts first."""
        return [self.contact, *self.further_contacts]

    @property
    def sweeps(self) -> list[SweepConfig]:
        """Its simulations in results/dem; none for a set-up that simulates on its own. Each sweep names its mills."""
        return []

    def simulated_inside(self, mill: MillConfig) -> list[Case]:
        """The simulations that have no file in results/dem: a rule of the validation has them inside."""
        return []

    @property
    def further_s(self) -> float:
        """Processor time that simulations without a case and a mill are likely to take, for the plan of a run [s]."""
        return 0.0


# What a run takes of a processor [s], and for which number of balls.
SECONDS, BALLS = 10.0, 300


class ShakenConfig(SetupConfig):
    """A box of a square cross-section that moves up and down, with a pile of balls of one size."""

    ball_diameter_mm: float = 10.0
    """ball diameter [mm]"""
    side_diameters: float
    """side of the cross-section [ball diameters]"""
    balls: int
    """number of balls [-]"""
    seeds: list[int] = [0, 1, 2]
    """seeds of the starting positions; their scatter is the interval"""
    rayleigh_fraction: float = 0.15
    """step over the Rayleigh time [-]"""
    closure_max: float = 0.02
    """a simulation fails at this energy balance error over the wall work [-]"""

    def without_intervals(self) -> "ShakenConfig":
        """One seed, and nothing changed."""
        fewer: dict[str, list] = {"further_balls": [], "varied_amplitudes": []}
        own = {key: value for key, value in fewer.items() if key in type(self).model_fields}
        return self.model_copy(update={**own, "seeds": self.seeds[:1]})

    @property
    def side_m(self) -> float:
        """Side of the cross-section [m]."""
        return self.side_diameters * self.ball_diameter_mm / 1e3

    @property
    def runs(self) -> int:
        """Simulations of the set-up, apart from those at measured places [-]."""
        raise NotImplementedError

    @property
    def further_s(self) -> float:
        """About SECONDS for a run of BALLS balls."""
        return SECONDS * self.runs * self.balls / BALLS


class ShakenBoxConfig(ShakenConfig):
    """Set-up 21: a box without gravity, half full of many layers, and what must not change the energy lost in it."""

    speed_m_s: float
    """peak speed of the box, A w, at every amplitude [m/s]"""
    fill_share: float
    """thickness of the packed pile over the inner length [-]"""
    amplitudes: list[float]
    """amplitudes over the free gap, in addition to the measured ones [-]"""
    packing_amplitude: float
    """least amplitude over the free gap at which shaking packs the poured pile; a larger one packs it more [-]"""
    packing_periods: int
    """periods in which shaking packs the poured pile [-]"""
    discard_periods: int
    """further periods before the averages begin [-]"""
    window_periods: int
    """periods that are averaged [-]"""
    varied_amplitudes: list[float]
    """amplitudes over the free gap at which one thing is changed, with the first seed [-]"""
    further_speeds_m_s: list[float]
    """other speeds, and so frequencies [m/s]"""
    further_restitutions: list[float]
    """other coefficients of restitution [-]"""
    further_frictions: list[float]
    """other coefficients of friction [-]"""
    further_balls: list[int]
    """other numbers of balls, and so of layers [-]"""

    @property
    def changes(self) -> dict[str, list]:
        """What is changed, one at a time: the value of a run and its values."""
        return {
            "speed_m_s": self.further_speeds_m_s,
            "restitution": self.further_restitutions,
            "static_friction": self.further_frictions,
            "balls": self.further_balls,
        }

    @property
    def runs(self) -> int:
        """Those of each seed, and those with one thing changed."""
        changed = sum(map(len, self.changes.values())) * len(self.varied_amplitudes)
        return len(self.amplitudes) * len(self.seeds) + changed


class LeafSpringConfig(ShakenConfig):
    """Set-up 22: a box on a leaf spring without gravity, which swings freely and is stopped by the balls in it."""

    length_diameters: float
    """inner length [ball diameters]"""
    frequency_hz: float
    """frequency of the box without balls [Hz]"""
    amplitude_diameters: float
    """amplitude at the start [ball diameters]"""
    mass_ratio: float
    """mass of the box over that of all balls [-]"""
    further_balls: list[int]
    """other numbers of balls, in a box of the same ratio of masses; the interval spans them"""
    times_s: list[float]
    """times, in addition to the measured ones [s]"""

    @property
    def runs(self) -> int:
        """One of each seed and of each other number of balls."""
        return len(self.seeds) + len(self.further_balls)


class ShakenPlateConfig(ShakenConfig):
    """Set-up 23: layers of balls on a shaken plate under gravity."""

    frequency_hz: float
    """frequency of the plate [Hz]"""
    accelerations: list[float]
    """peak accelerations of the plate over gravity [-]"""
    discard_periods: int
    """periods before the averages begin [-]"""
    window_periods: int
    """periods that are averaged [-]"""

    @property
    def runs(self) -> int:
        """One of each acceleration and seed."""
        return len(self.accelerations) * len(self.seeds)
