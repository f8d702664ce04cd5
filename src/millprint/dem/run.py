"""One case from its description to its files and their summary: powers, collisions by rule, the energy balance."""

import json
import logging
import math
from collections.abc import Callable, Sequence
from contextlib import nullcontext
from pathlib import Path

import numpy as np
import pandas as pd

from millprint.config.contact_set import NOMINAL_SPEED_M_S, PAIR_COEFFICIENTS, ContactConfig
from millprint.config.mill import MillConfig
from millprint.config.sweep import Case, DemConfig
from millprint.dem.advance import use_threads
from millprint.dem.collisions import (
    CHANNELS,
    by_surface,
    collision_statistics,
    collision_table,
    squares_per_turn,
    weighted_statistics,
)
from millprint.dem.laws.registry import law_of
from millprint.dem.ledger import OpenBalanceError, check_balance, ledger_series, ledger_summary
from millprint.dem.recording import Recording, continues, recorded_fraction
from millprint.dem.simulation import GoesOn, Simulation
from millprint.dem.store import write_run
from millprint.dem.turns import (
    FEWEST_BLOCKS,
    NEGLIGIBLE,
    half_width,
    has_impacts,
    is_steady,
    mean_of_turns,
    relative_error,
    scale_of_hits,
)
from millprint.mill.bodies import ball_space_m3, travel_m
from millprint.run.files import write_json
from millprint.run.numbers import counted


def per_revolution(series: pd.DataFrame, samples: int) -> dict[str, list[float]]:
    """Energies of each whole revolution [J], of `samples` samples of the ledger each; tangential is all of it."""
    columns = {
        "normal_J": series["normal_damping_J"],
        "tangential_J": series["tangential_damping_J"] + series["sliding_J"],
        "rolling_J": series["rolling_J"],
        "wall_J": series["wall_work_J"],
    }
    return {name: np.diff(column.to_numpy()[::samples]).tolist() for name, column in columns.items()}


def finite(value: float) -> float | None:
    """A number for JSON, which has no infinity."""
    return value if math.isfinite(value) else None


# A power that rises or falls through a window moves its mean by at most this share of the half-width that is asked for.
UNSTEADY_SHARE = 0.25


def window_goes_on(series: pd.DataFrame, samples: int, largest: float, scale_J: float) -> GoesOn:
    """How a window goes on: to its end where half of the 95 % intervals of the mean powers is at most `largest` [-].

    Of normal and tangential power, of each that is not NEGLIGIBLE, and of all dissipation, over at least FEWEST_BLOCKS
    independent turns; or where no ball hits anything, by scale_J as `has_impacts` has it, since then nothing is to be
    known better. It begins anew where one of them is not steady yet, by UNSTEADY_SHARE.
    """
    energies = per_revolution(series, samples)
    if not has_impacts(energies["normal_J"], scale_J):
        return "end" if len(energies["normal_J"]) >= FEWEST_BLOCKS else "longer"
    parts = {name: np.array(energies[f"{name}_J"]) for name in (*CHANNELS, "rolling")}
    whole = np.sum([*parts.values()], axis=0)
    told = [whole, *(parts[name] for name in CHANNELS if parts[name].mean() > NEGLIGIBLE * whole.mean())]
    if not all(is_steady(own.tolist(), UNSTEADY_SHARE * largest) for own in told):
        return "anew"
    return "end" if all(half_width(own.tolist()) <= largest for own in told) else "longer"


def largest_overlap(table: pd.DataFrame, radius_m: np.ndarray) -> float:
    """The largest overlap of a contact over the radius of its smaller ball [-]; radius_m: of every ball (balls,)."""
    if not len(table):
        return 0.0
    # In a contact with a wall, `second` is negative.
    partner = np.append(radius_m, np.inf)[np.maximum(table["second"].to_numpy(), -1)]
    smaller = np.minimum(radius_m[table["first"].to_numpy()], partner)
    return float((table["peak_overlap_m"].to_numpy() / smaller).max())


