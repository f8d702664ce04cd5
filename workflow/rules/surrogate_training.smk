"""Surrogates: training data and training.

The longest chain of jobs goes through them, so their jobs have priority.
"""


rule build_surrogate_dataset:
    input:
        runs=[simulated(case) for case in CONFIG.surrogate.snapshots.cases],
    output:
        dataset=f"{SURROGATE}/dataset.h5",
        wall_contacts=f"{SURROGATE}/wall_contacts.tsv",
    log:
        f"{LOGS}/surrogate/build_surrogate_dataset.log",
    benchmark:
        f"{BENCHMARKS}/build_surrogate_dataset/build_surrogate_dataset.tsv"
    priority: 1
    params:
        settings=CONFIG.surrogate.snapshots.model_dump(mode="json"),
    message:
        "Calculating features, targets and contacts of every training snapshot"
    script:
        "../../scripts/build_surrogate_dataset.py"


rule train_surrogate:
    input:
        dataset=rules.build_surrogate_dataset.output.dataset,
    output:
        weights=f"{SURROGATE}/{{variant}}/weights.pt",
        history=f"{SURROGATE}/{{variant}}/loss.tsv",
    log:
        f"{LOGS}/surrogate/{{variant}}/train_surrogate.log",
    benchmark:
        f"{BENCHMARKS}/train_surrogate/{{variant}}.tsv"
    priority: 1
    threads: lambda wildcards: CONFIG.surrogate.variant(wildcards.variant).training.threads
    resources:
        runtime=lambda wildcards: training_minutes(wildcards.variant),
    params:
        recipe=lambda wildcards: CONFIG.surrogate.variant(wildcards.variant).recipe().model_dump(mode="json"),
    message:
        "Training the surrogate {wildcards.variant}"
    script:
        "../../scripts/train_surrogate.py"
