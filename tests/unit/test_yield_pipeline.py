"""The scripts of chapter 5 from tables to claims; the test rows are not used for training."""

import shutil
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from scipy.stats import f_oneway

import evaluate_yield_models
import hold_out_yields
import leave_groups_out
import permute_yields
import plot_yields
import predict_yields
import search_retrospectively
import split_screening
import train_averaged_models
import train_yield_model
from millprint.config.search_spaces import COMPARED
from millprint.fingerprint.condition import Condition
from millprint.run.files import read_table
from millprint.thesis.claims.tabulate import collect_findings
from millprint.thesis.curves.regimes import read_regimes
from millprint.thesis.yields.metrics import LOCKED_AGAIN, SPREAD
from millprint.thesis.yields.new_conditions import write_predictions
from millprint.thesis.yields.regressors import AVERAGED, CLIMATOLOGY, REGRESSORS, models_of, other_seed
from tests.conftest import ROOT
from tests.unit.claim_words import word_of
from tests.unit.doe_settings import SCREENING
from tests.unit.doe_settings import settings as doe_settings
from tests.unit.yield_settings import SPLIT, parts, settings

pytestmark = pytest.mark.slow

CLAIMS = ROOT / "config/data/claims.tsv"
REGIMES = ROOT / "config/data/regimes.tsv"
MODELS = models_of(COMPARED)
EVERY_MODEL = (*MODELS, (AVERAGED, "primary"))
REFERENCE = Condition(0.10, speed_hz=10.0, ball_diameter_m=0.01, density_kg_m3=7700.0, amplitude_m=0.017)
TABLES = [
    "locked",
    "scores_by_scheme",
    "coverage",
    "predictions",
    "out_of_domain",
    "time_variance",
    "scores",
    "pit",
    "differences",
]
# Files that the test yields may change: the final metrics, and the predictions, which list the measured yields too.
FINAL_METRICS = {"test.tsv", "locked.tsv", "seeds.tsv", "predictions.tsv"}
# Models whose held-out predictions are computed here; those of `linear` stand for all other regressors.
HELD_OUT = ("linear", "averaged_gpr", "climatology")
# Files made from all runs: evaluations over all of them, and everything that follows the evaluation.
FOLLOWING = {
    "permutations.tsv",
    "permutation_test.tsv",
    "regimes.tsv",
    "regimes_summary.tsv",
    "retrospective.tsv",
    "retrospective_summary.tsv",
    "next_experiments.tsv",
    "not_proposed.tsv",
    "not_proposed_reasons.tsv",
}
ALL_RUNS = FOLLOWING | {
    "scores_by_scheme.tsv",
    "coverage.tsv",
    "time_variance.tsv",
    "scores.tsv",
    "pit.tsv",
    "differences.tsv",
    *(f"held_out/{model}{part}.tsv" for model in HELD_OUT for part in ("", "_intervals")),
    "models/averaged_gpr_final.json",
    "predicted_final.tsv",
    "final_rows.tsv",
}
TEST_CASES = ["9", "14", "10", "22", "1", "12"]
# Wrong yields of the test rows, by case.
POISON = {"9": 3, "14": 99, "10": 88, "22": 1, "1": 97, "12": 5}


def poisoned(path: Path) -> Path:
    """The screening table with other yields in the test rows."""
    lines = SCREENING.read_text().splitlines()
    for number, line in enumerate(lines):
        case, *_ = line.split("\t")
        if case in POISON:
            lines[number] = "\t".join([*line.split("\t")[:-1], str(POISON[case])])
    path.write_text("\n".join(lines) + "\n")
    return path


