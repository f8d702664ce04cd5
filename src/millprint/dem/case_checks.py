"""Checks of cases before the first job: shapes of mills, balls that fit, time steps and costs."""

import math
from collections.abc import Iterable
from typing import cast

import numpy as np

from millprint.config.charge import BallMixture
from millprint.config.contact_set import ContactConfig
from millprint.config.errors import ConfigError, SimulationError
from millprint.config.mill import MillConfig
from millprint.config.sweep import Case, ball_count
from millprint.config.workflow import WorkflowConfig
from millprint.dem.laws.registry import law_of, step_scale
from millprint.dem.packing import capacity, pack_mixture, room_in_words, widest_ball, widest_in_mm
from millprint.dem.resources import (
    LIKELY_BALL_STEP_S,
    OCCUPANCY_CELL_M,
    SNAPSHOT_COLUMNS,
    ball_steps,
    check_cohesion,
    largest_fraction,
    requested_step,
)
from millprint.mill.bodies import Body, build_bodies, check_inserts, check_volume, inserts_in_vessel
from millprint.mill.vessel import Vessel
from millprint.run.numbers import do_not_fit

MOST_DAYS = 60
# Bytes of energies, snapshots and the grid of occupancy, which stay in memory until the end.
MOST_BYTES = 32e9
# Numbers in a row of the energy ledger, and in a cell of the grid of occupancy.
LEDGER_COLUMNS, OCCUPANCY_COLUMNS = 16, 5
# Largest number of sites for the balls at the start.
MOST_SITES = 5e6


def sites_of(vessel: Vessel, diameter_m: float) -> float:
    """About how many balls a hexagonal close packing over the vessel's bounding box has: sqrt(2) V / d^3."""
    low, high = vessel.bounds
    return math.sqrt(2) * float(np.prod((high - low) / diameter_m))


def recorded_bytes(case: Case, vessel: Vessel, balls: int, sample_s: float) -> float:
    """Bytes in memory that a case records, to an order of magnitude; sample_s: time between energy samples [s]."""
    # A window holds at least one sample, even in a slow mill.
    window = max(case.window_s, case.window_max_s or 0.0, sample_s)
    low, high = vessel.bounds
    values = window / sample_s * LEDGER_COLUMNS
    values += float(np.prod((high - low)[:2] / OCCUPANCY_CELL_M + 1)) * OCCUPANCY_COLUMNS
    if case.snapshot_interval_s:
        values += window / case.snapshot_interval_s * balls * SNAPSHOT_COLUMNS
    return 8 * values


def fills_of_media(cases: Iterable[Case]) -> dict[tuple[str, float], set[float]]:
    """Fill ratios of each mill and ball diameter [m], of charges of one size."""
    fills: dict[tuple[str, float], set[float]] = {}
    for case in cases:
        if case.mixture:
            continue
        fills.setdefault((case.mill, case.ball_diameter_m), set()).add(case.fill_ratio)
    return dict(sorted(fills.items()))


def check_room(cases: Iterable[Case], mills: dict[str, MillConfig], bodies: dict[str, list[Body]], place: str) -> None:
    """Check that the balls of every case fit into its mill without overlap, and that there is at least one.

    place: file and key that define the cases.
    """
    for (name, diameter), fills in fills_of_media(cases).items():
        vessel, volume = bodies[name][0].vessel, mills[name].volume_ml * 1e-6
        share = math.pi / 6 * diameter**3 / volume
        enough = ball_count(max(fills), volume, diameter)
        inserts = inserts_in_vessel(bodies[name])
        most = capacity(vessel, diameter, inserts=inserts, enough=enough)
        for fill in sorted(fills):
            balls = ball_count(fill, volume, diameter)
            what, size = f"{place}: fill_ratios = {fill:g}", f"of {1e3 * diameter:g} mm"
            # Also where the fill ratio is less than one ball: no other makes it fit.
            if balls > most or (balls < 1 and diameter > widest_ball(vessel, inserts)):
                room = room_in_words(vessel, diameter, volume, inserts, most)
                if not most:
                    room += f"; {_size_in_words(mills[name], vessel)}"
                raise ConfigError(f"{what}: {do_not_fit(balls, size)} in mill {name}: {room}")
            if balls < 1:
                raise ConfigError(f"{what}: no ball {size} in mill {name}; one ball needs at least {share:.2g}")


def check_mixtures(
    cases: Iterable[Case], mills: dict[str, MillConfig], bodies: dict[str, list[Body]], place: str
) -> None:
    """Check that every charge of several sizes has a ball of each, and that they fit into its mill.

    place: file and key that define the cases.
    """
    for case in {(case.mill, case.mixture, case.fill_ratio): case for case in cases if case.mixture}.values():
        mixture = cast(BallMixture, case.mixture)
        volume = mills[case.mill].volume_ml * 1e-6
        counts = mixture.counts(ball_count(case.fill_ratio, volume, case.ball_diameter_m))
        what = f"{place}: fill_ratios = {case.fill_ratio:g}: of charge {mixture.name}"
        if min(counts) < 1:
            rarest = mixture.sizes_mm[counts.index(min(counts))]
            raise ConfigError(f"{what}, mill {case.mill} has no ball of {rarest:g} mm; raise the fill ratio")
        inserts = inserts_in_vessel(bodies[case.mill])
        try:
            pack_mixture(bodies[case.mill][0].vessel, np.array(mixture.sizes_mm) / 1e3, counts, case.seed, inserts)
        except SimulationError as error:
            raise ConfigError(f"{what} in mill {case.mill}, {error}") from None


