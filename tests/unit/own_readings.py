"""Thermometers and wattmeters that are made up: what is measured of them is known."""

import json
from pathlib import Path

import h5py
import numpy as np

from tests.unit.test_card import card_content
from tests.unit.test_heat import write_run


def events(rng: np.random.Generator, duration_s: float, rate_hz: float, turn_s: float = 0.2) -> tuple:
    """Times [s] and normal energies [J] of collisions that come more often in one half of each turn."""
    time_s = np.sort(rng.uniform(0, duration_s, rng.poisson(2 * rate_hz * duration_s)))
    time_s = time_s[rng.random(len(time_s)) < 0.5 + 0.4 * np.sin(2 * np.pi * time_s / turn_s)]
    return time_s, 1e-3 * rng.lognormal(0.0, 1.2, len(time_s))


def correlated(rng: np.random.Generator, n: int, memory: float = 0.8) -> np.ndarray:
    """Noise of unit variance whose neighbours are correlated by `memory`."""
    noise = rng.standard_normal(n)
    for place in range(1, n):
        noise[place] = memory * noise[place - 1] + np.sqrt(1 - memory**2) * noise[place]
    return noise


def write_condition(folder: Path, time_s: np.ndarray, energy_J: np.ndarray, window_s: float, power_W: float) -> Path:
    """A folder as of `millprint card`, with one run at 300 rpm that has these collisions with the wall."""
    content = card_content(speed_rpm=300.0)
    content["fingerprint"]["descriptors"]["wall_power_W"] = {
        "value": power_W, "unit": "W", "mean": {"lower": 0.98 * power_W, "upper": 1.02 * power_W},
        "contact": {"lower": 0.7 * power_W, "upper": 1.3 * power_W},
    }  # fmt: skip
    summary, run = map(Path, write_run(folder / "made"))
    place = folder / "runs/seed_0"
    place.parent.mkdir(parents=True)
    summary.parent.rename(place)
    known = json.loads((place / summary.name).read_text()) | {"frequency_hz": 5.0}
    (place / summary.name).write_text(json.dumps(known))
    number = len(time_s)
    with h5py.File(place / run.name, "a") as file:
        del file["collisions"]
        group = file.create_group("collisions")
        group.attrs.update({"begin_s": 0.5, "window_s": window_s})
        columns = {
            "first": np.arange(number), "second": -1, "facet": 0, "contact": np.arange(number), "start_s": 0.5 + time_s,
            "duration_s": 1e-4, "peak_force_N": 1.0, "normal_J": energy_J, "damping_J": 0.0, "sliding_J": energy_J,
            "rolling_J": 0.0, "ended": 1,
        }  # fmt: skip
        for name, values in columns.items():
            group[name] = np.broadcast_to(values, number)
        file["ledger/elastic_tangential_J"] = np.zeros(2)
    (folder / "card.json").write_text(json.dumps(content))
    return folder


def write_readings(path: Path, column: str, time_s: np.ndarray, values: np.ndarray) -> Path:
    """A table of a thermometer or a wattmeter."""
    rows = [f"{moment:.3f}\t{value:.3f}" for moment, value in zip(time_s, values, strict=True)]
    path.write_text("\n".join([f"time_s\t{column}", *rows]) + "\n")
    return path
