"""The analysis of a design's runs: terms, intervals, checks, figures of interactions."""

from typing import Annotated

from pydantic import Field, model_validator

from millprint.config.design import DesignConfig, Symbol
from millprint.config.section import Fraction, Name, Positive, Section


class InteractionFigure(Section):
    """A figure of interaction plots side by side."""

    name: Name = Field(description="last part of the file's name")
    title: str = Field(description="what the figure is, for the report")
    panels: list[tuple[Symbol, Symbol]] = Field(
        min_length=1, max_length=3, description="for each panel the factor on the axis and the factor of the curves"
    )


class AnalysisConfig(DesignConfig):
    """A design and the analysis of variance of its runs."""

    model: list[str] = Field(
        min_length=1, description="terms of the analysis of variance in the order of the type I sums, such as A or A:B"
    )
    confidence: Fraction = Field(default=0.95, description="level of the intervals of the effect sizes [-]")
    simulations: Annotated[int, Field(ge=100, le=100_000)] = Field(
        default=2000, description="simulated sets of normal errors behind the residual checks' p-values"
    )
    repeatability_percent: Positive | None = Field(
        default=None, description="standard deviation of a repeated run's yield, where the laboratory knows it [%]"
    )
    interactions: list[InteractionFigure] = Field(default=[], description="figures of interaction plots")

    @model_validator(mode="after")
    def _terms_are_known(self) -> "AnalysisConfig":
        used = [("model", term, term.split(":")) for term in self.model]
        used += [
            (f"interactions.{figure.name}", "/".join(panel), list(panel))
            for figure in self.interactions
            for panel in figure.panels
        ]
        for where, text, symbols in used:
            if not set(symbols) <= set(self.symbols) or len(set(symbols)) < len(symbols):
                raise ValueError(f"{where}: {text!r}: different factors among {', '.join(self.symbols)} are wanted")
        terms = [frozenset(term.split(":")) for term in self.model]
        if len(set(terms)) < len(terms):
            raise ValueError(f"model = {self.model}: a term appears twice")
        names = [figure.name for figure in self.interactions]
        if len(set(names)) < len(names):
            raise ValueError(f"interactions: names {names}: each figure has its own")
        return self
