"""Settings of what the powder has been through: wear of the balls."""

from typing import Annotated

from pydantic import Field

from millprint.config.section import Fraction, Name, Positive, ProjectFile, Section


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
    """further mills whose own sweeps are simulated for it"""
    fill_tolerance: Positive = 0.05
    """a run may differ in fill ratio from a weighing by this, as a fraction"""
    probability: Fraction = 0.95
    """of every interval [-]"""


class DoseConfig(Section):
    """What the powder has been through (results/dose)."""

    wear: WearConfig = WearConfig()
