"""The smoke workflow: the real pipeline at small size, from nothing to the table of claims."""

import re
import shutil
import subprocess
import sys

import pandas as pd
import pytest
from PIL import Image

from millprint.cli.commands import main as millprint
from millprint.config.counting import CountingRule
from millprint.estimate.judge import VERDICTS
from millprint.fingerprint.readers import with_counts
from millprint.run.files import read_json, read_table
from millprint.thesis.claims.evidence import CERTAIN, TIMED
from millprint.thesis.claims.tabulate import CLAIM_COLUMNS
from tests.stored_tables import compare_tables
from tests.workflow.conftest import ROOT, jobs_of, run_snakemake
from tests.workflow.handbook import PLACES, READ_A_RUN, commands, pages

SMOKE = ("--configfile", "config/smoke.yaml")


def rules_of(files: str) -> set[str]:
    """Names of the rules in those files of workflow/rules that match the pattern `files`."""
    text = "".join(path.read_text() for path in (ROOT / "workflow/rules").glob(files))
    return set(re.findall(r"^(?:use rule \w+ as |rule )(\w+)", text, re.MULTILINE))


@pytest.fixture(scope="module")
def claims(smoke_project) -> pd.DataFrame:
    return pd.read_csv(smoke_project / "results/report/claims.tsv", sep="\t", dtype=str, keep_default_na=False)


def test_every_claim_has_a_row_and_a_verdict(claims):
    expected = read_table(ROOT / "config/data/claims.tsv", text=CLAIM_COLUMNS)
    assert list(claims.columns) == [
        *("id", "locus", "quantity", "published", "unit", "nature", "basis", "tolerance"),
        *("reproduced", "lower", "upper", "interval_from", "repeats", "failed"),
        *("jars_lower", "jars_upper", "jars_meeting"),
        *("deviation", "verdict", "interval_verdict", "reason", "explanation", "source"),
    ]
    assert claims["id"].tolist() == expected["id"].tolist()
    assert set(claims["verdict"]) <= set(VERDICTS)
    assert set(claims["interval_verdict"]) <= {*VERDICTS, ""}


def test_what_is_simulated_or_trained_has_an_interval_that_holds_the_value(claims):
    """But for a word that nothing draws again."""
    chance = ~claims["nature"].isin([*CERTAIN, TIMED])
    found = claims[chance & (claims["verdict"] != "open")]
    known = found[found["interval_from"] != ""]
    assert len(known) > 30 and {"bootstrap of windows", "seeds"} <= set(known["interval_from"])
    numbers = known[pd.to_numeric(known["lower"], errors="coerce").notna() & (known["failed"] == "0")]
    value, lower, upper = (numbers[name].astype(float) for name in ("reproduced", "lower", "upper"))
    assert ((lower <= value * (1 + 1e-5)) & (value * (1 - 1e-5) <= upper)).all()
    assert (claims.loc[claims["nature"].isin(CERTAIN), "repeats"] == "").all()


def test_errata_and_claims_not_run_are_explained(claims):
    silent = claims[claims["reason"].str.contains("erratum|not run") & (claims["explanation"] == "")]
    assert silent.empty, silent["id"].tolist()


def test_tables_that_follow_from_printed_numbers_are_the_stored_ones(smoke_project):
    assert compare_tables(smoke_project / "results") == 27


def test_the_numbers_of_each_stage_are_the_stored_ones(smoke_project):
    missed = []
    for row in pd.read_csv(ROOT / "tests/data/smoke_numbers.tsv", sep="\t", comment="#").itertuples():
        found = pd.read_csv(smoke_project / "results" / row.table, sep="\t").query(row.rows)[row.column].tolist()
        if found != pytest.approx([row.value], rel=row.tolerance):
            missed.append(f"{row.table}, {row.rows}: {row.column} = {found}, stored {row.value}")
    assert not missed, "\n".join(missed)


def test_the_commands_of_the_pages_that_read_a_run_do_so(smoke_project, tmp_path, monkeypatch):
    """Each as its page has it, beside the results of the run; what they write lies in a copy of its case."""
    places = (command for page in pages() for command in commands(page))
    found = {command.words for command in places if any(place in str(command) for place in READ_A_RUN)}
    run = sorted(words for words in found if words[0] == "millprint" and words[1] != "run")
    assert {words[1] for words in run} == {"match", "yields", "wear", "animate", "export"}
    (tmp_path / "config").symlink_to(smoke_project / "config")
    case = PLACES["MILL/CONTACT/CASE"]
    shutil.copytree(smoke_project / "results/dem" / case, tmp_path / "results/dem" / case)
    for name in ("fingerprint", "yield", "dose", "mills"):
        (tmp_path / "results" / name).symlink_to(smoke_project / "results" / name)
    shutil.copy(smoke_project / "results/yield/next_experiments.tsv", tmp_path / "conditions.tsv")
    monkeypatch.chdir(tmp_path)
    for words in run:
        assert millprint(list(words[1:])) == 0, words


