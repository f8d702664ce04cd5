"""The section `validation`: set-ups that others measured, and the settings of each prediction.

The settings of a set-up are fixed before the prediction is compared with the measured values: `python
tools/fix_predictions.py` records their digest and the date. To add a set-up, write a section with its defaults in
millprint/config/setups and a record in millprint/validation/setups.py, and name the section here as the record.
"""

from pydantic import model_validator

from millprint.config.section import Name, ProjectFile, Section, first_repeated
from millprint.config.setups.base import SetupConfig
from millprint.config.setups.drum_setups import BeadDrumConfig, ReposeDrumConfig
from millprint.config.setups.impact_setups import AluminaImpactConfig, ElasticImpactConfig
from millprint.config.setups.shaker import ShakerConfig
from millprint.config.setups.tumbling_setups import BondMillConfig, DrumConfig, SliceMillConfig, TumblingConfig
from millprint.config.sweep import Case, DemConfig, expand_sweep

# The name that stands for every set-up.
ALL = "all"


class ValidationConfig(Section):
    """What others measured, predicted without a fit: target `validation`."""

    setups: list[Name] = []
    """set-ups to predict: names of the sections below, or `all`; none if left out"""
    in_all: bool = False
    """whether the validation is a part of `all`, and so of the report of a run with chapters"""
    measured: ProjectFile = "config/data/measured.tsv"
    """what others measured, with sources"""
    other_codes: ProjectFile = "config/data/other_codes.tsv"
    """power of the same mills by other DEM codes, which the figures show with ours"""
    fixed: ProjectFile = "config/data/fixed_predictions.tsv"
    """when the settings of each set-up were fixed, why again, and their digest"""
    alumina_impact: AluminaImpactConfig = AluminaImpactConfig()
    elastic_impact: ElasticImpactConfig = ElasticImpactConfig()
    slice_mill: SliceMillConfig = SliceMillConfig()
    drum_90cm: DrumConfig = DrumConfig()
    bond_mill: BondMillConfig = BondMillConfig()
    spex_shaker: ShakerConfig = ShakerConfig()
    bead_drum: BeadDrumConfig = BeadDrumConfig()
    repose_drum: ReposeDrumConfig = ReposeDrumConfig()

    @model_validator(mode="after")
    def _setups_are_known(self) -> "ValidationConfig":
        known = self.all_setups
        for name in self.setups:
            if name not in (*known, ALL):
                raise ValueError(f"setups: unknown set-up {name!r}; known: {', '.join(known)}; {ALL}")
        if twice := first_repeated(self.setups):
            raise ValueError(f"setups: {twice} is named twice")
        return self

    @property
    def all_setups(self) -> dict[str, SetupConfig]:
        """The settings of every set-up by name."""
        sections = {name: getattr(self, name) for name in type(self).model_fields}
        return {name: section for name, section in sections.items() if isinstance(section, SetupConfig)}

    @property
    def chosen(self) -> dict[str, SetupConfig]:
        """The settings of the set-ups to predict, by name."""
        known = self.all_setups
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


def setup_cases(setup: SetupConfig, dem: DemConfig) -> dict[str, Case]:
    """The simulations of a set-up in results/dem, by path. Raises ValueError for a sweep that names no mill."""
    cases = {}
    for sweep in setup.sweeps:
        if not sweep.mills:
            raise ValueError(f"sweep {sweep.name} of a set-up names no mill")
        cases.update({case.path: case for case in expand_sweep(sweep, dem, sweep.mills[0])})
    return cases
