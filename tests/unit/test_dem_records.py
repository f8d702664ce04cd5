"""What a simulation records: its summary, its ledger, its contacts and its snapshots agree."""

import json
from types import SimpleNamespace

import h5py
import numpy as np
import pandas as pd
import pytest

from millprint.config.counting import DEFAULT_RULES
from millprint.config.errors import SimulationError
from millprint.config.included import load_contact, load_mill
from millprint.config.sweep import Case, DemConfig
from millprint.dem import ledger, store
from millprint.dem.layout import COUNTER, HEIGHT, LAW, LAW_WIDTH, OCCUPANCY, SAMPLE, SNAPSHOT, SNAPSHOT_TOTAL, TOTAL
from millprint.dem.ledger import AIM, check_closure, closure, ledger_series, ledger_summary, work_scale
from millprint.dem.recording import SAMPLE_NAMES, Recording, begin_window, end_window, make_recorder, make_table
from millprint.dem.run import run_case
from millprint.mill.kernel_columns import span_of, width_of
from millprint.mill.walls import SURFACE
from millprint.observables.counted_collisions import CHANNELS
from millprint.run.files import read_json
from tests.conftest import ROOT
from tests.physics.setups import FewBalls, uniform

DEM = DemConfig(time_step_s=4e-6, settle_s=0.1, window_s=0.1)


def run(folder, dem=DEM, **change):
    """A short run of the Emax mill with 24 balls, its files in `folder`."""
    settings = {"ball_diameter_m": 0.01, "fill_ratio": 0.1, "speed_hz": 5, "seed": 0}
    settings |= {"settle_s": 0.05, "discard_s": 0.0, "window_s": 0.1}
    case = Case(mill="emax", contact="calibrated", **(settings | change))
    mill = load_mill("emax")
    contact = load_contact("calibrated")
    return run_case(case, mill, contact, dem, folder / "run.h5", folder / "summary.json")


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    folder = tmp_path_factory.mktemp("run")
    run(folder, window_s=0.45, snapshot_interval_s=1e-3)
    return folder


def test_summary_and_run_agree(files):
    summary = read_json(files / "summary.json")
    with h5py.File(files / "run.h5") as file:
        assert json.loads(file.attrs["config"])["case"] == summary["case"]
        assert file["ledger/wall_work_J"].attrs["units"] == "J"
        assert file["ledger/wall_work_J"][-1] == pytest.approx(summary["ledger_J"]["wall_work"])
        normal = file["collisions/normal_J"][:].sum()
        assert normal / summary["window_s"] == pytest.approx(summary["power_W"]["normal"], rel=1e-3)
        assert file["occupancy/count"][:].sum() > 0
        assert (file["occupancy/granular_temperature"][:][file["occupancy/count"][:] > 5] >= 0).all()
    # To half a ball of 24, the balls fill a tenth of the nominal volume.
    volume = summary["balls"] * np.pi / 6 * summary["ball_diameter_m"] ** 3
    assert volume / summary["nominal_volume_m3"] == pytest.approx(0.1, rel=0.03)
    assert [rule["name"] for rule in summary["collisions"]] == [rule.name for rule in DEFAULT_RULES]
    for rule in summary["collisions"]:
        kept = rule["frequency_hz"] * rule["mean_normal_J"]
        assert kept == pytest.approx(summary["power_W"]["normal"], rel=1e-3)


