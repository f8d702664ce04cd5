"""Counting rules on a hand-made table."""

import itertools

import numpy as np
import pandas as pd
import pytest

from millprint.config.counting import CountingRule
from millprint.dem.collisions import (
    by_facet,
    by_surface,
    collision_statistics,
    collision_table,
    kept_by,
    merge_contacts,
    sort_by_pair,
    squares_per_turn,
    strongest,
    weighted_energy,
    weighted_statistics,
)
from millprint.dem.layout import COLLISION, ENDED
from millprint.dem.recording import Table, make_table
from millprint.mill.kernel_columns import width_of
from millprint.observables.counted_collisions import CHANNELS

# Pair, start [s], peak force [N], normal and tangential energy [J]; each contact lasts 1 ms.
CONTACTS = (
    (0, 1, 0.000, 2.0, 1.0, 4.0),
    (0, 1, 0.002, 5.0, 1.0, 2.0),
    (0, -4, 0.0005, 8.0, 1.0, 1.0),
    (0, 1, 0.007, 1.0, 1.0, 2.0),
    (2, 5, -0.001, 1.0, 1.0, 1.0),
)


def table():
    """Pair (0, 1) touches at 0, 2 and 7 ms, ball 0 and facet 3 once, and a pair from before the window once."""
    first, second, start, force, normal, tangential = (np.array(column) for column in zip(*CONTACTS, strict=True))
    columns = {
        "start_s": start, "duration_s": 0.001, "peak_force_N": force, "normal_J": normal,
        "damping_J": 0.25 * tangential, "tangential_J": tangential,
    }  # fmt: skip
    return collision_table(made_up(first, second, **columns))


def made_up(first, second, contact=None, facet=None, ended=ENDED.parted, **columns) -> Table:
    """Rows, each a contact that has ended if nothing else is said, with some of the values of CollisionColumns."""
    value = np.zeros((len(first), width_of(COLLISION)))
    for name, column in columns.items():
        value[:, getattr(COLLISION, name)] = column
    contact = np.arange(len(first)) if contact is None else np.array(contact)
    facet = np.where(second < 0, -1 - second, -1) if facet is None else np.array(facet)
    return Table(first, second, facet, contact, np.broadcast_to(ended, len(first)).astype(np.uint8), value)


# Turns of the mill a second.
SPEED_HZ = 10.0


def count(rows=None, speed_hz=SPEED_HZ, window_s=0.5, **parameters):
    rule = CountingRule(name="rule", **parameters)
    rows = table() if rows is None else rows
    (row,) = collision_statistics(rows, [rule], begin_s=0.0, window_s=window_s, balls=6, frequency_hz=speed_hz)
    return row


@pytest.mark.parametrize(("gap", "number"), [(0.0, 4), (0.005, 4), (0.015, 3), (0.05, 2)])
def test_contacts_of_a_pair_within_the_gap_are_one_collision(gap, number):
    row = count(gap_turns=gap)
    assert row["count"] == number
    assert row["frequency_hz"] == pytest.approx(number / 0.5)
    assert row["specific_frequency_hz"] == pytest.approx(number / 0.5 / 6)
    # The energies of a collision from before the window are in the mean, so that frequency times mean is power.
    assert row["mean_normal_J"] == pytest.approx(5.0 / number)
    assert row["mean_tangential_J"] == pytest.approx(10.0 / number)
    assert row["dropped"] == {"count": 0, "normal": 0, "tangential": 0}


def test_shares_of_balls_and_walls():
    row = count(gap_turns=0.015)
    assert row["shares"]["ball_ball"] == pytest.approx({"count": 2 / 3, "normal": 4 / 5, "tangential": 9 / 10})
    assert row["shares"]["ball_wall"] == pytest.approx({"count": 1 / 3, "normal": 1 / 5, "tangential": 1 / 10})


def test_a_force_threshold_drops_merged_collisions_with_their_energy():
    """Merged by 1.5 ms, the pair's first collision peaks at 5 N; the threshold must see that, not its 2 N part."""
    row = count(gap_turns=0.015, peak_force_min_N=3.0)
    assert row["count"] == 2
    assert row["mean_normal_J"] == pytest.approx((2.0 + 1.0) / 2)
    assert row["mean_tangential_J"] == pytest.approx((6.0 + 1.0) / 2)
    # Of three collisions that begin within the window one is dropped; the pair from before it takes energy along.
    assert row["dropped"] == pytest.approx({"count": 1 / 3, "normal": 2 / 5, "tangential": 3 / 10})
    assert count(peak_force_min_N=3.0)["count"] == 2
    assert count(peak_force_min_N=3.0)["mean_normal_J"] == pytest.approx(1.0)


