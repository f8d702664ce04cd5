"""Runs of tumbling mills by either engine, and their charges."""

import json
import logging
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pandas as pd

from millprint.cases.simulate import simulate_each
from millprint.config.contact_set import ContactConfig
from millprint.config.mill import DrumGeometry, MillConfig
from millprint.config.motion_kinds import RotationMotion
from millprint.config.setup_models import POWER, RINGS, SHOULDER, TOE, TumblingConfig, with_number
from millprint.config.sweep import Case, DemConfig, as_tabulated
from millprint.dem.collisions import collision_table
from millprint.dem.layout import SNAPSHOT, SNAPSHOT_TOTAL
from millprint.dem.ledger import check_balance, ledger_series, ledger_summary
from millprint.dem.simulation import Simulation
from millprint.dem.turns import mean_of_turns
from millprint.estimate.estimates import latin_hypercube
from millprint.mill.gravity import GRAVITY
from millprint.mill.kernel_columns import span_of
from millprint.run.files import read_json
from millprint.run.hdf5 import open_hdf5

# At toe and shoulder, the shell is covered by half as many balls as in a closed ring.
COVERED = 0.5
BINS = 120
# For a ball that centrifuges: upper bound of the change of its distance from the axis over its diameter, and lower
# bound of the angle that it goes round over the drum's.
CARRIED = 0.5
# Distance of two rings over the ball diameter: between 0.87, for balls in the gaps of the other ring, and 1.
RING_PITCH = 0.9


def critical_speed_rpm(radius_m: float, ball_diameter_m: float) -> float:
    """The speed at which a ball at the shell weighs nothing at the top, sqrt(g / (R - d / 2)) [rpm].

    radius_m: of the shell R; ball_diameter_m: d [m].
    """
    return math.sqrt(GRAVITY / (radius_m - ball_diameter_m / 2)) * 30 / math.pi


def net_power(wall_work_J: np.ndarray, time_s: np.ndarray) -> float:
    """Mean power that the walls give to the balls [W]: the work between the first and the last sample over the time.

    wall_work_J, time_s: (m,) of the energy ledger. It is net of bearings, gears and motor.
    """
    return float((wall_work_J[-1] - wall_work_J[0]) / (time_s[-1] - time_s[0]))


def clock_angle(places: np.ndarray) -> np.ndarray:
    """Angles (...) of places (..., 2), clockwise from 12 o'clock, 0 to 360 [deg]."""
    return np.degrees(np.arctan2(places[..., 0], places[..., 1])) % 360.0


def coverage(places: np.ndarray, diameters: np.ndarray, radius_m: float, bins: int = BINS) -> np.ndarray:
    """How much of the shell the outermost balls cover (bins,): 1 for a closed ring, 0 without a ball [-].

    places: (t, n, 2) [m] at t times; diameters: (n,) [m]; radius_m: of the shell. Outermost balls have a gap to the
    shell of less than half their diameter; each covers d / (R - d / 2) of the circle [rad].
    """
    distance = np.linalg.norm(places, axis=-1)
    outermost = radius_m - distance < diameters
    share = np.broadcast_to(diameters / (2 * math.pi * (radius_m - diameters / 2)), distance.shape)
    place = (clock_angle(places) / 360 * bins).astype(int) % bins
    total = np.bincount(place[outermost], weights=share[outermost], minlength=bins)
    return total * bins / len(places)


def toe_and_shoulder(places: np.ndarray, diameters: np.ndarray, radius_m: float) -> tuple[float, float]:
    """Angles of toe and shoulder [deg]: the ends of the longest arc of the shell that balls cover by COVERED or more.

    The toe is the end that the shell reaches first; at the shoulder the balls leave it. Ends are interpolated within a
    bin. (nan, nan) if balls cover the whole circle, as in a centrifuge, or none of it.
    """
    share = coverage(places, diameters, radius_m, BINS)
    inside = share >= COVERED
    if inside.all() or not inside.any():
        return math.nan, math.nan
    # An arc begins at a covered bin after an uncovered one.
    starts = np.flatnonzero(inside & ~np.roll(inside, 1))
    lengths = [int(np.argmin(np.roll(inside, -start))) for start in starts]
    first, length = int(starts[np.argmax(lengths)]), max(lengths)
    last = first + length - 1

    def end(here: int, beyond: int) -> float:
        """The centre of the last covered bin, moved towards the next one to where the share is COVERED."""
        high, low = share[here % BINS], share[beyond % BINS]
        return (here + 0.5 + (beyond - here) * (high - COVERED) / (high - low)) * 360 / BINS

    return end(first, first - 1) % 360.0, end(last, last + 1) % 360.0