def test_balls_in_free_flight_are_recorded_by_hand():
    """Three balls, of which two just touch, in a box that moves along x; the grid ends before the last one."""
    place = np.array([[-0.05, 0.01, 0.1], [0.03, -0.02, 0.12], [0.0, 0.085, 0.12]])
    place[0] = place[1] + (9e-3 - 1e-10) * np.array([-0.6, 0.0, -0.8])
    speed, spin = np.array([[0.1, -0.3, 0.2]] * 2 + [[0, 0, 0.7]]), np.array([[1, 2, 3], [1, 2, 3], [0, 0, 4.0]])
    spin[:2], radius, drive, fall = 0.0, np.array([5e-3, 4e-3, 5e-3]), np.array([0.5, 0, 0]), np.array([0, 2.0, -9.81])
    world = FewBalls(place, speed, spin, radius, step=1e-5, gravity=fall, motion=uniform(drive))
    recorder = make_recorder(np.array([[-0.1, -0.1], [0.1, 0.05]]), 0.02, 3, 1, 10, (20, 20, 30), 10)
    world._advance(70, make_table(0), recorder)
    # A first step takes the speed as that of half a step before.
    speed = speed + fall * 5e-6

    def at(step: int) -> tuple[np.ndarray, np.ndarray]:
        return place + speed * (time := step * 1e-5) + fall * time**2 / 2, speed + fall * time

    mass = 7700 * 4 / 3 * np.pi * radius**3
    for n, step in enumerate((10, 30, 50, 70)):
        position, velocity = at(step)
        found = recorder.snapshot[n]
        assert found[:, span_of(SNAPSHOT.position_m)] == pytest.approx(position, abs=1e-8)
        assert found[:, span_of(SNAPSHOT.velocity_m_s)] == pytest.approx(velocity, abs=1e-5)
        assert found[:, span_of(SNAPSHOT.spin_rad_s)] == pytest.approx(spin, abs=1e-3)
        assert recorder.snapshot_pose[n, 0, 0] == pytest.approx(0.5 * step * 1e-5)
        about = recorder.snapshot_total[n]
        assert about[[SNAPSHOT_TOTAL.time_s, SNAPSHOT_TOTAL.contacts]] == pytest.approx([step * 1e-5, n + 1])
        energies = recorder.sample[n, [SAMPLE.kinetic_translation_J, SAMPLE.kinetic_spin_J, SAMPLE.potential_J]]
        turning = 2 / 5 * mass[2] * radius[2] ** 2 * 4**2 / 2
        known = [mass @ (velocity**2).sum(axis=1) / 2, turning, -mass @ (position @ fall)]
        assert energies == pytest.approx(known, rel=1e-5) and recorder.sample[n, SAMPLE.time_s] == step * 1e-5
    cells, heights = np.zeros_like(recorder.occupancy), np.zeros_like(recorder.height)
    for step in (10, 40, 70):
        position, velocity = at(step)
        own, relative = position - drive * step * 1e-5, velocity - drive
        for i in range(2):
            cell = cells[int((own[i, 0] + 0.1) / 0.02), int((own[i, 1] + 0.1) / 0.02)]
            cell[OCCUPANCY.balls] += 1
            cell[span_of(OCCUPANCY.velocity)] += relative[i]
            cell[OCCUPANCY.speed_squared] += relative[i] @ relative[i]
        heights[[HEIGHT.total, HEIGHT.balls, HEIGHT.vessel_squared]] += own[:, 2].sum(), 3, 3 * 0.25
        heights[HEIGHT.relative_squared] += (relative**2).sum()
    assert recorder.occupancy == pytest.approx(cells, rel=1e-4, abs=1e-4) and recorder.occupancy.shape[:2] == (10, 8)
    assert recorder.height == pytest.approx(heights, rel=1e-4)
    # The same under other names: what was ball 0 is ball 2.
    end_window(world.candidates, world.open_contacts, world.walls, 71e-5, world.counters, table := make_table(5))
    recording = Recording((), recorder.occupancy, recorder.height)
    recording.drain(table, recorder, world.counters, np.array([2, 0, 1]))
    assert recording.snapshots[0][:, [2, 0, 1]] == pytest.approx(recorder.snapshot[:4])
    assert np.sort(recording.snapshot_contacts[0]).tolist() == [[0, 2]] * 4
    row = recording.table
    assert sorted([row.first[0], row.second[0]]) == [0, 2] and len(row.first) == 1 and row.ended[0] == 0
    assert (
        row.value[0, :2] == pytest.approx([0, 71e-5]) and not world.counters[[COUNTER.records, COUNTER.samples]].any()
    )
    assert recording.height_m == pytest.approx(heights[HEIGHT.total] / 9)
    assert recording.speed_over_vessel**2 == pytest.approx(heights[HEIGHT.relative_squared] / (9 * 0.25))


