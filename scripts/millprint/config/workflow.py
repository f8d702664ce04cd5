"""The root of config/config.yaml."""

from pydantic import Field, model_validator

from millprint.config.calibration import CalibrationConfig
from millprint.config.convergence import ConvergenceConfig
from millprint.config.doe import DoeConfig
from millprint.config.fingerprint import FingerprintConfig
from millprint.config.fit import FitConfig
from millprint.config.mill_sweep import MillsConfig
from millprint.config.partition import PartitionConfig
from millprint.config.section import Name, ProjectFile, Section
from millprint.config.surrogate import SurrogateConfig
from millprint.config.sweep import DemConfig, SweepConfig
from millprint.config.view import ViewConfig
from millprint.config.yields import YieldConfig

# Folders that no result may be written into.
SOURCES = ("config", "envs", "scripts", "tests", "workflow")


class DataConfig(Section):
    """Measured tables, as paths from the project's root."""

    screening: ProjectFile = Field(description="the screening runs with their yields")
    wear: ProjectFile = Field(description="mass of the balls before and after milling")
    regimes: ProjectFile = Field(description="the five cases of chapter 4")
    split: ProjectFile = Field(description="the locked train-test split of the screening runs")
    claims: ProjectFile = Field(description="every number the thesis states, with a tolerance")
    published: ProjectFile = Field(description="published values shown as marks in figures")


class WorkflowConfig(Section):
    """Everything that a run of the pipeline can be told."""

    name: Name = Field(description="name of the run, shown in the report")
    results: str = Field(pattern=r"^[\w-]+(/[\w-]+)*$", description="folder that everything is written to")
    mill: Name = Field(description="the mill of the run: a file in config/mills")
    contacts: list[Name] = Field(min_length=1, description="contact sets of the run: files in config/contacts")
    data: DataConfig
    doe: DoeConfig
    dem: DemConfig
    sweeps: list[SweepConfig] = Field(min_length=1, description="blocks of simulations")
    convergence: ConvergenceConfig = ConvergenceConfig()
    view: ViewConfig
    calibration: CalibrationConfig
    fingerprint: FingerprintConfig
    mills: MillsConfig
    fit: FitConfig | None = Field(default=None, description="what was fitted to published values; none if left out")
    partition: PartitionConfig
    yields: YieldConfig
    surrogate: SurrogateConfig

    @model_validator(mode="after")
    def _nothing_twice_and_nothing_overwritten(self) -> "WorkflowConfig":
        names = [sweep.name for sweep in self.sweeps]
        twice = next((name for name in names if names.count(name) > 1), None)
        if twice:
            raise ValueError(f"sweeps: two have the name {twice}")
        if self.results.split("/")[0] in SOURCES:
            raise ValueError(f"results = {self.results!r}: {self.results.split('/')[0]}/ holds the project's own files")
        return self