def carried(places: np.ndarray, angles: np.ndarray, diameters: np.ndarray) -> np.ndarray:
    """Which balls (n,) centrifuge: they go round at a constant distance from the axis.

    places: (t, n, 2) [m] over a turn; angles: (t,) of the drum, clockwise [rad]; diameters: (n,) [m]. Over the turn the
    distance from the axis varies by less than CARRIED of the diameter, and the ball goes round by more than CARRIED of
    the angle of the drum: it may slip or roll on the shell, or on the ring outside it.
    """
    distance = np.linalg.norm(places, axis=-1)
    way = np.unwrap(np.radians(clock_angle(places)), axis=0)
    goes_round = way[-1] - way[0] > CARRIED * (angles[-1] - angles[0])
    return goes_round & (np.ptp(distance, axis=0) < CARRIED * diameters)


def complete_rings(
    places: np.ndarray, diameter_m: float, radius_m: float, lifter_height_m: float = 0.0, lifter_width_m: float = 0.0
) -> int:
    """How many complete rings these balls make, counted from the shell inwards.

    places: (n, 2) [m] of the balls that are carried round; diameter_m: of each; radius_m: of the shell. A ball's ring
    follows from its distance to the shell, in steps of RING_PITCH of the diameter. A ring is complete if it has no room
    for two more balls side by side: neighbours are less than three diameters apart, plus the width of a lifter where
    lifters are in the ring. The first incomplete ring ends the count.
    """
    distance = np.linalg.norm(places, axis=1)
    ring = np.floor((radius_m - diameter_m / 2 - distance) / (RING_PITCH * diameter_m) + 0.5).astype(int)
    angles = np.radians(clock_angle(places))
    for number in range(int(radius_m / (RING_PITCH * diameter_m))):
        own = ring == number
        if own.sum() < 2:
            return number
        middle = distance[own].mean()
        ordered = np.sort(angles[own])
        gaps = np.diff(ordered, append=ordered[0] + 2 * math.pi) * middle
        if gaps.max() >= 3 * diameter_m + lifter_width_m * (middle > radius_m - lifter_height_m):
            return number
    return number


logger = logging.getLogger("millprint")

CONTACT_KEYS = ("restitution", "static_friction", "wall_restitution", "wall_static_friction", "rolling_friction")
# The purpose of a run: the prediction, another equally likely contact set, or a set of the sample.
PREDICTS, FURTHER, SAMPLE = "predicts", "further", "sample"
# Columns of a table of runs.
DESIGN_COLUMNS = ("run", "role", "contact", "number", "speed", "speed_rpm", "seed", *CONTACT_KEYS)
CHARGE_COLUMNS = ("run", "number", "speed", "angle_deg", "x_m", "z_m", "diameter_m", "ball_speed_m_s")


def contact_values(contact: ContactConfig) -> dict[str, float]:
    """CONTACT_KEYS of a contact set; values at walls that it leaves out are as between balls."""
    wall = contact.at_wall
    return {
        "restitution": contact.value_of("restitution"),
        "static_friction": contact.value_of("static_friction"),
        "wall_restitution": wall.value_of("restitution"),
        "wall_static_friction": wall.value_of("static_friction"),
        "rolling_friction": contact.rolling_friction,
    }


def sampled_contacts(settings: TumblingConfig) -> list[dict[str, float]]:
    """CONTACT_KEYS of the sample: a Latin hypercube over the ranges of the section."""
    if not settings.samples:
        return []
    keys = ("restitution", "static_friction", "wall_static_friction", "rolling_friction")
    drawn = latin_hypercube({key: getattr(settings, key) for key in keys}, settings.samples)
    return pd.DataFrame({**drawn, "wall_restitution": drawn["restitution"]}).to_dict("records")


def measured_speeds(settings: TumblingConfig, points: pd.DataFrame) -> dict[int, list[float]]:
    """The measured speeds of each number of balls, in the unit of the set-up.

    points: `quantity` and `x` of what was measured in this set-up.
    """
    found = {}
    for number in settings.numbers:
        own = [with_number(name, number, settings) for name in (POWER, RINGS, TOE, SHOULDER)]
        found[number] = points.loc[points["quantity"].isin(own), "x"].dropna().tolist()
    return found


