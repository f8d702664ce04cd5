"""The section `dose`: quantities from finished simulations: energy spectra of collisions, wear of the balls, heat."""

import math
from typing import Annotated

from pydantic import Field, model_validator

from millprint.config.counting import RuleName
from millprint.config.heat import HeatConfig
from millprint.config.section import Fraction, Name, Positive, ProjectFile, Section, first_repeated


class SpectraConfig(Section):
    """Energy spectra. Every mill and condition has the same bins, with an open bin at either end."""

    lowest_J: Positive = 1e-12
    """lower edge of the first bin [J]; collisions below it have a bin of their own"""
    highest_J: Positive = 10.0
    """upper edge of the last bin [J]; collisions from it on have a bin of their own"""
    bins_per_decade: Annotated[int, Field(ge=1, le=100)] = 5
    """bins per decade, equally wide in the logarithm [-]"""
    counting_rules: list[RuleName] = ["lifetimes"]
    """further rules of dem.counting_rules in the tables, in addition to fingerprint.counting_rule"""

    @model_validator(mode="after")
    def _edges_rise(self) -> "SpectraConfig":
        if self.highest_J <= self.lowest_J:
            raise ValueError(f"highest_J = {self.highest_J:g}: must be above lowest_J = {self.lowest_J:g}")
        if (decades := math.log10(self.highest_J / self.lowest_J)) > 60:
            raise ValueError(f"lowest_J and highest_J are {decades:.0f} factors of ten apart: at most 60")
        if twice := first_repeated(self.counting_rules):
            raise ValueError(f"counting_rules: {twice} appears twice")
        return self


class ChargeConfig(Section):
    """How much powder is milled, and how long."""

    bpr: Annotated[float, Field(gt=0, le=1e4)]
    """ball-to-powder ratio [-]"""
    time_h: Annotated[float, Field(gt=0, le=1e4)]
    """milling time [h]"""


class WearConfig(Section):
    """Wear of the balls by Archard's law on the sliding work of the simulations."""

    materials: ProjectFile = "config/data/wear_materials.tsv"
    """table of materials: density, hardness with its range, share of iron"""
    material: str = "stainless_steel"
    """what the balls and the jar of data.wear are made of"""
    charges: list[ChargeConfig] = Field(
        default=[ChargeConfig(bpr=50, time_h=20), ChargeConfig(bpr=30, time_h=12.5)], min_length=1
    )
    """powder and time for which the wear is predicted, at every simulated condition"""
    mills: list[Name] = []
    """further mills whose own sweeps are simulated to predict wear"""
    fill_tolerance: Positive = 0.05
    """largest difference in fill ratio between a run and a weighing, as a fraction"""
    probability: Fraction = 0.95
    """probability of every interval [-]"""


class DoseConfig(Section):
    """What the powder has been through (results/dose); target `dose`."""

    spectra: SpectraConfig = SpectraConfig()
    wear: WearConfig = WearConfig()
    heat: HeatConfig = HeatConfig()
