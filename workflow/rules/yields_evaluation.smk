"""Evaluation of the yield models: locked split, held-out runs, other choices, SHAP values."""

from millprint.config.yields import HeldOutConfig

YIELD_TABLES = [
    "locked",
    "honest",
    "coverage",
    "predictions",
    "out_of_domain",
    "hyperparameters",
    "time_variance",
    "scores",
    "pit",
    "differences",
    "shap",
    "shap_ranking",
    "choices",
]


rule hold_out_yields:
    input:
        train=rules.split_screening.output.train,
        test=rules.split_screening.output.test,
    output:
        predictions=expand(f"{HELD_OUT}.tsv", strategy=STRATEGIES, allow_missing=True),
        intervals=expand(f"{HELD_OUT}_intervals.tsv", strategy=STRATEGIES, allow_missing=True),
    log:
        f"{LOGS}/yields/hold_out_{{model}}.log",
    benchmark:
        f"{BENCHMARKS}/hold_out_yields/{{model}}.tsv"
    wildcard_constraints:
        model=HELD_OUT_ALONE,
    params:
        models=lambda wildcards: [(wildcards.model, strategy) for strategy in STRATEGIES],
        training=yield_settings("training"),
        honest=CONFIG.yields.honest.part(HeldOutConfig),
        averaging=yield_settings("averaging"),
        library=library("hold_out_yields.py"),
    message:
        "Predicting every run with both models {wildcards.model} that were not trained on it"
    script:
        "../../scripts/hold_out_yields.py"


use rule hold_out_yields as hold_out_quick_yields with:
    output:
        predictions=every_model(f"{HELD_OUT}.tsv", HELD_OUT_TOGETHER),
        intervals=every_model(f"{HELD_OUT}_intervals.tsv", HELD_OUT_TOGETHER),
    log:
        f"{LOGS}/yields/hold_out_quick.log",
    benchmark:
        f"{BENCHMARKS}/hold_out_yields/quick.tsv"
    params:
        models=HELD_OUT_TOGETHER,
        training=yield_settings("training"),
        honest=CONFIG.yields.honest.part(HeldOutConfig),
        averaging=yield_settings("averaging"),
        library=library("hold_out_yields.py"),
    message:
        "Predicting every run with quick models that were not trained on it"


rule evaluate_yield_models:
    input:
        train=rules.split_screening.output.train,
        test=rules.split_screening.output.test,
        models=every_model(YIELD_MODEL, MODELS),
        averaged=f"{YIELDS}/models/averaged_gpr_primary.json",
        held_out=every_model(f"{HELD_OUT}.tsv", COMPARED_MODELS),
        intervals=every_model(f"{HELD_OUT}_intervals.tsv", COMPARED_MODELS),
        explained=every_model(YIELD_MODEL, EXPLAINED),
        otherwise=[
            OTHER_MODEL.format(model=model, strategy=strategy, choice=choice)
            for model, strategy, choice in SEARCHED_AGAIN
        ],
        outside=CONFIG.yields.out_of_domain,
    output:
        **{name: f"{YIELDS}/{name}.tsv" for name in YIELD_TABLES},
    log:
        f"{LOGS}/yields/evaluate_yield_models.log",
    benchmark:
        f"{BENCHMARKS}/evaluate_yield_models/evaluate_yield_models.tsv"
    params:
        training=yield_settings("training"),
        honest=yield_settings("honest"),
        interval_level=CONFIG.yields.interval_level,
        searched_again=SEARCHED_AGAIN,
        library=library("evaluate_yield_models.py"),
    message:
        "Evaluating the yield models on the locked split, on held-out runs, outside their domain, and with other choices"
    script:
        "../../scripts/evaluate_yield_models.py"
