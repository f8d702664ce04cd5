"""The root of config/config.yaml, and its small sections, such as the engine of the simulations."""

from collections.abc import Iterable, Mapping
from typing import Annotated, Any, ClassVar, Literal, NamedTuple

from pydantic import (
    Field,
    SerializerFunctionWrapHandler,
    ValidationInfo,
    field_validator,
    model_serializer,
    model_validator,
)

from millprint.config.calibration import CalibrationConfig, FitConfig
from millprint.config.card import CardsConfig
from millprint.config.doe import DoeConfig
from millprint.config.dose import DoseConfig
from millprint.config.errors import ConfigError
from millprint.config.fingerprint import (
    ConvergenceConfig,
    FingerprintConfig,
    InverseConfig,
    MapsConfig,
    UncertaintyConfig,
)
from millprint.config.mill_sweep import MillsConfig, MillSweepConfig
from millprint.config.section import Fraction, Name, ProjectFile, Section, first_repeated
from millprint.config.setup_models import QUICK, SETTINGS, SetupConfig, TumblingConfig
from millprint.config.surrogate import SurrogateConfig
from millprint.config.sweep import DemConfig, SweepConfig
from millprint.config.view import ViewConfig
from millprint.config.yields import YieldConfig

# Mills of each kind that no model sees, and the seeds of their draws: the last are held out; those before them were
# asked of an earlier model, and train the next.
HELD_OUT_MILLS = 100
DRAWS = {
    "planetary": (20_261, 20_281, 20_282, 20_291, 20_311, 20_321),
    "mixer": (20_261, 20_281, 20_282, 20_283, 20_291),
    "drum": (20_281, 20_291, 20_301, 20_311),
    "spex": (20_261, 20_281, 20_282, 20_283, 20_291),
}
Simulations = Annotated[int, Field(ge=0, le=5000)]


class AtlasConfig(Section):
    """The simulations of the atlas of mills: target `atlas`. The held-out mills, 100 of a kind, come on top.

    The defaults are those of the included atlas.
    """

    planetary: Simulations = 5000
    """rows of the design of planetary mills; those that teach something are simulated; 0 for none of the kind"""
    mixer: Simulations = 2025
    """of mixer mills"""
    drum: Simulations = 2100
    """of tumbling drums"""
    spex: Simulations = 800
    """of shakers like the SPEX 8000"""

    @property
    def kinds(self) -> dict[str, int]:
        """The kinds that are made, with their simulations."""
        return {name: count for name, count in self if count}

    @property
    def parts(self) -> dict[tuple[str, str], int]:
        """Rows of every kind and part of the design."""
        return {
            (kind, part): count
            for kind, simulations in self.kinds.items()
            for part, count in {
                "training": simulations,
                **{f"asked_{draw}": HELD_OUT_MILLS for draw in range(1, len(DRAWS[kind]))},
                "held_out": HELD_OUT_MILLS,
            }.items()
        }

    def batches(self, size: int) -> dict[tuple[str, str, int], tuple[int, int]]:
        """First row and number of rows of every batch of at most `size`, by kind, part and number of the batch."""
        return {
            (*part, place): (first, min(size, count - first))
            for part, count in self.parts.items()
            for place, first in enumerate(range(0, count, size))
        }


class LammpsConfig(Section):
    """How LAMMPS is run."""

    command: Annotated[str, Field(min_length=1)] = "lmp"
    """the program, with further words if it needs any"""
    ranks: Annotated[int, Field(ge=1, le=100_000)] = 1
    """processes of one simulation; with more than one, `mpirun` starts them [-]"""


