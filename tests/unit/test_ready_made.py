"""The fingerprints that come with millprint belong to its mills as they are, and hold new simulations."""

import hashlib

import numpy as np
import pytest
from scipy.stats import norm
from scipy.stats import t as student

from millprint.cases.of_mill import mill_cases
from millprint.config.errors import ConfigError
from millprint.config.included import included_mills, load_contact, load_mill, shipped
from millprint.config.mill_sweep import MillsConfig
from millprint.config.sweep import DemConfig
from millprint.dem import PHYSICS
from millprint.dem.run import simulate
from millprint.fingerprint import readers
from millprint.fingerprint.descriptors import tabulate_descriptors
from millprint.fingerprint.model import Fingerprint
from millprint.fingerprint.readers import find_fingerprint
from millprint.observables.definitions import POWER_PARTS
from millprint.run.files import read_table

NAMES = readers.ready_made()


@pytest.fixture(scope="module")
def made():
    return read_table(str(shipped(readers.TABLE))).set_index("mill")


def test_the_box_has_them():
    box = {"planetary", "mixer", "spex", "emax", "vibratory", "attritor", "drum"}
    assert box == set(NAMES) <= set(included_mills())


@pytest.mark.parametrize("name", NAMES)
def test_a_fingerprint_is_of_the_mill_as_it_is(name, made):
    path = readers.find_ready_made(name)
    assert path is not None, "made of another mill: python tools/ship_fingerprints.py FOLDER"
    assert hashlib.sha256(path.read_bytes()).hexdigest() == made["sha256"][name]
    assert made["physics"][name] == PHYSICS
    assert Fingerprint.read(path).about["mill"] == name


def test_another_mill_of_the_same_name_has_none(monkeypatch):
    wider = load_mill("mixer").model_copy(update={"volume_ml": 11.0})
    monkeypatch.setattr(readers, "load_mill", lambda name: wider)
    assert readers.find_ready_made("mixer") is None


def test_a_run_takes_precedence(tmp_path):
    own = tmp_path / "mills/mixer/fingerprint.json"
    own.parent.mkdir(parents=True)
    own.write_bytes(find_fingerprint("mixer", tmp_path).read_bytes())
    assert find_fingerprint("mixer", tmp_path) == own
    # Where a run of `millprint new` writes.
    new = tmp_path / "mine/mills/mine/fingerprint.json"
    new.parent.mkdir(parents=True)
    new.write_bytes(own.read_bytes())
    assert find_fingerprint("mine", tmp_path) == new
    # The file of its run says where that is.
    run = tmp_path / "mine.yaml"
    run.write_text(f"mill: mine\nresults: {tmp_path / 'mine'}\n")
    assert find_fingerprint(str(run), "nowhere") == new
    run.write_text("mill: bead_drum\n")
    with pytest.raises(ConfigError, match=f"`millprint fingerprint {run}` writes it"):
        find_fingerprint(str(run), "nowhere")


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_a_condition_simulated_again_lies_within_its_band(name):
    fingerprint = Fingerprint.read(find_fingerprint(name, "nowhere"))
    mill = load_mill(name)
    cases = mill_cases(mill, MillsConfig(box=[name], contact="calibrated", precision="quick"))
    case = min(cases, key=lambda each: each.fill_ratio * each.window_s / each.ball_diameter_m**3)
    case = case.model_copy(update={"seed": 1_000_000})
    found = simulate(case, mill, load_contact("calibrated"), DemConfig())
    predicted = fingerprint.predict(
        fingerprint.condition(speed_hz=case.speed_hz, ball_diameter_m=case.ball_diameter_m, fill_ratio=case.fill_ratio)
    )
    known = predicted.wall_power_W
    (row,) = tabulate_descriptors([found], fingerprint.about["counting_rule"]).to_dict("records")
    # The band is of a longer window; this one is known to what its own turns say. Seven mills fail once in 140 runs.
    own = student.ppf(0.975, case.window_s * case.speed_hz - 1) * row["wall_power_relative_se"]
    room = norm.ppf(0.9995) / norm.ppf(0.975) * np.hypot(np.log(known.upper / known.value), own)
    power = row["wall_power_W"]
    assert abs(np.log(power / known.value)) < room
    # What a meter sees is what the balls dissipate, but for the imbalance of the ledger, and rolling is a part of it.
    parts = {name: row[name] for name in POWER_PARTS}
    imbalance_W = found["ledger_J"]["imbalance"] / found["window_s"]
    assert power - sum(parts.values()) == pytest.approx(imbalance_W, abs=1e-9)
    predicted_parts = [predicted.known[name] for name in POWER_PARTS]
    assert sum(part.value for part in predicted_parts) == pytest.approx(known.value, rel=1e-9)
    for name in known.intervals:
        assert all(part.ends(name)[1] <= known.ends(name)[1] for part in predicted_parts if name in part.intervals)
