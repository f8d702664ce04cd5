"""Chapter 5: yield models on milling conditions and mechanical descriptors."""

from millprint.predict.catalogue import MODELS

YIELDS = f"{RESULTS}/yield"
YIELD_FIGURES = f"{YIELDS}/figures"
YIELD_TABLES = [
    "locked",
    "honest",
    "coverage",
    "predictions",
    "out_of_domain",
    "hyperparameters",
    "time_variance",
    "choices",
]


rule split_screening:
    input:
        screening=CONFIG.data.screening,
        split=CONFIG.data.split,
    output:
        train=f"{YIELDS}/train.tsv",
        test=f"{YIELDS}/test.tsv",
    log:
        f"{LOGS}/yields/split_screening.log",
    localrule: True
    conda:
        "../../envs/millprint.yaml"
    params:
        design=settings("doe"),
        library=library("split_screening.py"),
    message:
        "Splitting the screening runs as {input.split} says"
    script:
        "../../scripts/split_screening.py"


rule train_yield_model:
    input:
        train=rules.split_screening.output.train,
    output:
        model=f"{YIELDS}/models/{{model}}_{{strategy}}.json",
    log:
        f"{LOGS}/yields/train_{{model}}_{{strategy}}.log",
    benchmark:
        f"{BENCHMARKS}/yields/train_{{model}}_{{strategy}}.tsv"
    wildcard_constraints:
        model="linear|gpr|rf|svr|xgb",
        strategy="primary|two_step",
    conda:
        "../../envs/millprint.yaml"
    threads: 1
    params:
        training=yield_settings("training"),
        search=yield_settings("search"),
        library=library("train_yield_model.py"),
    message:
        "Tuning and fitting the yield model {wildcards.model} {wildcards.strategy} on the training rows"
    script:
        "../../scripts/train_yield_model.py"


rule leave_one_out:
    input:
        train=rules.split_screening.output.train,
        test=rules.split_screening.output.test,
    output:
        predictions=f"{YIELDS}/leave_one_out/{{model}}_{{strategy}}.tsv",
    log:
        f"{LOGS}/yields/leave_one_out_{{model}}_{{strategy}}.log",
    benchmark:
        f"{BENCHMARKS}/yields/leave_one_out_{{model}}_{{strategy}}.tsv"
    wildcard_constraints:
        model="linear|gpr|rf|svr|xgb",
        strategy="primary|two_step",
    conda:
        "../../envs/millprint.yaml"
    threads: 1
    params:
        training=yield_settings("training"),
        honest=yield_settings("honest"),
        library=library("leave_one_out.py"),
    message:
        "Predicting every run by a {wildcards.model} {wildcards.strategy} model that has not seen it"
    script:
        "../../scripts/leave_one_out.py"


rule evaluate_yield_models:
    input:
        train=rules.split_screening.output.train,
        test=rules.split_screening.output.test,
        models=every_model(rules.train_yield_model.output.model, MODELS),
        held_out=every_model(rules.leave_one_out.output.predictions, MODELS),
        outside=CONFIG.yields.out_of_domain,
    output:
        **{name: f"{YIELDS}/{name}.tsv" for name in YIELD_TABLES},
    log:
        f"{LOGS}/yields/evaluate_yield_models.log",
    conda:
        "../../envs/millprint.yaml"
    threads: 1
    params:
        settings=settings("yields"),
        library=library("evaluate_yield_models.py"),
    message:
        "Judging the yield models on the locked split, by leave-one-out and outside their domain"
    script:
        "../../scripts/evaluate_yield_models.py"


rule explain_yield_models:
    input:
        train=rules.split_screening.output.train,
        test=rules.split_screening.output.test,
        models=every_model(rules.train_yield_model.output.model, [(model, "two_step") for model in ("rf", "xgb")]),
    output:
        values=f"{YIELDS}/shap.tsv",
        ranking=f"{YIELDS}/shap_ranking.tsv",
    log:
        f"{LOGS}/yields/explain_yield_models.log",
    conda:
        "../../envs/millprint.yaml"
    threads: 1
    params:
        library=library("explain_yield_models.py"),
    message:
        "SHAP values of the two-step tree models"
    script:
        "../../scripts/explain_yield_models.py"


rule plot_yield_models:
    input:
        predictions=rules.evaluate_yield_models.output.predictions,
        honest=rules.evaluate_yield_models.output.honest,
        shap=rules.explain_yield_models.output.values,
        claims=CONFIG.data.claims,
    output:
        predictions_svg=report(
            f"{YIELD_FIGURES}/predictions.svg",
            caption="../report/yield_predictions.rst",
            category="Chapter 5",
            labels={"figure": "5.2", "shows": "predictions for the six test rows"},
        ),
        predictions_png=f"{YIELD_FIGURES}/predictions.png",
        intervals_svg=report(
            f"{YIELD_FIGURES}/intervals.svg",
            caption="../report/yield_intervals.rst",
            category="Chapter 5",
            labels={"figure": "5.3", "shows": "predictive intervals of the two-step GPR"},
        ),
        intervals_png=f"{YIELD_FIGURES}/intervals.png",
        shap_svg=report(
            f"{YIELD_FIGURES}/shap.svg",
            caption="../report/yield_shap.rst",
            category="Chapter 5",
            labels={"figure": "5.4", "shows": "SHAP values of the two-step tree models"},
        ),
        shap_png=f"{YIELD_FIGURES}/shap.png",
        evaluation_svg=report(
            f"{YIELD_FIGURES}/evaluation.svg",
            caption="../report/yield_evaluation.rst",
            category="Chapter 5",
            labels={"figure": "Table 5.6", "shows": "locked split against leave-one-out"},
        ),
        evaluation_png=f"{YIELD_FIGURES}/evaluation.png",
    log:
        f"{LOGS}/yields/plot_yield_models.log",
    localrule: True
    conda:
        "../../envs/millprint.yaml"
    params:
        library=library("plot_yield_models.py"),
    message:
        "Drawing predictions, intervals, SHAP values and the evaluation of the yield models"
    script:
        "../../scripts/plot_yield_models.py"


YIELD_OUTPUTS = [
    *rules.evaluate_yield_models.output,
    *rules.explain_yield_models.output,
    *rules.plot_yield_models.output,
]
