"""The section `validation`: which of the set-ups of `millprint.config.setup_models` are predicted."""

from pydantic import model_validator

from millprint.config.section import Name, ProjectFile, Section, first_repeated
from millprint.config.setup_models import QUICK, SETTINGS, SetupConfig, TumblingConfig

# The name that stands for every set-up.
ALL = "all"


class ValidationConfig(Section):
    """What others measured, predicted without a fit: target `validation`."""

    setups: list[Name] = []
    """set-ups to predict, of config/data/measured.tsv, or `all`; none if left out"""
    quick: bool = False
    """whether set-ups that have a coarse version take it, for a test of the workflow"""
    in_all: bool = False
    """whether the validation is a part of `all`, and so of the report of a run with chapters"""
    measured: ProjectFile = "config/data/measured.tsv"
    """what others measured, with sources"""
    other_codes: ProjectFile = "config/data/other_codes.tsv"
    """power of the same mills by other DEM codes, which the figures show with ours"""
    fixed: ProjectFile = "config/data/fixed_predictions.tsv"
    """when the settings of each set-up were fixed, why again, and their digest"""

    @model_validator(mode="after")
    def _setups_are_known(self) -> "ValidationConfig":
        for name in self.setups:
            if name not in (*SETTINGS, ALL):
                raise ValueError(f"setups: unknown set-up {name!r}; known: {', '.join(SETTINGS)}; {ALL}")
        if twice := first_repeated(self.setups):
            raise ValueError(f"setups: {twice} is named twice")
        return self

    @property
    def chosen(self) -> dict[str, SetupConfig]:
        """The settings of the set-ups to predict, by name."""
        known = SETTINGS | (QUICK if self.quick else {})
        return known if ALL in self.setups else {name: known[name] for name in self.setups}

    @property
    def tumbling(self) -> list[str]:
        """The set-ups to predict that are tumbling mills."""
        return [name for name, setup in self.chosen.items() if isinstance(setup, TumblingConfig)]

    @property
    def mills(self) -> list[str]:
        """The mills of the set-ups to predict."""
        chosen = self.chosen.values()
        return [name for setup in chosen if setup.mill_name for name in (setup.mill_name, *setup.further_mills)]

    @property
    def contacts(self) -> list[str]:
        """The contact sets of the set-ups to predict."""
        return [name for setup in self.chosen.values() for name in setup.contact_names]
