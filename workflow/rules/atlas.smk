"""The atlas: what any mill of a kind does, learned from simulations over mills. Target `atlas`, part of no other."""

ATLAS = f"{RESULTS}/atlas"
# Most rows of a job: a simulation takes a second or two, about as long as it takes Snakemake to start a few jobs.
ATLAS_BATCH = 25
ATLAS_ROWS = CONFIG.atlas.batches(ATLAS_BATCH)
# The scaling law, with which the atlas is compared, is that of the included mills, whatever this folder has.
ATLAS_INCLUDED = [
    shipped(path)
    for kind in CONFIG.atlas.kinds
    for path in (f"config/mills/{kind}.yaml", f"config/fingerprints/{kind}.json")
]


# The rows of the included table that were made with the present settings and physics are not simulated again.
rule simulate_atlas:
    input:
        kernels=ancient(f"{RESULTS}/dem/kernels.json"),
        held_out=SOURCES.find("config/atlas/held_out.tsv"),
        included=SOURCES.find("config/atlas/simulations.tsv"),
        atlas=SOURCES.find("config/atlas/model.json"),
    output:
        rows=f"{ATLAS}/rows/{{kind}}_{{part}}_{{batch}}.tsv",
    log:
        f"{LOGS}/atlas/{{kind}}_{{part}}_{{batch}}.log",
    benchmark:
        f"{BENCHMARKS}/simulate_atlas/{{kind}}_{{part}}_{{batch}}.tsv"
    wildcard_constraints:
        kind="[a-z]+",
        part=r"training|asked_\d|held_out",
        batch=r"\d+",
    resources:
        processor_s=2 * ATLAS_BATCH,
    params:
        rows=lambda wildcards: ATLAS_ROWS[wildcards.kind, wildcards.part, int(wildcards.batch)],
    message:
        "Simulating mills of the atlas: {wildcards.kind}, {wildcards.part}, batch {wildcards.batch}"
    script:
        "../../scripts/simulate_atlas.py"


rule tabulate_atlas:
    input:
        rows=[f"{ATLAS}/rows/{kind}_{part}_{batch}.tsv" for kind, part, batch in ATLAS_ROWS],
    output:
        table=f"{ATLAS}/simulations.tsv",
    log:
        f"{LOGS}/atlas/tabulate_atlas.log",
    localrule: True
    message:
        "Tabulating the simulations of the atlas"
    script:
        "../../scripts/tabulate_atlas.py"


rule fit_atlas:
    input:
        simulations=rules.tabulate_atlas.output.table,
        included=ATLAS_INCLUDED,
    output:
        model=f"{ATLAS}/model.json",
        comparison=f"{ATLAS}/comparison.tsv",
        learning=f"{ATLAS}/learning.tsv",
    log:
        f"{LOGS}/atlas/fit_atlas.log",
    benchmark:
        f"{BENCHMARKS}/fit_atlas/fit_atlas.tsv"
    params:
        kinds=list(CONFIG.atlas.kinds),
    message:
        "Fitting the atlas, and comparing it with other models"
    script:
        "../../scripts/fit_atlas.py"


# Held-out mills are asked once the model is chosen.
rule judge_atlas:
    input:
        simulations=rules.tabulate_atlas.output.table,
        model=rules.fit_atlas.output.model,
        included=ATLAS_INCLUDED,
    output:
        errors=f"{ATLAS}/errors.tsv",
        regions=f"{ATLAS}/regions.tsv",
    log:
        f"{LOGS}/atlas/judge_atlas.log",
    localrule: True
    params:
        kinds=list(CONFIG.atlas.kinds),
    message:
        "Asking the atlas for the mills that no model has seen"
    script:
        "../../scripts/judge_atlas.py"


rule atlas:
    """What any mill of a kind does, at once: simulations over mills, the model, and its errors."""
    input:
        rules.fit_atlas.output,
        rules.judge_atlas.output,
