"""What is checked once before the first job: measured tables, balls that fit, steps that are stable."""

import math

from millprint.config.contact import ContactConfig
from millprint.config.mill import MillConfig
from millprint.config.surrogate import check_surrogate_cases
from millprint.config.sweep import Case, ball_count
from millprint.config.workflow import WorkflowConfig
from millprint.dem.packing import capacity
from millprint.dem.timestep import rayleigh_time
from millprint.doe.literature import read_literature
from millprint.doe.runs import read_runs
from millprint.doe.wear import read_wear
from millprint.errors import ConfigError
from millprint.fingerprint.preflight import fingerprint_faults
from millprint.fingerprint.regimes import read_regimes
from millprint.mill.vessel import Vessel, build_vessel
from millprint.predict.region import check_region
from millprint.predict.tables import check_yield_tables


def check_before_running(
    config: WorkflowConfig,
    mills: dict[str, MillConfig],
    contacts: dict[str, ContactConfig],
    cases: dict[str, Case],
    source: str,
) -> None:
    """Raise ConfigError, a line for each fault, for the first part in which something would make a job fail."""
    check_tables(config, source)
    vessels = {name: build_vessel(mill) for name, mill in mills.items()}
    media = sorted({(case.mill, case.ball_diameter_mm) for case in cases.values()})
    for name, diameter in media:
        check_ball_size(vessels[name], name, diameter, source)
        most = capacity(vessels[name], diameter / 1000)
        for fill in sorted({case.fill_ratio for case in cases.values() if case.ball_diameter_mm == diameter}):
            check_fill(mills[name], diameter, fill, most, source)
    for case in cases.values():
        check_step(config, contacts[case.contact], case, source)
    check_surrogate_cases(config.surrogate, cases, source)
    faults = fingerprint_faults(config, cases, source)
    if faults:
        raise ConfigError("\n".join(faults))


def check_tables(config: WorkflowConfig, source: str) -> None:
    """Read every measured table once."""
    read_runs(config.data.screening, config.doe, positive=["bpr", "molar_ratio"])
    read_wear(config.data.wear)
    read_literature(config.doe.literature)
    check_yield_tables(config.yields, config.data.screening, config.data.split, config.doe, source)
    regimes = read_regimes(config.data.regimes)
    if config.yields.proposals.curves == "published":
        check_region(config.yields.proposals.region, regimes, source)


def check_ball_size(vessel: Vessel, mill: str, diameter_mm: float, source: str) -> None:
    """A ball must fit between the walls."""
    low, high = vessel.bounds
    widest = 1000 * float((high - low).min())
    if diameter_mm > widest:
        raise ConfigError(
            f"{source}: sweeps: ball_diameters_mm = {diameter_mm:g}: a ball of that size does not fit in mill {mill}; "
            f"at most {widest:.3g} mm"
        )


def check_fill(mill: MillConfig, diameter_mm: float, fill: float, most: int, source: str) -> None:
    """The balls of a fill ratio must fit without overlap (`most` of them do), and there must be one at least."""
    volume = mill.volume_ml * 1e-6
    balls = ball_count(fill, volume, diameter_mm / 1000)
    ball_volume = math.pi / 6 * (diameter_mm / 1000) ** 3
    place = f"{source}: sweeps: fill_ratios = {fill:g}: {balls} balls of {diameter_mm:g} mm"
    if balls > most:
        raise ConfigError(f"{place} do not fit in mill {mill.name}; at most {most * ball_volume / volume:.2g}")
    if balls < 1:
        raise ConfigError(f"{place} in mill {mill.name}; one ball needs at least {ball_volume / volume:.2g}")


def check_step(config: WorkflowConfig, contact: ContactConfig, case: Case, source: str) -> None:
    """The integration step must resolve a contact: at most a fraction of the Rayleigh time."""
    largest = config.dem.rayleigh_fraction_max
    if case.rayleigh_fraction is not None:
        if case.rayleigh_fraction > largest:
            raise ConfigError(
                f"{source}: sweeps: rayleigh_fraction = {case.rayleigh_fraction:g}: at most "
                f"dem.rayleigh_fraction_max = {largest:g}"
            )
        return
    modulus = case.young_modulus_gpa or contact.young_modulus_gpa
    rayleigh = rayleigh_time(case.ball_diameter_mm / 2000, contact.density_kg_m3, modulus * 1e9, contact.poisson_ratio)
    if config.dem.time_step_s > largest * rayleigh:
        raise ConfigError(
            f"{source}: dem.time_step_s = {config.dem.time_step_s:g}: more than {largest:g} of the Rayleigh time of "
            f"case {case.path}; at most {largest * rayleigh:.2g} s"
        )
