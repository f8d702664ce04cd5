"""Chapter 5: yield models, their evaluation, and the next experiments."""

from millprint.config.yields import PRIMARY, TWO_STEP, HeldOutConfig
from millprint.thesis.yields.regressors import (
    AVERAGED,
    BASELINES,
    REGRESSORS,
    models_of,
    other_seed,
    training_of,
)

YIELDS = f"{RESULTS}/yield"
MODELS = models_of(CONFIG.yields.models)
EVERY_MODEL = [*MODELS, (AVERAGED, PRIMARY)]
COMPARED_MODELS = [*EVERY_MODEL, *((name, PRIMARY) for name in BASELINES)]
EXPLAINED = [(name, TWO_STEP) for name in CONFIG.yields.models if REGRESSORS[name].explain]
TUNED = [(name, strategy) for name, strategy in MODELS if training_of(name).space]
YIELD_MODEL = f"{YIELDS}/models/{{model}}_{{strategy}}.json"
OTHER_MODEL = f"{YIELDS}/models/other_seed/{{model}}_{{strategy}}.json"
HELD_OUT = f"{YIELDS}/held_out/{{model}}_{{strategy}}"
# What a model is trained with, by its file in results/yield/models: regressor, strategy and settings.
TRAINED_MODELS = {
    **{f"{model}_{strategy}": (model, strategy, settings("yields.training")) for model, strategy in MODELS},
    **{
        f"other_seed/{model}_{strategy}": (model, strategy, other_seed(CONFIG.yields.training).model_dump(mode="json"))
        for model, strategy in TUNED
    },
}
# The machine of the cases of chapter 4, whose descriptors follow from the master curves. The mill gives the amplitude.
YIELD_CONTACT = CONTACTS[CONFIG.partition.contact]
YIELD_MACHINE = {
    "reference_speed": CONFIG.partition.reference_speed_rpm / 60,
    "density": YIELD_CONTACT.density_kg_m3,
    "diameter": CONFIG.partition.ball_diameter_mm * 1e-3,
}
# Runs of other groups, and the fingerprints of their mills.
OTHER_SOURCES = CONFIG.yields.other_sources
OTHER_FILES = {
    **({"others": OTHER_SOURCES.runs} if OTHER_SOURCES.runs else {}),
    "fingerprints": [source.fingerprint for source in OTHER_SOURCES.sources if source.fingerprint],
}
# Experiments that were proposed, are running or done.
TOLD_EXPERIMENTS = {"experiments": CONFIG.yields.proposals.experiments} if CONFIG.yields.proposals.experiments else {}


rule split_screening:
    input:
        **(OTHER_FILES if OTHER_SOURCES.in_training else {}),
        screening=CONFIG.data.screening,
        split=CONFIG.data.split,
    output:
        train=f"{YIELDS}/train.tsv",
        test=f"{YIELDS}/test.tsv",
    log:
        f"{LOGS}/yields/split_screening.log",
    localrule: True
    params:
        factors=FACTORS,
        other_sources=settings("yields.other_sources") if OTHER_SOURCES.in_training else {},
    message:
        "Splitting the screening runs according to {input.split}"
    script:
        "../../scripts/split_screening.py"


rule train_yield_model:
    input:
        train=rules.split_screening.output.train,
    output:
        model=f"{YIELDS}/models/{{trained}}.json",
    log:
        f"{LOGS}/yields/train/{{trained}}.log",
    benchmark:
        f"{BENCHMARKS}/train_yield_model/{{trained}}.tsv"
    wildcard_constraints:
        trained=any_of(TRAINED_MODELS),
    params:
        trained=lambda wildcards: TRAINED_MODELS[wildcards.trained],
        search=settings("yields.search"),
    message:
        "Tuning and fitting the yield model {wildcards.trained} on the training rows"
    script:
        "../../scripts/train_yield_model.py"


