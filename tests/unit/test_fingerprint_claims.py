"""From summaries to claims: the scripts of chapters 3 and 4 on a synthetic mill, and what their claims say."""

import shutil
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from scipy.stats import spearmanr

import partition_dissipation
from millprint.config.workflow import PartitionConfig
from millprint.estimate.judge import TOO_FEW
from millprint.run.files import read_table, write_table
from millprint.thesis.claims.chapter3 import rank_correlation
from millprint.thesis.claims.evidence import judge_repeats
from millprint.thesis.claims.tabulate import collect_findings, tabulate_intervals
from millprint.thesis.scaling import tables_of
from tests.conftest import configuration
from tests.stored_tables import compare_tables
from tests.unit.claim_words import word_of
from tests.unit.synthetic_mill import fingerprint, overrides, summaries, summary, true_curves

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parents[2]
DATA = ROOT / "config/data"


@pytest.fixture(scope="module")
def results(tmp_path_factory) -> Path:
    """The tables of both stages that claims read, for a sweep of the synthetic mill."""
    root = tmp_path_factory.mktemp("results")
    runs = summaries() + summaries(contacts=("steel",), factor=1.4) + [summary(0.17)] + overrides()
    for path, table in tables_of(runs, "emax", ["calibrated", "steel"], "gap_0_03").items():
        write_table(table, root / path)
    curves = root / "fingerprint/fingerprint_calibrated.json"
    for contact in ("calibrated", "steel"):
        fingerprint().write(curves.with_stem(f"fingerprint_{contact}"))
    names = ["table_4_2", "table_4_3", "table_4_4", "table_4_5", "slopes", "design"]
    files = SimpleNamespace(**{name: str(root / f"partition/{name}.tsv") for name in names})
    partition = PartitionConfig(**configuration()["partition"])
    partition_dissipation.main(str(DATA / "regimes.tsv"), str(curves), files, partition)
    return root


@pytest.fixture(scope="module")
def claims():
    return read_table(DATA / "claims.tsv", text=["id", "value", "tolerance", "nature"]).set_index("id")


def findings(results: Path, chapter: str) -> dict:
    return collect_findings(results, DATA / "claims.tsv", chapter)


def test_the_tables_of_chapter_4_from_printed_curves_are_the_stored_ones(results):
    assert compare_tables(results) == 5


def test_the_gains_with_our_own_curves_are_claims_of_their_own(results, claims):
    """They follow from our powers at the speeds of the experiments, and the yields."""
    found = findings(results, "4.own")
    assert (claims.loc[list(found), "nature"] == "simulated").all()
    (pn, pt, _), (own_n, own_t, _) = true_curves(0.10), true_curves(0.06)
    expected = 100 * (84 / 71 * 24 * (pn + pt) / (14 * (own_n + own_t)) - 1)
    assert found["4.own.speed.tangential.gain"].value == pytest.approx(expected, rel=1e-6)
    at_power = 100 * (94 / 71 * 24 * (pn + pt) / (14 * (own_n + own_t) * 1.314**3) - 1)
    assert found["4.own.power.tangential.gain"].value == pytest.approx(at_power, rel=1e-6)
    # Leverage and mass are over the power: those of Tables 4.5 and 4.4, times the printed Pn + Pt over ours.
    ours = {fill: sum(true_curves(fill)[:2]) for fill in (0.06, 0.10, 0.17)}
    leverage = {2.237: (0.10, 129.7), 3.652: (0.06, 98), 1.691: (0.17, 103), 1.777: (0.06, 98), 2.142: (0.17, 103)}
    found_over_ours = [printed * theirs / ours[fill] for printed, (fill, theirs) in leverage.items()]
    ends = [found[f"4.own.leverage.{end}"].value for end in ("least", "most")]
    assert ends == pytest.approx([min(found_over_ours), max(found_over_ours)], rel=1e-3)
    mass = [0.1132 * 129.7 / ours[0.10], 0.0899 * 98 / ours[0.06], 0.1084 * 103 / ours[0.17]]
    assert found["4.own.mass"].value == ("yes" if mass[0] > max(mass) - 1e-9 else "no")
    surely = mass[0] > max(mass[1] * (1 + 5 / 94), mass[2] * (1 + 5 / 40))
    assert found["4.own.mass"].repeats.lower == ("yes" if surely else "no")


