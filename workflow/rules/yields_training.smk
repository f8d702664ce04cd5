"""Training of the yield models: the locked split, the models of the thesis, and the averaged model."""


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
        other_sources=yield_settings("other_sources") if OTHER_SOURCES.in_training else {},
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
        search=yield_settings("search"),
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
        sources=MILLS[CONFIG.mill].source_files,
        regimes=CONFIG.data.regimes,
    output:
        rows=f"{YIELDS}/final_rows.tsv",
        mill=f"{YIELDS}/models/mill.json",
        models=expand(f"{YIELDS}/models/averaged_gpr_{{rows}}.json", rows=["primary", "final"]),
        members=expand(f"{YIELDS}/averaging_{{rows}}.tsv", rows=["primary", "final"]),
    log:
        f"{LOGS}/yields/train_averaged_models.log",
    benchmark:
        f"{BENCHMARKS}/train_averaged_models/train_averaged_models.tsv"
    params:
        machine=YIELD_MACHINE,
        mill=dumped(MILLS[CONFIG.mill]),
        volume_m3=MILLS[CONFIG.mill].volume_ml * 1e-6,
        proposals=CONFIG.yields.proposals.model_dump(mode="json", include={"regimes", "experiments", "region"}),
        averaging=yield_settings("averaging"),
    message:
        "Fitting the averaged Gaussian process on the training rows, and on every run"
    script:
        "../../scripts/train_averaged_models.py"
