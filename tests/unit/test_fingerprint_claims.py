"""From summaries to claims: the scripts of chapters 3 and 4 on a synthetic mill, and what their claims say."""

import json
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from scipy.stats import spearmanr

import fit_master_curves
import partition_dissipation
from millprint.config.counting import CountingRule
from millprint.config.fingerprint import FingerprintConfig
from millprint.config.workflow import PartitionConfig
from millprint.run.files import read_table
from millprint.thesis.claims.chapter3_curves import rank_correlation
from millprint.thesis.claims.tabulate import collect_findings
from tests.conftest import PRINTED, configuration
from tests.unit.claim_words import word_of
from tests.unit.synthetic_mill import VOLUME, overrides, summaries, summary, true_curves

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parents[2]
DATA = ROOT / "config/data"
CONTACTS = ["calibrated", "steel"]
PUBLISHED = [str(DATA / name) for name in ("published.tsv", "claims.tsv")]


def outputs(folder: Path, **names: str) -> SimpleNamespace:
    return SimpleNamespace(**{key: str(folder / name) for key, name in names.items()})


@pytest.fixture(scope="module")
def results(tmp_path_factory) -> Path:
    """The tables of both stages for a sweep of the synthetic mill."""
    root = tmp_path_factory.mktemp("results")
    content = configuration()
    settings = FingerprintConfig(**content["fingerprint"])
    runs = summaries() + summaries(contacts=("steel",), factor=1.4) + [summary(0.17)] + overrides()
    for run in runs:
        run["collisions"].append(run["collisions"][1] | {"name": settings.counting_rule, "by": "facet"})
    paths = []
    for index, run in enumerate(runs):
        paths.append(root / f"summary_{index}.json")
        paths[-1].write_text(json.dumps(run))
    stage = root / "fingerprint"
    names = ("descriptors", "counting_rules", "cycles", "densities", "table_3_5")
    described = outputs(stage, **{name: f"{name}.tsv" for name in names})
    rules = [CountingRule.of_count(count).model_dump() for count in runs[0]["collisions"]]
    fit_master_curves.tabulate_conditions(
        paths, rules, PUBLISHED, described, "emax", settings.counting_rule, settings.cycle_fill_ratio
    )
    fingerprints = {}
    for contact in CONTACTS:
        names = {name: f"{name}_{contact}.tsv" for name in ("means", "curves", "coverage")}
        files = outputs(stage, **names, fingerprint=f"fingerprint_{contact}.json")
        fit_master_curves.fit_contact(
            described.descriptors, files, "emax", contact, VOLUME, settings.interval, settings.smooth_points
        )
        fingerprints[contact] = files.fingerprint
    scaling = outputs(stage, **{name: f"{name}.tsv" for name in ("collapse", "universal", "exponents", "zones")})
    fit_master_curves.measure_scaling(
        described.descriptors,
        described.counting_rules,
        list(fingerprints.values()),
        scaling,
        "emax",
        CONTACTS,
        settings.interval,
    )
    answers = outputs(stage, inverse="inverse.tsv", ranked="inverse_ranked.tsv")
    fit_master_curves.invert(fingerprints, PUBLISHED, answers, settings.inverse)
    names = ["table_4_2", "table_4_3", "table_4_4", "table_4_5", "slopes", "design"]
    files = outputs(root / "partition", **{name: f"{name}.tsv" for name in names})
    partition = PartitionConfig(**content["partition"])
    partition_dissipation.main(str(DATA / "regimes.tsv"), fingerprints["calibrated"], files, partition)
    return root


@pytest.fixture(scope="module")
def claims():
    return read_table(DATA / "claims.tsv", text=["id", "value", "tolerance", "nature"]).set_index("id")


def findings(results: Path, chapter: str) -> dict:
    return collect_findings(results, DATA / "claims.tsv", chapter)


def test_every_claim_of_both_chapters_is_answered_once(results, claims):
    for chapter in ("3.", "4."):
        assert set(findings(results, chapter)) == {name for name in claims.index if name.startswith(chapter)}


def test_every_number_of_chapter_4_on_its_own_values_is_reproduced_but_for_one_erratum(results, claims):
    verdicts = {
        name: word_of(claims.loc[name, "value"], claims.loc[name, "tolerance"], finding)
        for name, finding in findings(results, "4.").items()
        if claims.loc[name, "nature"] != "simulated"
    }
    assert verdicts.pop("4.text.diminishing") == "erratum"
    assert set(verdicts.values()) == {"agrees"}


def test_the_gains_with_our_own_curves_are_claims_of_their_own(results, claims):
    """They follow from our powers at the speeds of the experiments, and the yields."""
    found = findings(results, "4.own")
    assert (claims.loc[list(found), "nature"] == "simulated").all()
    (pn, pt, _), (own_n, own_t, _) = true_curves(0.10), true_curves(0.06)
    expected = 100 * (84 / 71 * 24 * (pn + pt) / (14 * (own_n + own_t)) - 1)
    assert found["4.own.speed.tangential.gain"].value == pytest.approx(expected, rel=1e-6)
    at_power = 100 * (94 / 71 * 24 * (pn + pt) / (14 * (own_n + own_t) * 1.314**3) - 1)
    assert found["4.own.power.tangential.gain"].value == pytest.approx(at_power, rel=1e-6)
    # At equal power the gain is that of the yields, here where the power goes with the cube of the speed.
    hertz = (24 * (pn + pt) / (14 * (own_n + own_t))) ** (1 / 3) * 10
    between = (hertz - 10) / (13.14 - 10)
    at_equal = found["4.own.equal_power.gain"]
    if 0 <= between <= 1:
        assert at_equal.value == pytest.approx(100 * ((84 + 10 * between) / 71 - 1))
        assert (at_equal.repeats.lower, at_equal.repeats.upper) == pytest.approx((100 * 13 / 71, 100 * 23 / 71))
    else:
        assert at_equal.value is None


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