def _speeds(settings: TumblingConfig, number: int, measured: Mapping[int, Sequence[float]]) -> list[float]:
    """The speeds at which a number of balls is simulated with the contact set that predicts."""
    if settings.only_measured and len(settings.speeds) > 1:
        return sorted({*measured.get(number, ())})
    return sorted({*map(float, settings.speeds), *(speed for own in measured.values() for speed in own)})


def design(
    settings: TumblingConfig, contacts: Mapping[str, ContactConfig], measured: Mapping[int, Sequence[float]]
) -> pd.DataFrame:
    """A row (DESIGN_COLUMNS) for each simulation; `run` names it.

    The contact set that predicts is run for every number of balls, speed and seed; the further sets and the sample only
    for the first number, at `sample_speeds`, with the first seed. measured: of `measured_speeds`.
    """
    first = settings.numbers[0]
    own = contact_values(contacts[settings.contact])
    rows = [
        (PREDICTS, settings.contact, number, speed, seed, own)
        for seed in settings.seeds
        for number in settings.numbers
        for speed in _speeds(settings, number, measured)
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


def simulate(case: Case, mill: MillConfig, contact: ContactConfig, dem: DemConfig) -> tuple[dict, np.ndarray]:
    """The results of a case, and a last picture of the charge: (n, 4) x, z, diameter [m], speed [m/s].

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
        "closure": check_balance(simulation, series, collision_table(recording.table)),
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
    drawn |= {(number, table["speed"].max()) for number in settings.numbers[1 - bool(settings.only_measured) :]}

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


# Columns of simulations.tsv; empty where the engine does not give a quantity.
COLUMNS = (
    *("mill", "contact", "engine", "balls", "ball_diameter_mm", "fill_ratio", "speed_rpm", "seed", "window_s"),
    *("power_W", "power_se_W", "rms_speed_m_s", "ball_contacts_hz", "toe_deg", "shoulder_deg", "ns_per_ball_step"),
)


def simulation_row(summary_path: str | Path) -> dict[str, object]:
    """COLUMNS of the simulation with this summary, and with a run.h5 next to it."""
    summary = read_json(summary_path)
    case, engine = summary["case"], summary.get("engine", {"name": "millprint"})["name"]
    mass = summary["balls"] * summary["ball_mass_kg"]
    with open_hdf5(Path(summary_path).with_name("run.h5")) as file:
        energy = float(file["ledger/kinetic_translation_J"][:].mean())
        contacts = _ball_contacts(file)
        toe, shoulder = _toe_and_shoulder(file, summary["ball_diameter_m"])
    values = (
        summary["mill"], summary["contact"], engine, summary["balls"], *as_tabulated(case).values(), case["seed"],
        summary["window_s"], summary["power_W"]["wall"], _wall_error(summary), math.sqrt(2 * energy / mass),
        contacts / summary["window_s"], toe, shoulder, summary["ns_per_ball_step"],
    )  # fmt: skip
    return dict(zip(COLUMNS, values, strict=True))


def _wall_error(summary: dict) -> float:
    """Standard error of the walls' power by the scatter of single turns [W]; nan for fewer than two."""
    known = mean_of_turns(summary["per_revolution"].get("wall_J", []))
    return known.error * summary["frequency_hz"] if known else math.nan


def _ball_contacts(file: h5py.File) -> float:
    """The contacts between balls that begin in the window, from touch to release; nan where they are not recorded."""
    group = file.get("ball_contacts", file.get("collisions"))
    if group is None or "start_s" not in group:
        return math.nan
    begun = group["start_s"][:] >= group.attrs["begin_s"]
    return float((begun & (group["second"][:] >= 0)).sum())


def _toe_and_shoulder(file: h5py.File, diameter_m: float) -> tuple[float, float]:
    """Toe and shoulder of a drum that turns about y [deg]; nan for another mill, or without snapshots."""
    mill = MillConfig(**json.loads(file.attrs["config"])["mill"])
    drum = mill.geometry if isinstance(mill.geometry, DrumGeometry) else None
    turns = drum is not None and drum.axis == "y" and isinstance(mill.motion, RotationMotion)
    if drum is None or not turns or "snapshots" not in file:
        return math.nan, math.nan
    places = file["snapshots/position_m"][:][:, :, [0, 2]]
    return toe_and_shoulder(places, np.full(places.shape[1], diameter_m), drum.radius_mm / 1e3)


def tabulate(summaries: Sequence[str | Path]) -> pd.DataFrame:
    """A row of COLUMNS for each summary."""
    return pd.DataFrame([simulation_row(path) for path in summaries], columns=list(COLUMNS))
