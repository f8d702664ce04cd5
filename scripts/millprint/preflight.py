"""What is checked once before the first job: tables, the shapes of mills, balls that fit, steps that are stable."""

import math
from collections.abc import Iterable

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
from millprint.fingerprint.mill_cases import mill_cases
from millprint.fingerprint.preflight import fingerprint_faults, has_chapters
from millprint.fingerprint.regimes import read_regimes
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
    bodies = checked_bodies(mills)
    swept = own_sweeps(config, mills)
    for name, own in swept.items():
        check_room(own, mills, bodies, f"config/mills/{name}.yaml: sweep")
    check_room(cases.values(), mills, bodies, f"{source}: sweeps")
    for case in [*cases.values(), *(case for own in swept.values() for case in own)]:
        try:
            _, contact = overridden(case, mills[case.mill], contacts[case.contact])
        except ConfigError as error:
            raise ConfigError(f"{source}: {error}") from None
        check_step(config, contact, case, source)
    check_movie(config, source)
    faults = fingerprint_faults(config, cases, source)
    # The chapters are about the mill of the sweeps; a run of another mill has none.
    if has_chapters(config, cases):
        check_tables(config, source)
        check_surrogate_cases(config.surrogate, cases, source)
        faults += calibration_faults(config, mills, contacts)
    if faults:
        raise ConfigError("\n".join(faults))


def own_sweeps(config: WorkflowConfig, mills: dict[str, MillConfig]) -> dict[str, list[Case]]:
    """The cases of every mill's own sweep, of those that the targets of results/mills can ask for."""
    return {name: mill_cases(mills[name], config.mills) for name in dict.fromkeys([config.mill, *config.mills.named])}


def check_room(cases: Iterable[Case], mills: dict[str, MillConfig], bodies: dict[str, list[Body]], place: str) -> None:
    """The balls of every case must fit into its mill; place: file and key that the cases come from."""
    fills: dict[tuple[str, float], set[float]] = {}
    for case in cases:
        fills.setdefault((case.mill, case.ball_diameter_mm), set()).add(case.fill_ratio)
    for (name, diameter), wanted in sorted(fills.items()):
        vessel, volume = bodies[name][0].vessel, mills[name].volume_ml * 1e-6
        check_ball_size(vessel, name, diameter, place)
        enough = ball_count(max(wanted), volume, diameter / 1000)
        most = capacity(vessel, diameter / 1000, inserts=inserts_in_vessel(bodies[name]), enough=enough)
        for fill in sorted(wanted):
            check_fill(mills[name], diameter, fill, most, place)


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


def check_ball_size(vessel: Vessel, mill: str, diameter_mm: float, place: str) -> None:
    """A ball must fit between the walls."""
    low, high = vessel.bounds
    widest = 1000 * float((high - low).min())
    if diameter_mm > widest:
        raise ConfigError(
            f"{place}: ball_diameters_mm = {diameter_mm:g}: a ball of that size does not fit in mill {mill}; "
            f"at most {widest:.3g} mm"
        )


def check_fill(mill: MillConfig, diameter_mm: float, fill: float, most: int, place: str) -> None:
    """The balls of a fill ratio must fit without overlap (`most` of them do), and there must be one at least."""
    volume = mill.volume_ml * 1e-6
    balls = ball_count(fill, volume, diameter_mm / 1000)
    ball_volume = math.pi / 6 * (diameter_mm / 1000) ** 3
    place = f"{place}: fill_ratios = {fill:g}: {balls} balls of {diameter_mm:g} mm"
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
