"""The section `dose`: quantities from finished simulations: energy spectra of collisions, wear of the balls, heat."""

from typing import Annotated

from pydantic import Field, model_validator

from millprint.config.counting import RuleName
from millprint.config.heat import HeatConfig
from millprint.config.section import Name, ProjectFile, Section, first_repeated


class SpectraConfig(Section):
    """Energy spectra. Every mill and condition has the same bins, with an open bin at either end."""

    counting_rules: list[RuleName] = ["lifetimes"]
    """further rules of dem.counting_rules in the tables, in addition to fingerprint.counting_rule"""

    @model_validator(mode="after")
    def _rules_differ(self) -> "SpectraConfig":
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


class DoseConfig(Section):
    """What the powder has been through (results/dose); target `dose`."""

    spectra: SpectraConfig = SpectraConfig()
    wear: WearConfig = WearConfig()
    heat: HeatConfig = HeatConfig()