def test_what_a_window_counts_and_what_was_before_it_add_up():
    """A hit on the floor in whose middle the window begins."""
    whole, cut = (FewBalls([0, 0, 5.01e-3], [0.5, 0.1, -1.0], step=1e-6) for _ in range(2))
    whole.run(3e-4)
    cut.run(5e-5)
    begin_window(cut.open_contacts, cut.totals, cut.counters)
    before = cut.totals.copy()
    cut.run(3e-4)
    for name, at in (("normal_J", TOTAL.normal_damping_J), ("rolling_J", TOTAL.rolling_J)):
        assert 0 < before[at] < whole.totals[at]
        assert cut.contacts[name].to_list() == pytest.approx([whole.totals[at] - before[at]])
    assert cut.totals == pytest.approx(whole.totals)
    with pytest.raises(SimulationError, match="more than 1 contacts ended"):
        FewBalls([[0, 0, 5.01e-3], [0.02, 0, 5.01e-3]], [0, 0, -1.0], step=1e-6).run(3e-4, rows=1)


def test_values_of_collisions_are_rounded_evenly_and_compress_better(tmp_path):
    """By 2^-16 at most; of random numbers a byte of four is saved."""
    values = np.random.default_rng(3).lognormal(sigma=4, size=20_000) * np.where(np.arange(20_000) % 3, 1, -1)
    values[:2] = 0.0, 2.0**-30
    kept = store.rounded(values)
    assert np.array_equal(kept[:2], values[:2])
    change = kept[2:] / values[2:] - 1
    assert np.abs(change).max() <= 2**-16 and abs(change.mean()) < 1e-6
    assert np.array_equal(kept, kept.astype(np.float32))
    with h5py.File(tmp_path / "sizes.h5", "w") as file:
        for name, numbers in (("all", values), ("kept", kept)):
            store.put(file, name, numbers, narrow=True)
        assert file["kept"].id.get_storage_size() < 0.8 * file["all"].id.get_storage_size()


def test_a_ledger_adds_up_by_hand():
    counted = {"wall_work_J": [1, 11], "normal_damping_J": [2, 4], "tangential_damping_J": [1, 2]}
    counted |= {"rolling_J": [1, 1.5], "tangential_work_J": [3, 7], "elastic_normal_J": [0.5, 0.75]}
    counted |= {"elastic_tangential_J": [0.25, 0.5], "kinetic_translation_J": [4, 7], "kinetic_spin_J": [1, 1.5]}
    counted |= {"potential_J": [2, 1.5]}
    samples = pd.DataFrame({"time_s": [0, 1], **counted}).reindex(columns=SAMPLE_NAMES, fill_value=0).to_numpy(float)
    totals = ledger_summary(series := ledger_series(samples))
    # Of 4 J of tangential work 1 is damping and 0.25 is in the springs.
    assert totals["sliding"] == pytest.approx(2.75)
    assert (totals["wall_work"], totals["gravity_work"]) == (10, 0.5)
    assert (totals["kinetic_change"], totals["elastic_change"]) == (3.5, 0.5)
    # 10.5 J of work, of which 4 are stored and 2 + 1 + 2.75 + 0.5 dissipated.
    assert totals["imbalance"] == pytest.approx(0.25) and closure(series) == pytest.approx(0.025)
    # Walls at rest: a tenth of what is dissipated, or of what the balls rise and fall by, whichever is more.
    at_rest = series.assign(wall_work_J=0.0)
    assert work_scale(at_rest) == pytest.approx(0.625)
    assert work_scale(at_rest.assign(potential_J=[2.0, 42.0])) == pytest.approx(4.0)
    assert check_closure(series, 0.026) == closure(series)
    with pytest.raises(SimulationError, match=r"open by 2\.5 % of the wall work"):
        check_closure(series, 0.024)


