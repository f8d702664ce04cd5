"""The simulations of a tumbling mill, and their results."""

import logging
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from millprint.config.contact_set import ContactConfig
from millprint.config.mill import MillConfig
from millprint.config.setups.tumbling_setups import TumblingConfig
from millprint.config.sweep import Case, DemConfig
from millprint.dem.layout import SNAPSHOT, SNAPSHOT_TOTAL
from millprint.dem.ledger import check_closure, ledger_series, ledger_summary
from millprint.dem.short_runs import simulate_each
from millprint.dem.simulation import Simulation
from millprint.mill.kernel_columns import span_of
from millprint.validation.charge import carried, complete_rings, net_power, toe_and_shoulder

logger = logging.getLogger("millprint")

CONTACT_KEYS = ("restitution", "static_friction", "wall_restitution", "wall_static_friction", "rolling_friction")
# The purpose of a run: the prediction, another equally likely contact set, or a set of the sample.
PREDICTS, FURTHER, SAMPLE = "predicts", "further", "sample"
# Columns of a table of runs.
DESIGN_COLUMNS = ("run", "role", "contact", "number", "speed", "speed_rpm", "seed", *CONTACT_KEYS)
RESULT_COLUMNS = (
    *("power_W", "dissipation_W", "toe_deg", "shoulder_deg", "carried", "rings", "angle_deg"),
    *("closure", "step_s", "window_s", "wall_clock_s"),
)
CHARGE_COLUMNS = ("run", "number", "speed", "angle_deg", "x_m", "z_m", "diameter_m", "ball_speed_m_s")
SAMPLE_SEED = 0


def contact_values(contact: ContactConfig) -> dict[str, float]:
    """CONTACT_KEYS of a contact set; values at walls that it leaves out are as between balls."""
    wall = contact.at_wall
    return {
        "restitution": contact.restitution,
        "static_friction": contact.static_friction,
        "wall_restitution": wall.restitution,
        "wall_static_friction": wall.static_friction,
        "rolling_friction": contact.rolling_friction,
    }


def sampled_contacts(settings: TumblingConfig) -> list[dict[str, float]]:
    """CONTACT_KEYS of the sample: a Latin hypercube over the ranges of the section."""
    # Slow to import, and every set-up imports this module.
    from scipy.stats import qmc

    keys = ("restitution", "static_friction", "wall_static_friction", "rolling_friction")
    ranges = np.array([getattr(settings, key) for key in keys])
    points = qmc.LatinHypercube(len(keys), rng=np.random.default_rng(SAMPLE_SEED)).random(settings.samples)
    rows = [dict(zip(keys, row, strict=True)) for row in qmc.scale(points, ranges[:, 0], ranges[:, 1]).tolist()]
    return [{**row, "wall_restitution": row["restitution"]} for row in rows]


def design(settings: TumblingConfig, contacts: Mapping[str, ContactConfig], measured: Iterable[float]) -> pd.DataFrame:
    """A row (DESIGN_COLUMNS) for each simulation; `run` names it.

    The contact set that predicts is run for every number of balls, speed and seed; the further sets and the sample only
    for the first number, at `sample_speeds`, with the first seed. measured: measured speeds, in the unit of the set-up.
    """
    speeds = sorted({*map(float, settings.speeds), *map(float, measured)})
    first = settings.numbers[0]
    own = contact_values(contacts[settings.contact])
    rows = [
        (PREDICTS, settings.contact, number, speed, seed, own)
        for seed in settings.seeds
        for number in settings.numbers
        for speed in speeds
    ]
    others = [(FURTHER, name, contact_values(contacts[name])) for name in settings.further_contacts]
    others += [(SAMPLE, f"sample_{place}", values) for place, values in enumerate(sampled_contacts(settings))]
    rows += [
        (role, name, first, float(speed), settings.seeds[0], values)
        for role, name, values in others
        for speed in settings.sample_speeds
    ]
    table = [
        {
            "run": f"{name}_n{number}_x{speed:g}_s{seed}", "role": role, "contact": name, "number": number,
            "speed": speed, "speed_rpm": settings.speed_rpm(speed), "seed": seed, **values,
        }
        for role, name, number, speed, seed, values in rows
    ]  # fmt: skip
    frame = pd.DataFrame(table, columns=list(DESIGN_COLUMNS))
    # The first seed and the other contact sets come first, so that a stopped run has the most useful results.
    later = (frame["role"] == PREDICTS) & (frame["seed"] != settings.seeds[0])
    return pd.concat([frame[~later], frame[later]], ignore_index=True)


def case_of(row: Mapping[str, Any], settings: TumblingConfig, mill: MillConfig) -> Case:
    """The case of a row of the design."""
    return settings.case(row["number"], row["speed_rpm"], row["seed"], mill)


