"""The root of config/config.yaml."""

from typing import Any

from pydantic import Field, ValidationInfo, field_validator, model_validator

from millprint.config.calibration import CalibrationConfig
from millprint.config.card import CardsConfig
from millprint.config.claims import ClaimsConfig
from millprint.config.doe import DoeConfig
from millprint.config.dose import DoseConfig
from millprint.config.fingerprint import ConvergenceConfig, FingerprintConfig, InverseConfig, MapsConfig
from millprint.config.fit import FitConfig
from millprint.config.mill_sweep import MillsConfig, MillSweepConfig
from millprint.config.partition import PartitionConfig
from millprint.config.provenance import ProvenanceConfig
from millprint.config.section import Name, ProjectFile, Section, first_repeated
from millprint.config.surrogate import SurrogateConfig
from millprint.config.sweep import DemConfig, SweepConfig
from millprint.config.uncertainty import UncertaintyConfig
from millprint.config.validation import ValidationConfig
from millprint.config.view import ViewConfig
from millprint.config.yields import YieldConfig

# Folders in which no result may be written.
SOURCES = ("config", "envs", "scripts", "src", "tests", "workflow")


class DataConfig(Section):
    """Measured tables, as paths from the project's root."""

    screening: ProjectFile
    """the screening runs with their yields"""
    wear: ProjectFile
    """mass of the balls before and after milling"""
    regimes: ProjectFile
    """the five cases of chapter 4"""
    split: ProjectFile
    """the locked train-test split of the screening runs"""
    claims: ProjectFile
    """numbers and statements of the thesis, with what each is and a tolerance"""
    published: ProjectFile
    """published values shown as marks in figures"""
    verdicts: ProjectFile = "config/data/verdicts_elsewhere.tsv"
    """verdicts of the claims on other machines"""
    conclusions: ProjectFile = "config/data/conclusions.tsv"
    """each chapter's conclusions, and the claims that support them"""


class ChapterSections(Section):
    """The sections that the thesis chapters need; the last three are keys of `fingerprint`."""

    data: DataConfig
    doe: DoeConfig
    calibration: CalibrationConfig
    partition: PartitionConfig
    yields: YieldConfig
    surrogate: SurrogateConfig
    cycle_fill_ratio: float
    maps: MapsConfig
    inverse: InverseConfig


class WorkflowConfig(Section):
    """The complete configuration of a run. Only `mill` is required."""

    name: Name = "run"
    """name of the run, shown in the report"""
    results: str = Field(default="results", pattern=r"^[\w-]+(/[\w-]+)*$")
    """folder for all results"""
    mill: Name
    """the mill of the run: a file in config/mills"""
    contacts: list[Name] = Field(default=["calibrated"], min_length=1)
    """contact sets of the run: files in config/contacts; mills have the first"""
    sweep: MillSweepConfig | None = None
    """conditions of the fingerprint of the mill; if left out, those of the mill's file"""
    dem: DemConfig = DemConfig()
    sweeps: list[SweepConfig] = []
    """blocks of further simulations, which chapters read"""
    convergence: ConvergenceConfig = ConvergenceConfig()
    view: ViewConfig = ViewConfig()
    fingerprint: FingerprintConfig = FingerprintConfig()
    # As if it were given, so that its contact set and its counting rule are filled in.
    mills: MillsConfig = Field(default=MillsConfig(), validate_default=True)
    dose: DoseConfig = DoseConfig()
    uncertainty: UncertaintyConfig = UncertaintyConfig()
    cards: CardsConfig = CardsConfig()
    provenance: ProvenanceConfig = ProvenanceConfig()
    validation: ValidationConfig = ValidationConfig()
    data: DataConfig | None = None
    """measured tables; for the chapters of the thesis"""
    doe: DoeConfig | None = None
    """chapter 2; for the chapters of the thesis"""
    calibration: CalibrationConfig | None = None
    """virtual calibration (Sec. 3.2.2); for the chapters of the thesis"""
    fit: FitConfig | None = None
    """fit to published values; none if left out"""
    partition: PartitionConfig | None = None
    """chapter 4; for the chapters of the thesis"""
    yields: YieldConfig | None = None
    """chapter 5; for the chapters of the thesis"""
    surrogate: SurrogateConfig | None = None
    """chapter 6; for the chapters of the thesis"""
    claims: ClaimsConfig = ClaimsConfig()

    @field_validator("mills")
    @classmethod
    def _balls_and_rule_of_the_run(cls, mills: MillsConfig, info: ValidationInfo) -> MillsConfig:
        contacts, fingerprint = info.data.get("contacts"), info.data.get("fingerprint")
        update = {}
        if mills.contact is None and contacts:
            update["contact"] = contacts[0]
        if mills.counting_rule is None and fingerprint:
            update["counting_rule"] = fingerprint.counting_rule
        return mills.model_copy(update=update)

    @model_validator(mode="after")
    def _nothing_twice_and_nothing_overwritten(self) -> "WorkflowConfig":
        if twice := first_repeated(sweep.name for sweep in self.sweeps):
            raise ValueError(f"sweeps: two have the name {twice}")
        if self.results.split("/")[0] in SOURCES:
            raise ValueError(f"results = {self.results!r}: {self.results.split('/')[0]}/ holds the project's own files")
        return self

    @model_validator(mode="after")
    def _chapters_have_all_their_sections(self) -> "WorkflowConfig":
        parts = self._chapter_parts()
        missing = [key for key, part in parts.items() if part is None]
        # Chapter 3 compares the fit with a table of `data`.
        if missing and (len(missing) < len(parts) or self.fit):
            given = [key for key in parts if key not in missing] + (["fit"] if self.fit else [])
            raise ValueError(
                f"{', '.join(missing)} {'is' if len(missing) == 1 else 'are'} missing: the chapters of the thesis need "
                f"all of their sections, or none of them (given: {', '.join(given)})"
            )
        return self

    def _chapter_parts(self) -> dict[str, Any]:
        """The sections that the chapters need, by their dotted keys; None for one that is left out."""
        keys = ChapterSections.model_fields
        own = {key: getattr(self, key) for key in keys if key in type(self).model_fields}
        return own | {f"fingerprint.{key}": getattr(self.fingerprint, key) for key in keys if key not in own}

    @property
    def chapters(self) -> ChapterSections | None:
        """The sections of the chapters; None for a configuration without chapters."""
        parts = {key.split(".")[-1]: part for key, part in self._chapter_parts().items()}
        return None if any(part is None for part in parts.values()) else ChapterSections(**parts)