def run_chapter(results: Path, screening: Path, to_the_end: bool = True) -> Path:
    """All of chapter 5 at a small budget; to save time, held-out predictions of two models are used for all models.

    Unless `to_the_end`, without what is made of all runs after the evaluation.
    """
    config, folder = settings(), results / "yield"
    train, test = str(folder / "train.tsv"), str(folder / "test.tsv")
    split_screening.main(str(screening), str(SPLIT), train, test, doe_settings().factors, config.other_sources)
    models = []
    for model, strategy in MODELS:
        models.append(str(folder / f"models/{model}_{strategy}.json"))
        train_yield_model.main(train, models[-1], model, strategy, config.training, config.search)
    rows, mill = str(folder / "final_rows.tsv"), str(folder / "models/mill.json")
    cases = read_regimes(str(REGIMES))
    train_averaged_models.collect([train, test], cases, None, rows, mill, REFERENCE, "emax", 125e-6, config.proposals)
    for name, files in (("primary", [train]), ("final", [rows])):
        stored = str(folder / f"models/averaged_gpr_{name}.json")
        train_averaged_models.main(files, stored, config.averaging)
    held_out = {}
    for model, strategy in ((name, "primary") for name in HELD_OUT):
        paths = folder / f"held_out/{model}.tsv", folder / f"held_out/{model}_intervals.tsv"
        held_out[model] = tuple(map(str, paths))
        hold_out_yields.main(train, test, *paths, model, strategy, config.training, config.evaluation, config.averaging)
    used = [held_out["linear"]] * len(models) + [held_out["averaged_gpr"], held_out[CLIMATOLOGY]]
    evaluate_yield_models.main(
        SimpleNamespace(
            train=train,
            test=test,
            models=models,
            averaged=str(folder / "models/averaged_gpr_primary.json"),
            held_out=[predictions for predictions, _ in used],
            intervals=[intervals for _, intervals in used],
            outside=config.out_of_domain,
        ),
        SimpleNamespace(**{name: folder / f"{name}.tsv" for name in TABLES}),
        config.training,
        config.evaluation,
        config.interval_level,
    )
    again = []
    for model, strategy in ((name, strategy) for name, strategy in MODELS if REGRESSORS[name].space):
        again.append(str(folder / f"models/other_seed/{model}_{strategy}.json"))
        train_yield_model.main(train, again[-1], model, strategy, other_seed(config.training), config.search)
    compared = SimpleNamespace(
        train=train, test=test, models=models, searched_again=again, outside=config.out_of_domain
    )
    evaluate_yield_models.compare(compared, folder / "seeds.tsv", config.training)
    trees = [path for path in models if "rf_two" in path or "xgb_two" in path]
    evaluate_yield_models.explain([train, test], trees, folder / "shap.tsv", folder / "shap_ranking.tsv")
    for name in ("primary", "final"):
        model, out = str(folder / f"models/averaged_gpr_{name}.json"), str(folder / f"predicted_{name}.tsv")
        own = (config.prediction, config.training, config.evaluation.conformal_folds, 0.95, False)
        write_predictions(model, config.prediction.conditions, out, *own, mill)
    if to_the_end:
        follow_up(folder, [train, test], config)
    return folder


def follow_up(folder: Path, parts: list[str], config) -> None:
    """What comes after the evaluation: other regimes, the next experiments, and what the models are worth."""
    regimes = SimpleNamespace(regimes=folder / "regimes.tsv", regimes_summary=folder / "regimes_summary.tsv")
    own = (config.training, config.evaluation, config.averaging, config.interval_level)
    cases = read_regimes(str(REGIMES))
    leave_groups_out.leave_regimes(parts, cases, regimes, REFERENCE, *own)
    mill, final = str(folder / "models/mill.json"), str(folder / "models/averaged_gpr_final.json")
    names = {"proposals": "next_experiments", "left_out": "not_proposed", "reasons": "not_proposed_reasons"}
    proposed = SimpleNamespace(**{key: folder / f"{name}.tsv" for key, name in names.items()})
    chemistry = doe_settings().chemistry
    predict_yields.propose_experiments(final, mill, proposed, 125e-6, config.proposals, config.prediction, chemistry)
    searched = SimpleNamespace(
        retrospective=folder / "retrospective.tsv",
        summary=folder / "retrospective_summary.tsv",
    )
    search_retrospectively.main(parts, searched, config.retrospective, config.averaging, config.evaluation.level)
    trust(folder, parts, config)