def described(simulation: Simulation) -> dict:
    """What a simulation is of: its case, balls, contact parameters, mill, step and window.

    Of a coefficient that depends on the speed of the hit it has the value at the nominal speed (config.contact_set).
    """
    case, contact = simulation.case, simulation.contact.at_speed(NOMINAL_SPEED_M_S)
    window, frequency = simulation.window_s, simulation.frequency_hz
    return {
        "case": json.loads(case.model_dump_json()),
        "mill": case.mill,
        "contact": case.contact,
        "balls": simulation.count,
        "ball_diameter_m": simulation.diameter,
        "ball_sizes_m": (2 * simulation.radii).tolist(),
        "ball_counts": simulation.ball_counts,
        "ball_mass_kg": float(np.bincount(simulation.balls.species) / simulation.count @ simulation.balls.mass),
        "density_kg_m3": contact.density_kg_m3,
        "restitution": contact.restitution,
        "static_friction": contact.static_friction,
        "rolling_friction": contact.rolling_friction,
        **{f"wall_{name}": getattr(contact.at_wall, name) for name in PAIR_COEFFICIENTS},
        "young_modulus_pa": contact.young_modulus_gpa and contact.young_modulus_gpa * 1e9,
        "frequency_hz": frequency,
        "amplitude_m": travel_m(simulation.bodies),
        "jar_volume_m3": ball_space_m3(simulation.bodies),
        "nominal_volume_m3": simulation.mill.volume_ml / 1e6,
        "time_step_s": simulation.step,
        "rayleigh_fraction": simulation.step / simulation.step_scale_s,
        "begin_s": simulation.begin_s,
        "window_s": window,
        "revolutions": window * frequency,
    }


def summarise(simulation: Simulation, series: pd.DataFrame, table: pd.DataFrame, recording: Recording) -> dict:
    """The summary of a run; raises SimulationError where the energy balance does not close.

    table: rows as `collision_table` gives them.
    speed_over_vessel: as of Recording, how much the balls move against the vessel.
    wall_clock_s and processor_s are those of the kernel; ns_per_ball_step is processor time, which other jobs
    disturb less.
    """
    dem = simulation.dem
    ledger = ledger_summary(series)
    window = simulation.window_s
    frequency = simulation.frequency_hz
    revolutions = per_revolution(series, dem.ledger_samples_per_revolution) if frequency else {}
    means = {name: mean_of_turns(revolutions.get(f"{name}_J", [])) for name in ("normal", "tangential")}
    errors = {name: known and known.error * frequency for name, known in means.items()}
    contacts = by_surface(table)
    turns = len(revolutions.get("normal_J", []))
    squares = squares_per_turn(contacts, simulation.begin_s, frequency, turns) if turns else {}
    power = {
        "normal": ledger["normal_damping"] / window,
        "tangential": (ledger["tangential_damping"] + ledger["sliding"]) / window,
        "rolling": ledger["rolling"] / window,
        # What walls and gravity supply, less what the balls stored of it: what a long run sees.
        "wall": (ledger["wall_work"] + ledger["gravity_work"] - ledger["kinetic_change"] - ledger["elastic_change"])
        / window,
    }
    weighted = weighted_statistics(contacts, power, simulation.begin_s, window, simulation.count, frequency)
    return described(simulation) | {
        "ledger_J": ledger,
        "closure": check_balance(simulation, series, table),
        "power_W": power,
        "power_standard_error_W": errors,
        "power_relative_error": {name: finite(relative_error(revolutions.get(f"{name}_J", []))) for name in CHANNELS},
        "per_revolution": revolutions | {f"{name}_square_J2": own.tolist() for name, own in squares.items()},
        "collisions": collision_statistics(
            table, dem.counting_rules, simulation.begin_s, window, simulation.count, frequency
        ),
        "weighted": weighted,
        "median_contact_duration_s": float(contacts["duration_s"].median()) if len(contacts) else None,
        "mean_ball_height_m": recording.height_m,
        "speed_over_vessel": recording.speed_over_vessel,
        "max_overlap_fraction": largest_overlap(table, simulation.balls.radius[simulation.balls.species]),
        "wall_clock_s": simulation.wall_clock_s,
        "processor_s": simulation.processor_s,
        "steps": simulation.steps_taken,
        "ns_per_ball_step": simulation.processor_s / simulation.steps_taken / simulation.count * 1e9,
    }


logger = logging.getLogger("millprint")

# The restart file of an unfinished case.
RESTART = "restart.h5"
# How often a step is shortened until the energy balance closes, and to what part of the first one at least.
SHORTENED, SHORTEST = 2, 0.4


def _goes_on(simulation: Simulation) -> Callable[[Recording], GoesOn] | None:
    """A function that tells how a window goes on after what it has recorded; None if any window does."""
    largest, samples = simulation.case.power_error_max, simulation.dem.ledger_samples_per_revolution
    if not largest:
        return None
    scale_J = scale_of_hits(described(simulation))
    return lambda recording: window_goes_on(ledger_series(np.concatenate(recording.samples)), samples, largest, scale_J)


