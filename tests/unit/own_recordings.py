"""Recordings, thermometers and wattmeters that are made up: what is measured of them is known."""

import json
from pathlib import Path

import h5py
import numpy as np
from scipy.io import wavfile
from scipy.signal import fftconvolve

from tests.unit.test_card import card_content
from tests.unit.test_heat import write_run

RATE_HZ = 32_000


def events(rng: np.random.Generator, duration_s: float, rate_hz: float, turn_s: float = 0.2) -> tuple:
    """Times [s] and normal energies [J] of collisions that come more often in one half of each turn."""
    time_s = np.sort(rng.uniform(0, duration_s, rng.poisson(2 * rate_hz * duration_s)))
    time_s = time_s[rng.random(len(time_s)) < 0.5 + 0.4 * np.sin(2 * np.pi * time_s / turn_s)]
    return time_s, 1e-3 * rng.lognormal(0.0, 1.2, len(time_s))


def sound_of(
    time_s: np.ndarray, energy_J: np.ndarray, duration_s: float, rng: np.random.Generator,
    exponent: float = 0.5, gain: float = 1.0, noise: float = 2e-3, hum: float = 0.05,
) -> np.ndarray:  # fmt: skip
    """What a microphone hears: a ringing burst for each collision, two echoes, noise, a motor with its harmonics."""
    train = np.zeros(int(duration_s * RATE_HZ) + 1)
    place = (time_s * RATE_HZ).astype(int)
    np.add.at(train, place, gain * energy_J**exponent * rng.choice([-1.0, 1.0], len(time_s)))
    ring = np.arange(int(0.012 * RATE_HZ)) / RATE_HZ
    burst = np.exp(-ring / 1.5e-3) * (np.sin(2 * np.pi * 4300 * ring) + 0.7 * np.sin(2 * np.pi * 6900 * ring))
    echo = np.zeros(int(0.02 * RATE_HZ))
    echo[[0, int(0.008 * RATE_HZ), int(0.015 * RATE_HZ)]] = 1.0, 0.25, 0.12
    sound = fftconvolve(train, fftconvolve(burst, echo))[: len(train)]
    clock = np.arange(len(train)) / RATE_HZ
    motor = sum(np.sin(2 * np.pi * tone * clock + tone) / (1 + tone / 500) for tone in (50, 100, 1190, 2380, 4760))
    return sound + hum * motor + noise * rng.standard_normal(len(train))


def write_wav(path: Path, sound: np.ndarray, kind: type = np.int16, rate_hz: int = RATE_HZ) -> Path:
    """A WAV of a sound, full scale 1."""
    if kind is np.uint8:
        samples = np.clip(np.round(128 * sound) + 128, 0, 255).astype(kind)
    elif kind is np.float32:
        samples = sound.astype(kind)
    else:
        full = np.iinfo(kind).max
        samples = np.clip(np.round(full * sound), -full, full).astype(kind)
    wavfile.write(path, rate_hz, samples)
    return path


def correlated(rng: np.random.Generator, n: int, memory: float = 0.8) -> np.ndarray:
    """Noise of unit variance whose neighbours are correlated by `memory`."""
    noise = rng.standard_normal(n)
    for place in range(1, n):
        noise[place] = memory * noise[place - 1] + np.sqrt(1 - memory**2) * noise[place]
    return noise


def write_condition(folder: Path, time_s: np.ndarray, energy_J: np.ndarray, window_s: float, power_W: float) -> Path:
    """A folder as of `millprint card`, with one run at 300 rpm that has these collisions with the wall."""
    content = card_content(speed_rpm=300.0)
    content["fingerprint"]["descriptors"]["power_W"] = {
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
        group.attrs.update({"is_histogram": False, "begin_s": 0.5, "window_s": window_s})
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