def trust(folder: Path, parts: list[str], config) -> None:
    """The permutation test."""
    permuted = SimpleNamespace(
        permutations=folder / "permutations.tsv", permutation_test=folder / "permutation_test.tsv"
    )
    permute_yields.main(parts, permuted, config.averaging, config.library_trial)


@pytest.fixture(scope="module")
def chapter(tmp_path_factory) -> Path:
    results = tmp_path_factory.mktemp("clean")
    return run_chapter(results, SCREENING)


@pytest.fixture(scope="module")
def poisoned_chapter(tmp_path_factory) -> Path:
    results = tmp_path_factory.mktemp("poisoned")
    return run_chapter(results, poisoned(results / "screening.tsv"), to_the_end=False)


def test_poisoned_test_yields_change_nothing_but_the_final_metrics(chapter, poisoned_chapter):
    files = {str(path.relative_to(chapter)) for path in chapter.rglob("*") if path.is_file()}
    made = {str(path.relative_to(poisoned_chapter)) for path in poisoned_chapter.rglob("*") if path.is_file()}
    assert made < files and files - made <= ALL_RUNS
    assert files >= ALL_RUNS and files >= FINAL_METRICS
    same = files - ALL_RUNS - FINAL_METRICS
    assert {f"models/{model}_{strategy}.json" for model, strategy in EVERY_MODEL} <= same
    assert {"out_of_domain.tsv", "shap.tsv"} <= same
    for name in same:
        assert (chapter / name).read_bytes() == (poisoned_chapter / name).read_bytes(), name
    clean, other = (read_table(folder / "predictions.tsv", text=["case"]) for folder in (chapter, poisoned_chapter))
    for column in ("predicted_percent", "deviation_pp", "lower_percent", "upper_percent"):
        assert clean[column].equals(other[column])
    changed = clean["yield_percent"] != other["yield_percent"]
    assert set(clean.loc[changed, "case"]) == set(TEST_CASES)
    locked, wrong = (read_table(folder / "locked.tsv") for folder in (chapter, poisoned_chapter))
    assert (locked["rmse"] != wrong["rmse"]).all()


def test_poisoned_test_yields_do_not_change_what_is_predicted_for_them(chapter, poisoned_chapter):
    """The files of held-out predictions contain the locked split too, at the reduced budget."""
    for model in HELD_OUT:
        for part, same in (("", ["predicted_percent"]), ("_intervals", ["lower_percent", "upper_percent"])):
            clean, other = (
                read_table(folder / f"held_out/{model}{part}.tsv", text=["scheme", "case"]).query(
                    f"scheme == '{LOCKED_AGAIN}'"
                )
                for folder in (chapter, poisoned_chapter)
            )
            assert all(clean[column].equals(other[column]) for column in same)
            assert not clean["yield_percent"].equals(other["yield_percent"])
            if not part:
                # Only the truth that a distribution is scored with has changed.
                assert clean["distribution"].equals(other["distribution"])
                assert not clean["crps_pp"].equals(other["crps_pp"])


def test_what_follows_the_evaluation_is_the_same_to_the_last_bit_in_a_second_run(chapter, tmp_path, monkeypatch):
    """The models before it are those of the run with poisoned yields, and with them those of single regressors."""
    again = tmp_path / "yield"
    shutil.copytree(chapter, again)
    for name in FOLLOWING:
        (again / name).unlink()
    averaged = {key: own for key, own in leave_groups_out.REGIME_PROCEDURES.items() if key[0] == AVERAGED}
    monkeypatch.setattr(leave_groups_out, "REGIME_PROCEDURES", averaged)
    follow_up(again, [str(again / "train.tsv"), str(again / "test.tsv")], settings())
    for name in FOLLOWING:
        first, second = ((folder / name).read_text().splitlines() for folder in (chapter, again))
        if name.startswith("regimes"):
            first = [first[0], *(line for line in first if line.startswith(AVERAGED))]
        assert first == second, name


