"""What every set-up of the validation has: its contact sets, its mill if it has one, and its simulations."""

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