def test_a_time_threshold_counts_time_in_contact_only():
    """Two contacts of 1 ms with 1 ms between them are 2 ms in contact."""
    assert count(gap_turns=0.015, duration_min_s=0.0015)["count"] == 1
    assert count(gap_turns=0.015, duration_min_s=0.0025)["count"] == 0
    assert count(gap_turns=0.0, duration_min_s=0.0005)["count"] == 4


def test_kept_and_dropped_energies_sum_to_all_under_every_rule():
    for gap, force in itertools.product((0.0, 0.015, 0.05), (0.0, 1.5, 6.0)):
        row = count(gap_turns=gap, peak_force_min_N=force)
        kept = row["count"] * row["mean_normal_J"]
        assert kept + 5.0 * row["dropped"]["normal"] == pytest.approx(5.0)


def test_merging_agrees_with_a_plain_loop():
    """Thousands of random contacts, merged pair by pair in Python."""
    rng = np.random.default_rng(0)
    n, gap = 4000, 0.003
    first = rng.integers(0, 6, n)
    second = np.where(rng.random(n) < 0.5, first + rng.integers(1, 4, n), -1 - rng.integers(0, 5, n))
    duration, force, energy, start = rng.exponential(1e-3, n), rng.exponential(1, n), rng.random(n), np.zeros(n)
    # No pair touches again before it has parted.
    order = np.lexsort([second, first])
    start[order] = np.cumsum(np.concatenate([[0], duration[order][:-1]]) + rng.exponential(gap, n))
    table = made_up(first, second, start_s=start, duration_s=duration, peak_force_N=force, normal_J=energy)
    shuffled = rng.permutation(n)
    contacts = by_surface(collision_table(Table(*(column[shuffled] for column in table))))
    expected = []
    for pair in sorted(set(zip(first.tolist(), second.tolist(), strict=True))):
        rows = contacts[(contacts["first"] == pair[0]) & (contacts["second"] == pair[1])].sort_values("start_s")
        end = -np.inf
        for row in rows.itertuples():
            if row.start_s - end > gap:
                expected.append([*pair, row.start_s, 0.0, 0.0, 0.0])
            expected[-1][3] += row.duration_s
            expected[-1][4] = max(expected[-1][4], row.peak_force_N)
            expected[-1][5] += row.normal_J
            end = row.start_s + row.duration_s
    merged = merge_contacts(sort_by_pair(contacts), gap)
    assert 200 < len(expected) < n
    names = ["first", "second", "start_s", "duration_s", "peak_force_N", "normal_J"]
    np.testing.assert_allclose(merged[names].to_numpy(), np.array(expected), rtol=1e-12)


def test_gaps_of_whole_steps_are_counted_alike_before_and_after_a_file():
    """Parts of 86 to 88 steps of a turn of 8700: 0.01 turns is 87 steps, which rounding must not decide."""
    rng, step, n = np.random.default_rng(1), 60 / 1200 / 8700, 3000
    lasting, free = rng.integers(1, 60, n), rng.integers(86, 89, n)
    start = 30_000 + np.cumsum(np.append(0, (lasting + free)[:-1]))
    table = collision_table(made_up(np.zeros(n, int), np.ones(n, int), start_s=start * step, duration_s=lasting * step))
    read = table.assign(duration_s=table["duration_s"].astype(np.float32).astype(float))
    expected = 1 + int((free[:-1] > 87).sum())
    assert [len(merge_contacts(sort_by_pair(each), 0.01 / 20)) for each in (table, read)] == [expected, expected]
    # Durations of whole steps against a threshold of 25 of them.
    rule = CountingRule(name="long", by="surface", duration_min_s=25 * step)
    assert [int(kept_by(rule, each).sum()) for each in (table, read)] == [int((lasting >= 25).sum())] * 2


def travelled() -> pd.DataFrame:
    """A ball on two surfaces. Contact 7 goes over facets 3, 4 and 5 of surface 0; contact 8 is cut by the window."""
    return collision_table(
        made_up(
            first=np.array([0, 0, 0, 0, 0, 1]),
            second=np.array([-1, -1, -1, -2, -2, 2]),
            facet=[4, 3, 5, 0, 9, -1],
            contact=[7, 7, 7, 8, 8, 9],
            ended=[ENDED.passed, ENDED.passed, ENDED.parted, ENDED.passed, ENDED.cut, ENDED.parted],
            start_s=[0.012, 0.010, 0.015, 0.020, 0.021, 0.030],
            duration_s=[0.003, 0.002, 0.001, 0.001, 0.004, 0.001],
            approach_speed_m_s=[0.0, 0.5, 0.0, 0.2, 0.0, 1.0],
            peak_force_N=[9.0, 4.0, 1.0, 2.0, 3.0, 6.0],
            normal_J=[1.0, 2.0, 4.0, 0.5, 0.25, 8.0],
        )
    )


