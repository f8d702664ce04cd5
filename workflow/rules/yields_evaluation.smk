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
        predictions=f"{HELD_OUT}.tsv",
        intervals=f"{HELD_OUT}_intervals.tsv",
    log:
        f"{LOGS}/yields/hold_out/{{model}}_{{strategy}}.log",
    benchmark:
        f"{BENCHMARKS}/hold_out_yields/{{model}}_{{strategy}}.tsv"
    wildcard_constraints:
        strategy=f"{PRIMARY}|{TWO_STEP}",
    params:
        training=yield_settings("training"),
        honest=CONFIG.yields.honest.part(HeldOutConfig),
        averaging=yield_settings("averaging"),
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
    message:
        "Evaluating the yield models on the locked split, on held-out runs, outside their domain, and with other choices"
    script:
        "../../scripts/evaluate_yield_models.py"
