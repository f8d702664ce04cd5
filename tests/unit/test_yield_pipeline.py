"""The scripts of chapter 5 from tables to claims; the test rows are not used for training."""

import itertools
import shutil
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import evaluate_yield_models
import hold_out_yields
import predict_yields
import split_screening
import train_averaged_models
import train_yield_model
import try_averaged_model
from millprint.config.yields import COMPARED
from millprint.run.files import read_table
from millprint.thesis.yields.features import LOCKED_AGAIN
from millprint.thesis.yields.held_out import procedure_of
from millprint.thesis.yields.new_conditions import write_predictions
from millprint.thesis.yields.regressors import AVERAGED, BASELINES, CLIMATOLOGY, models_of, other_seed, training_of
from tests.unit.doe_settings import SCREENING
from tests.unit.doe_settings import settings as doe_settings
from tests.unit.yield_settings import CASES, REFERENCE, SPLIT, settings

pytestmark = pytest.mark.slow

MODELS = models_of(COMPARED)
EVERY_MODEL = (*MODELS, (AVERAGED, "primary"))
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
HELD_OUT = ("linear", "averaged_gpr", *BASELINES)
# Files made from all runs: evaluations over all of them, and everything that follows the evaluation.
FOLLOWING = {f"{name}.tsv" for name in ("permutations", "permutation_test", "regimes", "regimes_summary")} | {
    *("next_experiments.tsv", "not_proposed.tsv", "not_proposed_reasons.tsv"),
}
ALL_RUNS = FOLLOWING | {
    *(f"{name}.tsv" for name in TABLES if name not in ("locked", "predictions", "out_of_domain")),
    *(f"held_out/{model}{part}.tsv" for model in HELD_OUT for part in ("", "_intervals")),
    *("models/averaged_gpr_final.json", "predicted_final.tsv", "final_rows.tsv"),
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
    given, made = SimpleNamespace(train=train, test=test), SimpleNamespace(rows=rows, mill=mill)
    train_averaged_models.collect(given, made, CASES, CASES, REFERENCE, "emax", 125e-6, config.proposals)
    for name, path in (("primary", train), ("final", rows)):
        stored = str(folder / f"models/averaged_gpr_{name}.json")
        train_averaged_models.main(path, stored, config.averaging)
    held_out = {}
    for model, strategy in ((name, "primary") for name in HELD_OUT):
        paths = folder / f"held_out/{model}.tsv", folder / f"held_out/{model}_intervals.tsv"
        made = SimpleNamespace(predictions=paths[0], intervals=paths[1])
        held_out[model] = tuple(map(str, paths))
        procedure = procedure_of(model, strategy, config.training, config.evaluation, config.averaging)
        hold_out_yields.hold_out(given, made, model, procedure, config.evaluation)
    used = [held_out["linear"]] * len(models) + [held_out[name] for name in ("averaged_gpr", *BASELINES)]
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
    for model, strategy in ((name, strategy) for name, strategy in MODELS if training_of(name).space):
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

    def tables(*names: str) -> SimpleNamespace:
        return SimpleNamespace(**{name: folder / f"{name}.tsv" for name in names})

    models, made = (config.training, config.evaluation, config.averaging), tables("regimes", "regimes_summary")
    hold_out_yields.leave_regimes(parts, CASES, made, REFERENCE, models, config.interval_level)
    given = SimpleNamespace(
        proposing=str(folder / "models/averaged_gpr_final.json"), mill=str(folder / "models/mill.json")
    )
    names = {"proposals": "next_experiments", "left_out": "not_proposed", "reasons": "not_proposed_reasons"}
    proposed = SimpleNamespace(**{key: folder / f"{name}.tsv" for key, name in names.items()})
    chemistry = doe_settings().chemistry
    predict_yields.propose_experiments(given, proposed, 125e-6, config.proposals, config.prediction, chemistry)
    try_averaged_model.main(parts, tables("permutations", "permutation_test"), config.averaging, config.library_trial)


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
    averaged = {key: own for key, own in hold_out_yields.REGIME_PROCEDURES.items() if key[0] == AVERAGED}
    monkeypatch.setattr(hold_out_yields, "REGIME_PROCEDURES", averaged)
    follow_up(again, [str(again / "train.tsv"), str(again / "test.tsv")], settings())
    for name in FOLLOWING:
        first, second = ((folder / name).read_text().splitlines() for folder in (chapter, again))
        if name.startswith("regimes"):
            first = [first[0], *(line for line in first if line.startswith(AVERAGED))]
        assert first == second, name


def test_tables_of_trust_agree_with_each_other(chapter):
    scores = (
        read_table(chapter / "scores_by_scheme.tsv").query("metric == 'r2'").set_index(["model", "scheme"])["value"]
    )
    differences = read_table(chapter / "differences.tsv")
    paired = differences.query("model == 'linear' and metric == 'r2'").set_index(["against", "scheme"])["difference"]
    for scheme, reference in itertools.product(("leave_one_out", "nested_cv"), ("averaged_gpr", *BASELINES)):
        gap = scores[("linear", scheme)] - scores[(reference, scheme)]
        assert paired[(f"{reference} primary", scheme)] == pytest.approx(gap, rel=1e-4, abs=1e-6)
    assert (differences["p_holm"] >= differences["p"] - 1e-12).all()
    assert ((differences["p_holm"] < 0.05) == (differences["told_apart"] == "yes")).all()
    reference = read_table(chapter / "scores.tsv").query(f"model == '{CLIMATOLOGY}'")
    assert (reference["skill"].abs() < 1e-9).all() and len(reference) == 4
    shares = read_table(chapter / "pit.tsv").groupby(["model", "strategy", "scheme"])["share"].sum()
    np.testing.assert_allclose(shares, 1)
    permuted, test = read_table(chapter / "permutations.tsv")["r2"], read_table(chapter / "permutation_test.tsv")
    assert test["p"][0] == pytest.approx((1 + (permuted[1:] >= permuted[0]).sum()) / 20)
