"""Each mill of the box in a known limit, which its motion and its physics must meet for any size."""

import math

import h5py
import numpy as np
import pytest

from millprint.config.sweep import Case, DemConfig
from millprint.config.view import ViewConfig
from millprint.dem.layout import SNAPSHOT
from millprint.dem.ledger import closure, ledger_series
from millprint.dem.run import run_case
from millprint.dem.run import simulate as simulated
from millprint.dem.simulation import Simulation
from millprint.fingerprint.descriptors import said_of, tabulate_descriptors
from millprint.mill.bodies import build_bodies
from millprint.mill.motion import POSE
from millprint.view.frames import read_movie
from millprint.view.paraview import export_run
from tests import poses

DEM = DemConfig(time_step_s=4e-6, settle_s=0.1, window_s=0.3)
GRAVITY = 9.81
DISSIPATED = ["normal_damping_J", "tangential_damping_J", "sliding_J", "rolling_J"]


def simulate(mill, contact, speed_rpm: float, closure_max: float = 2e-3, **changes):
    """A run, and what it dissipates [W]: the work of a wall also lifts and lowers the balls within a turn."""
    described = {
        "mill": mill.name, "contact": contact.name, "ball_diameter_m": 0.01, "fill_ratio": 0.1,
        "speed_hz": speed_rpm / 60, "seed": 0, "settle_s": 0.1, "discard_s": 0.1, "window_s": 0.5,
        "rayleigh_fraction": 0.03,
    }  # fmt: skip
    simulation = Simulation(Case(**{**described, **changes}), mill, contact, DEM)
    series = ledger_series(np.concatenate(simulation.run("test").samples))
    assert closure(series) < closure_max
    return simulation, series[DISSIPATED].iloc[-1].sum() / simulation.window_s


def exponents(powers: list[float], speeds: list[float]) -> np.ndarray:
    return np.diff(np.log(powers)) / np.diff(np.log(speeds))


def accelerations(body, point: np.ndarray, times: np.ndarray, step: float = 1e-6) -> np.ndarray:
    """Accelerations (n, 3) of a point of a body by differences of the wall's velocity."""

    def velocity(now):
        spin, place = poses.angular_velocity(body.motion, now), body.motion.rotation(now) @ point
        return poses.velocity(body.motion, now) + np.cross(spin, place)

    return (velocity(times + step) - velocity(times - step)) / (2 * step)


def test_the_jar_of_the_emax_translates_with_one_acceleration(mills):
    (jar,) = build_bodies(mills["emax"], 20.0)
    found = accelerations(jar, jar.vessel.vertices[0], np.linspace(0.01, 0.05, 50))
    assert np.linalg.norm(found, axis=1) == pytest.approx(0.017 * (2 * math.pi * 20) ** 2, rel=1e-6)


@pytest.mark.slow
def test_the_torque_of_the_drive_does_the_work_of_the_walls(mills, contacts):
    """Eqs 3.24 and 3.25: omega times the mean torque about the centre, from the momentum of the balls."""
    case = Case(
        mill="emax", contact="calibrated", ball_diameter_m=0.01, fill_ratio=0.1, speed_hz=10.0, seed=0, settle_s=0.1,
        discard_s=0.2, window_s=0.3, rayleigh_fraction=0.03, snapshot_interval_s=1e-4,
    )  # fmt: skip
    simulation = Simulation(case, mills["emax"], contacts["calibrated"], DEM)
    recording = simulation.run("test")
    state, pose = np.concatenate(recording.snapshots), np.concatenate(recording.poses)[:, 0]
    mass = simulation.balls.mass[simulation.balls.species]
    place = SNAPSHOT.velocity_m_s.x
    momentum = np.einsum("n,tnc->tc", mass, state[:, :, place : place + 3])
    # What the wall does to the balls besides gravity; its reaction is what the drive is loaded with.
    force = np.diff(momentum, axis=0) / 1e-4 + [0, 0, GRAVITY * mass.sum()]
    arm = (pose[1:, POSE.position.x : POSE.position.x + 3] + pose[:-1, POSE.position.x : POSE.position.x + 3]) / 2
    torque = np.cross(arm, force)[:, 2]
    series = ledger_series(np.concatenate(recording.samples))
    power = series["wall_work_J"].iloc[-1] / simulation.window_s
    turning = 2 * math.pi * 10 * (1 if np.cross(arm[0], arm[1])[2] > 0 else -1)
    assert turning * torque.mean() == pytest.approx(power, rel=0.01)
    assert power > 0


def test_the_planetary_jar_has_the_acceleration_of_its_two_rotations(mills):
    """Towards the sun's axis R w^2, towards the jar's r (1 + k)^2 w^2: between their sum and their difference."""
    (jar,) = build_bodies(mills["planetary"], 5.0)
    w, radius = 2 * math.pi * 5, 0.0375
    found = np.linalg.norm(accelerations(jar, np.array([radius, 0, 0.03]), np.linspace(0.01, 0.41, 4001)), axis=1)
    assert found.max() == pytest.approx((0.0705 + radius) * w**2, rel=1e-4)
    assert found.min() == pytest.approx((0.0705 - radius) * w**2, rel=1e-4)


