"""What no training row covers: other regimes, and runs of other groups and mills, predicted by models of the others."""


rule leave_groups_out:
    input:
        **OTHER_FILES,
        screening=CONFIG.data.screening,
        split=CONFIG.data.split,
        train=rules.split_screening.output.train,
        test=rules.split_screening.output.test,
        sources=MILLS[CONFIG.mill].source_files,
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
        other_sources=yield_settings("other_sources"),
        training=yield_settings("training"),
        honest=yield_settings("honest"),
        averaging=yield_settings("averaging"),
        prediction=yield_settings("prediction"),
        interval_level=CONFIG.yields.interval_level,
    message:
        "Predicting every source of yields, and the fill ratios of {input.regimes}, by models trained without them"
    script:
        "../../scripts/leave_groups_out.py"