class EngineConfig(DemConfig):
    """Settings of every simulation unless a sweep overrides them."""

    engine: Literal["numba", "lammps"] = "numba"
    """what simulates: `numba`, millprint's own kernel, or `lammps`"""
    lammps: LammpsConfig = LammpsConfig()

    @model_serializer(mode="wrap")
    def _own_kernel_as_before(self, handler: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """Dumps without the engine where it is millprint's own, so that no simulation runs again for these keys."""
        dumped = handler(self)
        return dumped if self.engine == "lammps" else {key: dumped[key] for key in dumped if key in OWN_KEYS}


OWN_KEYS = set(DemConfig.model_fields)

# Jobs that read a simulation of LAMMPS, or none.
JOBS_OF_LAMMPS = {
    *("run_dem_case", "simulations", "draw_mill", "derive_sweep"),
    *("compile_kernels", "gallery", "write_crate", "crate"),
}


def check_jobs(engine: str, rules: Iterable[str]) -> None:
    """Raise ConfigError, in one line, where a run asks for more than the engine gives."""
    refused = [rule for rule in dict.fromkeys(rules) if rule not in JOBS_OF_LAMMPS]
    if engine == "lammps" and refused:
        more = f" and {len(refused) - 1} more" if len(refused) > 1 else ""
        raise ConfigError(
            f"dem.engine = lammps: the job {refused[0]}{more} needs collisions with walls and their energies, which "
            "LAMMPS does not give; take the target simulations, or dem.engine: numba"
        )


class ClaimsConfig(Section):
    """Intervals of the claims that depend on chance."""

    draws: Annotated[int, Field(ge=2, le=100_000)] = 200
    """times that the simulations of chapter 3 are drawn again from their own windows [-]"""
    # Level of the intervals that decide the verdicts [-].
    level: ClassVar[float] = 0.95
    # Seed of the draws.
    seed: ClassVar[int] = 0


class Prior(NamedTuple):
    """Earlier work: yield [%], milling time [h], ball-to-powder mass ratio [-], speed of the mill [Hz]."""

    yield_percent: float
    time_h: float
    bpr: float
    speed_hz: float


class PartitionConfig(Section):
    """Settings of the partition stage."""

    # Contact set whose master curves are used.
    contact: ClassVar[str] = "calibrated"
    # Ball diameter of the cases [mm].
    ball_diameter_mm: ClassVar[float] = 10.0
    # Speed of the reference and of the constant-speed cases [rpm].
    reference_speed_rpm: ClassVar[float] = 600.0
    fill_ratios: list[Fraction] = []
    """further fill ratios of equal speed and of equal power"""
    # Molar masses of NaBO2.4H2O and NaBH4 [g/mol].
    borate_molar_mass_g_mol: ClassVar[float] = 137.86
    borohydride_molar_mass_g_mol: ClassVar[float] = 37.83
    # Sizes of the reaction enthalpy and of the Gibbs energy at 298 K, lower heating value of the H2 [kJ per mol NaBH4].
    enthalpy_kJ_mol: ClassVar[float] = 1226.0
    gibbs_kJ_mol: ClassVar[float] = 1510.0
    lower_heating_value_kJ_mol: ClassVar[float] = 2908.0
    # Assumed power of the balls over the plug's, Eq. 4.8 [-], and assumed price, Eq. 4.9 [EUR/kWh].
    plug_efficiency: ClassVar[float] = 0.5
    electricity_price_EUR_kWh: ClassVar[float] = 0.2
    # Probability of the confidence intervals [-].
    interval: ClassVar[float] = 0.95
    # Chen et al. 2017, with which Table 4.3 compares the best case.
    prior: ClassVar[Prior] = Prior(yield_percent=88.0, time_h=20.0, bpr=50.0, speed_hz=20.0)


# The name that stands for every set-up.
ALL = "all"
INCLUDED = "config/data/measured.tsv"


class ValidationConfig(Section):
    """What others measured, predicted without a fit: target `validation`."""

    setups: list[Name] = []
    """set-ups to predict, or `all`; if left out, those of a table of your own in `measured`, and none otherwise"""
    intervals: bool | None = None
    """whether tumbling mills are simulated with several seeds and contact sets, for intervals of the predictions, and
    at further speeds; if left out, only for the included measurements
    """
    quick: bool = False
    """whether set-ups that have a coarse version take it, for a test of the workflow"""
    measured: ProjectFile = INCLUDED
    """what others measured, with sources; or a table of your own"""
    # Power of the same mills by other DEM codes, which the figures show with ours.
    other_codes: ClassVar[str] = "config/data/other_codes.tsv"

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
        chosen = known if ALL in self.setups else {name: known[name] for name in self.setups}
        if self.intervals is False or (self.intervals is None and self.is_own):
            return {name: setup.without_intervals() for name, setup in chosen.items()}
        return chosen

    @property
    def is_own(self) -> bool:
        """Whether the measurements are not the included ones."""
        return not self.measured.endswith(INCLUDED)

    @property
    def tumbling(self) -> list[str]:
        """The set-ups to predict that are tumbling mills."""
        return [name for name, setup in self.chosen.items() if isinstance(setup, TumblingConfig)]

    @property
    def mills(self) -> list[str]:
        """The mills of the set-ups to predict."""
        chosen = self.chosen.values()
        swept = [name for setup in chosen for sweep in setup.sweeps for name in sweep.mills or []]
        return list(dict.fromkeys([*(setup.mill_name for setup in chosen if setup.mill_name), *swept]))

    @property
    def contacts(self) -> list[str]:
        """The contact sets of the set-ups to predict."""
        return [name for setup in self.chosen.values() for name in setup.contact_names]


# The identifier of a person at orcid.org; its last sign may be an X.
ORCID = r"^(|\d{4}-\d{4}-\d{4}-\d{3}[\dX])$"
# A name of the list at spdx.org/licenses, or an address.
LICENCE = r"^(|[A-Za-z0-9.+-]+|https?://\S+)$"


class ProvenanceConfig(Section):
    """What the record of a run, `ro-crate-metadata.json`, says about the person who runs it. No result needs it."""

    agent: Annotated[str, Field(max_length=200)] = ""
    """name of the person who made the run; if it is empty, the record names nobody"""
    orcid: Annotated[str, Field(pattern=ORCID)] = ""
    """ORCID of that person, such as 0000-0002-1825-0097"""
    affiliation: Annotated[str, Field(max_length=200)] = ""
    """institution of that person"""
    licence: Annotated[str, Field(pattern=LICENCE)] = ""
    """licence of the results, a name of spdx.org/licenses such as CC-BY-4.0 or an address; empty: millprint's"""


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
    # Verdicts of the claims on other machines; each chapter's conclusions, and the claims that support them.
    verdicts: ClassVar[str] = "config/data/verdicts_elsewhere.tsv"
    conclusions: ClassVar[str] = "config/data/conclusions.tsv"


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
    also: list[Literal["ablations", "fit", "validation"]] = []
    """targets that are a part of `all` too: `ablations` with their claims; `fit`, the search of the jar, whose shape
    then widens the intervals; `validation`, so that it is in the report of a run with chapters
    """
    contacts: list[Name] = Field(default=["calibrated"], min_length=1)
    """contact sets of the run: files in config/contacts; mills have the first"""
    sweep: MillSweepConfig | None = None
    """conditions of the fingerprint of the mill; if left out, those of the mill's file"""
    dem: EngineConfig = EngineConfig()
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
    atlas: AtlasConfig = AtlasConfig()
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
        if self.chapters is None and (own := sorted({*self.also} - {"validation"})):
            raise ValueError(f"also: {own[0]} is a part of the thesis, whose sections are missing")
        if self.results.split("/")[0] in SOURCES:
            raise ValueError(f"results = {self.results!r}: {self.results.split('/')[0]}/ holds the project's own files")
        return self

    # Before all others: a file that names a mill and a part of the thesis has one fault, not those of the part.
    @model_validator(mode="before")
    @classmethod
    def _chapters_have_all_their_sections(cls, content: Any) -> Any:
        if not isinstance(content, dict):
            return content
        parts = cls._chapter_parts(content)
        missing = [key for key, part in parts.items() if part is None]
        given = [key for key in parts if key not in missing]
        # Two more keys are of the chapters; a stored configuration has the defaults of the second.
        further = {"fit": None, "claims": ClaimsConfig().model_dump()}
        given += [key for key, plain in further.items() if content.get(key) not in (None, plain)]
        if missing and given:
            raise ValueError(
                f"{', '.join(given)} {'belongs' if len(given) == 1 else 'belong'} to the thesis, whose chapters need "
                f"all of their sections, or none; {', '.join(missing)} {'is' if len(missing) == 1 else 'are'} missing: "
                f"delete {'it' if len(given) == 1 else 'them'}, or name no mill, to change the thesis"
            )
        return content

    @classmethod
    def _chapter_parts(cls, values: Mapping[str, Any]) -> dict[str, Any]:
        """The sections that the chapters need, by their dotted keys; None for one that `values` leave out."""
        fingerprint, keys = values.get("fingerprint"), ChapterSections.model_fields
        inner = fingerprint if isinstance(fingerprint, dict) else getattr(fingerprint, "__dict__", {})
        own = {key: values.get(key) for key in keys if key in cls.model_fields}
        return own | {f"fingerprint.{key}": inner.get(key) for key in keys if key not in own}

    @property
    def chapters(self) -> ChapterSections | None:
        """The sections of the chapters; None for a configuration without chapters."""
        parts = {key.split(".")[-1]: part for key, part in self._chapter_parts(vars(self)).items()}
        return None if any(part is None for part in parts.values()) else ChapterSections(**parts)
