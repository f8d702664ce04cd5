"""The file `card.yaml`: one milling experiment, described on a card; and the section `cards` of a run.

A table of experiments has one row per experiment: each column is a key of `card.yaml`, a key in a section
with a dot, such as `balls.fill_ratio`. An empty cell is a key that is left out.
"""

import math
from pathlib import Path
from typing import Annotated, Any

from pydantic import BeforeValidator, Field, model_validator

from millprint.config.charge import BallSize, ChargeSection, SpeedSection
from millprint.config.dose import JarSection, ProgrammeSection
from millprint.config.errors import ConfigError
from millprint.config.load import check_model
from millprint.config.mill_sweep import TurnsSection
from millprint.config.rows import read_rows
from millprint.config.section import Name, Positive, ProjectFile, Section, Seed, first_repeated
from millprint.config.sweep import Case, balls_of

# A line of text in a card.
Words = Annotated[str, Field(max_length=600)]


class CardBallsSection(ChargeSection):
    """The charge of balls."""

    diameter_mm: BallSize
    """ball diameter [mm]; a charge of several sizes is `{name, sizes_mm, numbers}` or `{name, sizes_mm, shares}`"""
    material: str | None = None
    """material of the balls, for wear: a row of dose.wear.materials; no wear if left out"""
    density_kg_m3: Positive | None = None
    """density of the balls, if it differs from the contact set's [kg/m3]"""


class PowderSection(Section):
    """What is milled."""

    name: Annotated[str, Field(min_length=1, max_length=200)]
    """name of the powder, as in the methods section of a paper"""
    mass_g: Positive | None = None
    """mass of all powder in the jar; or give `bpr` [g]"""
    bpr: Annotated[float, Field(gt=0, le=1e4)] | None = None
    """ball-to-powder mass ratio, in place of mass_g [-]"""

    @model_validator(mode="after")
    def _one_measure_of_the_powder(self) -> "PowderSection":
        if (self.mass_g is None) == (self.bpr is None):
            raise ValueError("give either mass_g or bpr")
        return self


class CardProgrammeSection(ProgrammeSection):
    """Milling and pauses."""

    duration_h: Annotated[float, Field(gt=0, le=1000)]
    """from the start to the end, pauses included [h]"""
    reversal: bool = False
    """whether the mill turns the other way after each pause; of no effect on the numbers of a card"""

    @model_validator(mode="after")
    def _pauses_have_a_cycle(self) -> "CardProgrammeSection":
        if (self.pause_min or self.reversal) and "cycle_min" not in self.model_fields_set:
            raise ValueError("cycle_min: this key is missing: milling and its pause together [min]")
        return self

    @property
    def milling_h(self) -> float:
        """Time for which the mill runs, without pauses [h]."""
        if not self.pause_min:
            return self.duration_h
        cycles, rest_min = divmod(60 * self.duration_h, self.cycle_min)
        return (cycles * self.milling_min + min(rest_min, self.milling_min)) / 60


class CardJarSection(JarSection):
    """The jar: material, cooling, and its mass and surface where they are known."""

    material: Words = ""
    """material of the jar, as in the methods section of a paper"""


def _split(value: Any) -> Any:
    """The numbers of a cell of a table as a list."""
    return value.split() if isinstance(value, str) else value


class Experiment(SpeedSection, TurnsSection):
    """One experiment. `mill`, a speed and `balls` are enough; without powder there is no dose and no wear."""

    name: Name
    """name of the card, and of its folder in a run"""
    mill: Name
    """a file in config/mills"""
    contact: Name | None = None
    """contact set, a file in config/contacts; if left out, `mills.contact`"""
    balls: CardBallsSection
    """the charge of balls"""
    powder: PowderSection | None = None
    """what is milled; no dose and no wear if left out"""
    programme: CardProgrammeSection | None = None
    """milling and pauses; no dose and no wear if left out"""
    jar: CardJarSection | None = None
    """the jar; if left out, the mill's entry in `dose.heat.jars`"""
    atmosphere: Words = ""
    """gas in the jar, such as argon"""
    title: Words = ""
    """title of the card; the name of the mill if left out"""
    authors: Words = ""
    """who did the experiment"""
    reference: Words = ""
    """where it is published"""
    note: Words = ""
    """anything else that a reader must know"""
    seeds: Annotated[list[Seed], Field(min_length=1, max_length=100), BeforeValidator(_split)] = [0, 1, 2]
    """seeds of the starting positions: the condition is simulated with each; in a table with blanks between them"""

    @model_validator(mode="after")
    def _seeds_differ(self) -> "Experiment":
        if twice := first_repeated(self.seeds):
            raise ValueError(f"seeds: {twice} appears twice")
        return self

    def is_case(self, case: Case, contact: str, fill_ratio: float) -> bool:
        """Whether a case simulates this experiment: same mill, contact set, speed, fill ratio and balls, as built."""
        own = balls_of(self.balls.diameter_mm)
        numbers = ((case.fill_ratio, fill_ratio), (case.speed_hz, self.hz))
        plain = (case.young_modulus_gpa, case.amplitude_mm, case.facets, case.time_step_s, case.disturbance_m)
        return (
            (case.mill, case.contact, case.density_kg_m3) == (self.mill, contact, self.balls.density_kg_m3)
            and (case.ball_diameter_m, case.mixture) == (own["ball_diameter_m"], own["mixture"])
            and all(math.isclose(one, other, rel_tol=1e-6) for one, other in numbers)
            and all(value is None for value in plain)
            and case.snapshot_interval_s is None
        )


class CardsConfig(Section):
    """Milling cards of a table of experiments: results/cards, target `cards`."""

    experiments: ProjectFile | None = None
    """table of experiments: a row for each experiment, a column for each key of `card.yaml`; none if left out"""
    match: list[Name] = []
    """mills whose settings come nearest to each card, in the target `cards`: files in config/mills"""
    animation: bool = True
    """whether each card has an animation; it needs another short simulation"""


def read_experiments(path: str | Path) -> list[Experiment]:
    """The experiments of a table (TSV; lines that begin with # are comments), by the columns of `Experiment`.

    Raises ConfigError, a line for each fault, as `check_model`, and for a table that cannot be read.
    """
    found = []
    for number, content in enumerate(read_rows(path), start=1):
        found.append(check_model(content, Experiment, f"{path}: {content.get('name') or f'row {number}'}"))
    if again := first_repeated(each.name for each in found):
        raise ConfigError(f"{path}: column name = {again} appears twice: each row needs a name of its own")
    return found
