"""Readers of the fingerprint stage: summaries of simulations, and fingerprints of other runs.

Each reader refuses, in one line, a file that lacks what is needed.
"""

import hashlib
import json
from collections.abc import Iterable
from functools import reduce
from operator import getitem
from pathlib import Path

import numpy as np

from millprint.config.contact_set import ContactConfig
from millprint.config.counting import recorded_count
from millprint.config.errors import ConfigError
from millprint.config.included import load_contact, load_mill, shipped
from millprint.config.mill import MillConfig
from millprint.config.mixture import ONE_SIZE, BallMixture, balls_in_words
from millprint.fingerprint.columns import MEASURED
from millprint.run.files import read_format, read_json, read_table

# Coefficients of walls, stored where they differ from those of ball on ball.
WALL = {"wall_restitution": "restitution", "wall_static_friction": "static_friction"}
# The format of a fingerprint file, and the usual name of such files.
FORMAT = "millprint fingerprint 2"
WHERE = "one is written as fingerprint_CONTACT.json"
# Numbers that a summary must have: group.key, or a key without a group.
ERRORS = ("power_standard_error_W.normal", "power_standard_error_W.tangential")
SUMMARY_NUMBERS = (
    *(column.key for column in MEASURED if column.key and not column.key.startswith("rule.")),
    *("density_kg_m3", "amplitude_m", "case.ball_diameter_mm", "case.fill_ratio", "case.speed_rpm", "case.seed"),
    *ERRORS,
)
# A run without a finished contact has no median duration, a window of less than two revolutions no standard error.
OPTIONAL_NUMBERS = {*(column.key for column in MEASURED if column.optional), *ERRORS}


def check_summary(summary: dict, source: str) -> dict:
    """Return `summary` unchanged; raises ConfigError that names the file, the key and the value."""
    for key in [*(key.split(".")[0] for key in SUMMARY_NUMBERS), "mill", "contact", "collisions", "per_revolution"]:
        if key not in summary:
            raise ConfigError(f"{source}: {key}: this key is missing; rerun the simulation that wrote the summary")
    for key in SUMMARY_NUMBERS:
        *groups, name = key.split(".")
        value = reduce(getitem, groups, summary).get(name)
        if value is None and key in OPTIONAL_NUMBERS:
            continue
        if isinstance(value, bool) or not isinstance(value, int | float) or not np.isfinite(value):
            raise ConfigError(f"{source}: {key} = {value!r}: must be a finite number")
    # A rule with a threshold may count no collision, but a run must have contacts.
    if not any(rule["frequency_hz"] > 0 for rule in summary["collisions"]):
        raise ConfigError(f"{source}: no collision in {summary['window_s']:g} s; make dem.window_s longer")
    if summary["frequency_hz"] <= 0:
        raise ConfigError(f"{source}: frequency_hz = {summary['frequency_hz']}: a mill at rest has no descriptors")
    return summary


def read_summaries(paths: Iterable[str | Path]) -> list[dict]:
    """Read and check every summary; raises ConfigError for a file that is absent, is not JSON or lacks a key.

    run_path: the run.h5 next to it.
    """
    found = []
    for path in paths:
        try:
            summary = read_json(path)
        except FileNotFoundError:
            raise ConfigError(f"{path}: no such summary") from None
        except json.JSONDecodeError as error:
            raise ConfigError(f"{path}: not valid JSON ({error})") from None
        found.append(check_summary(summary, str(path)) | {"run_path": str(Path(path).with_name("run.h5"))})
    if not found:
        raise ConfigError("fingerprint: no simulation to describe; sweeps must hold a case without snapshots")
    return found


def charges_of(summaries: Iterable[dict]) -> dict[str, BallMixture]:
    """The charges of several ball sizes that were simulated, by their names."""
    mixtures = [summary["case"].get("mixture") for summary in summaries]
    return {mixture["name"]: BallMixture(**mixture) for mixture in mixtures if mixture}


def counted(summary: dict, rule_name: str) -> dict:
    """The collisions of one run by a counting rule; raises ConfigError if the run lacks the rule or it counted none."""
    count = recorded_count(summary, rule_name)
    if count["count"] == 0:
        case, name = summary["case"], (summary["case"].get("mixture") or {}).get("name", ONE_SIZE)
        balls = balls_in_words(case["ball_diameter_mm"], name)
        raise ConfigError(
            f"fingerprint.counting_rule = {rule_name}: it counts no collision of balls of {balls} at fill "
            f"{case['fill_ratio']:g} and {case['speed_rpm']:g} rpm; choose a rule with a lower threshold"
        )
    return count


def read_content(path: str | Path) -> dict:
    """The content of a fingerprint file. Raises ConfigError, in one line, for a missing or an invalid file."""
    return read_format(path, [FORMAT], "fingerprint", WHERE)


FOLDER = "config/fingerprints"
# A row for each: mill, contact, digest (of `digest_of`), sha256 of its file, and what it was made with.
TABLE = f"{FOLDER}/made.tsv"
# What changes no simulation of a mill.
WORDS = {"title", "source", "speed_unit", "sweep"}


def digest_of(mill: MillConfig, contact: ContactConfig) -> str:
    """A short digest of what a mill and its contact set are, without their words and the mill's sweep."""
    parts = [mill.model_dump(mode="json", exclude=WORDS), contact.model_dump(mode="json", exclude=WORDS)]
    return hashlib.sha256(json.dumps(parts, sort_keys=True).encode()).hexdigest()[:16]


def ready_made() -> list[str]:
    """Names of the mills that have a fingerprint without a simulation, in the order of the table."""
    table = shipped(TABLE)
    return list(read_table(table)["mill"]) if table else []


def find_ready_made(mill: str) -> Path | None:
    """The file of a mill's fingerprint; None if it has none, or if the mill of that name is another one here."""
    if mill not in ready_made():
        return None
    row = read_table(str(shipped(TABLE))).set_index("mill").loc[mill]
    if digest_of(load_mill(mill), load_contact(row["contact"])) != row["digest"]:
        return None
    path = shipped(f"{FOLDER}/{mill}.json")
    return Path(path) if path else None
