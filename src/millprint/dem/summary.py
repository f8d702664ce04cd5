"""The summary of a run: powers, collisions by counting rule, and the energy balance."""

import json
import math

import numpy as np
import pandas as pd

from millprint.config.contact_set import PAIR_COEFFICIENTS
from millprint.config.over_speed import NOMINAL_SPEED_M_S
from millprint.dem.collisions import CHANNELS, by_surface, collision_statistics, squares_per_turn, weighted_statistics
from millprint.dem.ledger import check_balance, ledger_summary
from millprint.dem.recording import Recording
from millprint.dem.simulation import Simulation
from millprint.dem.turns import FEWEST_BLOCKS, half_width, has_impacts, mean_of_turns, relative_error
from millprint.mill.bodies import ball_space_m3, travel_m


def per_revolution(series: pd.DataFrame, samples: int) -> dict[str, list[float]]:
    """Energies of each whole revolution [J], of `samples` samples of the ledger each; tangential is all of it."""
    columns = {
        "normal_J": series["normal_damping_J"],
        "tangential_J": series["tangential_damping_J"] + series["sliding_J"],
        "rolling_J": series["rolling_J"],
        "wall_J": series["wall_work_J"],
    }
    return {name: np.diff(column.to_numpy()[::samples]).tolist() for name, column in columns.items()}


def weighted_errors(energies: list[float], squares: np.ndarray) -> dict[str, float | None]:
    """Relative standard errors [-] of an energy-weighted mean E* and of its rate f* = P / E*.

    energies: of each turn [J]; squares: sums of squares of the contacts that begin in each turn (turns,) [J2]. E* goes
    with squares / energy and f* with energy^2 / squares: errors of ratios, to first order. None for fewer than two
    turns.
    """
    energy = np.asarray(energies, dtype=float)
    if len(energy) < 2 or not energy.mean() or not squares.mean():
        return {"energy": None, "frequency": None}
    of_energy, of_squares = energy / energy.mean(), squares / squares.mean()
    residuals = {"energy": of_squares - of_energy, "frequency": 2 * of_energy - of_squares}
    return {name: float(values.std(ddof=1) / math.sqrt(len(values))) for name, values in residuals.items()}


def finite(value: float) -> float | None:
    """A number for JSON, which has no infinity."""
    return value if math.isfinite(value) else None


# The power of a channel under this share of the whole is known well enough, however it varies [-].
NEGLIGIBLE = 0.01


def is_certain(series: pd.DataFrame, samples: int, largest: float, scale_J: float) -> bool:
    """Whether the window is long enough: half of the 95 % intervals of the mean powers is at most `largest` [-].

    Of normal and tangential power, of each that is not NEGLIGIBLE, and of all dissipation, over at least FEWEST_BLOCKS
    independent turns; or where no ball hits anything, by scale_J as `has_impacts` has it, since then nothing is to be
    known better.
    """
    energies = per_revolution(series, samples)
    if not has_impacts(energies["normal_J"], scale_J):
        return len(energies["normal_J"]) >= FEWEST_BLOCKS
    parts = {name: np.array(energies[f"{name}_J"]) for name in (*CHANNELS, "rolling")}
    whole = np.sum([*parts.values()], axis=0)
    told = [whole, *(parts[name] for name in CHANNELS if parts[name].mean() > NEGLIGIBLE * whole.mean())]
    return all(half_width(own.tolist()) <= largest for own in told)


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

    Of a coefficient that depends on the speed of the hit it has the value at the nominal speed (config.over_speed).
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
    steps = simulation.settle_steps + simulation.discard_steps + simulation.window_steps + 1
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
    for name in CHANNELS:
        own = squares.get(name, np.empty(0))
        weighted[name]["relative_error"] = weighted_errors(revolutions.get(f"{name}_J", []), own)
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
        "steps": steps,
        "ns_per_ball_step": simulation.processor_s / steps / simulation.count * 1e9,
    }