rule train_averaged_models:
    input:
        **TOLD_EXPERIMENTS,
        **(
            {"curves": f"{RESULTS}/fingerprint/curves_{CONFIG.partition.contact}.tsv"}
            if CONFIG.yields.proposals.curves == "fingerprint"
            else {}
        ),
        train=rules.split_screening.output.train,
        test=rules.split_screening.output.test,
        sources=shape_files(CONFIG.mill),
        regimes=CONFIG.data.regimes,
    output:
        rows=f"{YIELDS}/final_rows.tsv",
        mill=f"{YIELDS}/models/mill.json",
        models=expand(f"{YIELDS}/models/averaged_gpr_{{rows}}.json", rows=["primary", "final"]),
    log:
        f"{LOGS}/yields/train_averaged_models.log",
    benchmark:
        f"{BENCHMARKS}/train_averaged_models/train_averaged_models.tsv"
    params:
        machine=YIELD_MACHINE,
        mill=dumped(MILLS[CONFIG.mill]),
        volume_m3=MILLS[CONFIG.mill].volume_ml * 1e-6,
        proposals=CONFIG.yields.proposals.model_dump(mode="json", include={"experiments", "region"}),
        averaging=settings("yields.averaging"),
    message:
        "Fitting the averaged Gaussian process on the training rows, and on every run"
    script:
        "../../scripts/train_averaged_models.py"


YIELD_TABLES = [
    *("locked", "scores_by_scheme", "coverage", "predictions", "out_of_domain", "time_variance"),
    *("scores", "pit", "differences", "shap", "shap_ranking", "seeds"),
]


rule hold_out_yields:
    input:
        train=rules.split_screening.output.train,
        test=rules.split_screening.output.test,
    output:
        predictions=f"{HELD_OUT}.tsv",
        intervals=f"{HELD_OUT}_intervals.tsv",
    log:
        f"{LOGS}/yields/hold_out/{{model}}_{{strategy}}.log",
    benchmark:
        f"{BENCHMARKS}/hold_out_yields/{{model}}_{{strategy}}.tsv"
    wildcard_constraints:
        strategy=f"{PRIMARY}|{TWO_STEP}",
    params:
        training=settings("yields.training"),
        evaluation=CONFIG.yields.evaluation.part(HeldOutConfig),
        averaging=settings("yields.averaging"),
    message:
        "Predicting every run with models {wildcards.model}, {wildcards.strategy}, that were not trained on it"
    script:
        "../../scripts/hold_out_yields.py"


rule evaluate_yield_models:
    input:
        train=rules.split_screening.output.train,
        test=rules.split_screening.output.test,
        models=every_model(YIELD_MODEL, MODELS),
        averaged=f"{YIELDS}/models/averaged_gpr_primary.json",
        held_out=every_model(f"{HELD_OUT}.tsv", COMPARED_MODELS),
        intervals=every_model(f"{HELD_OUT}_intervals.tsv", COMPARED_MODELS),
        explained=every_model(YIELD_MODEL, EXPLAINED),
        searched_again=every_model(OTHER_MODEL, TUNED if CONFIG.yields.searched_again else []),
        outside=CONFIG.yields.out_of_domain,
    output:
        **{name: f"{YIELDS}/{name}.tsv" for name in YIELD_TABLES},
    log:
        f"{LOGS}/yields/evaluate_yield_models.log",
    benchmark:
        f"{BENCHMARKS}/evaluate_yield_models/evaluate_yield_models.tsv"
    params:
        training=settings("yields.training"),
        evaluation=settings("yields.evaluation"),
        interval_level=CONFIG.yields.interval_level,
    message:
        "Evaluating the yield models on the locked split, on held-out runs, outside their domain, and with other seeds"
    script:
        "../../scripts/evaluate_yield_models.py"


rule permute_yields:
    input:
        train=rules.split_screening.output.train,
        test=rules.split_screening.output.test,
    output:
        permutations=f"{YIELDS}/permutations.tsv",
        permutation_test=f"{YIELDS}/permutation_test.tsv",
    log:
        f"{LOGS}/yields/permute_yields.log",
    benchmark:
        f"{BENCHMARKS}/permute_yields/permute_yields.tsv"
    params:
        averaging=settings("yields.averaging"),
        trial=settings("yields.library_trial"),
    message:
        "Scoring the averaged model on shuffled yields"
    script:
        "../../scripts/try_averaged_model.py"


