"""The energy balance, the table of collisions, and runs that must agree to the last digit."""

import numpy as np
import pytest

from millprint.config.counting import CountingRule
from millprint.config.errors import SimulationError
from millprint.config.sweep import Case, DemConfig
from millprint.dem import resources
from millprint.dem.collisions import by_surface, collision_statistics, collision_table, merge_contacts, sort_by_pair
from millprint.dem.layout import COUNTER
from millprint.dem.ledger import check_balance, check_closure, closure, ledger_series, ledger_summary
from millprint.dem.simulation import Simulation
from millprint.mill import wall_arrays
from tests.physics.setups import FewBalls, box, prism

DEM = DemConfig(time_step_s=2e-6, settle_s=0.1, window_s=0.2)
LOST = ["normal_damping_J", "tangential_damping_J", "sliding_J", "rolling_J"]


def simulate(mills, contacts, mill="emax", contact="calibrated", diameter=10, fill=0.10, seed=0, dem=DEM, **change):
    durations = {"settle_s": dem.settle_s, "discard_s": 0.05, "window_s": dem.window_s} | change
    case = Case(
        mill=mill,
        contact=contact,
        ball_diameter_m=diameter / 1e3,
        fill_ratio=fill,
        speed_hz=10.0,
        seed=seed,
        **durations,
    )
    simulation = Simulation(case, mills[mill], contacts[contact], dem)
    recording = simulation.run("test")
    series = ledger_series(np.concatenate(recording.samples))
    table = collision_table(recording.table)
    return simulation, series, table


@pytest.fixture(scope="module")
def reference(mills, contacts):
    return simulate(mills, contacts)


def test_a_rule_that_counts_by_facet_changes_no_contact_with_a_surface(reference, mills, contacts):
    """A contact then leaves a row on each facet; together they are the one contact that is recorded without."""
    rules = [*DEM.counting_rules, CountingRule(name="each_facet", by="facet")]
    *_, rows = simulate(mills, contacts, dem=DEM.model_copy(update={"counting_rules": rules}))
    assert len(rows) > 1.1 * len(reference[-1])
    order = ["start_s", "first", "second"]
    joined, whole = (by_surface(table).sort_values(order).reset_index(drop=True) for table in (rows, reference[-1]))
    assert len(joined) == len(whole)
    for name in whole:
        assert joined[name].to_numpy() == pytest.approx(whole[name].to_numpy(), rel=1e-9, abs=1e-15), name


@pytest.mark.parametrize(("contact", "diameter"), [("calibrated", 5), ("steel", 10), ("steel", 5)])
@pytest.mark.slow
def test_ledger_closes(mills, contacts, contact, diameter):
    _, series, _ = simulate(mills, contacts, contact=contact, diameter=diameter, discard_s=0.0, window_s=0.1)
    assert closure(series) < 1e-3


@pytest.mark.slow
def test_ledger_closes_round_a_post(mills, contacts):
    _, series, _ = simulate(mills, contacts, mill="emax_post")
    assert closure(series) < 1e-3


def test_every_channel_of_the_reference_takes_its_share(reference):
    _, series, _ = reference
    assert closure(series) < 1e-3
    ledger = ledger_summary(series)
    shares = {name: ledger[name] / ledger["wall_work"] for name in ("normal_damping", "sliding", "rolling")}
    assert all(0.05 < share < 0.9 for share in shares.values()), shares
    works = series[["normal_damping_J", "tangential_damping_J", "rolling_J"]].to_numpy()
    assert (np.diff(works, axis=0) >= 0).all()


def test_balance_error_falls_with_the_square_of_the_step():
    """Oblique impacts of two spinning balls on the floor and on each other, every channel at work."""
    steps, errors = np.array([4e-6, 2e-6, 1e-6, 5e-7]), []
    for step in steps:
        world = FewBalls(
            [[0, 0, 5.2e-3], [9.9e-3, 2e-3, 5.3e-3]], [[1.0, 0.3, -0.7], [-0.8, 0, -0.5]], [[50, -90, 30], [0, 80, 0]],
            step=step, gravity=9.81,
        )  # fmt: skip
        series = world.run(2e-3, sample_every=1)
        assert len(world.contacts) == 3
        errors.append(np.abs(series["imbalance_J"]).max() / series["kinetic_J"].iloc[0])
    orders = np.diff(np.log(errors)) / np.diff(np.log(steps))
    assert orders == pytest.approx(2, abs=0.15)
    assert errors[-1] < 4e-5