def test_the_rows_of_a_contact_that_travels_are_one_contact_by_surface():
    contacts = by_surface(travelled()).set_index("first")
    assert len(contacts) == 3
    one = contacts.loc[0].iloc[0]
    assert one[["second", "start_s", "approach_speed_m_s", "peak_force_N", "complete"]].tolist() == [
        -1,
        0.01,
        0.5,
        9,
        1,
    ]
    assert one["duration_s"] == pytest.approx(0.006) and one["normal_J"] == 7.0
    cut = contacts.loc[0].iloc[1]
    assert cut["complete"] == 0 and cut["normal_J"] == 0.75 and cut["peak_force_N"] == 3.0


def test_by_facet_each_row_is_a_contact_of_its_own():
    contacts = by_facet(travelled())
    assert contacts["second"].tolist() == [-5, -4, -6, -1, -10, 2]
    assert contacts["complete"].tolist() == [0, 0, 1, 0, 0, 1]
    assert count(travelled(), by="facet")["count"] == 6 and count(travelled())["count"] == 3
    both = [count(travelled(), by=by) for by in ("facet", "surface")]
    energies = [row["count"] * row["mean_normal_J"] for row in both]
    assert energies == pytest.approx([15.75, 15.75])


def test_a_gap_in_turns_counts_alike_at_every_speed():
    """The same motion three times as fast has the same collisions; a gap in seconds would not."""
    for gap in (0.01, 0.03):
        slow = count(gap_turns=gap)
        rows = table().assign(start_s=table()["start_s"] / 3, duration_s=table()["duration_s"] / 3)
        fast = count(rows, speed_hz=3 * SPEED_HZ, window_s=0.5 / 3, gap_turns=gap)
        assert fast["count"] == slow["count"] and fast["frequency_hz"] == pytest.approx(3 * slow["frequency_hz"])
    assert count(speed_hz=0.0, gap_turns=0.05)["count"] == count()["count"]


def test_collisions_of_a_ball_are_those_that_it_takes_part_in():
    """Against a count of every ball by itself."""
    rng = np.random.default_rng(2)
    n, balls = 500, 6
    first = rng.integers(0, balls, n)
    second = np.where(rng.random(n) < 0.4, (first + rng.integers(1, balls, n)) % balls, -1 - rng.integers(0, 3, n))
    rows = collision_table(made_up(first, second, start_s=rng.random(n), duration_s=1e-6))
    taken_part = [sum(ball in pair for pair in zip(first, second, strict=True)) for ball in range(balls)]
    row = count(rows, window_s=2.0)
    assert row["collisions_of_a_ball_hz"] == pytest.approx(np.mean(taken_part) / 2.0)
    assert row["specific_frequency_hz"] == pytest.approx(n / 2.0 / balls)
    between = row["shares"]["ball_ball"]["count"]
    assert row["collisions_of_a_ball_hz"] == pytest.approx((1 + between) * row["specific_frequency_hz"])


def weighted_of(normal, tangential=None, window_s=2.0, balls=4) -> dict:
    normal = np.asarray(normal, dtype=float)
    tangential = 2 * normal if tangential is None else np.asarray(tangential, dtype=float)
    rows = made_up(np.zeros(len(normal), dtype=int), np.arange(1, len(normal) + 1), normal_J=normal,
                   tangential_J=tangential)  # fmt: skip
    power = {"normal": normal.sum() / window_s, "tangential": tangential.sum() / window_s}
    return weighted_statistics(by_surface(collision_table(rows)), power, 0.0, window_s, balls, SPEED_HZ)


def test_equal_collisions_have_their_own_energy_and_number():
    found = weighted_of(np.full(30, 2e-4))
    assert found["normal"]["energy_J"] == pytest.approx(2e-4) and found["tangential"]["energy_J"] == pytest.approx(4e-4)
    for channel in CHANNELS:
        assert found[channel]["specific_frequency_hz"] == pytest.approx(30 / 2.0 / 4)
    assert found["strong_frequency_hz"] == pytest.approx(27 / 2.0 / 4)


def test_collisions_without_energy_change_no_weighted_descriptor():
    energies = np.random.default_rng(1).lognormal(0, 2, 200)
    alone, among = weighted_of(energies), weighted_of([*energies, *np.zeros(1000)])
    assert among["strong_frequency_hz"] == alone["strong_frequency_hz"]
    for channel in CHANNELS:
        for name in ("energy_J", "specific_frequency_hz"):
            assert among[channel][name] == pytest.approx(alone[channel][name], rel=1e-12)