rule predict_yields:
    input:
        **TOLD_EXPERIMENTS,
        model=f"{YIELDS}/models/{CONFIG.yields.prediction.model}.json",
        proposing=f"{YIELDS}/models/averaged_gpr_final.json",
        mill=rules.train_averaged_models.output.mill,
        conditions=CONFIG.yields.prediction.conditions,
    output:
        predicted=f"{YIELDS}/predicted_conditions.tsv",
        proposals=f"{YIELDS}/next_experiments.tsv",
        left_out=f"{YIELDS}/not_proposed.tsv",
        reasons=f"{YIELDS}/not_proposed_reasons.tsv",
    log:
        f"{LOGS}/yields/predict_yields.log",
    benchmark:
        f"{BENCHMARKS}/predict_yields/predict_yields.tsv"
    params:
        settings=settings("yields.prediction"),
        training=settings("yields.training"),
        conformal_folds=CONFIG.yields.evaluation.conformal_folds,
        interval_level=CONFIG.yields.interval_level,
        volume_m3=MILLS[CONFIG.mill].volume_ml * 1e-6,
        proposals=settings("yields.proposals"),
        chemistry=settings("doe.chemistry"),
    message:
        "Predicting the yields of {input.conditions}, and proposing the next experiments within the region"
    script:
        "../../scripts/predict_yields.py"


use rule hold_out_yields as leave_groups_out with:
    input:
        **OTHER_FILES,
        screening=CONFIG.data.screening,
        split=CONFIG.data.split,
        train=rules.split_screening.output.train,
        test=rules.split_screening.output.test,
        sources=shape_files(CONFIG.mill),
        regimes=CONFIG.data.regimes,
    output:
        regimes=f"{YIELDS}/regimes.tsv",
        regimes_summary=f"{YIELDS}/regimes_summary.tsv",
        sources=f"{YIELDS}/sources.tsv",
        sources_predictions=f"{YIELDS}/sources_predictions.tsv",
        sources_runs=f"{YIELDS}/sources_runs.tsv",
    log:
        f"{LOGS}/yields/leave_groups_out.log",
    benchmark:
        f"{BENCHMARKS}/leave_groups_out/leave_groups_out.tsv"
    params:
        machine=YIELD_MACHINE,
        mill=dumped(MILLS[CONFIG.mill]),
        factors=FACTORS,
        other_sources=settings("yields.other_sources"),
        evaluation=settings("yields.evaluation"),
        prediction=settings("yields.prediction"),
        interval_level=CONFIG.yields.interval_level,
    message:
        "Predicting every source of yields, and the fill ratios of {input.regimes}, by models trained without them"


YIELD_FIGURES = f"{YIELDS}/figures"
DRAWN_YIELDS = [
    *("predictions", "intervals", "shap", "evaluation", "coverage"),
    *("proposals", "regimes", "scores", "pit", "permutations", "sources"),
]


rule plot_yields:
    input:
        predictions=rules.evaluate_yield_models.output.predictions,
        shap=rules.evaluate_yield_models.output.shap,
        scores_by_scheme=rules.evaluate_yield_models.output.scores_by_scheme,
        coverage=rules.evaluate_yield_models.output.coverage,
        proposals=rules.predict_yields.output.proposals,
        regimes=rules.leave_groups_out.output.regimes_summary,
        scores=rules.evaluate_yield_models.output.scores,
        pit=rules.evaluate_yield_models.output.pit,
        permutations=rules.permute_yields.output.permutations,
        sources=rules.leave_groups_out.output.sources,
        sources_predictions=rules.leave_groups_out.output.sources_predictions,
        claims=CONFIG.data.claims,
    output:
        **{f"{name}_figure": figures(f"{YIELD_FIGURES}/{name}") for name in DRAWN_YIELDS},
    log:
        f"{LOGS}/yields/plot_yields.log",
    localrule: True
    message:
        "Drawing the figures of chapter 5"
    script:
        "../../scripts/plot_yields.py"


YIELD_OUTPUTS = [
    *rules.evaluate_yield_models.output,
    *rules.permute_yields.output,
    *rules.leave_groups_out.output,
    *rules.predict_yields.output,
    *rules.plot_yields.output,
]