def test_a_jam_is_a_ball_pressed_from_two_sides_for_long():
    """Ball 0 at the wall and with balls 1 and 2, for more than ten impacts; ball 3 elsewhere; and a hit of ball 0."""
    contacts = pd.DataFrame(
        {"first": [0, 0, 0, 3, 0], "second": [-1, 1, 2, 4, 5], "duration_s": [22.0, 22, 22, 22, 18]}
    )
    contacts["peak_force_N"] = [10.0, 4.0, 5.0, 20.0, 30.0]
    one = np.ones(len(contacts))
    hits = ledger.Hits(mass=one, taken=one, reached=2 * one, excess=one)
    assert ledger._pressed_with(0, contacts, hits) == [2, 1]
    assert ledger._pressed_with(1, contacts, hits) == [0, 2]
    # Nothing presses ball 3 from another side, and a hit is no jam.
    assert ledger._pressed_with(3, contacts, hits) == [] and ledger._pressed_with(4, contacts, hits) == []
    # What presses it holds 9 N: a third of 26 N, and not of 28 N.
    for force, others in ((26.0, [2, 1]), (28.0, [])):
        assert ledger._pressed_with(0, contacts.assign(peak_force_N=[force, 4.0, 5.0, 20.0, 30.0]), hits) == others


def test_a_contact_as_an_impact_is_by_hand():
    """Balls of 3 and 6 g that met at 1.5 m/s and overlap as after 3 m/s; and one that was pressed to the wall."""
    laws = SimpleNamespace(wall=np.zeros((width_of(SURFACE), 2, LAW_WIDTH)), pair=np.zeros((2, 2, LAW_WIDTH)))
    laws.pair[0, 1, LAW.normal_stiffness], laws.wall[SURFACE.rough, 1, LAW.normal_stiffness] = 1e9, 5e8
    balls = SimpleNamespace(species=np.array([0, 1]), mass=np.array([3e-3, 6e-3]))
    met, overlap = ((5 / 4 * 2e-3 * speed**2 / 1e9) ** 0.4 for speed in (1.5, 3))
    contacts = pd.DataFrame({"first": [0, 1], "second": [1, -1], "approach_speed_m_s": [1.5, -0.1]})
    contacts["peak_overlap_m"] = [overlap, 1e-5]
    hits = ledger._as_impacts(SimpleNamespace(contact=load_contact("calibrated"), balls=balls, laws=laws), contacts)
    assert hits.mass == pytest.approx([2e-3, 6e-3])
    # Hertz: 2/5 k d^(5/2) is stored, of which the approach brought m v^2 / 2; an impact takes 2.9432 d / v.
    assert hits.excess == pytest.approx([2e-3 / 2 * (9 - 2.25), 0.4 * 5e8 * 1e-5**2.5])
    assert (hits.taken[0], hits.reached[0]) == pytest.approx((2.9432 * met / 1.5, 2.9432 * overlap / 3))


def test_the_ledger_is_a_series_finer_than_a_revolution_and_sums_to_it(files):
    """A window of 2.25 revolutions at 300 rpm: the quarter is in the series and in no revolution."""
    summary = read_json(files / "summary.json")
    with h5py.File(files / "run.h5") as file:
        ledger = {name: dataset[:] for name, dataset in file["ledger"].items()}
    samples = DEM.ledger_samples_per_revolution
    assert summary["revolutions"] == pytest.approx(2.25)
    assert len(ledger["time_s"]) == 1 + 2.25 * samples
    assert np.diff(ledger["time_s"]) == pytest.approx(0.2 / samples)
    tangential = ledger["tangential_damping_J"] + ledger["sliding_J"]
    series = {"normal_J": ledger["normal_damping_J"], "tangential_J": tangential, "wall_J": ledger["wall_work_J"]}
    series["rolling_J"] = ledger["rolling_J"]
    squares = {f"{name}_square_J2" for name in CHANNELS}
    assert set(summary["per_revolution"]) == set(series) | squares
    for name, values in series.items():
        turns = values[[0, samples, 2 * samples]]
        assert summary["per_revolution"][name] == pytest.approx(np.diff(turns).tolist())
    for name in ("normal", "tangential"):
        # Of two turns of 0.2 s: half their difference is the standard error of their mean.
        (difference,) = np.abs(np.diff(summary["per_revolution"][f"{name}_J"]))
        assert summary["power_standard_error_W"][name] == pytest.approx(difference / 2 / 0.2)
    balance = ledger["wall_work_J"] + ledger["gravity_work_J"] - ledger["imbalance_J"]
    for name in ("normal_damping_J", "tangential_damping_J", "sliding_J", "rolling_J"):
        balance -= ledger[name]
    for name in ("kinetic_J", "elastic_J"):
        balance -= ledger[name] - ledger[name][0]
    assert balance == pytest.approx(0.0, abs=1e-12)