def test_another_split_and_another_seed_work(tmp_path):
    split = pd.read_csv(SPLIT, sep="\t", comment="#", dtype=str)
    split["role"] = ["test" if number % 4 == 0 else "train" for number in range(len(split))]
    path, config = tmp_path / "split.tsv", settings()
    split.to_csv(path, sep="\t", index=False)
    train, test = str(tmp_path / "train.tsv"), str(tmp_path / "test.tsv")
    split_screening.main(str(SCREENING), str(path), train, test, doe_settings().factors, config.other_sources)
    other = config.training.model_copy(update={"seed": 7})
    for seed, training in (("first", config.training), ("other", other)):
        train_yield_model.main(train, str(tmp_path / f"{seed}.json"), "xgb", "primary", training, config.search)
    assert (tmp_path / "first.json").read_bytes() != (tmp_path / "other.json").read_bytes()
    outputs = tmp_path / "held.tsv", tmp_path / "intervals.tsv"
    shifted = config.evaluation.model_copy(update={"seed": 7})
    hold_out_yields.main(train, test, *outputs, "linear", "primary", config.training, shifted, config.averaging)
    held = read_table(outputs[0], text=["scheme", "case"])
    assert (held["scheme"] == LOCKED_AGAIN).sum() == 7


def test_every_claim_has_a_finding_and_linear_is_reproduced(chapter):
    claims = read_table(CLAIMS, text=["id", "value", "tolerance"])
    own = claims[claims["id"].str.startswith("5.")].set_index("id")
    found = collect_findings(chapter.parent, CLAIMS, "5.")
    assert set(found) == set(own.index)
    # The two-step GPR is not held out here.
    assert [name for name, finding in found.items() if finding.value is None] == ["5.high_yields"]
    verdicts = {name: word_of(own.loc[name, "value"], own.loc[name, "tolerance"], found[name]) for name in found}
    assert {verdicts[name] for name in verdicts if name.startswith("5.linear")} == {"agrees"}
    assert "decide nothing" in found["5.linear.r2"].explanation
    # The share is below the half that the thesis states; it follows from the F of a one-way analysis of variance.
    train, test = parts()
    runs = pd.concat([train, test])
    levels = [rows["yield_percent"] for _, rows in runs.groupby("time_h")]
    ratio = f_oneway(*levels).statistic * (len(levels) - 1) / (len(runs) - len(levels))
    assert found["5.time_variance"].value == pytest.approx(100 * ratio / (1 + ratio), rel=1e-6)
    assert found["5.time_variance"].value < 40


def test_tables_have_the_columns_that_are_read_later(chapter):
    locked = read_table(chapter / "locked.tsv")
    assert list(locked)[:7] == ["model", "strategy", "rmse", "mae", "mape", "r2", "wmse"]
    assert list(zip(locked["model"], locked["strategy"], strict=True)) == list(EVERY_MODEL)
    scores = read_table(chapter / "scores_by_scheme.tsv")
    assert list(scores) == ["model", "strategy", "scheme", "metric", "value", "error", "lower", "upper", *SPREAD]
    schemes = {"locked", "locked_reduced_budget", "leave_one_out", "nested_cv", "random_split"}
    # Climatology is not a trained model, so it has no row for the locked split at the full budget.
    assert set(scores["scheme"]) == schemes and len(scores) == (len(schemes) * 13 - 1) * 5
    assert (scores["lower"] <= scores["upper"]).all()
    repeated = scores["scheme"].isin(["nested_cv", "random_split"])
    assert ((scores["repeats"] > 1) == repeated).all()
    assert (scores["lowest"] <= scores["value"])[repeated].all()
    assert (scores["value"] <= scores["highest"])[repeated].all()
    merged = scores[(scores["scheme"] == "locked") & (scores["metric"] == "rmse")].merge(locked)
    np.testing.assert_allclose(merged["value"], merged["rmse"], rtol=1e-6)
    coverage = read_table(chapter / "coverage.tsv")
    assert set(coverage["method"]) == {"cv_plus", "mixture", "errors"} and set(coverage["nominal"]) == {0.5, 0.8, 0.95}
    assert coverage["covered"].between(coverage["lower"], coverage["upper"]).all()
    choices = read_table(chapter / "seeds.tsv")
    taken = choices[choices["choice"] == "as taken"].reset_index(drop=True)
    np.testing.assert_allclose(taken["rmse"], locked["rmse"].iloc[:-1], rtol=1e-6)
    outside = read_table(chapter / "out_of_domain.tsv", text=["case"]).query("case == '27'").iloc[:-1]
    np.testing.assert_allclose(taken["case_27_percent"], outside["predicted_percent"], rtol=1e-6)
    assert set(choices["choice"]) == {"as taken", "seed", "search_seed"}
    assert len(choices) == len(choices.drop_duplicates(["model", "strategy", "choice", "value"]))


