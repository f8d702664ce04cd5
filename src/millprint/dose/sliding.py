"""Sliding work of a run by kind of contact: ball on ball, and ball on wall.

The table of collisions in run.h5 has the sliding work of every contact in the window, so its sum over the contacts
between balls and over those with a wall splits the ledger's channel `sliding` without anything left over.
"""

import json
from pathlib import Path

import h5py
import numpy as np
import pandas as pd

from millprint.config.errors import ConfigError
from millprint.run.files import read_json
from millprint.run.hdf5 import open_hdf5

BALL_BALL, BALL_WALL = "ball_ball", "ball_wall"
KINDS = (BALL_BALL, BALL_WALL)
# The key of the friction of each kind of contact in a summary.
FRICTIONS = {BALL_BALL: "static_friction", BALL_WALL: "wall_static_friction"}
CONTACTS, SHARES = "every contact", "shares of the tangential energy"
# The columns that distinguish conditions; runs that are equal in them are seeds of one condition.
CONDITION = ["mill", "contact", "ball_diameter_mm", "fill_ratio", "speed_rpm"]
# More than contacts open at the ends of the window and the single precision of the table can cause.
LARGEST_GAP = 1e-3


def sliding_of_contacts(second: np.ndarray, sliding_J: np.ndarray) -> dict[str, float]:
    """Sliding work [J] between balls and with walls; second (n,): ball, or under 0 a wall; sliding_J (n,)."""
    of_balls = second >= 0
    return {
        BALL_BALL: float(sliding_J[of_balls].sum(dtype=float)),
        BALL_WALL: float(sliding_J[~of_balls].sum(dtype=float)),
    }


def load_distance(work_J: float, friction: float) -> float:
    """Normal load times sliding distance of contacts that slide [N m], from their friction work [J].

    Where a contact slides, its friction is mu F_n (Coulomb), so that the work mu F_n ds over mu is F_n ds; friction:
    mu [-]. NaN without friction.
    """
    return work_J / friction if friction > 0 else float("nan")


def sliding_of_run(run_path: str | Path, summary_path: str | Path) -> dict:
    """One row of the table of sliding: condition, balls, and powers by kind of contact.

    sliding_KIND_W: friction power; load_KIND_N_m_s: normal load times sliding distance a second; relative_error: of
    the tangential power, from whole revolutions, NaN for fewer than two; split: whether every contact was counted or,
    in a run with too many contacts to keep, the ledger's sliding work was divided by shares of the tangential energy.
    Raises ConfigError, in one line, for another file, and where contacts and ledger differ by more than LARGEST_GAP.
    """
    if not Path(summary_path).is_file():
        raise ConfigError(f"{summary_path}: no such file; a run has run.h5 and summary.json")
    summary = read_json(summary_path)
    with open_hdf5(run_path) as file:
        works, split = _works(file, summary)
        config = json.loads(file.attrs["config"])
    total = summary["ledger_J"]["sliding"]
    if abs(sum(works.values()) - total) > LARGEST_GAP * max(abs(total), 1e-12):
        raise ConfigError(
            f"{run_path}: sliding work of all contacts {sum(works.values()):.6g} J, of the ledger {total:.6g} J: "
            "run and summary are not of one simulation"
        )
    window, case = summary["window_s"], config["case"]
    error, power = summary["power_standard_error_W"]["tangential"], summary["power_W"]["tangential"]
    row = {name: case[name] for name in CONDITION} | {"seed": case["seed"], "balls": summary["balls"]}
    row |= {
        "balls_mass_kg": summary["balls"] * summary["ball_mass_kg"],
        "density_kg_m3": summary["density_kg_m3"],
        "volume_m3": summary["nominal_volume_m3"],
        "window_s": window,
        "relative_error": np.nan if error is None or power == 0 else error / power,
        "split": split,
    }
    for kind in KINDS:
        row[f"sliding_{kind}_W"] = works[kind] / window
        row[f"load_{kind}_N_m_s"] = (
            load_distance(works[kind], summary.get(FRICTIONS[kind], summary["static_friction"])) / window
        )
    return row


def _works(file: h5py.File, summary: dict) -> tuple[dict[str, float], str]:
    """Sliding work by kind in the window [J], and how it was split."""
    contacts = file["collisions"]
    if not contacts.attrs["is_histogram"]:
        return sliding_of_contacts(contacts["second"][:], contacts["sliding_J"][:]), CONTACTS
    shares = summary["collisions"][0]["shares"]
    return {kind: summary["ledger_J"]["sliding"] * shares[kind]["tangential"] for kind in KINDS}, SHARES


def tabulate_sliding(runs: list[tuple[str, str]]) -> pd.DataFrame:
    """A row of `sliding_of_run` for each pair of run.h5 and summary.json."""
    return pd.DataFrame([sliding_of_run(*paths) for paths in runs])


def mean_conditions(table: pd.DataFrame) -> pd.DataFrame:
    """One row for each condition: means over its seeds, and the relative error of the mean.

    relative_error: the larger of the scatter between seeds and the scatter within windows, over the square root of the
    number of seeds.
    """
    loads = [f"load_{kind}_N_m_s" for kind in KINDS]
    rows = []
    for keys, runs in table.groupby(CONDITION, sort=False):
        total = runs[loads].sum(axis=1)
        spread = total.std(ddof=1) / total.mean() if len(runs) > 1 and total.mean() else np.nan
        errors = [error for error in (spread, runs["relative_error"].mean()) if np.isfinite(error)]
        about = runs[["balls", "balls_mass_kg", "density_kg_m3", "volume_m3"]].iloc[0].to_dict()
        rows.append(
            dict(zip(CONDITION, keys, strict=True))
            | about
            | {"seeds": len(runs), **runs[loads].mean().to_dict()}
            | {"relative_error": max(errors) / np.sqrt(len(runs)) if errors else np.nan}
        )
    return pd.DataFrame(rows)
