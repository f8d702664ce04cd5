"""A table of simulations, of either engine: power, speed of the balls, contacts between them, toe and shoulder."""

import json
import math
from collections.abc import Sequence
from pathlib import Path

import h5py
import numpy as np
import pandas as pd

from millprint.config.geometry import DrumGeometry
from millprint.config.mill import MillConfig
from millprint.config.motion_kinds import RotationMotion
from millprint.config.sweep import as_tabulated
from millprint.dem.turns import mean_of_turns
from millprint.run.files import read_json
from millprint.run.hdf5 import open_hdf5
from millprint.validation.tumbling_runs import toe_and_shoulder

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
