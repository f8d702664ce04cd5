"""The section `data`: measured tables."""

from pydantic import Field

from millprint.config.section import ProjectFile, Section


class DataConfig(Section):
    """Measured tables, as paths from the project's root."""

    screening: ProjectFile = Field(description="the screening runs with their yields")
    wear: ProjectFile = Field(description="mass of the balls before and after milling")
    regimes: ProjectFile = Field(description="the five cases of chapter 4")
    split: ProjectFile = Field(description="the locked train-test split of the screening runs")
    claims: ProjectFile = Field(description="every number the thesis states, with a tolerance")
    published: ProjectFile = Field(description="published values shown as marks in figures")