def test_what_follows_from_printed_numbers_of_chapter_3_is_reproduced_but_for_an_erratum(results, claims):
    computed = claims[claims["nature"].isin(["arithmetic"])]
    verdicts = {
        name: word_of(computed.loc[name, "value"], computed.loc[name, "tolerance"], finding)
        for name, finding in findings(results, "3.").items()
        if name in computed.index
    }
    assert verdicts.pop("3.experiment.difference") == "erratum"
    assert set(verdicts.values()) == {"agrees"}


def test_the_inverse_claim_says_that_the_frequency_is_lost(results):
    assert "+183 %), not kept" in findings(results, "3.")["3.inverse.speed"].explanation


def test_values_are_those_of_the_synthetic_mill(results):
    found = findings(results, "3.")
    assert found["3.curve.0.10.f"].value == pytest.approx(40.0, rel=1e-6)
    assert found["3.reference.f"].value == pytest.approx(400.0, rel=1e-6)
    assert found["3.frequency.calibrated"].value == "yes"
    assert found["3.frequency.steel"].value == "no"
    assert found["3.collapse"].value == pytest.approx(0.0, abs=1e-4)


def test_rank_correlation_is_that_of_scipy_with_ties_too():
    drawn = np.random.default_rng(3).integers(0, 6, (50, 2, 8))
    for first, second in drawn:
        expected = spearmanr(first, second).statistic
        assert rank_correlation(pd.Series(first), pd.Series(second)) == pytest.approx(expected, abs=1e-14)


def test_a_run_without_tables_says_not_run(tmp_path, claims):
    found = findings(tmp_path, "3.") | findings(tmp_path, "4.")
    simulated = [name for name in found if claims.loc[name, "nature"] in ("simulated", "fitted", "timed")]
    assert simulated and all(found[name].value is None for name in simulated)
    assert all(found[name].explanation.startswith("not run: ") for name in simulated)


@pytest.mark.parametrize("contact", CONTACTS)
def test_the_table_of_curves_has_the_layout_that_others_read(results, contact):
    """fill_ratio, then value, lower and upper of each quantity; every simulated fill ratio has a row."""
    table = read_table(results / f"fingerprint/curves_{contact}.tsv")
    quantities = ("Pn", "Pt", "f", "ratio", "En_star", "Et_star")
    assert list(table) == ["fill_ratio", *(f"{name}{end}" for name in quantities for end in ("", "_lower", "_upper"))]
    assert table["fill_ratio"].is_monotonic_increasing
    row = table[table["fill_ratio"] == 0.10].iloc[0]
    factor = 1.4 if contact == "steel" else 1.0
    for name, value in zip(("Pn", "Pt", "f"), true_curves(0.10), strict=True):
        assert row[name] == pytest.approx(factor * value, rel=0.02)
        assert row[f"{name}_lower"] < row[name] < row[f"{name}_upper"]


def test_the_tables_of_chapter_4_hold_both_curves(results):
    for number in ("4_2", "4_3", "4_4", "4_5"):
        table = read_table(results / f"partition/table_{number}.tsv")
        assert list(table["curves"].unique()) == ["published", "ours"]
        assert (table["curves"] == "ours").sum() == (table["curves"] == "published").sum()
    design = read_table(results / "partition/design.tsv")
    ours = design[(design["curves"] == "ours") & (design["mode"] == "power")]
    assert ours["power_W"].max() == pytest.approx(ours["power_W"].min(), rel=1e-6)
    assert set(design.loc[design["curves"] == "published", "fill_ratio"]) == {0.06, 0.10, 0.17}


def test_table_3_5_has_the_published_values(results):
    table = read_table(results / "fingerprint/table_3_5.tsv")
    row = table[(table["contact"] == "calibrated") & (table["ball_diameter_mm"] == 10) & (table["speed_rpm"] == 600)]
    assert len(row) == 1 and row["normal_mean_J_published"].iloc[0] == pytest.approx(
        float(PRINTED["3.cycle.10mm.600.n"]), abs=5e-4
    )
    deviation = 100 * (row["normal_mean_J"] / row["normal_mean_J_published"] - 1)
    assert row["normal_mean_J_deviation_percent"].iloc[0] == pytest.approx(deviation.iloc[0], rel=1e-5)
    assert table[table["contact"] == "steel"]["normal_mean_J_published"].isna().all()


def test_runs_of_another_amplitude_or_density_change_no_claim_on_the_mill_as_built(results):
    means = read_table(results / "fingerprint/means_calibrated.tsv").set_index("fill_ratio")
    assert means["conditions"].to_dict() == {fill: 1 if fill == 0.17 else 4 for fill in means.index}
    found = findings(results, "3.")
    assert "exponents from our runs" in found["3.collapse"].explanation
    assert "A 2.00 (2.00 to 2.00)" in found["3.collapse"].explanation
    # Steel was made 1.4 times as strong: 1 - eps of 0.449 against 0.883 makes that an exponent of -0.50.
    assert found["3.universal"].value == "yes"
