"""From summaries to claims: the scripts of chapters 3 and 4 on a synthetic mill, and what their claims say."""

import json
from pathlib import Path
from types import SimpleNamespace

import pytest
import yaml

import fit_master_curves
import invert_master_curves
import measure_scaling
import partition_dissipation
import tabulate_descriptors
from millprint.claims import chapter3, chapter4
from millprint.claims.compare import verdict
from millprint.config.fingerprint import FingerprintConfig
from millprint.config.partition import PartitionConfig
from millprint.files import read_table
from tests.unit.synthetic_mill import VOLUME, summaries, summary

ROOT = Path(__file__).parents[2]
DATA = ROOT / "config/data"


def outputs(folder: Path, **names: str) -> SimpleNamespace:
    return SimpleNamespace(**{key: str(folder / name) for key, name in names.items()})


@pytest.fixture(scope="module")
def results(tmp_path_factory) -> Path:
    """The tables of both stages for a sweep of the synthetic mill."""
    root = tmp_path_factory.mktemp("results")
    content = yaml.safe_load((ROOT / "config/config.yaml").read_text())
    settings = FingerprintConfig(**content["fingerprint"])
    runs = summaries() + summaries(contacts=("steel",), factor=1.4) + [summary(0.17)]
    paths = []
    for index, run in enumerate(runs):
        paths.append(root / f"summary_{index}.json")
        paths[-1].write_text(json.dumps(run))
    stage = root / "fingerprint"
    tables = {name: f"{name}.tsv" for name in ("descriptors", "counting_rules", "cycles", "densities")}
    tabulate_descriptors.main(paths, outputs(stage, **tables), settings)
    descriptors = str(stage / "descriptors.tsv")
    smooth = {}
    for contact in ("calibrated", "steel"):
        files = outputs(
            stage, curves=f"curves_{contact}.tsv", smooth=f"smooth_{contact}.tsv", about=f"smooth_{contact}.json"
        )
        fit_master_curves.main(descriptors, files, "emax", contact, VOLUME, settings)
        smooth[contact] = (files.smooth, files.about)
    scaling = outputs(stage, **{name: f"{name}.tsv" for name in ("collapse", "universal", "exponents", "zones")})
    measure_scaling.main(descriptors, {name: paths[0] for name, paths in smooth.items()}, scaling, "emax", settings)
    answers = outputs(stage, inverse="inverse.tsv", ranked="inverse_ranked.tsv")
    invert_master_curves.main(smooth, str(DATA / "published.tsv"), answers, settings.inverse)
    names = ["table_4_2", "table_4_2_ours", "table_4_3", "table_4_4", "table_4_4_ours", "table_4_5", "table_4_5_ours"]
    files = outputs(root / "partition", **{name: f"{name}.tsv" for name in [*names, "slopes"]})
    partition = PartitionConfig(**content["partition"])
    partition_dissipation.main(str(DATA / "regimes.tsv"), *smooth["calibrated"], files, partition)
    return root


@pytest.fixture(scope="module")
def claims():
    return read_table(DATA / "claims.tsv", text=["id", "value", "tolerance", "kind"]).set_index("id")


def test_every_claim_of_both_chapters_is_answered_once(results, claims):
    for number, chapter in ((3, chapter3), (4, chapter4)):
        assert set(chapter.findings(results, DATA)) == {name for name in claims.index if name.startswith(f"{number}.")}


def test_every_number_of_chapter_4_is_reproduced(results, claims):
    for name, finding in chapter4.findings(results, DATA).items():
        row = claims.loc[name]
        assert verdict(row["value"], row["tolerance"], finding) == "reproduced", (name, finding)


def test_computed_claims_of_chapter_3_are_reproduced_but_for_one_ball_count(results, claims):
    computed = claims[claims["kind"] == "computed"]
    verdicts = {
        name: verdict(computed.loc[name, "value"], computed.loc[name, "tolerance"], finding)
        for name, finding in chapter3.findings(results, DATA).items()
        if name in computed.index
    }
    assert verdicts.pop("3.balls.10mm.0.40") == "erratum"
    assert set(verdicts.values()) == {"reproduced"}


def test_the_inverse_claim_says_that_the_frequency_is_lost(results):
    assert "+183 %), not kept" in chapter3.findings(results, DATA)["3.inverse.speed"].explanation


def test_values_are_those_of_the_synthetic_mill(results):
    found = chapter3.findings(results, DATA)
    assert found["3.curve.0.10.f"].value == pytest.approx(40.0, rel=1e-6)
    assert found["3.reference.f"].value == pytest.approx(400.0, rel=1e-6)
    assert found["3.frequency.calibrated"].value == "yes"
    assert found["3.frequency.steel"].value == "no"
    assert found["3.collapse"].value == pytest.approx(0.0, abs=1e-4)


def test_a_run_without_tables_says_not_run(tmp_path, claims):
    found = chapter3.findings(tmp_path, DATA) | chapter4.findings(tmp_path, DATA)
    simulated = [name for name in found if claims.loc[name, "kind"] in ("simulated", "runtime")]
    assert simulated and all(found[name].value is None for name in simulated)
    assert all(found[name].explanation.startswith("not run: ") for name in simulated)
