"""Set-up of a shaker mill."""

from typing import Annotated

from pydantic import Field

from millprint.config.section import Fraction, Name, Positive, PositiveSpeed, Seed
from millprint.config.setups.base import SetupConfig
from millprint.config.sweep import SweepConfig


class ShakerConfig(SetupConfig):
    """Row 8a: a shaker mill of the class of SPEX 8000, of which neither balls nor vial are known."""

    contact: Name = "steel"
    mill: Name = "spex"
    """mill: a file in config/mills"""
    ball_diameters_mm: Annotated[list[Positive], Field(min_length=1)] = [12.7, 6.35]
    """ball diameters, each a charge of its own [mm]"""
    fill_ratio: Fraction = 0.06
    """ball volume over the mill's nominal volume [-]"""
    speed_rpm: PositiveSpeed = 1050.0
    """cycles of the arm [1/min]"""
    seeds: Annotated[list[Seed], Field(min_length=1)] = [0, 1]
    """seeds of the starting positions"""
    discard_s: Positive = 0.5
    """time before the record begins [s]"""
    window_s: Positive = 2.0
    """recorded time [s]"""
    interval_s: Positive = 2e-3
    """time between two records of the balls [s]"""
    share: Fraction = 0.8
    """share of all speeds that the range holds [-]"""

    @property
    def mill_name(self) -> str:
        """The mill."""
        return self.mill

    @property
    def run_files(self) -> tuple[str, ...]:
        """The records of the balls."""
        return ("run.h5",)

    @property
    def sweeps(self) -> list[SweepConfig]:
        """A charge of each size with each seed."""
        return [
            SweepConfig(
                name="spex_shaker", mills=[self.mill], contacts=self.contact_names,
                ball_diameters_mm=self.ball_diameters_mm, fill_ratios=[self.fill_ratio], speeds_rpm=[self.speed_rpm],
                seeds=self.seeds, rayleigh_fraction=0.024, discard_s=self.discard_s, window_s=self.window_s,
                snapshot_interval_s=self.interval_s,
            )
        ]  # fmt: skip
