"""Reads the summaries of simulations and refuses, in one line, one that lacks what the descriptors need."""

import json
from collections.abc import Iterable
from pathlib import Path

import numpy as np

from millprint.errors import ConfigError
from millprint.files import read_json

NUMBERS = (
    "balls",
    "ball_diameter_m",
    "density_kg_m3",
    "restitution",
    "static_friction",
    "frequency_hz",
    "amplitude_m",
    "window_s",
    "closure",
    "mean_ball_height_m",
    "median_contact_duration_s",
)
GROUPS = {
    "case": ("ball_diameter_mm", "fill_ratio", "speed_rpm", "seed"),
    "power_W": ("normal", "tangential", "rolling", "wall"),
    "power_standard_error_W": ("normal", "tangential"),
}


def _finite(source: str, key: str, value: object) -> None:
    if isinstance(value, bool) or not isinstance(value, int | float) or not np.isfinite(value):
        raise ConfigError(f"{source}: {key} = {value!r}: a finite number is wanted")


def check_summary(summary: dict, source: str) -> dict:
    """Return `summary` unchanged; raises ConfigError that names the file, the key and the value."""
    wanted = [*NUMBERS, *GROUPS, "mill", "contact", "collisions", "per_revolution"]
    missing = [key for key in wanted if key not in summary]
    if missing:
        raise ConfigError(f"{source}: {missing[0]}: this key is missing; rerun the simulation that wrote the summary")
    for key in NUMBERS:
        # A run without a single finished contact has no median duration: that is a result, not a fault.
        if not (key == "median_contact_duration_s" and summary[key] is None):
            _finite(source, key, summary[key])
    for group, keys in GROUPS.items():
        for key in keys:
            # A window of less than two revolutions has no standard error.
            if not (group == "power_standard_error_W" and summary[group].get(key) is None):
                _finite(source, f"{group}.{key}", summary[group].get(key))
    # A rule with a threshold may well count none; a run in which nothing touched is no run.
    if not any(rule["frequency_hz"] > 0 for rule in summary["collisions"]):
        raise ConfigError(f"{source}: no collision in {summary['window_s']:g} s; make dem.window_s longer")
    if summary["frequency_hz"] <= 0:
        raise ConfigError(f"{source}: frequency_hz = {summary['frequency_hz']}: a mill at rest has no descriptors")
    return summary


def read_summaries(paths: Iterable[str | Path]) -> list[dict]:
    """Read and check every summary; raises ConfigError for a file that is absent, is not JSON or lacks a key."""
    found = []
    for path in paths:
        try:
            summary = read_json(path)
        except FileNotFoundError:
            raise ConfigError(f"{path}: no such summary") from None
        except json.JSONDecodeError as error:
            raise ConfigError(f"{path}: not valid JSON ({error})") from None
        found.append(check_summary(summary, str(path)))
    if not found:
        raise ConfigError("fingerprint: no simulation to describe; sweeps must hold a case without snapshots")
    return found


def counted(summary: dict, rule_name: str) -> dict:
    """The collision count of one run under a counting rule; raises ConfigError if the run lacks it or counted none."""
    for rule in summary["collisions"]:
        if rule["name"] != rule_name:
            continue
        if rule["count"] == 0:
            case = summary["case"]
            raise ConfigError(
                f"fingerprint.counting_rule = {rule_name}: it counts no collision of {case['ball_diameter_mm']:g} mm "
                f"balls at fill {case['fill_ratio']:g} and {case['speed_rpm']:g} rpm; a lower threshold would"
            )
        return rule
    known = ", ".join(rule["name"] for rule in summary["collisions"])
    raise ConfigError(
        f"fingerprint.counting_rule = {rule_name}: not among the rules that the simulations recorded ({known}); "
        "add it to dem.counting_rules"
    )
