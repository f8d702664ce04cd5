"""Runs of other groups and mills: each source predicted by models trained on all others."""


rule leave_sources_out:
    input:
        **OTHER_FILES,
        screening=CONFIG.data.screening,
        split=CONFIG.data.split,
    output:
        scores=f"{YIELDS}/sources.tsv",
        predictions=f"{YIELDS}/sources_predictions.tsv",
        runs=f"{YIELDS}/sources_runs.tsv",
    log:
        f"{LOGS}/yields/leave_sources_out.log",
    benchmark:
        f"{BENCHMARKS}/leave_sources_out/leave_sources_out.tsv"
    params:
        factors=FACTORS,
        other_sources=yield_settings("other_sources"),
        training=yield_settings("training"),
        honest=yield_settings("honest"),
        averaging=yield_settings("averaging"),
        prediction=yield_settings("prediction"),
        interval_level=CONFIG.yields.interval_level,
        library=library("leave_sources_out.py"),
    message:
        "Predicting every source of yields by models trained on the others"
    script:
        "../../scripts/leave_sources_out.py"