def at_equal_power(results, folder, factor: float):
    """The gain at equal power in a copy of the results, with the powers of the shear cases times a factor."""
    shutil.copytree(results, folder, dirs_exist_ok=True)
    path = folder / "fingerprint/means_calibrated.tsv"
    means = read_table(path)
    means.loc[means["fill_ratio"] == 0.06, ["Pn", "Pt"]] *= factor
    write_table(means, path)
    return findings(folder, "4.own")["4.own.equal_power.gain"]


def test_at_a_power_that_is_equal_by_our_curves_the_yield_lies_between_two_measured_ones(results, tmp_path):
    """Where the power goes with the cube of the speed."""
    (pn, pt, _), (own_n, own_t, _) = true_curves(0.10), true_curves(0.06)
    hertz = (24 * (pn + pt) / (14 * (own_n + own_t))) ** (1 / 3) * 10
    found = at_equal_power(results, tmp_path, 1.0)
    assert found.value == pytest.approx(100 * ((84 + 10 * (hertz - 10) / 3.14) / 71 - 1))
    assert (found.repeats.lower, found.repeats.upper) == pytest.approx((100 * 13 / 71, 100 * 23 / 71))


@pytest.mark.parametrize("factor", [0.5, 2.0])
def test_beyond_both_measured_yields_nothing_is_said_of_equal_power(results, tmp_path, factor):
    assert at_equal_power(results, tmp_path, factor).value is None


def test_bounds_decide_though_they_are_of_no_repeats(results, claims, tmp_path):
    """From a file, too."""
    write_table(tabulate_intervals(results, DATA / "claims.tsv", []), tmp_path / "intervals.tsv")
    read = read_table(tmp_path / "intervals.tsv", text=["lower", "upper"])
    for intervals in (None, read):
        found = collect_findings(results, DATA / "claims.tsv", "4.own", intervals)
        for name in ("4.own.mass", "4.own.equal_power.gain"):
            assert found[name].repeats.of is None
            verdict = judge_repeats(*claims.loc[name, ["value", "tolerance"]], found[name])
            assert verdict.reason != TOO_FEW


def test_energies_between_zones_and_their_optimum_follow_from_the_simulations(results, claims):
    found = findings(results, "3.")
    table = read_table(results / "fingerprint/descriptors.tsv", text=["contact", "varied"])
    own = table[(table["contact"] == "calibrated") & (table["ball_diameter_mm"] == 10) & (table["varied"] == "nothing")]
    zone = own[(own["fill_ratio"] > 0.10) & (own["fill_ratio"] <= 0.20) & (own["speed_rpm"] == 600)]
    border = own[(own["fill_ratio"] == 0.10) & (own["speed_rpm"] == 600)].iloc[0]
    expected = 100 * (zone["normal_energy_J"].max() / border["normal_energy_J"] - 1)
    assert found["3.zone.calibrated.10.n"].value == pytest.approx(expected, rel=1e-6)
    # A fall by 150 % contradicts what a mean of energies is, whatever is simulated.
    row = claims.loc["3.zone.steel.10.t"]
    assert word_of(row["value"], row["tolerance"], found["3.zone.steel.10.t"]) == "erratum"
    assert found["3.zone.steel.5.n"].contradiction is None
    best = own.groupby("fill_ratio")["normal_energy_J"].mean().idxmax()
    assert found["3.optimum.calibrated"].value == pytest.approx(100 * best)


def test_values_are_those_of_the_synthetic_mill(results):
    found = findings(results, "3.")
    assert found["3.curve.0.10.f"].value == pytest.approx(40.0, rel=1e-6)
    assert found["3.reference.f"].value == pytest.approx(400.0, rel=1e-6)
    assert found["3.frequency.calibrated"].value == "yes"
    assert found["3.frequency.steel"].value == "no"
    assert found["3.collapse"].value == pytest.approx(0.0, abs=1e-4)
    # Both curves have one shape, so that neither grows less.
    assert found["3.growth"].value == "no"


def test_rank_correlation_is_that_of_scipy_with_ties_too():
    drawn = np.random.default_rng(3).integers(0, 6, (50, 2, 8))
    for first, second in drawn:
        expected = spearmanr(first, second).statistic
        assert rank_correlation(pd.Series(first), pd.Series(second)) == pytest.approx(expected, abs=1e-14)