@pytest.mark.parametrize("sides", [3, 4, 6, 8])
def test_a_ball_between_walls_loses_its_spin_and_then_nothing(sides):
    """Rolling friction of all walls together stops it: what it dissipates is its kinetic energy, for any number."""
    angle = 2 * np.pi * np.arange(sides) / sides
    inner = 4.99e-3
    outline = inner / np.cos(np.pi / sides) * np.column_stack([np.cos(angle), np.sin(angle)])
    world = FewBalls([[0, 0, inner]], None, [[40, -60, 80]], vessel=prism(outline, 2 * inner), step=2e-6)
    moving, resting = (world.run(5e-3, sample_every=1) for _ in range(2))
    assert (world.open_contacts.slot >= 0).sum() == sides + 2
    kinetic = moving["kinetic_J"].iloc[0]
    assert moving[LOST].iloc[-1].sum() == pytest.approx(kinetic, rel=1e-3)
    assert np.ptp(resting[LOST].to_numpy(), axis=0).sum() < 1e-9 * kinetic
    assert resting["kinetic_J"].iloc[-1] < 1e-12 * kinetic


@pytest.mark.slow
def test_a_pressed_bed_at_rest_makes_no_energy():
    """Each touches about four others: a bed that sank at 20 g, and creeps by rolling."""
    at = np.array([-10e-3, 0, 10e-3])
    grid = np.array([[x, y, 6e-3 + 11e-3 * k] for k in range(6) for x in at for y in at])
    start = grid + np.random.default_rng(0).uniform(-4e-4, 4e-4, grid.shape)
    world = FewBalls(start, vessel=box(34e-3, 34e-3, 0.1), gravity=200.0, step=2e-6)
    sunk = world.run(0.2, sample_every=1000)
    touching = world.open_contacts.slot >= 0
    assert 2 * touching.sum() - (world.open_contacts.partner[touching] < 0).sum() > 3.5 * len(grid)
    assert np.ptp(world.run(0.02, sample_every=100)["imbalance_J"]) < 1e-9 * sunk["gravity_work_J"].iloc[-1]


@pytest.mark.slow
def test_ledger_of_the_reference_closes_at_the_default_step_and_with_the_square_of_it(mills, contacts):
    """Both ball sizes, calibrated: within 0.1 % of the wall work at 2e-6 s, and four times less at half the step."""
    for diameter, bound in ((10, 2e-4), (5, 1e-3)):
        errors = []
        for step in (4e-6, 2e-6):
            dem = DEM.model_copy(update={"time_step_s": step})
            _, series, _ = simulate(mills, contacts, diameter=diameter, dem=dem, settle_s=0.05)
            errors.append(closure(series))
        assert errors[1] < bound
        assert 3 < errors[0] / errors[1] < 6


def test_an_open_balance_is_refused(reference):
    simulation, series, table = reference
    made = series.assign(imbalance_J=series["imbalance_J"] + 0.01 * series["wall_work_J"])
    with pytest.raises(SimulationError, match="is open by"):
        check_closure(made, 0.005)
    # Of a ball that is pressed for long, it would say that.
    hits = table[table["duration_s"] < 5e-4].reset_index(drop=True)
    with pytest.raises(SimulationError, match="a shorter one does not help"):
        check_balance(simulation, made, hits)


def test_collisions_sum_to_the_ledger(reference):
    _, series, table = reference
    ledger = ledger_summary(series)
    for column, channel in (
        ("normal_J", "normal_damping"),
        ("damping_J", "tangential_damping"),
        ("rolling_J", "rolling"),
    ):
        assert table[column].sum() == pytest.approx(ledger[channel], rel=1e-3)
    # What the springs hold at the two ends of the window is all that tells the table's sliding from the ledger's.
    held = series["elastic_tangential_J"].iloc[-1] - series["elastic_tangential_J"].iloc[0]
    assert table["sliding_J"].sum() == pytest.approx(ledger["sliding"] + held, rel=1e-3)