def test_the_report_shows_the_mill_in_motion(smoke_project):
    folder = smoke_project / "results/dem/emax/calibrated/d10_f0.10_n300_s0"
    for name in ("mill.gif", "mill.png"):
        with Image.open(folder / name) as image:
            assert image.n_frames > 30
    assert "mill.png" in (smoke_project / "results/report/report.html").read_text()


def test_every_job_left_a_log(smoke_project):
    logs = list((smoke_project / "results/logs").rglob("*.log"))
    assert len(logs) > 20
    empty = [path.name for path in logs if not path.read_text().strip()]
    assert not empty


def test_collisions_are_counted_again_from_a_run_as_they_were_in_it(smoke_project):
    for path in sorted(smoke_project.glob("results/dem/emax/calibrated/*/summary.json"))[:2]:
        summary = read_json(path)
        rules = [CountingRule.of_count(count) for count in summary["collisions"]]
        again = with_counts({**summary, "collisions": []}, path.with_name("run.h5"), rules)["collisions"]
        assert len(rules) > 10
        for own, recorded in zip(again, summary["collisions"], strict=True):
            numbers = {name: value for name, value in recorded.items() if isinstance(value, int | float)}
            assert {name: own[name] for name in numbers} == pytest.approx(numbers, rel=1e-6)


def test_the_python_of_the_page_on_matching_runs(smoke_project):
    text = (ROOT / "docs/how_to/match.md").read_text()
    code = "".join(re.findall(r"^```python\n(.*?)^```", text, re.MULTILINE | re.DOTALL))
    check = "power = found.wall_power_W\nassert power.lower < power.value < power.upper and power.contact"
    done = subprocess.run([sys.executable, "-c", f"{code}{check}"], cwd=smoke_project, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_the_quick_validation_judges_impacts_and_a_tumbling_mill(smoke_project):
    verdicts = read_table(smoke_project / "results/validation/verdicts.tsv", text=["id", "verdict"])
    restitution = verdicts[(verdicts["id"] == "3a") & (verdicts["x"] > 30)]
    assert len(restitution) == 6
    assert set(restitution["verdict"]) == {"agrees"}
    assert (smoke_project / "results/validation/alumina_impact/predictions.svg").exists()
    bond = verdicts[verdicts["setup"] == "bond_mill"]
    assert set(bond["id"]) == {"5a", "5b", "5c"}
    assert bond["predicted"].between(bond["predicted_lower"], bond["predicted_upper"]).all()
    assert (bond["predicted"] > 0).all()
    assert (smoke_project / "results/validation/bond_mill/charge.svg").exists()
    assert "Validation" in (smoke_project / "results/report/report.html").read_text()


def test_a_second_run_has_nothing_to_do(smoke_project):
    again = run_snakemake(smoke_project, *SMOKE)
    assert "Nothing to be done" in again.stdout


def test_an_edit_of_the_yield_models_reruns_only_yield_and_report(smoke_project):
    file = smoke_project / "src/millprint/thesis/yields/__init__.py"
    before = file.read_text()
    file.write_text(before + "\nTOUCHED = 1\n")
    try:
        plan = run_snakemake(smoke_project, *SMOKE, "-n").stdout
    finally:
        file.write_text(before)
    rules = set(jobs_of(plan))
    yield_rules = rules_of("yields.smk")
    assert rules & yield_rules
    # It compares claims with our results, as the report does.
    report_rules = rules_of("chapters.smk") | rules_of("provenance.smk") | {"add_uncertainty_to_chapters"}
    assert rules <= yield_rules | report_rules | {"all", "everything"}


# Settings that are changed together, and the rules that use them.
CHANGED = [
    {
        "fingerprint={maps: {fill_ratios: [0.06]}}": {"plot_fingerprint"},
        "yields={proposals: {draws: 210}}": {"predict_yields", "plot_yields"},
    },
    {"yields={evaluation: {resamples: 1100}}": {"evaluate_yield_models", "leave_groups_out", "plot_yields"}},
]


@pytest.mark.parametrize("changes", CHANGED)
def test_changed_settings_rerun_only_the_rules_that_use_them_and_the_report(smoke_project, changes):
    plan = run_snakemake(smoke_project, *SMOKE, "-n", "--config", *changes).stdout
    always = rules_of("chapters.smk") | rules_of("provenance.smk") | {"all", "everything"}
    assert set(jobs_of(plan)) - always == set.union(*changes.values()), plan[-3000:]