def test_tables_of_trust_agree_with_each_other(chapter):
    by_scheme = read_table(chapter / "scores_by_scheme.tsv")
    differences = read_table(chapter / "differences.tsv")
    averaged = by_scheme.query("model == 'averaged_gpr' and metric == 'r2'").set_index("scheme")
    linear = by_scheme.query("model == 'linear' and metric == 'r2'").set_index("scheme")
    paired = differences.query("model == 'linear' and metric == 'r2'").set_index("scheme")
    for scheme in ("leave_one_out", "nested_cv"):
        gap = linear.loc[scheme, "value"] - averaged.loc[scheme, "value"]
        assert paired.loc[scheme, "difference"] == pytest.approx(gap, rel=1e-4, abs=1e-6)
    assert (differences["p_holm"] >= differences["p"] - 1e-12).all() and len(differences) == 2 * 2 * 12
    assert ((differences["p_holm"] < 0.05) == (differences["told_apart"] == "yes")).all()
    scores = read_table(chapter / "scores.tsv")
    reference = scores[scores["model"] == CLIMATOLOGY]
    assert (reference["skill"].abs() < 1e-9).all() and len(reference) == 4
    shares = read_table(chapter / "pit.tsv").groupby(["model", "strategy", "scheme"])["share"].sum()
    np.testing.assert_allclose(shares, 1)
    permuted, test = read_table(chapter / "permutations.tsv"), read_table(chapter / "permutation_test.tsv").iloc[0]
    assert len(permuted) == 20 and test["p"] == pytest.approx(
        (1 + (permuted["r2"][1:] >= permuted["r2"][0]).sum()) / 20
    )


def drawn(names: list[str], folder: Path) -> SimpleNamespace:
    return SimpleNamespace(**{f"{name}_{kind}": folder / f"{name}.{kind}" for name in names for kind in ("svg", "png")})


def test_figures_are_drawn(chapter, tmp_path):
    plotted = drawn(["predictions", "intervals", "shap"], tmp_path)
    tables = {name: chapter / f"{name}.tsv" for name in ("predictions", "shap")}
    plot_yields.draw_models(SimpleNamespace(**tables), plotted)
    trusted = drawn(["evaluation", "coverage", "retrospective", "proposals", "regimes"], tmp_path)
    tables = {name: chapter / f"{name}.tsv" for name in ("scores_by_scheme", "coverage", "retrospective")}
    more = {"proposals": chapter / "next_experiments.tsv", "regimes": chapter / "regimes_summary.tsv"}
    plot_yields.draw_trust(SimpleNamespace(**tables, **more, claims=CLAIMS), trusted)
    scored = drawn(["scores", "pit", "permutations"], tmp_path)
    tables = {name: chapter / f"{name}.tsv" for name in ("scores", "pit", "permutations")}
    plot_yields.draw_scores(SimpleNamespace(**tables), scored)
    for path in (*vars(plotted).values(), *vars(trusted).values(), *vars(scored).values()):
        assert path.stat().st_size > 5000