def tumbling_cases(settings: TumblingConfig, mills: Mapping[str, MillConfig]) -> list[Case]:
    """A case for each number of balls and speed, to check size, step and cost before anything runs."""
    mill = mills[settings.mill]
    rows = [
        {"number": number, "speed_rpm": settings.speed_rpm(speed), "seed": settings.seeds[0]}
        for number in settings.numbers
        for speed in settings.speeds
    ]
    return [case_of(row, settings, mill) for row in rows]


def simulate(case: Case, mill: MillConfig, contact: ContactConfig, dem: DemConfig) -> tuple[dict, np.ndarray]:
    """The results (RESULT_COLUMNS) of a case, and a last picture of the charge: (n, 4) x, z, diameter [m], speed [m/s].

    Raises SimulationError as the simulation does, and for an energy balance that does not close.
    """
    simulation = Simulation(case, mill, contact, dem)
    recording = simulation.run()
    series = ledger_series(np.concatenate(recording.samples))
    ledger = ledger_summary(series)
    snapshots = np.concatenate(recording.snapshots)
    places = snapshots[:, :, span_of(SNAPSHOT.position_m)][:, :, [0, 2]]
    speeds = np.linalg.norm(snapshots[-1][:, span_of(SNAPSHOT.velocity_m_s)], axis=1)
    times = np.concatenate(recording.snapshot_works)[:, SNAPSHOT_TOTAL.time_s]
    diameters = 2 * simulation.radii[simulation.balls.species]
    radius = float(simulation.vessel.bounds[1, 2])
    toe, shoulder = toe_and_shoulder(places, diameters, radius)
    turn = times > times[-1] - 1.001 / simulation.frequency_hz
    stay = carried(places[turn], 2 * np.pi * simulation.frequency_hz * times[turn], diameters)
    lifters = getattr(mill.geometry, "lifters", None)
    bars = (lifters.height_mm / 1e3, lifters.width_mm / 1e3) if lifters else (0.0, 0.0)
    dissipated = ledger["normal_damping"] + ledger["tangential_damping"] + ledger["sliding"] + ledger["rolling"]
    results = {
        "power_W": net_power(series["wall_work_J"].to_numpy(), series["time_s"].to_numpy()),
        "dissipation_W": dissipated / simulation.window_s,
        "toe_deg": toe,
        "shoulder_deg": shoulder,
        "carried": int(stay.sum()),
        "rings": complete_rings(places[-1][stay], simulation.diameter, radius, *bars),
        "angle_deg": 360 * (simulation.frequency_hz * times[-1] % 1),
        "closure": check_closure(series, case.closure_max or dem.closure_max),
        "step_s": simulation.step,
        "window_s": simulation.window_s,
        "wall_clock_s": simulation.wall_clock_s,
    }
    return results, np.column_stack([places[-1], diameters, speeds])


def run_all(
    table: pd.DataFrame,
    settings: TumblingConfig,
    mill: MillConfig,
    contact: ContactConfig,
    dem: DemConfig,
    done: str | Path,
) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Simulate every row of a design. Returns the rows with their results, and the balls of the drawn speeds.

    done: a file that collects simulated rows, and from which a killed call continues (`simulate_each`); the caller
    removes it. Raises SimulationError, with the name of the run.
    """
    drawn = {(settings.numbers[0], float(speed)) for speed in settings.drawn_speeds}
    drawn |= {(number, speed) for number in settings.numbers[1:] for speed in (table["speed"].max(),)}

    def simulated(row: dict[str, Any]) -> dict[str, Any]:
        own = contact.model_copy(update={key: row[key] for key in CONTACT_KEYS})
        results, balls = simulate(case_of(row, settings, mill), mill, own, dem)
        logger.info("%s: %.4g W in %.1f s", row["run"], results["power_W"], results["wall_clock_s"])
        is_drawn = row["role"] == PREDICTS and (row["number"], row["speed"]) in drawn
        is_drawn &= row["seed"] == settings.seeds[0]
        return {"results": results, "balls": balls.tolist() if is_drawn else []}

    named = {f"run {row['run']}": row for row in table.to_dict("records")}
    rows = list(simulate_each(named, simulated, (settings, mill, contact, dem), mill.title, done).values())
    runs = table.join(pd.DataFrame([row["results"] for row in rows], index=table.index))
    pictures = []
    for row, kept in zip(table.to_dict("records"), rows, strict=True):
        for place in kept["balls"]:
            labels = (row["run"], row["number"], row["speed"], kept["results"]["angle_deg"])
            pictures.append(dict(zip(CHARGE_COLUMNS, (*labels, *place), strict=True)))
    return runs, pd.DataFrame(pictures, columns=list(CHARGE_COLUMNS))