def test_collisions_cut_in_parts_have_a_part_of_the_weighted_energy():
    """In k equal parts E* is a k-th, and f* k times; of one of two unlike collisions, by the closed form."""
    whole, parts = weighted_of([3.0, 3.0]), weighted_of(np.ones(6))
    assert parts["normal"]["energy_J"] == pytest.approx(whole["normal"]["energy_J"] / 3)
    assert parts["normal"]["specific_frequency_hz"] == pytest.approx(3 * whole["normal"]["specific_frequency_hz"])
    # Cutting the weak one hardly matters, cutting the strong one does.
    assert weighted_energy(np.array([10.0, 0.5, 0.5]), np.ones(3)) == pytest.approx((100 + 0.5) / 11)
    assert weighted_energy(np.array([5.0, 5.0, 1.0]), np.ones(3)) == pytest.approx(51 / 11)


def test_a_contact_that_lasts_is_one_for_each_turn_however_long_it_is_recorded():
    """A ball that rolls all the time, with 0.3 J a turn, beside a hit of 1 J in each turn; contacts of 20 turns."""
    found = []
    for window_turns in (5, 10):
        hits, window_s = np.arange(window_turns) / SPEED_HZ, window_turns / SPEED_HZ
        rows = collision_table(made_up(
            np.zeros(window_turns + 1, dtype=int), np.array([-1, *np.full(window_turns, 1)]),
            start_s=[-1.0, *hits], duration_s=[1.0 + window_s, *np.full(window_turns, 1e-3)],
            normal_J=[0.3 * window_turns, *np.ones(window_turns)],
        ))  # fmt: skip
        power = {"normal": 1.3 * SPEED_HZ, "tangential": 0.0}
        found.append(weighted_statistics(by_surface(rows), power, 0.0, window_s, 4, SPEED_HZ))
    for each in found:
        assert each["normal"]["energy_J"] == pytest.approx((1 + 0.3**2) / 1.3)
        # The hits hold 77 % of the energy, so that the rolling is among the strongest: one more each turn.
        assert each["strong_frequency_hz"] == pytest.approx(2 * SPEED_HZ / 4)


def test_the_weighted_energy_of_an_exponential_distribution_is_twice_the_mean():
    energies = np.random.default_rng(3).exponential(1.0, 400_000)
    assert weighted_energy(energies, np.ones(energies.size)) == pytest.approx(2.0, rel=0.01)
    # The strongest that hold 90 %: x e^-x + e^-x = 0.9 at the least of them, and their share e^-x.
    assert len(strongest(energies, np.ones(energies.size))) / len(energies) == pytest.approx(0.5877, abs=0.003)


def test_negative_works_weigh_nothing_and_are_told():
    found = weighted_of([4.0, 2.0, -0.5], [1.0, 1.0, 1.0])
    assert found["normal"]["energy_J"] == pytest.approx(20 / 6)
    assert found["normal"]["negative"] == {"count": 1, "share": pytest.approx(-0.5 / 5.5)}
    assert found["tangential"]["negative"] == {"count": 0, "share": 0.0}
    # A small work is not a negative one.
    assert weighted_of([0.75, -0.5])["normal"]["negative"] == {"count": 1, "share": pytest.approx(-2.0)}
    # E* times f* is the power, that of the negative works included.
    assert found["normal"]["energy_J"] * found["normal"]["specific_frequency_hz"] * 4 == pytest.approx(5.5 / 2.0)
    assert weighted_of([])["normal"]["energy_J"] == 0.0 and weighted_of([-1.0])["strong_frequency_hz"] == 0.0


def test_squares_of_every_turn_add_up_to_those_of_all_contacts():
    contacts = by_surface(table())
    found = squares_per_turn(contacts, 0.0, 500.0, 3)
    assert found["normal"].tolist() == [3.0, 1.0, 1.0]
    assert found["tangential"].sum() == pytest.approx(16 + 4 + 1 + 4 + 1)


def test_sliding_is_what_damping_leaves_of_the_tangential_work():
    assert table()["sliding_J"].to_numpy() == pytest.approx(0.75 * np.array([4, 2, 1, 2, 1]))


def test_no_contacts_at_all():
    empty = collision_table(make_table(0))
    (row,) = collision_statistics(
        empty, [CountingRule(name="r", gap_turns=0.03, peak_force_min_N=1)], 0.0, 1.0, 3, 10.0
    )
    none = {"count": 0.0, "normal": 0.0, "tangential": 0.0}
    zeros = ("frequency_hz", "specific_frequency_hz", "collisions_of_a_ball_hz", "mean_normal_J", "mean_tangential_J")
    rule = {"name": "r", "by": "surface", "gap_turns": 0.03, "peak_force_min_N": 1.0, "duration_min_s": 0.0}
    of_pairs = {"shares": {"ball_ball": none, "ball_wall": none}, "dropped": none}
    assert row == rule | {"count": 0} | dict.fromkeys(zeros, 0.0) | of_pairs
