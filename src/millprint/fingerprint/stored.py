"""What the file of a fingerprint must hold, for a refusal in one line of one that is damaged or of something else."""

from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field, NonNegativeFloat, PositiveInt, model_validator

from millprint.config.section import Positive
from millprint.observables.condition import VARIABLES


class _Part(BaseModel):
    model_config = ConfigDict(extra="ignore", frozen=True, allow_inf_nan=False)


class StoredValues(_Part):
    """What was simulated in n conditions."""

    values: list[Positive]
    relative_errors: list[Annotated[float, Field(ge=0, le=1e3)]]
    seeds: list[PositiveInt] | None = None

    @property
    def counts(self) -> set[int]:
        """The numbers of conditions, one if the lists are as long as each other."""
        return {len(each) for each in (self.values, self.relative_errors, self.seeds) if each is not None}


class StoredProcess(StoredValues):
    """A process of n conditions, as `Process.to_dict`; apart: of those of no_impacts."""

    components: dict[str, list[str]]
    log_parameters: list[float]
    noise_variance: NonNegativeFloat
    sampling: tuple[float, float]
    stretch: Annotated[float, Field(ge=1)]
    apart: StoredValues | None = None


class About(_Part):
    """The data of a mill in every fingerprint; ranges and settings by the names of VARIABLES."""

    mill: str
    contact: str
    volume_m3: Positive
    density_kg_m3: Positive
    amplitude_m: Positive
    probability: Annotated[float, Field(gt=0, lt=1)]
    ranges: dict[str, tuple[Positive, Positive]]
    settings: dict[str, list[Positive | str]]
    kinds: list[str] = []
    charges: dict[str, dict[str, Positive | list[Positive]]] = {}
    no_curve: dict[str, str] = {}


class StoredFingerprint(_Part):
    """The parts of a file that a prediction needs."""

    about: About
    inputs: dict[str, list[Positive | str]]
    no_impacts: dict[str, list[Positive | str]] = {}
    processes: dict[str, StoredProcess]

    @model_validator(mode="after")
    def _as_many_as_conditions(self) -> "StoredFingerprint":
        if self.no_impacts and {*self.no_impacts} != {*self.inputs}:
            raise ValueError("no_impacts: must have the variables of inputs")
        if len({len(own) for own in self.no_impacts.values()}) > 1:
            raise ValueError("no_impacts: must have as many of each variable")
        conditions, still = ({len(own) for own in each.values()} for each in (self.inputs, self.no_impacts))
        for name, own in self.processes.items():
            if own.counts != conditions:
                raise ValueError(f"processes.{name}: must have a number for each of the conditions of inputs")
            if own.apart and own.apart.counts != still:
                raise ValueError(f"processes.{name}.apart: must have a number for each of those of no_impacts")
            if len(own.log_parameters) != len(own.components) * (1 + len(self.inputs)):
                raise ValueError(f"processes.{name}.log_parameters: are not those of its components")
        if len({len(own) for own in self.about.settings.values()}) != 1:
            raise ValueError("about.settings: must have as many of each variable")
        if missing := [name for name in VARIABLES if name not in self.inputs or name not in self.about.ranges]:
            raise ValueError(f"inputs.{missing[0]}: this key is missing, or its range")
        return self