def test_the_arm_of_the_shaker_draws_a_figure_of_eight(mills):
    """Sideways it goes to and fro twice in a turn, along the vial once, and passes its middle twice."""
    (vial,) = build_bodies(mills["spex"])
    times = np.arange(720) / 720
    x, y, _ = vial.motion.position(times).T
    assert np.ptp(y) == pytest.approx(0.059, rel=1e-3)
    assert np.ptp(x) == pytest.approx(0.025, rel=1e-3)
    crossings = [int((np.sign(c) != np.sign(np.roll(c, 1))).sum()) for c in (x + 1e-9, y + 1e-9)]
    assert crossings == [4, 2]


@pytest.mark.slow
@pytest.mark.parametrize("name", ["spex", "mixer"])
def test_the_power_of_a_shaken_vessel_goes_with_the_cube_of_its_frequency(mills, contacts, name):
    """At fixed amplitude and far above g nothing but the frequency sets a time: P ~ f^3."""
    speeds = [15 * 60, 30 * 60]
    powers = [simulate(mills[name], contacts["calibrated"], speed, window_s=0.8)[1] for speed in speeds]
    assert exponents(powers, speeds) == pytest.approx(3, abs=0.25)


@pytest.mark.slow
def test_the_jar_of_the_mixer_mill_stays_on_its_horizontal_arc(mills):
    (jar,) = build_bodies(mills["mixer"], 25.0)
    times, pivot = np.linspace(0, 0.08, 400), np.array([0, -0.13, 0])
    arm = jar.motion.position(times) - pivot
    assert np.linalg.norm(arm, axis=1) == pytest.approx(0.13)
    assert np.abs(arm[:, 2]).max() < 1e-12
    # The jar's axis stays along the arc.
    along = jar.motion.rotation(times) @ np.array([1.0, 0, 0])
    assert np.abs((along * arm).sum(axis=1)).max() < 1e-12
    assert np.abs(arm[:, 0]).max() == pytest.approx(0.02, rel=0.01)


@pytest.mark.slow
def test_a_planetary_jar_with_few_balls_has_no_impacts_and_says_so(mills, contacts):
    """All balls go round the smooth wall as one layer, rubbing it (fill 0.08); more balls fall and hit (0.20)."""
    summaries = []
    for fill in (0.08, 0.20):
        case = Case(
            mill="planetary", contact="calibrated", ball_diameter_m=0.01, fill_ratio=fill, speed_hz=400 / 60, seed=0,
            settle_s=0.1, discard_s=0.3, window_s=0.6, rayleigh_fraction=0.11,
        )  # fmt: skip
        summaries.append(simulated(case, mills["planetary"], contacts["calibrated"], DEM))
    table = tabulate_descriptors(summaries, "gap_0_02")
    assert said_of(table, "no_impacts").tolist() == [True, False]
    assert (table["tangential_power_W"] > 5).all()
    assert table["normal_power_W"].iloc[0] < 0.1 < 1 < table["normal_power_W"].iloc[1]


def test_a_ball_of_the_mixer_mill_flies_from_end_to_end_and_back_in_a_turn(mills, contacts):
    """One ball in a jar swung far above g hits each end about once a turn: its way along the jar reverses twice."""
    mill = mills["mixer"].model_copy(update={"volume_ml": 0.6})
    simulation = Simulation(
        Case(mill="mixer", contact="calibrated", ball_diameter_m=0.01, fill_ratio=0.9, speed_hz=25.0, seed=0,
             settle_s=0.05, discard_s=0.2, window_s=0.8, rayleigh_fraction=0.03, snapshot_interval_s=1e-3),
        mill, contacts["calibrated"], DEM,
    )  # fmt: skip
    assert simulation.count == 1
    recording = simulation.run("test")
    ball = np.concatenate(recording.snapshots)[:, 0, :3]
    pose = np.concatenate(recording.poses)[:, 0]
    inside = np.einsum("nji,nj->ni", pose[:, 9:].reshape(-1, 3, 3), ball - pose[:, :3])[:, 0]
    sides = np.sign(inside[np.abs(inside) > 0.005])
    crossings = (np.diff(sides) != 0).sum() / (simulation.window_s * 25)
    assert 1.5 < crossings <= 2.1


