"""Surrogates: training data and training.

The longest chain of jobs goes through them, so their jobs have priority.
"""

# Settings of the simulations that train the contact surrogate.
TRACES = CONFIG.surrogate.contact.traces
TRACED_MODELS = {
    "mills": {trace.mill: dumped(MILLS[trace.mill]) for trace in TRACES},
    "contacts": {trace.contact: CONTACTS[trace.contact].model_dump(mode="json") for trace in TRACES},
    "dem": settings("dem"),
}


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
        library=library("build_surrogate_dataset.py"),
    message:
        "Calculating features, targets and contacts of every training snapshot"
    script:
        "../../scripts/build_surrogate_dataset.py"


rule trace_surrogate_contacts:
    input:
        kernels=ancient(f"{RESULTS}/dem/kernels.json"),
    output:
        dataset=f"{SURROGATE}/contacts.h5",
    log:
        f"{LOGS}/surrogate/trace_surrogate_contacts.log",
    benchmark:
        f"{BENCHMARKS}/trace_surrogate_contacts/trace_surrogate_contacts.tsv"
    priority: 1
    params:
        # Nothing of the training: other settings of it need no other traces.
        settings=CONFIG.surrogate.contact.model_dump(mode="json", include={"traces", "coarse", "judge"}),
        models=TRACED_MODELS,
        library=library("trace_surrogate_contacts.py"),
    message:
        "Simulating the training data of the contact surrogate, contact by contact"
    script:
        "../../scripts/trace_surrogate_contacts.py"


rule train_contact_surrogate:
    input:
        dataset=rules.trace_surrogate_contacts.output.dataset,
    output:
        weights=[f"{SURROGATE}/{{variant}}/weights.pt"],
        histories=[f"{SURROGATE}/{{variant}}/loss.tsv"],
    log:
        f"{LOGS}/surrogate/{{variant}}/train_surrogate.log",
    benchmark:
        f"{BENCHMARKS}/train_contact_surrogate/{{variant}}.tsv"
    wildcard_constraints:
        variant=any_of(CONFIG.surrogate.of_kind("contact")),
    priority: 1
    threads: CONFIG.surrogate.contact.training.threads
    params:
        kind="contact",
        variants=lambda wildcards: {
            wildcards.variant: {"settings": CONFIG.surrogate.contact.model_dump(mode="json"), "models": TRACED_MODELS}
        },
        library=library("train_surrogate.py"),
    message:
        "Training the ensemble of the surrogate {wildcards.variant}"
    script:
        "../../scripts/train_surrogate.py"


rule train_surrogate:
    input:
        dataset=rules.build_surrogate_dataset.output.dataset,
    output:
        weights=[f"{SURROGATE}/{{variant}}/weights.pt"],
        histories=[f"{SURROGATE}/{{variant}}/loss.tsv"],
    log:
        f"{LOGS}/surrogate/{{variant}}/train_surrogate.log",
    benchmark:
        f"{BENCHMARKS}/train_surrogate/{{variant}}.tsv"
    wildcard_constraints:
        variant=any_of([name for name in CONFIG.surrogate.of_kind("graph") if name not in TRAINED_TOGETHER]),
    priority: 1
    threads: lambda wildcards: CONFIG.surrogate.variant(wildcards.variant).training.threads
    resources:
        runtime=lambda wildcards: training_minutes([wildcards.variant]),
    params:
        kind="graph",
        variants=lambda wildcards: {wildcards.variant: recipe_of(wildcards.variant)},
        library=library("train_surrogate.py"),
    message:
        "Training the surrogate {wildcards.variant}"
    script:
        "../../scripts/train_surrogate.py"


if TRAINED_TOGETHER:

    use rule train_surrogate as train_quick_surrogates with:
        output:
            weights=expand(f"{SURROGATE}/{{variant}}/weights.pt", variant=TRAINED_TOGETHER),
            histories=expand(f"{SURROGATE}/{{variant}}/loss.tsv", variant=TRAINED_TOGETHER),
        log:
            f"{LOGS}/surrogate/train_surrogates.log",
        benchmark:
            f"{BENCHMARKS}/train_surrogate/quick.tsv"
        threads: max(CONFIG.surrogate.variant(each).training.threads for each in TRAINED_TOGETHER)
        resources:
            runtime=training_minutes(TRAINED_TOGETHER),
        params:
            kind="graph",
            variants={each: recipe_of(each) for each in TRAINED_TOGETHER},
            library=library("train_surrogate.py"),
        message:
            "Training {TRAINED_TOGETHER}"
