"""Energy spectra: made-up contacts with a known spectrum, and a short run against its own ledger."""

from pathlib import Path

import h5py
import numpy as np
import pandas as pd
import pytest

from millprint.cases.of_mill import mill_cases
from millprint.config.counting import DEFAULT_RULES, CountingRule
from millprint.config.errors import MillprintError
from millprint.config.included import load_contact, load_mill
from millprint.config.mill_sweep import MillsConfig
from millprint.config.sweep import DemConfig
from millprint.dem.run import run_case
from millprint.dose.heat_balance import read_sources
from millprint.dose.spectra import BIN_EDGES, PAIRS, TABLE_ONLY, tabulate_spectra, weighted_median
from millprint.dose.spectra_shown import rules_apart
from millprint.dose.wear import sliding_of_run

EDGES = np.geomspace(1e-8, 1e-1, 7 * 2 + 1)
RULE = {"name": "lifetimes", "by": "surface", "gap_turns": 0.0, "peak_force_min_N": 0.0, "duration_min_s": 0.0}
MERGING = RULE | {"name": "gap_0_02", "gap_turns": 0.02}
HARD = RULE | {"name": "over_1N", "peak_force_min_N": 1.0}
BEGIN, WINDOW = 0.5, 2.0


def contacts(
    number: int, normal: float, tangential: float, wall: bool = False, force: float = 2.0, start: float = 0.6
) -> pd.DataFrame:
    """Contacts of `number` pairs, each 1 ms long with these energies; a quarter of the tangential one is damping."""
    first = np.arange(number)
    return pd.DataFrame(
        {
            "first": first, "second": -1 - first if wall else 1000 + first, "start_s": start, "duration_s": 1e-3,
            "peak_force_N": force, "normal_J": normal, "damping_J": tangential / 4, "sliding_J": 3 * tangential / 4,
            "facet": first if wall else -1, "ended": 1,
        }
    )  # fmt: skip


def write(path: Path, *groups: pd.DataFrame, stored: float = 0.0, fill: float = 0.1, seed: int = 0) -> tuple[str, dict]:
    """A run.h5 with these contacts, and the summary that its ledger would have."""
    table = pd.concat(groups, ignore_index=True)
    table["contact"] = table.index
    with h5py.File(path, "w") as file:
        group = file.create_group("collisions")
        group.attrs.update({"begin_s": BEGIN, "window_s": WINDOW})
        for name in table:
            group[name] = table[name].to_numpy()
        file["ledger/elastic_tangential_J"] = np.array([0.25, 0.25 + stored])
    tangential = (table["damping_J"] + table["sliding_J"]).sum() - stored
    case = {"ball_diameter_m": 0.01, "fill_ratio": fill, "speed_hz": 10.0, "seed": seed}
    return str(path), {
        "mill": "emax", "contact": "steel", "case": case, "frequency_hz": 10.0, "density_kg_m3": 7700.0,
        "amplitude_m": 0.017, "balls": 2, "ball_diameter_m": 0.01,
        "power_W": {"normal": table["normal_J"].sum() / WINDOW, "tangential": tangential / WINDOW},
        "collisions": [RULE, MERGING, HARD],
    }  # fmt: skip


def rows(table: pd.DataFrame, **chosen: str) -> pd.DataFrame:
    for name, value in chosen.items():
        table = table[table[name] == value]
    return table


@pytest.fixture
def two_kinds(tmp_path):
    """300 soft collisions of balls, 100 hard ones at the wall: 3e-4 J against 0.1 J of normal energy."""
    return write(tmp_path / "run.h5", contacts(300, 1e-6, 4e-6), contacts(100, 1e-3, 2e-3, wall=True))


