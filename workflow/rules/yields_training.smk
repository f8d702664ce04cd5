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
        models=expand(YIELD_MODEL, strategy=STRATEGIES, allow_missing=True),
    log:
        f"{LOGS}/yields/train_{{model}}.log",
    benchmark:
        f"{BENCHMARKS}/train_yield_model/{{model}}.tsv"
    wildcard_constraints:
        model=OF_TWO_STRATEGIES,
    params:
        trained=[(strategy, yield_settings("training")) for strategy in STRATEGIES],
        search=yield_settings("search"),
        library=library("train_yield_model.py"),
    message:
        "Tuning and fitting both yield models {wildcards.model} on the training rows"
    script:
        "../../scripts/train_yield_model.py"


use rule train_yield_model as train_primary_model with:
    output:
        models=[YIELD_MODEL.replace("{strategy}", PRIMARY)],
    wildcard_constraints:
        model=OF_ONE_STRATEGY,
    params:
        trained=[(PRIMARY, yield_settings("training"))],
        search=yield_settings("search"),
        library=library("train_yield_model.py"),
    message:
        "Tuning and fitting the yield model {wildcards.model} on the training rows"


use rule train_yield_model as train_yield_model_otherwise with:
    output:
        models=[f"{YIELDS}/models/otherwise/{{model}}_{'_'.join(each)}.json" for each in TRAINED_OTHERWISE],
    log:
        f"{LOGS}/yields/train_{{model}}_otherwise.log",
    benchmark:
        f"{BENCHMARKS}/train_yield_model_otherwise/{{model}}.tsv"
    params:
        trained=[
            (strategy, otherwise(CONFIG.yields.training, choice).model_dump(mode="json"))
            for strategy, choice in TRAINED_OTHERWISE
        ],
        search=yield_settings("search"),
        library=library("train_yield_model.py"),
    message:
        "Training {wildcards.model} with other values of the choices that the thesis leaves open"


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
