"""Settings of chapter 2: a design of experiments, the analysis of its runs, the wet laboratory, and the literature."""

import re
from itertools import pairwise
from math import prod
from typing import Annotated, ClassVar

from pydantic import Field, model_validator

from millprint.config.section import Name, Positive, Section, Seed, first_repeated

Symbol = Annotated[str, Field(pattern=r"^[A-Z]$")]

# Levels of a regular fraction are counted modulo a prime.
PRIMES = (2, 3, 5, 7)
MOST_RUNS = 100_000


class Factor(Section):
    """One factor of the design: a column of the table of runs, and the values that it takes."""

    symbol: Symbol
    """capital letter that stands for the factor"""
    column: Name
    """column of the table of runs"""
    label: str = Field(min_length=1)
    """name in figures, with its unit"""
    levels: list[float | str] = Field(min_length=2, max_length=10)
    """values from low to high in the unit of the column, or the names of a factor without numbers"""

    @model_validator(mode="after")
    def _levels_differ(self) -> "Factor":
        numbers = [level for level in self.levels if isinstance(level, float)]
        names = [level for level in self.levels if isinstance(level, str)]
        if numbers and names:
            raise ValueError(f"levels of {self.symbol} = {self.levels}: must be all numbers or all names")
        if any(low >= high for low, high in pairwise(numbers)):
            raise ValueError(f"levels of {self.symbol} = {self.levels}: values must rise")
        if first_repeated(names) or any(name != " ".join(name.split()) or not name for name in names):
            raise ValueError(f"levels of {self.symbol} = {self.levels}: names must differ and have no odd blanks")
        return self

    @property
    def numeric(self) -> bool:
        """Whether the levels are numbers, so that they can have a trend."""
        return isinstance(self.levels[0], float)

    def text(self, code: int) -> str:
        """A level as text for tables and figures."""
        return f"{self.levels[code]:g}" if self.numeric else str(self.levels[code])


class Generator(Section):
    """A generated factor as a sum of base factors and a constant, modulo the number of levels."""

    factor: Symbol
    coefficients: dict[Symbol, Annotated[int, Field(ge=1)]]
    constant: int = 0
    word: bool = False

    def shift(self, levels: int) -> int:
        """What is added to the sum; a word of two levels is a product of signs, low -1, high +1: AB is high in 00."""
        signs = len(self.coefficients) - 1 if self.word and levels == 2 else 0
        return (self.constant + signs) % levels


def parse_generator(text: str) -> Generator:
    """Read `D = A + 2B + C`, with a constant `D = A + B + 1`, or a word `D = AB2C`; raises ValueError otherwise.

    At two levels a word is the product of signs of the textbooks; at more it is the sum with its exponents.
    """
    left, equals, right = text.replace(" ", "").partition("=")
    word = bool(re.fullmatch(r"([A-Z]\d?){2,}", right))
    if word:
        terms, constants = [(power, symbol) for symbol, power in re.findall(r"([A-Z])(\d?)", right)], []
    else:
        parts = right.split("+")
        constants = [int(part) for part in parts if part.isdecimal()]
        found = [re.fullmatch(r"(\d*)\*?([A-Z])", part) for part in parts if not part.isdecimal()]
        terms = [(match[1], match[2]) for match in found if match] if all(found) else []
    if not equals or not re.fullmatch("[A-Z]", left) or not terms or len(constants) > 1:
        raise ValueError(f"generator {text!r}: must be a sum such as 'D = A + B + C' or 'D = A + 2B'")
    coefficients = {symbol: int(number or 1) for number, symbol in terms}
    if len(coefficients) < len(terms) or left in coefficients or 0 in coefficients.values():
        raise ValueError(f"generator {text!r}: each factor may appear once, with a coefficient that is not zero")
    return Generator(factor=left, coefficients=coefficients, constant=sum(constants), word=word)


class DesignConfig(Section):
    """A full factorial, or a regular fraction of one; with several numbers of levels, each can have its fraction."""

    factors: list[Factor] = Field(min_length=2, max_length=26)
    """factors of the design"""
    generators: list[str] = []
    """generated factors, such as 'D = A + B + C' modulo the levels; none: a full factorial"""
    replicates: Annotated[int, Field(ge=1, le=10_000)] = 1
    """number of runs of each treatment [-]"""
    order_seed: Seed = 2
    """seed of the randomised order of the runs"""

    @property
    def symbols(self) -> list[str]:
        """The symbols of the factors, in order."""
        return [factor.symbol for factor in self.factors]

    @property
    def parsed_generators(self) -> list[Generator]:
        """The parsed generators."""
        return [parse_generator(text) for text in self.generators]

    @property
    def base_factors(self) -> list[Factor]:
        """The factors without a generator."""
        made = {generator.factor for generator in self.parsed_generators}
        return [factor for factor in self.factors if factor.symbol not in made]

    def factor(self, symbol: str) -> Factor:
        """The factor with this symbol."""
        return next(factor for factor in self.factors if factor.symbol == symbol)

    @model_validator(mode="after")
    def _factors_differ(self) -> "DesignConfig":
        for what in ("symbol", "column"):
            if twice := first_repeated(getattr(factor, what) for factor in self.factors):
                raise ValueError(f"factors: {what} {twice} appears twice; each factor has its own")
        return self

    @model_validator(mode="after")
    def _generators_hold(self) -> "DesignConfig":
        made = [generator.factor for generator in self.parsed_generators]
        base = [symbol for symbol in self.symbols if symbol not in made]
        if first_repeated(made):
            raise ValueError(f"generators = {self.generators}: a factor can be generated once")
        if unknown := sorted(set(made) - set(self.symbols)):
            raise ValueError(f"generators: {unknown[0]} is not a factor; known: {', '.join(self.symbols)}")
        for generator in self.parsed_generators:
            place = f"generator of {generator.factor}"
            if other := sorted(set(generator.coefficients) - set(base)):
                raise ValueError(f"{place}: {other[0]} is not a base factor ({', '.join(base)})")
            involved = [self.factor(symbol) for symbol in (generator.factor, *generator.coefficients)]
            number = len(involved[0].levels)
            if any(len(factor.levels) != number for factor in involved) or number not in PRIMES:
                raise ValueError(f"{place}: every factor in it must have the same number of levels, 2, 3, 5 or 7")
            if any(coefficient % number == 0 for coefficient in generator.coefficients.values()):
                raise ValueError(f"{place}: a coefficient is zero modulo {number}")
        return self

    @model_validator(mode="after")
    def _runs_are_few_enough(self) -> "DesignConfig":
        runs = prod(len(factor.levels) for factor in self.base_factors) * self.replicates
        if runs > MOST_RUNS:
            raise ValueError(f"factors: {runs} runs; must be at most {MOST_RUNS}: add generators or take levels away")
        return self


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
    # A gas reading that gives a larger yield is refused [%].
    yield_max_percent: ClassVar[float] = 105.0


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

    # Tables of the parameters and of the yields that other groups report, from the project's root.
    literature: ClassVar[str] = "config/data/literature.tsv"
    literature_yields: ClassVar[str] = "config/data/literature_yields.tsv"
    chemistry: ChemistryConfig
    gas: GasConfig = GasConfig()
