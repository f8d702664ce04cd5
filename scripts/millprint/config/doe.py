"""Settings of the doe stage: the design, its analysis, the literature, and the wet laboratory."""

from pydantic import Field

from millprint.config.analysis import AnalysisConfig
from millprint.config.section import ProjectFile
from millprint.config.wet_lab import ChemistryConfig, GasConfig, HalfLifeConfig, PowderConfig


class DoeConfig(AnalysisConfig):
    """Settings of the doe stage."""

    literature: ProjectFile = Field(
        description="table of the parameters that other groups report, from the project's root"
    )
    literature_yields: ProjectFile = Field(description="table of the yields that they report, from the project's root")
    chemistry: ChemistryConfig
    half_life: HalfLifeConfig
    powder: PowderConfig
    gas: GasConfig = GasConfig()