def test_two_kinds_of_collisions_stand_in_two_bins(two_kinds):
    spectra, summary = tabulate_spectra([two_kinds], ["lifetimes"], EDGES)
    normal = rows(spectra, channel="normal")
    filled = normal[normal["power_W"] > 0]
    # From the first bin with a collision to the last.
    assert len(spectra) == 4
    assert np.log10(BIN_EDGES) == pytest.approx(np.linspace(-12, 1, 66))
    assert filled["pair"].tolist() == list(PAIRS)
    assert filled["collisions_hz"].tolist() == pytest.approx([150.0, 50.0])
    assert filled["power_W"].tolist() == pytest.approx([1.5e-4, 0.05])
    for energy, bin_ in zip((1e-6, 1e-3), filled.itertuples(), strict=True):
        assert bin_.energy_low_J <= energy * (1 + 1e-9) and energy < bin_.energy_high_J
        assert bin_.collisions_above_share == bin_.power_above_share == 1.0
    both = rows(summary, channel="normal", pair="both").iloc[0]
    assert both["mean_J"] == pytest.approx((300e-6 + 100e-3) / 400)
    # Three quarters of the collisions are soft, but nearly all of the power is in hard ones.
    assert both["median_J"] == pytest.approx(1e-6)
    assert both["half_power_J"] == pytest.approx(1e-3)
    assert rows(summary, channel="normal")["power_share"].tolist() == pytest.approx([0.003 / 1.003, 1 / 1.003, 1.0])


def test_the_integral_is_the_power_also_of_what_lies_beyond_the_bins(tmp_path):
    """Energies over 16 orders of magnitude, none at all, and a spring that gave back more than was dissipated."""
    energies = [
        contacts(3, 10.0**power, 10.0 ** (power + 1), start=0.6 + 0.01 * k) for k, power in enumerate(range(-14, 2))
    ]
    run = write(tmp_path / "run.h5", *energies, contacts(1, 0.0, -1e-6, wall=True), stored=2e-3)
    spectra, summary = tabulate_spectra([run], ["lifetimes", "gap_0_02"], EDGES)
    for rule in ("lifetimes", "gap_0_02"):
        for channel, stored in (("normal", 0.0), ("tangential", 2e-3)):
            total = rows(spectra, counting_rule=rule, channel=channel)["power_W"].sum()
            assert total - stored / WINDOW == pytest.approx(run[1]["power_W"][channel], rel=1e-12)
            row = rows(summary, counting_rule=rule, channel=channel, pair="both").iloc[0]
            assert row["stored_W"] == pytest.approx(stored / WINDOW)
            assert abs(row["error_percent"]) < 1e-9
            # The bins end at 1e-8 and 0.1 J: nearly all is of the hits of 0.1 (at the end itself), 1 and 10 J.
            assert channel == "tangential" or row["beyond_bins_share"] == pytest.approx(11.1 / 11.11111111, abs=1e-7)
            assert row["beyond_bins_share"] > 0.5
    # A ledger that has 0.05 % more.
    run[1]["power_W"]["normal"] *= 1.0005
    _, summary = tabulate_spectra([run], ["lifetimes"], EDGES)
    row = rows(summary, channel="normal", pair="both").iloc[0]
    assert row["error_percent"] == pytest.approx(100 * (1 / 1.0005 - 1), rel=1e-6)
    open_bins = spectra[spectra["energy_high_J"].isna() | spectra["energy_low_J"].isna()]
    assert set(open_bins["pair"]) == set(PAIRS)


def test_rules_are_apart_by_what_all_pairs_have_together():
    """Twice the collisions, 1.1 and 1.2 times the power, 3 and 4 times the half power; pairs alone are left out."""
    rows = [
        {"pair": pair, "counting_rule": rule, "channel": channel, "note": "", "collisions_hz": own * (1 + by),
         "power_W": own * (1 + by * power), "half_power_J": own * (1 + by * half)}
        for pair, own, steps in (("both", 10.0, (0, 1)), ("ball_ball", 1.0, (0, 5)))
        for by, rule in zip(steps, ("lifetimes", "gap_0_02"), strict=True)
        for channel, power, half in (("normal", 0.1, 2), ("tangential", 0.2, 3))
    ]  # fmt: skip
    said = rules_apart(pd.DataFrame(rows))
    assert "2 counting rules differ by a factor of 2 in collisions" in said
    assert "1.1 (normal) and 1.2 (tangential) in power, and of 3 (normal) and 4 (tangential)" in said


