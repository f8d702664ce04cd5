"""Simulations: compile the kernels once, run every case that is asked for."""


# First of all: half of the other jobs wait for it. Once only: what a later edit of the library changes, the simulations
# that it reruns compile themselves. Made again, it would hide them from Snakemake 9, which plans nothing behind an
# ancient input that another job makes (its issue 4166).
rule compile_kernels:
    output:
        report=f"{RESULTS}/dem/kernels.json",
    log:
        f"{LOGS}/dem/compile_kernels.log",
    benchmark:
        f"{BENCHMARKS}/compile_kernels/compile_kernels.tsv"
    priority: 1
    message:
        "Compiling the DEM kernels"
    script:
        "../../scripts/compile_kernels.py"


rule run_dem_case:
    input:
        kernels=ancient(f"{RESULTS}/dem/kernels.json"),
        sources=lambda wildcards: mill_named(wildcards.mill).source_files,
    output:
        run=f"{CASE}/run.h5",
        summary=f"{CASE}/summary.json",
    log:
        f"{LOGS}/dem/{{mill}}/{{contact}}/{{case}}.log",
    benchmark:
        f"{BENCHMARKS}/run_dem_case/{{mill}}/{{contact}}/{{case}}.tsv"
    wildcard_constraints:
        case=none_of(LONG_CASES),
    threads: lambda wildcards: resources_at(wildcards).threads
    # Another attempt goes on where the last one was ended, so it has more time in all.
    resources:
        runtime=lambda wildcards, attempt: attempt * resources_at(wildcards).runtime_min,
        mem_mb=lambda wildcards, attempt: attempt * resources_at(wildcards).memory_mb,
    params:
        case=lambda wildcards: case_at(wildcards).model_dump(mode="json"),
        mill=lambda wildcards: dumped(mill_named(wildcards.mill)),
        contact=lambda wildcards: CONTACTS[wildcards.contact].model_dump(mode="json"),
        settings=settings("dem"),
        library=library("run_dem_case.py"),
    message:
        "DEM {wildcards.mill}/{wildcards.contact}/{wildcards.case}"
    script:
        "../../scripts/run_dem_case.py"


# The same in a cluster job of its own: a profile puts short simulations several to a job, by the name of their rule.
use rule run_dem_case as run_long_dem_case with:
    benchmark:
        f"{BENCHMARKS}/run_long_dem_case/{{mill}}/{{contact}}/{{case}}.tsv"
    wildcard_constraints:
        case=any_of(LONG_CASES),
