"""Training of the yield models: the locked split, the models of the thesis, and the averaged model."""

QUICK_MODELS = [(name, strategy) for name, strategy in MODELS if name in QUICK]
QUICK_OTHERWISE = [(name, strategy, choice) for name, strategy, choice in SEARCHED_AGAIN if name in QUICK]


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
        models=expand(YIELD_MODEL, strategy=STRATEGIES, allow_missing=True),
    log:
        f"{LOGS}/yields/train_{{model}}.log",
    benchmark:
        f"{BENCHMARKS}/train_yield_model/{{model}}.tsv"
    wildcard_constraints:
        model=TRAINED_ALONE,
    params:
        trained=lambda wildcards: [(wildcards.model, strategy, yield_settings("training")) for strategy in STRATEGIES],
        search=yield_settings("search"),
    message:
        "Tuning and fitting both yield models {wildcards.model} on the training rows"
    script:
        "../../scripts/train_yield_model.py"


use rule train_yield_model as train_yield_model_otherwise with:
    output:
        models=expand(
            OTHER_MODEL,
            zip,
            strategy=[strategy for strategy, _ in TRAINED_OTHERWISE],
            choice=[choice for _, choice in TRAINED_OTHERWISE],
            allow_missing=True,
        ),
    log:
        f"{LOGS}/yields/train_{{model}}_otherwise.log",
    benchmark:
        f"{BENCHMARKS}/train_yield_model_otherwise/{{model}}.tsv"
    params:
        trained=lambda wildcards: [(wildcards.model, *trained_otherwise(*each)) for each in TRAINED_OTHERWISE],
        search=yield_settings("search"),
    message:
        "Training {wildcards.model} with other values of the choices that the thesis leaves open"


# Those that take less time than the start of a job each.
use rule train_yield_model as train_quick_models with:
    output:
        models=[
            *every_model(YIELD_MODEL, QUICK_MODELS),
            *(
                OTHER_MODEL.format(model=model, strategy=strategy, choice=choice)
                for model, strategy, choice in QUICK_OTHERWISE
            ),
        ],
    log:
        f"{LOGS}/yields/train_quick.log",
    benchmark:
        f"{BENCHMARKS}/train_yield_model/quick.tsv"
    params:
        trained=[
            *((*model, yield_settings("training")) for model in QUICK_MODELS),
            *((model, *trained_otherwise(*each)) for model, *each in QUICK_OTHERWISE),
        ],
        search=yield_settings("search"),
    message:
        "Tuning and fitting the yield models of {QUICK} on the training rows"


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