def test_merged_contacts_are_one_collision_of_their_whole_energy(tmp_path):
    run = write(tmp_path / "run.h5", contacts(10, 1e-5, 0.0), contacts(10, 3e-5, 0.0, start=0.602))
    _, summary = tabulate_spectra([run], ["lifetimes", "gap_0_02"], EDGES)
    normal = rows(summary, channel="normal", pair="ball_ball").set_index("counting_rule")
    assert normal["collisions_hz"].to_dict() == pytest.approx({"lifetimes": 10.0, "gap_0_02": 5.0})
    assert normal["median_J"].to_dict() == pytest.approx({"lifetimes": 1e-5, "gap_0_02": 4e-5})
    assert normal["power_W"].tolist() == pytest.approx([2e-4, 2e-4])


def test_what_a_threshold_drops_is_told_and_completes_the_power(tmp_path):
    groups = contacts(10, 1e-5, 0.0, force=0.5), contacts(10, 3e-5, 0.0, wall=True)
    runs = [write(tmp_path / f"{seed}.h5", *groups, seed=seed) for seed in (0, 1)]
    _, summary = tabulate_spectra(runs, ["over_1N"], EDGES)
    row = rows(summary, channel="normal", pair="both").iloc[0]
    assert row["dropped_W"] == pytest.approx(1e-4 / WINDOW)
    assert row["power_W"] == pytest.approx(3e-4 / WINDOW)
    assert row["error_percent"] == pytest.approx(0.0, abs=1e-9)


def test_a_contact_from_before_the_window_gives_power_and_is_not_counted(tmp_path):
    groups = contacts(10, 1e-5, 0.0), contacts(4, 1e-5, 0.0, wall=True, start=0.4)
    runs = [write(tmp_path / f"{seed}.h5", *groups, seed=seed) for seed in (0, 1)]
    _, summary = tabulate_spectra(runs, ["lifetimes"], EDGES)
    normal = rows(summary, channel="normal").set_index("pair")
    assert normal["collisions_hz"].to_dict() == pytest.approx({"ball_ball": 5.0, "ball_wall": 0.0, "both": 5.0})
    assert normal.loc["both", "open_W"] == pytest.approx(4e-5 / WINDOW)
    assert normal.loc["both", "power_W"] == pytest.approx(14e-5 / WINDOW)


def test_seeds_of_a_condition_are_averaged(tmp_path):
    one = write(tmp_path / "a.h5", contacts(10, 1e-5, 1e-5))
    two = write(tmp_path / "b.h5", contacts(30, 1e-5, 1e-5), seed=1)
    other = write(tmp_path / "c.h5", contacts(5, 1e-4, 1e-4), fill=0.2)
    _, summary = tabulate_spectra([one, other, two], ["lifetimes"], EDGES)
    both = rows(summary, channel="normal", pair="both")
    assert both["seeds"].tolist() == [2, 1]
    assert both["collisions_hz"].tolist() == pytest.approx([10.0, 2.5])
    assert both["ledger_W"].tolist() == pytest.approx([1e-4, 2.5e-4])


def test_a_run_without_contacts_has_a_row_that_says_so(tmp_path):
    path, summary = write(tmp_path / "run.h5", contacts(3, 1e-5, 1e-5))
    with h5py.File(path, "a") as file:
        del file["collisions/second"]
    spectra, table = tabulate_spectra([(path, summary)], ["lifetimes"], EDGES)
    assert spectra.empty
    assert table["note"].tolist() == [TABLE_ONLY]


def test_what_cannot_be_read_is_one_line(two_kinds):
    path, summary = two_kinds
    wrong = summary | {"power_W": summary["power_W"] | {"normal": 1.002 * summary["power_W"]["normal"]}}
    for runs, rule, part in (
        ([(path, wrong)], "lifetimes", r"run\.h5: its contacts dissipate .* \(normal\)"),
        ([two_kinds], "gap_0_09", "gap_0_09"),
        ([], "lifetimes", "no simulation"),
    ):
        with pytest.raises(MillprintError, match=part) as caught:
            tabulate_spectra(runs, [rule], EDGES)
        assert "\n" not in str(caught.value)


