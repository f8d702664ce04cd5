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
        library=library("split_screening.py"),
    message:
        "Splitting the screening runs according to {input.split}"
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
        model=ANY_REGRESSOR,
        strategy=ANY_STRATEGY,
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
        model=ANY_REGRESSOR,
        strategy=ANY_STRATEGY,
        choice=f"{SEARCH_SEED}|{RESIDUAL_WEIGHTS}",
    params:
        training=lambda wildcards: otherwise(CONFIG.yields.training, wildcards.choice).model_dump(mode="json"),
        search=yield_settings("search"),
        library=library("train_yield_model.py"),
    message:
        "Training {wildcards.model} {wildcards.strategy} with another choice of {wildcards.choice}"


rule collect_final_rows:
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
    log:
        f"{LOGS}/yields/collect_final_rows.log",
    localrule: True
    params:
        machine=YIELD_MACHINE,
        mill=dumped(MILLS[CONFIG.mill]),
        volume_m3=MILLS[CONFIG.mill].volume_ml * 1e-6,
        settings=CONFIG.yields.proposals.model_dump(mode="json", include={"regimes", "experiments", "region"}),
        library=library("collect_final_rows.py"),
    message:
        "Collecting every run that the final yield model is trained on, and the curves of the mill"
    script:
        "../../scripts/collect_final_rows.py"


rule train_averaged_model:
    input:
        lambda wildcards: (
            rules.collect_final_rows.output.rows if wildcards.rows == "final" else rules.split_screening.output.train
        ),
    output:
        model=f"{YIELDS}/models/averaged_gpr_{{rows}}.json",
        members=f"{YIELDS}/averaging_{{rows}}.tsv",
    log:
        f"{LOGS}/yields/train_averaged_model_{{rows}}.log",
    benchmark:
        f"{BENCHMARKS}/train_averaged_model/{{rows}}.tsv"
    wildcard_constraints:
        rows="primary|final",
    params:
        settings=yield_settings("averaging"),
        library=library("train_averaged_model.py"),
    message:
        "Fitting the averaged Gaussian process ({wildcards.rows}: primary on the training rows, final on all runs)"
    script:
        "../../scripts/train_averaged_model.py"
