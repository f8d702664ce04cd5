"""Settings of chapter 2: the analysis of a design's runs, the wet laboratory, and the literature."""

from typing import Annotated, ClassVar

from pydantic import Field, model_validator

from millprint.config.design import DesignConfig, Symbol
from millprint.config.section import Name, Positive, ProjectFile, Section, first_repeated

Purity = Annotated[float, Field(gt=0, le=1)]


class ChemistryConfig(Section):
    """The reaction: a limiting reactant, a reductant, and the gas that the product gives (thesis Eq. 3.27).

    Both formulas are checked by `millprint.thesis.doe.chemistry.check_formulas`, which knows the elements.
    """

    limiting: str
    """formula of the limiting reactant, such as NaBO2.4H2O"""
    reductant: str
    """formula of the other reactant, such as MgH2"""
    stoichiometric_ratio: Positive
    """mol of reductant per mol of limiting reactant [-]"""
    gas_per_mole: Positive
    """mol of gas collected per mol of limiting reactant at full conversion [-]"""
    limiting_purity: Purity = 1.0
    """mass fraction of the limiting reactant in its powder [-]"""
    reductant_purity: Purity = 1.0
    """mass fraction of the reductant in its powder [-]"""


class GasConfig(Section):
    """Conditions of the hydrogen collected over water. Within the bounds, the vapour pressure stays below the total."""

    temperature_k: float = Field(default=298.15, ge=273.15, le=353.15)
    """temperature of the gas and the water [K]"""
    pressure_pa: float = Field(default=101325.0, ge=5e4, le=2e5)
    """total pressure of the gas [Pa]"""
    saturated: bool = True
    """whether the gas holds water vapour, which is then subtracted"""
    yield_max_percent: float = Field(default=105.0, ge=100)
    """a gas reading that gives a larger yield is refused [%]"""


class WetLabConfig(Section):
    """What the wet-lab command needs of the section `doe`."""

    chemistry: ChemistryConfig
    gas: GasConfig = GasConfig()


class InteractionFigure(Section):
    """A figure of interaction plots side by side."""

    name: Name
    """last part of the file's name"""
    title: str
    """title of the figure in the report"""
    panels: list[tuple[Symbol, Symbol]] = Field(min_length=1, max_length=3)
    """for each panel the factor on the axis and the factor of the curves"""


class AnalysisConfig(DesignConfig):
    """A design and the analysis of variance of its runs."""

    model: list[str] = Field(min_length=1)
    """terms of the analysis of variance in the order of the type I sums, such as A or A:B"""
    # Level of the intervals of the effect sizes; a term stands if its p-value after Holm is below one minus it
    # [-].
    confidence: ClassVar[float] = 0.95
    # Probability with which the smallest effect in detectable.tsv would be found [-].
    power: ClassVar[float] = 0.8
    simulations: Annotated[int, Field(ge=100, le=100_000)] = 2000
    """simulated sets of normal errors for the p-values of the residual checks"""
    repeatability_percent: Positive | None = None
    """standard deviation of the yield of repeated runs, if known from the laboratory [%]"""
    interactions: list[InteractionFigure] = []
    """figures of interaction plots"""

    @model_validator(mode="after")
    def _terms_are_known(self) -> "AnalysisConfig":
        used = [("model", term.split(":")) for term in self.model]
        used += [
            (f"interactions.{figure.name}", list(panel)) for figure in self.interactions for panel in figure.panels
        ]
        for place, symbols in used:
            if not set(symbols) <= set(self.symbols) or len(set(symbols)) < len(symbols):
                term, known = ":".join(symbols), ", ".join(self.symbols)
                raise ValueError(f"{place}: {term!r}: must be made of different factors among {known}")
        if first_repeated(frozenset(term.split(":")) for term in self.model):
            raise ValueError(f"model = {self.model}: a term appears twice")
        if name := first_repeated(figure.name for figure in self.interactions):
            raise ValueError(f"interactions: name {name!r} appears twice; each figure has its own")
        return self


class DoeConfig(AnalysisConfig):
    """Settings of the doe stage."""

    literature: ProjectFile
    """table of the parameters that other groups report, from the project's root"""
    literature_yields: ProjectFile
    """table of the yields that they report, from the project's root"""
    chemistry: ChemistryConfig
    gas: GasConfig = GasConfig()
