"""The engine of the simulations: millprint's own kernel, or LAMMPS on many cores."""

from collections.abc import Iterable
from typing import Annotated, Any, Literal

from pydantic import Field, SerializerFunctionWrapHandler, model_serializer

from millprint.config.errors import ConfigError
from millprint.config.section import Section
from millprint.config.sweep import DemConfig


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
    *("run_dem_case", "tabulate_simulations", "simulations", "draw_mill", "derive_sweep"),
    *("compile_kernels", "build_gallery", "write_crate", "gallery", "crate"),
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