def balls_in_words(counts: Sequence[int], sizes_m: Sequence[float]) -> str:
    """The charge for a log: "285 balls: 43 of 36.83 mm, ...", or "80 balls of 10 mm"."""
    if len(sizes_m) == 1:
        return f"{counted(counts[0], 'ball')} of {1e3 * sizes_m[0]:g} mm"
    parts = (f"{count} of {1e3 * size:g} mm" for count, size in zip(counts, sizes_m, strict=True))
    return f"{counted(sum(counts), 'ball')}: {', '.join(parts)}"


def run_case(
    case: Case,
    mill: MillConfig,
    contact: ContactConfig,
    dem: DemConfig,
    run_path: str | Path,
    summary_path: str | Path,
    cores: int = 1,
) -> dict:
    """Simulate a case, write run.h5 and summary.json, and return the summary.

    cores: how many the case's threads may run on; with fewer than it has threads it is slower, and the same.

    A stopped run continues from its restart file in the folder of run.h5, which is removed at the end.

    Raises SimulationError for balls that do not fit, a ball that escapes or overlaps too much, a number that is not
    finite, a step that is too long for the law, or an energy balance that does not close, see `_closing`; nothing is
    written then.
    """
    restart = Path(run_path).with_name(RESTART)

    def recorded(simulation: Simulation) -> Recording:
        logger.info(
            "%s, step %.4g s (%.3g of %s), %d facets",
            balls_in_words(simulation.ball_counts, case.sizes_m),
            simulation.step,
            simulation.step / simulation.step_scale_s,
            law_of(simulation.contact).scale_title,
            sum(len(body.vessel.normals) for body in simulation.bodies),
        )
        with use_threads(cores) if simulation.threads > 1 else nullcontext():
            return simulation.run(case.path, restart, _goes_on(simulation))

    begun = _begun(case, mill, contact, dem, restart)
    simulation, recording, series, table, summary = _closing(case, mill, contact, dem, recorded, begun)
    if simulation.begin_step > simulation.first_begin_step:
        logger.info("powers were not steady before %.3g turns", simulation.begin_s * simulation.frequency_hz)
    logger.info(
        "simulated in %.1f s (%.1f ns a ball-step); energy balance closes within %.2g of the wall work; %d contacts",
        simulation.wall_clock_s,
        summary["ns_per_ball_step"],
        summary["closure"],
        len(table),
    )
    write_run(run_path, simulation, recording, series, table)
    write_json(summary, summary_path)
    restart.unlink(missing_ok=True)
    return summary


def simulate(case: Case, mill: MillConfig, contact: ContactConfig, dem: DemConfig, title: str | None = None) -> dict:
    """The summary of one case, without any file; title: of a progress bar. Raises SimulationError as `run_case`."""
    return _closing(case, mill, contact, dem, lambda own: own.run(title, goes_on=_goes_on(own)))[-1]


def _begun(case: Case, mill: MillConfig, contact: ContactConfig, dem: DemConfig, restart: Path) -> Case | None:
    """The case with a shorter step, if it was stopped after its step had been shortened."""
    fraction = recorded_fraction(restart)
    if fraction is None or not fraction < (case.rayleigh_fraction or 0.0):
        return None
    shorter = case.model_copy(update={"rayleigh_fraction": fraction})
    return shorter if continues(restart, Simulation(shorter, mill, contact, dem)) else None


def _closing(
    case: Case,
    mill: MillConfig,
    contact: ContactConfig,
    dem: DemConfig,
    recorded: Callable[[Simulation], Recording],
    begun: Case | None = None,
) -> tuple[Simulation, Recording, pd.DataFrame, pd.DataFrame, dict]:
    """A simulation whose energy balance closes, its recording, ledger, collisions and summary; recorded: runs it.

    A step that is given as a fraction of the law's scale is what suits most mills: where the balance does not close
    with it, and a shorter one helps, that is taken, SHORTENED times and to SHORTEST of the first. The case of the
    summary and of run.h5 has the fraction that was taken. A step that is given in seconds stays. begun: the case of a
    stopped run whose step had been shortened. Raises SimulationError as `run_case`.
    """
    first, case = case.rayleigh_fraction or 0.0, begun or case
    for attempt in range(SHORTENED + 1):
        simulation = Simulation(case, mill, contact, dem)
        recording = recorded(simulation)
        series = ledger_series(np.concatenate(recording.samples))
        table = collision_table(recording.table)
        try:
            return simulation, recording, series, table, summarise(simulation, series, table, recording)
        except OpenBalanceError as error:
            shorter = (case.rayleigh_fraction or 0.0) * error.step_factor
            if attempt == SHORTENED or not shorter > SHORTEST * first:
                raise
            logger.warning("%s; again with rayleigh_fraction %.2g", error, shorter)
            case = case.model_copy(update={"rayleigh_fraction": shorter})
    raise AssertionError("the last attempt returns or raises")