def test_balls_that_rest_have_no_power_but_rounding(tmp_path):
    """Two balls in a slow mill: contacts and ledger differ, and both are nothing beside hits by the wall."""
    path, summary = write(tmp_path / "run.h5", contacts(2, 1e-21, 0.0))
    summary["power_W"]["normal"] *= 0.7
    _, table = tabulate_spectra([(path, summary)], ["lifetimes"], EDGES)
    assert rows(table, channel="normal", pair="both")["error_percent"].tolist() == [0.0]


def test_median_of_weighted_values():
    assert weighted_median(np.array([3.0, 1.0, 2.0]), np.array([1.0, 1.0, 1.0])) == 2.0
    assert weighted_median(np.array([3.0, 1.0, 2.0]), np.array([5.0, 1.0, 1.0])) == 3.0
    assert np.isnan(weighted_median(np.array([3.0]), np.array([0.0])))


@pytest.fixture(scope="module", params=["emax", "spex"])
def real_run(request, tmp_path_factory):
    """A short run of the first condition of a mill's sweep, whose window cuts contacts off at both edges."""
    folder = tmp_path_factory.mktemp(request.param)
    mill = load_mill(request.param)
    first = mill_cases(mill, MillsConfig(contact="calibrated"))[0]
    case = first.model_copy(update={"settle_s": 0.05, "discard_s": 0.05, "window_s": 0.1, "rayleigh_fraction": 0.05})
    contact = load_contact("calibrated")
    dem = DemConfig(counting_rules=[*DEFAULT_RULES, CountingRule(name="over_1N", peak_force_min_N=1.0)])
    return folder / "run.h5", run_case(case, mill, contact, dem, folder / "run.h5", folder / "summary.json")


@pytest.mark.slow
def test_spectra_of_a_real_run_hold_its_ledger_and_its_count(real_run):
    """For every rule; a threshold drops power, which is told."""
    path, summary = real_run
    ledger = summary["ledger_J"]
    stored = ledger["kinetic_change"] + ledger["elastic_change"]
    wall = ledger["wall_work"] + ledger["gravity_work"] - stored
    assert summary["power_W"]["wall"] * summary["window_s"] == pytest.approx(wall)
    ball_steps = summary["balls"] * summary["steps"]
    assert summary["ns_per_ball_step"] * ball_steps == pytest.approx(1e9 * summary["processor_s"])
    spectra, table = tabulate_spectra([(str(path), summary)], [rule["name"] for rule in summary["collisions"]])
    for rule in summary["collisions"]:
        for channel in ("normal", "tangential"):
            bins = rows(spectra, counting_rule=rule["name"], channel=channel)
            row = rows(table, counting_rule=rule["name"], channel=channel, pair="both").iloc[0]
            # The record is in single precision: a collision at the edge of a rule may fall on its other side.
            one = 1.01 / summary["window_s"]
            assert bins["collisions_hz"].sum() == pytest.approx(rule["frequency_hz"], rel=2e-3, abs=one)
            whole = bins["power_W"].sum() + row["dropped_W"] - row["stored_W"]
            assert whole == pytest.approx(summary["power_W"][channel], rel=1e-3)
            assert rule["name"] == "over_1N" or row["dropped_W"] == 0
            wall = bins[bins["pair"] == "ball_wall"]["power_W"].sum() / bins["power_W"].sum()
            assert wall == pytest.approx(rule["shares"]["ball_wall"][channel], rel=1e-3, abs=1e-6)


def test_what_slides_and_what_heats_is_the_power_of_the_ledger(real_run):
    """Wear and heat read the same contacts: their powers are those of the ledger within 0.1 % too."""
    path, summary = real_run
    row = sliding_of_run(path, path.with_name("summary.json"))
    slid = row["sliding_ball_ball_W"] + row["sliding_ball_wall_W"]
    assert slid == pytest.approx(summary["ledger_J"]["sliding"] / summary["window_s"], rel=1e-3)
    (source,) = read_sources([(str(path.with_name("summary.json")), str(path))])
    powers = [max(summary["power_W"][channel], 0.0) for channel in ("normal", "tangential", "rolling")]
    assert source.power_W.sum(axis=0) == pytest.approx(powers, rel=1e-9)
