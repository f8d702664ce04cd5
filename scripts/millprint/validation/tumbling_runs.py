"""The simulations of a tumbling mill: which there are, and what each gives. All run in one process, one after another.

Each takes seconds, so that a process for each would cost more than the simulations. Rows that are done are kept in a
sealed file, from which a killed job continues.
"""

import hashlib
import json
import logging
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from scipy.stats import qmc

from millprint.columns import span_of
from millprint.config.contact import ContactConfig
from millprint.config.mill import MillConfig
from millprint.config.sweep import Case, DemConfig, balls_of
from millprint.config.validation import TumblingConfig
from millprint.dem.layout import SNAPSHOT, SNAPSHOT_TOTAL
from millprint.dem.ledger import check_closure, ledger_series, ledger_summary
from millprint.dem.simulation import Simulation
from millprint.errors import SimulationError
from millprint.files import whole_file
from millprint.job import progress
from millprint.kernel import kernel_digest
from millprint.sealed import seal, unsealed
from millprint.validation.charge import carried, complete_rings, net_power, toe_and_shoulder

logger = logging.getLogger("millprint")

CONTACT_KEYS = ("restitution", "static_friction", "wall_restitution", "wall_static_friction", "rolling_friction")
# What a run is for: the prediction, another contact set that is as likely, or a set of the sample.
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
    """CONTACT_KEYS of a contact set; what it leaves out for walls is that of two balls."""
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
    keys = ("restitution", "static_friction", "wall_static_friction", "rolling_friction")
    ranges = np.array([getattr(settings, key) for key in keys])
    points = qmc.LatinHypercube(len(keys), rng=np.random.default_rng(SAMPLE_SEED)).random(settings.samples)
    rows = [dict(zip(keys, row, strict=True)) for row in qmc.scale(points, ranges[:, 0], ranges[:, 1]).tolist()]
    return [{**row, "wall_restitution": row["restitution"]} for row in rows]


def design(settings: TumblingConfig, contacts: Mapping[str, ContactConfig], measured: Iterable[float]) -> pd.DataFrame:
    """A row (DESIGN_COLUMNS) for each simulation; `run` names it.

    The contact set that predicts is run for every number of balls, speed and seed; the further ones and the sample for
    the first number, at `sample_speeds`, with the first seed. measured: measured speeds, in the unit of the set-up.
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
    # The first seed and the other contact sets come first, so that a run that was stopped says the most.
    later = (frame["role"] == PREDICTS) & (frame["seed"] != settings.seeds[0])
    return pd.concat([frame[~later], frame[later]], ignore_index=True)


def case_of(row: Mapping[str, Any], settings: TumblingConfig, mill: MillConfig) -> Case:
    """The case of a row of the design."""
    turn_s = 60 / row["speed_rpm"]
    return Case(
        mill=mill.name, contact=settings.contact, **balls_of(settings.ball_diameter_mm),
        fill_ratio=settings.fill_ratio(row["number"], mill.volume_ml), speed_rpm=row["speed_rpm"], seed=row["seed"],
        rayleigh_fraction=settings.rayleigh_fraction, closure_max=settings.closure_max, settle_s=settings.settle_s,
        discard_s=max(settings.discard_turns * turn_s, settings.discard_s),
        window_s=max(settings.window_turns * turn_s, settings.window_s),
        snapshot_interval_s=turn_s / settings.snapshots_per_turn,
    )  # fmt: skip


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

    done: a file that holds each row once it is simulated, and from which a killed call with the same arguments
    continues; the caller removes it. Raises SimulationError, with the name of the run.
    """
    drawn = {(settings.numbers[0], float(speed)) for speed in settings.drawn_speeds}
    drawn |= {(number, speed) for number in settings.numbers[1:] for speed in (table["speed"].max(),)}
    parts = [part.model_dump_json() for part in (settings, mill, contact, dem)]
    identity = hashlib.sha256(json.dumps([*parts, table.to_json(), kernel_digest()]).encode()).hexdigest()
    rows = _rows_done(done, identity)
    with progress(len(table), f"{mill.title}", " simulations") as bar:
        bar.update(len(rows))
        for row in table.to_dict("records"):
            if row["run"] in rows:
                continue
            own = contact.model_copy(update={key: row[key] for key in CONTACT_KEYS})
            try:
                results, balls = simulate(case_of(row, settings, mill), mill, own, dem)
            except SimulationError as error:
                raise SimulationError(f"run {row['run']}: {error}") from None
            is_drawn = row["role"] == PREDICTS and (row["number"], row["speed"]) in drawn
            is_drawn &= row["seed"] == settings.seeds[0]
            rows[row["run"]] = {"results": results, "balls": balls.tolist() if is_drawn else []}
            _keep(done, identity, rows)
            logger.info("%s: %.4g W in %.1f s", row["run"], results["power_W"], results["wall_clock_s"])
            bar.update()
    runs = table.join(pd.DataFrame([rows[run]["results"] for run in table["run"]], index=table.index))
    pictures = []
    for row in table.to_dict("records"):
        kept = rows[row["run"]]
        for place in kept["balls"]:
            labels = (row["run"], row["number"], row["speed"], kept["results"]["angle_deg"])
            pictures.append(dict(zip(CHARGE_COLUMNS, (*labels, *place), strict=True)))
    return runs, pd.DataFrame(pictures, columns=list(CHARGE_COLUMNS))


def _keep(path: str | Path, identity: str, rows: dict[str, dict]) -> None:
    """Write the rows, with a digest in front."""
    payload = json.dumps({"identity": identity, "rows": rows}).encode()
    with whole_file(path) as partial:
        partial.write_bytes(seal(payload) + payload)


def _rows_done(path: str | Path, identity: str) -> dict[str, dict]:
    """The rows that an earlier call with the same arguments has kept; none if the file is absent or damaged."""
    if not Path(path).exists():
        return {}
    try:
        kept = json.loads(unsealed(path))
    except ValueError as error:
        logger.warning("%s: %s; every simulation is run again", path, error)
        return {}
    return kept["rows"] if kept["identity"] == identity else {}