def test_every_key_of_a_summary_is_documented(files):
    text = (ROOT / "workflow/outputs.md").read_text()
    summary = read_json(files / "summary.json")
    keys = [*summary, *summary["collisions"][0], *summary["weighted"], *summary["weighted"]["normal"]]
    assert [key for key in keys if f"`{key}`" not in text] == []


def test_an_open_balance_fails_the_run_and_leaves_no_file(tmp_path):
    with pytest.raises(SimulationError, match=r"energy balance is open by .*closure_max .* make time_step_s"):
        run(tmp_path, DEM.model_copy(update={"closure_max": 1e-9}))
    assert list(tmp_path.iterdir()) == []


def test_a_case_has_its_own_bound_on_the_balance(tmp_path):
    strict = DEM.model_copy(update={"closure_max": 1e-9})
    assert run(tmp_path, strict, closure_max=0.02)["closure"] < 0.02


@pytest.mark.slow
def test_a_step_by_the_rayleigh_time_is_shortened_until_the_balance_closes(tmp_path):
    open_case = {"rayleigh_fraction": 0.1, "rayleigh_fraction_max": 0.4}
    found = run(tmp_path, closure_max=1.0, **open_case)
    largest = 0.6 * found["closure"]
    shorter = run(tmp_path, closure_max=largest, **open_case)
    assert shorter["closure"] <= largest
    assert shorter["rayleigh_fraction"] == pytest.approx(0.1 * (0.6 * AIM) ** 0.5, rel=0.02)
    # Both files say which step was taken, and nothing is left of the first attempt.
    with h5py.File(tmp_path / "run.h5") as file:
        assert json.loads(file.attrs["config"])["case"] == shorter["case"]
    assert {path.name for path in tmp_path.iterdir()} == {"run.h5", "summary.json"}
    with pytest.raises(SimulationError, match="energy balance is open"):
        run(tmp_path, closure_max=1e-9, **open_case)


def test_a_long_table_is_not_kept(files, tmp_path, monkeypatch):
    """The same run with room for no row: the summary counts its contacts as before."""
    monkeypatch.setattr(store, "COLLISION_ROWS_MAX", 10)
    small = run(tmp_path, DEM, window_s=0.45, snapshot_interval_s=1e-3)
    with h5py.File(files / "run.h5") as whole, h5py.File(tmp_path / "run.h5") as short:
        assert short["collisions"].attrs["rows"] == len(whole["collisions/first"])
        assert len(short["collisions"]) == 0
    assert small["collisions"] == read_json(files / "summary.json")["collisions"]


def test_snapshots_hold_the_work_and_the_contacts(files):
    with h5py.File(files / "run.h5") as file:
        snapshots = {name: dataset[:] for name, dataset in file["snapshots"].items()}
        ledger = {name: dataset[:] for name, dataset in file["ledger"].items()}
    assert np.diff(snapshots["time_s"]) == pytest.approx(1e-3)
    assert len(snapshots["time_s"]) == 451
    assert snapshots["normal_J"].sum() == pytest.approx(ledger["normal_damping_J"][-1], rel=1e-6)
    tangential = ledger["tangential_damping_J"][-1] + ledger["sliding_J"][-1]
    assert snapshots["tangential_J"].sum() == pytest.approx(tangential, rel=1e-6)
    assert snapshots["contact_offset"][-1] == len(snapshots["contact_first"])
    # Two balls in contact are nearer than a diameter (or have just come apart).
    for m in (50, 300):
        rows = slice(*snapshots["contact_offset"][m : m + 2])
        first, second = snapshots["contact_first"][rows], snapshots["contact_second"][rows]
        pairs = second >= 0
        away = snapshots["position_m"][m, first[pairs]] - snapshots["position_m"][m, second[pairs]]
        assert (np.linalg.norm(away, axis=1) < 0.01).all()
    assert np.abs(snapshots["body_position_m"][:, 2]).max() == 0