def test_frequency_times_energy_is_power(reference):
    simulation, series, table = reference
    ledger = ledger_summary(series)
    rules = [CountingRule(name=f"gap_{gap}", gap_turns=gap / 100) for gap in (0, 1, 3)]
    window = (simulation.begin_s, simulation.window_s)
    rows = collision_statistics(table, rules, *window, simulation.count, simulation.frequency_hz)
    counts = [row["count"] for row in rows]
    assert counts == sorted(counts, reverse=True)
    assert counts[-1] > 0
    for row in rows:
        power = row["frequency_hz"] * row["mean_normal_J"]
        assert power == pytest.approx(ledger["normal_damping"] / simulation.window_s, rel=1e-3)


def test_contacts_of_a_pair_never_overlap_in_time(reference):
    _, _, table = reference
    ordered = table.sort_values(["first", "second", "start_s"])
    same = (ordered["first"].diff() == 0) & (ordered["second"].diff() == 0)
    end = (ordered["start_s"] + ordered["duration_s"]).shift()
    assert (ordered["start_s"][same] >= end[same] - 1e-12).all()
    assert len(merge_contacts(sort_by_pair(table), 0.0)) == len(table)


def test_the_same_seed_gives_the_same_run_to_the_last_bit(mills, contacts):
    first, second, other = (
        simulate(mills, contacts, seed=seed, settle_s=0.05, discard_s=0.0, window_s=0.1)[0] for seed in (3, 3, 4)
    )
    assert np.array_equal(first.balls.position, second.balls.position)
    assert np.array_equal(first.totals, second.totals)
    assert not np.allclose(first.balls.position, other.balls.position, atol=1e-3)


def test_history_survives_new_candidate_lists(mills, contacts, monkeypatch):
    """A run whose lists are rebuilt five times as often gives the same result."""
    runs = []
    for skin in (0.3, 1.5):
        monkeypatch.setattr(resources, "SKIN_SHARE", skin)
        runs.append(simulate(mills, contacts, settle_s=0.02, discard_s=0.0, window_s=0.02)[0])
    rebuilds = [run.counters[COUNTER.rebuilds] for run in runs]
    assert rebuilds[0] > 3 * rebuilds[1]
    assert np.abs(runs[0].balls.position - runs[1].balls.position).max() < 1e-8


def test_cells_and_all_pairs_list_the_same_pairs(mills, contacts, monkeypatch):
    simulation, _, _ = simulate(mills, contacts, diameter=5, fill=0.10, settle_s=0.05, discard_s=0.0, window_s=0.05)
    candidates, n = simulation.candidates, simulation.count
    listed = {
        (i, int(candidates.partner[k])) for i in range(n) for k in range(candidates.first[i], candidates.first[i + 1])
    }
    away = candidates.anchor[0, :, None] - candidates.anchor[0, None]
    close = np.argwhere(np.triu((away**2).sum(axis=-1) < (2 * simulation.radius + simulation.clock.skin) ** 2, 1))
    assert n > 160
    assert listed == {tuple(pair) for pair in close.tolist()}


@pytest.mark.parametrize("mill", ["emax", "emax_post"])
def test_a_run_with_few_cells_of_the_walls_is_the_same(mills, contacts, monkeypatch, mill):
    """As in a vessel so large that its cells must be wider, or they would take more memory than the balls."""
    times = {"settle_s": 0.02, "discard_s": 0.0, "window_s": 0.03}
    whole, _, _ = simulate(mills, contacts, mill=mill, diameter=5, **times)
    monkeypatch.setattr(wall_arrays, "CELLS_MAX", 3000)
    few, _, _ = simulate(mills, contacts, mill=mill, diameter=5, **times)
    assert len(whole.walls.cell_first) > 50_000
    assert 1500 < len(few.walls.cell_first) < 4500
    assert np.array_equal(few.balls.position, whole.balls.position)
    assert np.array_equal(few.totals, whole.totals)


def test_a_soft_fast_mill_is_refused(mills, contacts):
    with pytest.raises(SimulationError, match="overlaps"):
        simulate(mills, {"calibrated": contacts["calibrated"].model_copy(update={"young_modulus_gpa": 2e-4})},
                 dem=DEM.model_copy(update={"overlap_max": 0.02}))  # fmt: skip