@pytest.mark.slow
def test_the_bed_of_a_vibratory_mill_takes_power_only_where_it_can_move_in_the_tube(mills, contacts):
    """At a tenth of g the apparent gravity leans by 6 degrees, under any angle of repose, and the charge rides along.

    At four g it is thrown. Power over omega^3, which the scaling holds constant, tells the two apart.
    """
    amplitude = 0.0024
    scaled = {}
    for g in (0.1, 4.0):
        w = math.sqrt(g * GRAVITY / amplitude)
        _, power = simulate(mills["vibratory"], contacts["calibrated"], w * 30 / math.pi, fill_ratio=0.28, settle_s=0.3,
                            discard_s=0.1, window_s=0.2, rayleigh_fraction=0.1, closure_max=0.05)  # fmt: skip
        scaled[g] = power / w**3
    assert abs(scaled[0.1]) < 0.1 * scaled[4.0]


@pytest.mark.slow
def test_an_attritor_is_driven_against_friction_not_inertia(mills, contacts):
    """In a dense bed the torque is Coulomb's and hardly depends on the speed.

    So power goes with its first power, less where the bed opens, and is far from its cube.
    """
    made = mills["attritor"]
    settings = {
        "ball_diameter_m": 0.009,
        "fill_ratio": 0.26,
        "window_s": 0.6,
        "discard_s": 0.3,
        "rayleigh_fraction": 0.1,
    }
    # The bed jams and slips: a start may have three times the power of others.
    starts = {60: range(4), 180: range(3)}
    powers = [
        np.median([simulate(made, contacts["calibrated"], speed, seed=seed, **settings)[1] for seed in seeds])
        for speed, seeds in starts.items()
    ]
    (found,) = exponents(powers, [*starts])
    assert 0 < found < 1.7


@pytest.mark.slow
def test_the_drum_of_the_box_cascades_below_its_critical_speed_and_centrifuges_above(mills, contacts):
    critical = 30 / math.pi * math.sqrt(GRAVITY / (0.05 - 0.005))
    slips = {}
    for share in (0.6, 4.0):
        simulation, power = simulate(mills["drum"], contacts["calibrated"], share * critical, fill_ratio=0.15,
                                     settle_s=0.15, discard_s=0.6, window_s=0.4, rayleigh_fraction=0.1,
                                     closure_max=0.02)  # fmt: skip
        body, now = simulation.bodies[0], simulation.counters[0] * simulation.step
        wall = np.cross(poses.angular_velocity(body.motion, now), simulation.balls.position - body.motion.position(now))
        speed = share * critical * math.pi / 30 * 0.05
        slips[share] = np.linalg.norm(simulation.balls.velocity - wall, axis=1).mean() / speed
        assert power > 0
    # Gravity still rolls to and fro what turns with the wall: with g / 1.4 along it for half a turn, which is up to
    # 5 / 7 (w_c / w)^2 of the wall's speed, and less where rolling friction holds it.
    assert slips[4.0] < 5 / 7 / 4.0**2 and slips[0.6] > 0.5, slips


@pytest.mark.slow
def test_the_arms_of_an_attritor_are_seen_where_they_are(mills, contacts, tmp_path):
    """Pictures and the files for ParaView hold every body in its place, and contacts end on the body touched."""
    case = Case(
        mill="attritor", contact="calibrated", ball_diameter_m=0.009, fill_ratio=0.05, speed_hz=10.0, seed=0,
        settle_s=0.1, discard_s=0.0, window_s=0.1, rayleigh_fraction=0.03, snapshot_interval_s=2e-3,
    )  # fmt: skip
    mill, run = mills["attritor"], tmp_path / "run.h5"
    run_case(case, mill, contacts["calibrated"], DEM, run, tmp_path / "summary.json")
    bodies = build_bodies(mill, 10.0)
    files = [tmp_path / f"{name}.vtkhdf" for name in ("balls", "walls", "contacts")]
    steps = export_run(run, *files)
    with h5py.File(files[1]) as walls, h5py.File(files[2]) as contacts_file:
        root, lines = walls["VTKHDF"], contacts_file["VTKHDF"]
        points = root["Points"][:].reshape(steps, -1, 3)
        assert points.shape[1] == sum(len(body.vessel.triangles()[0]) for body in bodies)
        # Half a turn a tenth of a second: the last snapshot has the arms where the motion says.
        times = root["Steps/Values"][:]
        upper = bodies[-1].to_laboratory(bodies[-1].vessel.triangles()[0], times[-1])
        assert points[-1, -len(upper) :] == pytest.approx(upper, abs=1e-6)
        assert set(root["CellData/body"][:]) == set(range(len(bodies)))
        ends = lines["Points"][:].reshape(-1, 2, 3)
        is_wall = lines["CellData/partner"][:] == 1
        reach = np.linalg.norm(ends[is_wall, 1] - ends[is_wall, 0], axis=1)
        assert len(reach) > 100
        # A foot on another body, or on one in another pose, would be millimetres off.
        assert reach == pytest.approx(0.0045, abs=2e-4)
    movie = read_movie(run, ViewConfig())
    first, later = (movie.frames[k].pictures[0].insert_mm for k in (0, 10))
    assert len(first)
    assert movie.frames[0].revolution is not None
    assert len(first) != len(later) or np.abs(first - later).max() > 1