def checked_bodies(mills: dict[str, MillConfig]) -> dict[str, list[Body]]:
    """The bodies of every mill. Raises ConfigError with a line for each mill whose geometry or volume is not valid."""
    bodies, faults = {}, []
    for name, mill in mills.items():
        try:
            bodies[name] = build_bodies(mill)
            check_volume(mill, bodies[name][0].vessel)
            check_inserts(mill, bodies[name])
        except ConfigError as error:
            faults.append(str(error))
    if faults:
        raise ConfigError("\n".join(faults))
    return bodies


def _size_in_words(mill: MillConfig, vessel: Vessel) -> str:
    """How large the vessel of a mill is, and what to correct where that is not so."""
    shape, cure = mill.geometry.origin()
    sides = " x ".join(f"{1e3 * side:.4g}" for side in np.ptp(vessel.bounds, axis=0))
    return f"{shape} is {sides} mm; if it is not so, correct {cure}"


def check_ball_size(vessel: Vessel, mill: MillConfig, diameter_m: float, place: str) -> None:
    """Check that a ball fits between the walls, and that not too many of them are needed."""
    if diameter_m > float(np.ptp(vessel.bounds, axis=0).min()):
        raise ConfigError(
            f"{place}: ball_diameters_mm = {1e3 * diameter_m:g}: a ball of that size does not fit in mill {mill.name}; "
            f"at most {widest_in_mm(vessel)}; {_size_in_words(mill, vessel)}"
        )
    sites = sites_of(vessel, diameter_m)
    if sites > MOST_SITES:
        smallest = 1e3 * diameter_m * (sites / MOST_SITES) ** (1 / 3)
        raise ConfigError(
            f"{place}: ball_diameters_mm = {1e3 * diameter_m:g}: too small to simulate, {sites:.2g} of them "
            f"have room in mill {mill.name}; at least {smallest:.3g} mm"
        )


def check_step_and_cost(
    config: WorkflowConfig,
    mill: MillConfig,
    contact: ContactConfig,
    case: Case,
    bodies: list[Body],
    told: tuple[str, str, str],
) -> None:
    """Check that a case has a small enough time step, ends in a reasonable time and fits into the memory of a machine.

    contact: the set as the case runs it. told: the file of the configuration, file and section of the case, and file
    and key of its step as a fraction of the law's scale, for messages. The largest step is a fraction of this time.
    """
    source, place, fraction = told
    scale = step_scale(contact, min(case.sizes_m) / 2)
    largest = largest_fraction(case, config.dem)
    step = requested_step(case, config.dem, scale)
    # With a tolerance, so that the largest fraction itself passes.
    if step > largest * scale * (1 + 1e-12):
        if case.rayleigh_fraction is not None:
            raise ConfigError(
                f"{fraction} = {case.rayleigh_fraction:g}: at most dem.rayleigh_fraction_max = {largest:g}"
            )
        key = f"{source}: dem.time_step_s" if case.time_step_s is None else f"{place}: time_steps_s"
        raise ConfigError(
            f"{key} = {step:g}: more than {largest:g} of {law_of(contact).scale_title} of case {case.path}; "
            f"at most {largest * scale:.2g} s"
        )
    try:
        check_cohesion(contact, [size / 2 for size in case.sizes_m], config.dem.overlap_max)
    except SimulationError as error:
        raise ConfigError(str(error)) from None
    frequency = max(body.motion.frequency_hz for body in bodies) * case.speed_hz
    balls = ball_count(case.fill_ratio, mill.volume_ml * 1e-6, case.ball_diameter_m)
    days = ball_steps(case, config.dem, contact, balls)[1] * LIKELY_BALL_STEP_S / 86_400
    sample = (1 / frequency if frequency else case.window_s) / config.dem.ledger_samples_per_revolution
    size = recorded_bytes(case, bodies[0].vessel, balls, sample)
    if days > MOST_DAYS:
        raise ConfigError(
            f"{place}: case {case.path} would take about {days:.2g} days on one core (limit {MOST_DAYS}); "
            "look at its speed, its durations, its balls, time_step_s and snapshot_interval_s"
        )
    if size > MOST_BYTES:
        raise ConfigError(
            f"{place}: case {case.path} would record about {size / 1e9:.2g} GB (limit {MOST_BYTES / 1e9:g}); "
            "look at snapshot_interval_s, window_s and the size of the mill"
        )
