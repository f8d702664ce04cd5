"""Evaluation of the yield models: locked split, held-out runs, other choices, other regimes, SHAP values."""

from millprint.config.yields import HeldOutConfig

YIELD_TABLES = [
    "locked",
    "honest",
    "coverage",
    "split_luck",
    "predictions",
    "out_of_domain",
    "hyperparameters",
    "time_variance",
    "scores",
    "pit",
    "differences",
]


rule hold_out_yields:
    input:
        train=rules.split_screening.output.train,
        test=rules.split_screening.output.test,
    output:
        predictions=f"{YIELDS}/held_out/{{model}}_{{strategy}}.tsv",
        intervals=f"{YIELDS}/held_out/{{model}}_{{strategy}}_intervals.tsv",
    log:
        f"{LOGS}/yields/hold_out_{{model}}_{{strategy}}.log",
    benchmark:
        f"{BENCHMARKS}/hold_out_yields/{{model}}/{{strategy}}.tsv"
    wildcard_constraints:
        model=f"{ANY_REGRESSOR}|{AVERAGED}|{CLIMATOLOGY}",
        strategy=ANY_STRATEGY,
    params:
        training=yield_settings("training"),
        honest=CONFIG.yields.honest.part(HeldOutConfig),
        averaging=yield_settings("averaging"),
        library=library("hold_out_yields.py"),
    message:
        "Predicting every run with {wildcards.model} {wildcards.strategy} models that were not trained on it"
    script:
        "../../scripts/hold_out_yields.py"


rule evaluate_yield_models:
    input:
        train=rules.split_screening.output.train,
        test=rules.split_screening.output.test,
        models=every_model(rules.train_yield_model.output.model, MODELS),
        averaged=f"{YIELDS}/models/averaged_gpr_primary.json",
        held_out=every_model(rules.hold_out_yields.output.predictions, COMPARED_MODELS),
        intervals=every_model(rules.hold_out_yields.output.intervals, COMPARED_MODELS),
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
        library=library("evaluate_yield_models.py"),
    message:
        "Evaluating the yield models on the locked split, on held-out runs and outside their domain"
    script:
        "../../scripts/evaluate_yield_models.py"


rule compare_yield_choices:
    input:
        train=rules.split_screening.output.train,
        test=rules.split_screening.output.test,
        models=every_model(rules.train_yield_model.output.model, MODELS),
        otherwise=[
            rules.train_yield_model_otherwise.output.model.format(model=model, strategy=strategy, choice=choice)
            for model, strategy, choice in SEARCHED_AGAIN
        ],
        outside=CONFIG.yields.out_of_domain,
    output:
        choices=f"{YIELDS}/choices.tsv",
    log:
        f"{LOGS}/yields/compare_yield_choices.log",
    benchmark:
        f"{BENCHMARKS}/compare_yield_choices/compare_yield_choices.tsv"
    params:
        training=yield_settings("training"),
        searched_again=SEARCHED_AGAIN,
        library=library("compare_yield_choices.py"),
    message:
        "Comparing models with other values of the choices that the thesis leaves open"
    script:
        "../../scripts/compare_yield_choices.py"


rule try_yield_models:
    input:
        rules.split_screening.output.train,
        rules.split_screening.output.test,
    output:
        tried=f"{YIELDS}/tried.tsv",
    log:
        f"{LOGS}/yields/try_yield_models.log",
    benchmark:
        f"{BENCHMARKS}/try_yield_models/try_yield_models.tsv"
    params:
        training=yield_settings("training"),
        averaging=yield_settings("averaging"),
        library=library("try_yield_models.py"),
    message:
        "Cross-validating the alternative yield models, leaving one run out"
    script:
        "../../scripts/try_yield_models.py"


rule leave_regimes_out:
    input:
        train=rules.split_screening.output.train,
        test=rules.split_screening.output.test,
        sources=MILLS[CONFIG.mill].source_files,
        regimes=CONFIG.data.regimes,
    output:
        regimes=f"{YIELDS}/regimes.tsv",
        summary=f"{YIELDS}/regimes_summary.tsv",
    log:
        f"{LOGS}/yields/leave_regimes_out.log",
    benchmark:
        f"{BENCHMARKS}/leave_regimes_out/leave_regimes_out.tsv"
    params:
        machine=YIELD_MACHINE,
        mill=dumped(MILLS[CONFIG.mill]),
        training=yield_settings("training"),
        honest=CONFIG.yields.honest.part(HeldOutConfig),
        averaging=yield_settings("averaging"),
        interval_level=CONFIG.yields.interval_level,
        library=library("leave_regimes_out.py"),
    message:
        "Predicting the fill ratios of {input.regimes}, without and with cases of them in the training rows"
    script:
        "../../scripts/leave_regimes_out.py"


rule explain_yield_models:
    input:
        train=rules.split_screening.output.train,
        test=rules.split_screening.output.test,
        models=every_model(rules.train_yield_model.output.model, EXPLAINED),
    output:
        values=f"{YIELDS}/shap.tsv",
        ranking=f"{YIELDS}/shap_ranking.tsv",
    log:
        f"{LOGS}/yields/explain_yield_models.log",
    benchmark:
        f"{BENCHMARKS}/explain_yield_models/explain_yield_models.tsv"
    params:
        library=library("explain_yield_models.py"),
    message:
        "Calculating SHAP values of the two-step tree models"
    script:
        "../../scripts/explain_yield_models.py"
