"""What is checked once before the first job: tables, the shapes of mills, balls that fit, steps that are stable."""

import math

from millprint.calibration.preflight import calibration_faults
from millprint.config.contact import ContactConfig
from millprint.config.mill import MillConfig
from millprint.config.override import overridden
from millprint.config.surrogate import check_surrogate_cases
from millprint.config.sweep import Case, ball_count
from millprint.config.workflow import WorkflowConfig
from millprint.dem.packing import capacity
from millprint.dem.timestep import largest_fraction, rayleigh_time, wanted_step
from millprint.doe.literature import read_literature, read_reported_yields
from millprint.doe.runs import read_runs
from millprint.doe.wear import read_wear
from millprint.errors import ConfigError
from millprint.fingerprint.preflight import fingerprint_faults
from millprint.fingerprint.regimes import read_regimes
from millprint.fit.preflight import fit_faults
from millprint.mill.bodies import CHECK_RPM, Body, build_bodies, check_inserts, inserts_in_vessel
from millprint.mill.vessel import Vessel
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
    bodies = checked_bodies(mills)
    media = sorted({(case.mill, case.ball_diameter_mm) for case in cases.values()})
    for name, diameter in media:
        vessel = bodies[name][0].vessel
        check_ball_size(vessel, name, diameter, source)
        most = capacity(vessel, diameter / 1000, inserts=inserts_in_vessel(bodies[name]))
        for fill in sorted({case.fill_ratio for case in cases.values() if case.ball_diameter_mm == diameter}):
            check_fill(mills[name], diameter, fill, most, source)
    for case in cases.values():
        try:
            _, contact = overridden(case, mills[case.mill], contacts[case.contact])
        except ConfigError as error:
            raise ConfigError(f"{source}: {error}") from None
        check_step(config, contact, case, source)
    check_movie(config, source)
    check_surrogate_cases(config.surrogate, cases, source)
    faults = [
        *fingerprint_faults(config, cases, source),
        *calibration_faults(config, mills, contacts),
        *fit_faults(config, mills, source),
    ]
    if faults:
        raise ConfigError("\n".join(faults))


def checked_bodies(mills: dict[str, MillConfig]) -> dict[str, list[Body]]:
    """The bodies of every mill. Raises ConfigError, a line for each mill whose geometry does not hold."""
    bodies, faults = {}, []
    for name, mill in mills.items():
        try:
            bodies[name] = build_bodies(mill, CHECK_RPM)
            check_inserts(mill, bodies[name])
        except ConfigError as error:
            faults.append(str(error))
    if faults:
        raise ConfigError("\n".join(faults))
    return bodies


def check_tables(config: WorkflowConfig, source: str) -> None:
    """Read every measured table once."""
    read_runs(config.data.screening, config.doe, positive=["bpr", "molar_ratio"])
    read_wear(config.data.wear)
    read_literature(config.doe.literature)
    read_reported_yields(config.doe.literature_yields)
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


def check_movie(config: WorkflowConfig, source: str) -> None:
    """What is shown in the report's animation must record snapshots."""
    for sweep in config.sweeps:
        if sweep.name == "movie" and sweep.snapshot_interval_s is None:
            raise ConfigError(
                f"{source}: sweeps.movie.snapshot_interval_s: this key is missing; an animation is made of snapshots"
            )


def check_step(config: WorkflowConfig, contact: ContactConfig, case: Case, source: str) -> None:
    """The integration step must resolve a contact of the set as the case runs it: a fraction of the Rayleigh time."""
    stiffness = contact.young_modulus_gpa * 1e9
    rayleigh = rayleigh_time(case.ball_diameter_mm / 2000, contact.density_kg_m3, stiffness, contact.poisson_ratio)
    largest = largest_fraction(case, config.dem)
    step = wanted_step(case, config.dem, rayleigh)
    # A fraction that is given as the largest itself must pass.
    if step <= largest * rayleigh * (1 + 1e-12):
        return
    if case.rayleigh_fraction is not None:
        raise ConfigError(
            f"{source}: sweeps: rayleigh_fraction = {case.rayleigh_fraction:g}: at most "
            f"dem.rayleigh_fraction_max = {largest:g}"
        )
    key = "dem.time_step_s" if case.time_step_s is None else "sweeps: time_steps_s"
    raise ConfigError(
        f"{source}: {key} = {step:g}: more than {largest:g} of the Rayleigh time of case {case.path}; "
        f"at most {largest * rayleigh:.2g} s"
    )
