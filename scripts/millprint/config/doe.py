"""Settings of the doe stage: factors and levels, the fraction, the analysis, and the wet-lab constants."""

import re
from itertools import pairwise
from math import prod
from typing import Annotated

from pydantic import Field, model_validator

from millprint.config.section import Fraction, Name, Positive, Section

Symbol = Annotated[str, Field(pattern=r"^[A-Z]$")]


class Factor(Section):
    """One factor of the design: a column of the table of runs, and the values that it takes."""

    symbol: Symbol = Field(description="capital letter that stands for the factor")
    column: Name = Field(description="column of the table of runs")
    label: str = Field(min_length=1, description="name in figures, with its unit")
    levels: list[float] = Field(min_length=2, description="values from low to high, in the unit of the column")

    @model_validator(mode="after")
    def _levels_rise(self) -> "Factor":
        if any(low >= high for low, high in pairwise(self.levels)):
            raise ValueError(f"levels of {self.symbol} = {self.levels}: values that rise are wanted")
        return self


class Generator(Section):
    """A generated factor as a sum of base factors, modulo the number of levels."""

    factor: Symbol
    coefficients: dict[Symbol, Annotated[int, Field(ge=1)]]


def parse_generator(text: str) -> Generator:
    """Read `D = A + 2B + C` as a generator; raises ValueError for anything else."""
    left, equals, right = text.replace(" ", "").partition("=")
    terms = [re.fullmatch(r"(\d*)\*?([A-Z])", term) for term in right.split("+")]
    if not equals or not re.fullmatch("[A-Z]", left) or not all(terms):
        raise ValueError(f"generator {text!r}: a sum such as 'D = A + B + C' or 'D = A + 2B' is wanted")
    coefficients = {term[2]: int(term[1] or 1) for term in terms}
    if len(coefficients) < len(terms) or left in coefficients or 0 in coefficients.values():
        raise ValueError(f"generator {text!r}: each factor may appear once, with a coefficient that is not zero")
    return Generator(factor=left, coefficients=coefficients)


class InteractionFigure(Section):
    """A figure of interaction plots side by side."""

    name: Name = Field(description="last part of the file's name")
    title: str = Field(description="what the figure is, for the report")
    panels: list[tuple[Symbol, Symbol]] = Field(
        min_length=1, max_length=3, description="for each panel the factor on the axis and the factor of the curves"
    )


class HalfLifeConfig(Section):
    """Conditions of the spent solution (thesis Eq. 2.7)."""

    ph: float = Field(ge=7, le=14, description="pH of the solution [-]")
    temperature_k: float = Field(ge=273, le=373, description="temperature of the solution [K]")


class PowderConfig(Section):
    """The charge of the jar in the screening runs."""

    balls: Annotated[int, Field(ge=1)] = Field(description="number of balls in the jar [-]")
    ball_mass_g: Positive = Field(description="mass of all of them together [g]")


class GasConfig(Section):
    """Conditions of the hydrogen collected over water; within the bounds the vapour never reaches the pressure."""

    temperature_k: float = Field(ge=273.15, le=353.15, description="temperature of the gas and the water [K]")
    pressure_pa: float = Field(ge=5e4, le=2e5, description="total pressure of the gas [Pa]")


class DoeConfig(Section):
    """Settings of the doe stage."""

    factors: list[Factor] = Field(min_length=2, description="factors, base factors before generated ones")
    generators: list[str] = Field(
        default=[], description="generated factors, such as 'D = A + B + C' modulo the levels; none: a full factorial"
    )
    order_seed: Annotated[int, Field(ge=0)] = Field(description="seed of the randomised order of the runs")
    model: list[str] = Field(
        min_length=1, description="terms of the analysis of variance in the order of the type I sums, such as A or A:B"
    )
    confidence: Fraction = Field(default=0.95, description="level of the intervals of the effect sizes [-]")
    simulations: Annotated[int, Field(ge=100)] = Field(
        default=2000, description="simulated sets of normal errors behind the residual checks' p-values"
    )
    interactions: list[InteractionFigure] = Field(default=[], description="figures of interaction plots")
    literature: str = Field(
        description="table of other groups' reported yields and parameters, from the project's root"
    )
    half_life: HalfLifeConfig
    powder: PowderConfig
    gas: GasConfig

    @property
    def symbols(self) -> list[str]:
        """The factors' letters, in order."""
        return [factor.symbol for factor in self.factors]

    @property
    def parsed_generators(self) -> list[Generator]:
        """The generators, read."""
        return [parse_generator(text) for text in self.generators]

    @property
    def base_factors(self) -> list[Factor]:
        """The factors that no generator makes."""
        made = {generator.factor for generator in self.parsed_generators}
        return [factor for factor in self.factors if factor.symbol not in made]

    def factor(self, symbol: str) -> Factor:
        """The factor of a letter."""
        return next(factor for factor in self.factors if factor.symbol == symbol)

    @model_validator(mode="after")
    def _factors_differ(self) -> "DoeConfig":
        for what in ("symbol", "column"):
            names = [getattr(factor, what) for factor in self.factors]
            twice = sorted({name for name in names if names.count(name) > 1})
            if twice:
                raise ValueError(f"factors: {what} {twice[0]} appears twice; each factor has its own")
        return self

    @model_validator(mode="after")
    def _generators_hold(self) -> "DoeConfig":
        generators = self.parsed_generators
        made = [generator.factor for generator in generators]
        base = [symbol for symbol in self.symbols if symbol not in made]
        if len(set(made)) < len(made):
            raise ValueError(f"generators = {self.generators}: a factor can be generated once")
        if unknown := sorted(set(made) - set(self.symbols)):
            raise ValueError(f"generators: {unknown[0]} is no factor; known: {', '.join(self.symbols)}")
        if not generators:
            return self
        levels = {len(factor.levels) for factor in self.factors}
        number = levels.pop()
        if levels or number not in (2, 3, 5, 7):
            raise ValueError("generators: a fraction needs 2, 3, 5 or 7 levels, the same number for every factor")
        for generator in generators:
            if other := sorted(set(generator.coefficients) - set(base)):
                raise ValueError(f"generator of {generator.factor}: {other[0]} is no base factor ({', '.join(base)})")
            if any(coefficient % number == 0 for coefficient in generator.coefficients.values()):
                raise ValueError(f"generator of {generator.factor}: a coefficient is zero modulo {number}")
        return self

    @model_validator(mode="after")
    def _terms_are_known(self) -> "DoeConfig":
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

    @model_validator(mode="after")
    def _runs_are_few_enough(self) -> "DoeConfig":
        runs = prod(len(factor.levels) for factor in self.base_factors)
        if runs > 100_000:
            raise ValueError(f"factors: {runs} runs; at most 100000 are wanted: add generators or take levels away")
        return self
