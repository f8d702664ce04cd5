"""The next experiments, and predicted yields of new conditions."""


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
        settings=yield_settings("prediction"),
        training=yield_settings("training"),
        conformal_folds=CONFIG.yields.honest.conformal_folds,
        interval_level=CONFIG.yields.interval_level,
        volume_m3=MILLS[CONFIG.mill].volume_ml * 1e-6,
        proposals=yield_settings("proposals"),
        chemistry=CONFIG.doe.chemistry.model_dump(mode="json"),
    message:
        "Predicting the yields of {input.conditions}, and proposing the next experiments within the region"
    script:
        "../../scripts/predict_yields.py"


rule search_retrospectively:
    input:
        train=rules.split_screening.output.train,
        test=rules.split_screening.output.test,
    output:
        retrospective=f"{YIELDS}/retrospective.tsv",
        summary=f"{YIELDS}/retrospective_summary.tsv",
        learning=f"{YIELDS}/retrospective_learning.tsv",
    log:
        f"{LOGS}/yields/search_retrospectively.log",
    benchmark:
        f"{BENCHMARKS}/search_retrospectively/search_retrospectively.tsv"
    params:
        settings=yield_settings("retrospective"),
        averaging=yield_settings("averaging"),
        level=CONFIG.yields.honest.level,
    message:
        "Counting how many runs it would have taken to find the best one"
    script:
        "../../scripts/search_retrospectively.py"
