"""Runs of other groups or mills, in addition to the screening runs: their table and their sources."""

from typing import Annotated

from pydantic import StringConstraints, model_validator

from millprint.config.section import ProjectFile, Section, first_repeated

SourceName = Annotated[str, StringConstraints(strip_whitespace=True, min_length=1, max_length=60)]


class SourceConfig(Section):
    """A group or a mill whose runs are in the table of others."""

    name: SourceName
    """as in the column `source` of the table"""
    fingerprint: ProjectFile | None = None
    """fingerprint of its mill, for rows without energies; if left out, each row gives its own"""


class OtherSourcesConfig(Section):
    """Runs of other groups or mills, to test the yield models on runs that are not ours."""

    own: SourceName = "screening"
    """name of the source of data.screening"""
    runs: ProjectFile | None = None
    """table of the others' runs, with a column `source`; if left out, there is one source"""
    sources: list[SourceConfig] = []
    """every source in that table"""
    in_training: bool = False
    """whether the models of chapter 5 train on these runs too; if not, they see only data.screening. The locked
    test rows stay the same
    """

    @model_validator(mode="after")
    def _table_and_names_go_together(self) -> "OtherSourcesConfig":
        names = [source.name for source in self.sources]
        if twice := first_repeated([self.own, *names]):
            raise ValueError(f"sources: two have the name {twice!r}; data.screening is {self.own!r}")
        if self.runs is None and names:
            raise ValueError(f"runs is missing: the table that has the runs of {', '.join(names)}")
        if self.runs is not None and not names:
            raise ValueError("sources is missing: name every source of the table, as [{name: NAME}]")
        if self.in_training and self.runs is None:
            raise ValueError("in_training = true: there is no table of others; give runs")
        return self
