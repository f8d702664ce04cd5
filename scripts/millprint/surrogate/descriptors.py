"""The mechanical fingerprint {E_n, E_t, f / n} of a roll-out that keeps account of single collisions."""

import numpy as np

from millprint.errors import ConfigError
from millprint.surrogate.rolled import Rolled

NAMES = ("normal_energy", "tangential_energy", "collision_frequency")
UNITS = dict(zip(NAMES, ("J", "J", "per_ball_hz"), strict=True))


def simulated_descriptors(summary: dict, rule: str) -> dict[str, float]:
    """Of a simulation's window: energies of a collision [J], Eqs 3.20 and 3.21, and collisions a ball and second.

    Raises ConfigError for a counting rule that the simulation did not count by.
    """
    counts = {count["name"]: count for count in summary["collisions"]}
    if rule not in counts:
        raise ConfigError(f"surrogate: counting rule {rule} is not among dem.counting_rules: {', '.join(counts)}")
    frequency, power = counts[rule]["frequency_hz"], summary["power_W"]
    return {
        "normal_energy": power["normal"] / frequency if frequency else np.nan,
        "tangential_energy": power["tangential"] / frequency if frequency else np.nan,
        "collision_frequency": frequency / summary["balls"],
    }


def rolled_descriptors(rollout: Rolled) -> dict[str, float]:
    """The same of a roll-out, over its batch; empty where it knows no channels or no collisions."""
    if not {"normal_J", "tangential_J", "collisions"} <= rollout.extra.keys():
        return {}
    normal, tangential, count = (rollout.extra[name].sum() for name in ("normal_J", "tangential_J", "collisions"))
    batch, balls = rollout.crossed_s.shape
    return {
        "normal_energy": float(normal / count) if count else np.nan,
        "tangential_energy": float(tangential / count) if count else np.nan,
        "collision_frequency": float(count / (batch * balls * rollout.time_s[-1])),
    }


def compare_descriptors(values: dict[str, float], truth: dict[str, float]) -> dict[str, float]:
    """Each descriptor, and by how much it is off the simulation's [%]."""
    found = {f"{name}_{UNITS[name]}": value for name, value in values.items()}
    for name, value in values.items():
        found[f"{name}_error_percent"] = float(100 * abs(value / truth[name] - 1))
    return found
