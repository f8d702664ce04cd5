"""One measured piece of work in a process of its own, so that its memory and time are its own.

    python -m millprint.growth.work fit DESCRIPTORS CONDITIONS OUT
    python -m millprint.growth.work ask FINGERPRINT TIMES
    python -m millprint.growth.work simulate BENCH_CONFIG BALLS THREADS

It prints a JSON object with what it found.
"""

import json
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd

from millprint.bench.cases import Setup, count_steps, start_from
from millprint.bench.large import large_setup, large_start
from millprint.config.bench import BenchConfig
from millprint.config.checks import CONTACT_FOLDER, MILL_FOLDER
from millprint.config.contact import ContactConfig
from millprint.config.load import check_model, load_named, read_yaml
from millprint.config.mill import MillConfig
from millprint.fingerprint.curves import CURVES
from millprint.fingerprint.descriptors import read_descriptors
from millprint.fingerprint.model import Fingerprint

# A ball-step is measured over so many of them, and at least over the time of the bench's large case.
BALL_STEPS = 2e8
# The case of the bench whose fill ratio they have.
COMPARED_WITH = "191x5mm"
# The scatter of made conditions about the measured ones [-].
JITTER, SCATTER = 0.03, 0.02


def grown(table: pd.DataFrame, conditions: int) -> pd.DataFrame:
    """So many conditions, from measured ones: each near one of them in fill ratio, with a little scatter."""
    rng = np.random.default_rng(conditions)
    made = table.iloc[np.arange(conditions) % len(table)].reset_index(drop=True)
    near = np.where(np.arange(conditions) < len(table), 0.0, 1.0)
    made["fill_ratio"] *= 1 + JITTER * near * rng.uniform(-1, 1, conditions)
    for quantity in CURVES:
        made[quantity] = made[quantity] * (1 + SCATTER * near * rng.normal(size=conditions))
    return made


def fit(descriptors: str, conditions: str, out: str) -> dict:
    """Fit a fingerprint to so many conditions, and write it."""
    table = read_descriptors(descriptors)
    first = table[(table["mill"] == table["mill"].iloc[0]) & (table["contact"] == table["contact"].iloc[0])]
    begin = time.process_time()
    fingerprint = Fingerprint.fit(grown(first, int(conditions)), 125e-6, 0.95)
    found = {"processor_s": time.process_time() - begin}
    fingerprint.write(out)
    return {**found, "file_MB": Path(out).stat().st_size / 1e6}


def ask(path: str, times: str) -> dict:
    """Read a fingerprint, and predict so many conditions one by one."""
    begin = time.process_time()
    fingerprint = Fingerprint.read(path)
    read = time.process_time()
    low, high = fingerprint.fill_range
    speed, diameter, _ = fingerprint.settings[0]
    for fill in np.linspace(low, high, int(times)):
        fingerprint.predict(fingerprint.condition(speed_hz=speed, ball_diameter_m=diameter, fill_ratio=float(fill)))
    return {"processor_s": (time.process_time() - read) / int(times), "read_s": read - begin}


def simulate(config_file: str, balls: str, threads: str) -> dict:
    """The cost of a step of the bench's mill with so many balls, scaled up or down at the same fill ratio."""
    config = check_model(read_yaml(config_file), BenchConfig, config_file)
    large = config.large.model_copy(update={"balls": int(balls), "compared_with": COMPARED_WITH})
    config = config.model_copy(update={"large": large})
    mill = load_named(MILL_FOLDER, config.mill, MillConfig, "mill")
    contact = load_named(CONTACT_FOLDER, config.contact, ContactConfig, "contact set")
    setup = large_setup(config, mill, contact)
    # With as many threads, so that their code is compiled or read before anything is timed.
    start = large_start(setup, int(threads))
    return timed(setup, start, int(threads), config.large.driven_s)


def timed(setup: Setup, start: np.ndarray, threads: int, least_s: float) -> dict:
    """Time the driven mill from balls at rest, over about BALL_STEPS, and at least over `least_s` of its motion."""
    driven_s = max(least_s, BALL_STEPS / setup.balls * setup.time_step_s)
    simulation = start_from(setup, start, driven_s, threads)
    simulation.run(None)
    ball_steps = count_steps(simulation) * setup.balls
    return {
        "processor_s": simulation.processor_s,
        "ns_per_ball_step": simulation.wall_clock_s / ball_steps * 1e9,
        "processor_ns": simulation.processor_s / ball_steps * 1e9,
    }


WORK: dict[str, Callable[..., dict]] = {"fit": fit, "ask": ask, "simulate": simulate}

if __name__ == "__main__":
    print(json.dumps(WORK[sys.argv[1]](*sys.argv[2:])))
