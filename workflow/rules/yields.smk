"""Chapter 5: yield models on milling conditions and mechanical descriptors."""

from millprint.predict.catalogue import EVERY_MODEL, MODELS, otherwise, searched_again

YIELDS = f"{RESULTS}/yield"
YIELD_FIGURES = f"{YIELDS}/figures"
# The machine of the chapter 4 cases, whose descriptors follow from their master curves.
YIELD_CONTACT = CONTACTS[CONFIG.partition.contact]
YIELD_MACHINE = {
    "reference_speed": CONFIG.partition.reference_speed_rpm / 60,
    "density": YIELD_CONTACT.density_kg_m3,
    "amplitude": MILLS[CONFIG.mill].motion.amplitude_mm * 1e-3,
    "diameter": CONFIG.partition.ball_diameter_mm * 1e-3,
}
YIELD_TABLES = [
    "locked",
    "honest",
    "coverage",
    "split_luck",
    "predictions",
    "out_of_domain",
    "hyperparameters",
    "time_variance",
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
        f"{BENCHMARKS}/train_yield_model/{{model}}/{{strategy}}.tsv"
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


use rule train_yield_model as train_yield_model_otherwise with:
    output:
        model=f"{YIELDS}/models/otherwise/{{model}}_{{strategy}}_{{choice}}.json",
    log:
        f"{LOGS}/yields/train_{{model}}_{{strategy}}_{{choice}}.log",
    benchmark:
        f"{BENCHMARKS}/train_yield_model_otherwise/{{model}}/{{strategy}}_{{choice}}.tsv"
    wildcard_constraints:
        model="linear|gpr|rf|svr|xgb",
        strategy="primary|two_step",
        choice="search_seed|residual_weights",
    params:
        training=lambda wildcards: otherwise(CONFIG.yields.training, wildcards.choice).model_dump(mode="json"),
        search=yield_settings("search"),
        library=library("train_yield_model.py"),
    message:
        "Training {wildcards.model} {wildcards.strategy} with another choice of {wildcards.choice}"


rule compare_yield_choices:
    input:
        train=rules.split_screening.output.train,
        test=rules.split_screening.output.test,
        models=every_model(rules.train_yield_model.output.model, MODELS),
        otherwise=[
            rules.train_yield_model_otherwise.output.model.format(model=model, strategy=strategy, choice=choice)
            for model, strategy, choice in searched_again(CONFIG.yields.searched_again)
        ],
        outside=CONFIG.yields.out_of_domain,
    output:
        choices=f"{YIELDS}/choices.tsv",
    log:
        f"{LOGS}/yields/compare_yield_choices.log",
    benchmark:
        f"{BENCHMARKS}/compare_yield_choices/compare_yield_choices.tsv"
    conda:
        "../../envs/millprint.yaml"
    threads: 1
    params:
        training=yield_settings("training"),
        searched_again=CONFIG.yields.searched_again,
        library=library("compare_yield_choices.py"),
    message:
        "Comparing what the thesis leaves open"
    script:
        "../../scripts/compare_yield_choices.py"


rule train_averaged_model:
    input:
        lambda wildcards: [
            rules.split_screening.output.train,
            *([rules.split_screening.output.test] if wildcards.rows == "final" else []),
        ],
    output:
        model=f"{YIELDS}/models/averaged_gpr_{{rows}}.json",
        members=f"{YIELDS}/averaging_{{rows}}.tsv",
    log:
        f"{LOGS}/yields/train_averaged_model_{{rows}}.log",
    benchmark:
        f"{BENCHMARKS}/train_averaged_model/{{rows}}.tsv"
    wildcard_constraints:
        rows="primary|final",
    conda:
        "../../envs/millprint.yaml"
    threads: 1
    params:
        settings=yield_settings("averaging"),
        library=library("train_averaged_model.py"),
    message:
        "Fitting the averaged Gaussian process ({wildcards.rows}: primary on the training rows, final on all runs)"
    script:
        "../../scripts/train_averaged_model.py"


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
        model="linear|gpr|rf|svr|xgb|averaged_gpr",
        strategy="primary|two_step",
    conda:
        "../../envs/millprint.yaml"
    threads: 1
    params:
        training=yield_settings("training"),
        honest=yield_settings("honest"),
        averaging=yield_settings("averaging"),
        library=library("hold_out_yields.py"),
    message:
        "Predicting every run by {wildcards.model} {wildcards.strategy} models that have not seen it"
    script:
        "../../scripts/hold_out_yields.py"


rule evaluate_yield_models:
    input:
        train=rules.split_screening.output.train,
        test=rules.split_screening.output.test,
        models=every_model(rules.train_yield_model.output.model, MODELS),
        averaged=f"{YIELDS}/models/averaged_gpr_primary.json",
        held_out=every_model(rules.hold_out_yields.output.predictions, EVERY_MODEL),
        intervals=every_model(rules.hold_out_yields.output.intervals, EVERY_MODEL),
        outside=CONFIG.yields.out_of_domain,
    output:
        **{name: f"{YIELDS}/{name}.tsv" for name in YIELD_TABLES},
    log:
        f"{LOGS}/yields/evaluate_yield_models.log",
    benchmark:
        f"{BENCHMARKS}/evaluate_yield_models/evaluate_yield_models.tsv"
    conda:
        "../../envs/millprint.yaml"
    threads: 1
    params:
        settings=settings("yields"),
        library=library("evaluate_yield_models.py"),
    message:
        "Judging the yield models on the locked split, on held-out runs and outside their domain"
    script:
        "../../scripts/evaluate_yield_models.py"


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
    conda:
        "../../envs/millprint.yaml"
    threads: 1
    params:
        training=yield_settings("training"),
        averaging=yield_settings("averaging"),
        library=library("try_yield_models.py"),
    message:
        "Leave-one-out of everything that was tried for a better yield model"
    script:
        "../../scripts/try_yield_models.py"


rule leave_regimes_out:
    input:
        train=rules.split_screening.output.train,
        test=rules.split_screening.output.test,
        regimes=CONFIG.data.regimes,
    output:
        regimes=f"{YIELDS}/regimes.tsv",
        summary=f"{YIELDS}/regimes_summary.tsv",
    log:
        f"{LOGS}/yields/leave_regimes_out.log",
    benchmark:
        f"{BENCHMARKS}/leave_regimes_out/leave_regimes_out.tsv"
    conda:
        "../../envs/millprint.yaml"
    threads: 1
    params:
        machine=YIELD_MACHINE,
        settings=settings("yields"),
        library=library("leave_regimes_out.py"),
    message:
        "Predicting the fill ratios of {input.regimes} before and after cases of them are added"
    script:
        "../../scripts/leave_regimes_out.py"


rule propose_experiments:
    input:
        **(
            {"curves": f"{RESULTS}/fingerprint/smooth_{CONFIG.partition.contact}.tsv"}
            if CONFIG.yields.proposals.curves == "fingerprint"
            else {}
        ),
        train=rules.split_screening.output.train,
        test=rules.split_screening.output.test,
        regimes=CONFIG.data.regimes,
    output:
        proposals=f"{YIELDS}/next_experiments.tsv",
    log:
        f"{LOGS}/yields/propose_experiments.log",
    benchmark:
        f"{BENCHMARKS}/propose_experiments/propose_experiments.tsv"
    conda:
        "../../envs/millprint.yaml"
    threads: 1
    params:
        machine=YIELD_MACHINE,
        volume_m3=MILLS[CONFIG.mill].volume_ml * 1e-6,
        settings=settings("yields"),
        library=library("propose_experiments.py"),
    message:
        "Proposing the next experiments within the region that can be reached"
    script:
        "../../scripts/propose_experiments.py"


rule search_retrospectively:
    input:
        train=rules.split_screening.output.train,
        test=rules.split_screening.output.test,
    output:
        retrospective=f"{YIELDS}/retrospective.tsv",
        summary=f"{YIELDS}/retrospective_summary.tsv",
    log:
        f"{LOGS}/yields/search_retrospectively.log",
    benchmark:
        f"{BENCHMARKS}/search_retrospectively/search_retrospectively.tsv"
    conda:
        "../../envs/millprint.yaml"
    threads: 1
    params:
        settings=settings("yields"),
        library=library("search_retrospectively.py"),
    message:
        "Counting the runs to the best of those that were done"
    script:
        "../../scripts/search_retrospectively.py"


rule predict_yields:
    input:
        model=f"{YIELDS}/models/{CONFIG.yields.prediction.model}.json",
        conditions=CONFIG.yields.prediction.conditions,
    output:
        predicted=f"{YIELDS}/predicted_conditions.tsv",
    log:
        f"{LOGS}/yields/predict_yields.log",
    benchmark:
        f"{BENCHMARKS}/predict_yields/predict_yields.tsv"
    conda:
        "../../envs/millprint.yaml"
    threads: 1
    params:
        settings=settings("yields"),
        library=library("predict_yields.py"),
    message:
        "Predicting the yields of {input.conditions}"
    script:
        "../../scripts/predict_yields.py"


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
    benchmark:
        f"{BENCHMARKS}/explain_yield_models/explain_yield_models.tsv"
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
        shap=rules.explain_yield_models.output.values,
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
    log:
        f"{LOGS}/yields/plot_yield_models.log",
    localrule: True
    conda:
        "../../envs/millprint.yaml"
    params:
        library=library("plot_yield_models.py"),
    message:
        "Drawing predictions, intervals and SHAP values of the yield models"
    script:
        "../../scripts/plot_yield_models.py"


rule plot_yield_trust:
    input:
        honest=rules.evaluate_yield_models.output.honest,
        coverage=rules.evaluate_yield_models.output.coverage,
        retrospective=rules.search_retrospectively.output.retrospective,
        proposals=rules.propose_experiments.output.proposals,
        regimes=rules.leave_regimes_out.output.summary,
        claims=CONFIG.data.claims,
    output:
        evaluation_svg=report(
            f"{YIELD_FIGURES}/evaluation.svg",
            caption="../report/yield_evaluation.rst",
            category="Chapter 5",
            labels={"figure": "Table 5.6", "shows": "locked split against honest schemes"},
        ),
        evaluation_png=f"{YIELD_FIGURES}/evaluation.png",
        coverage_svg=report(
            f"{YIELD_FIGURES}/coverage.svg",
            caption="../report/yield_coverage.rst",
            category="Chapter 5",
            labels={"figure": "coverage", "shows": "predictive intervals of left-out runs"},
        ),
        coverage_png=f"{YIELD_FIGURES}/coverage.png",
        retrospective_svg=report(
            f"{YIELD_FIGURES}/retrospective.svg",
            caption="../report/yield_retrospective.rst",
            category="Chapter 5",
            labels={"figure": "retrospective", "shows": "runs to the best run"},
        ),
        retrospective_png=f"{YIELD_FIGURES}/retrospective.png",
        proposals_svg=report(
            f"{YIELD_FIGURES}/proposals.svg",
            caption="../report/yield_proposals.rst",
            category="Chapter 5",
            labels={"figure": "next experiments", "shows": "what to run next"},
        ),
        proposals_png=f"{YIELD_FIGURES}/proposals.png",
        regimes_svg=report(
            f"{YIELD_FIGURES}/regimes.svg",
            caption="../report/yield_regimes.rst",
            category="Chapter 5",
            labels={"figure": "regimes", "shows": "error at unseen fill ratios"},
        ),
        regimes_png=f"{YIELD_FIGURES}/regimes.png",
    log:
        f"{LOGS}/yields/plot_yield_trust.log",
    localrule: True
    conda:
        "../../envs/millprint.yaml"
    params:
        library=library("plot_yield_trust.py"),
    message:
        "Drawing the honest evaluation, coverage, regimes and the next experiments"
    script:
        "../../scripts/plot_yield_trust.py"


YIELD_OUTPUTS = [
    *rules.evaluate_yield_models.output,
    rules.compare_yield_choices.output.choices,
    rules.try_yield_models.output.tried,
    *rules.leave_regimes_out.output,
    rules.propose_experiments.output.proposals,
    *rules.search_retrospectively.output,
    rules.predict_yields.output.predicted,
    *rules.explain_yield_models.output,
    *rules.plot_yield_models.output,
    *rules.plot_yield_trust.output,
]
