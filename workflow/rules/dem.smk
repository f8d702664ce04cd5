"""Simulations: compile the kernels once, run every case of the sweeps."""

from millprint.config.sweep import threads_of


# First of all: half of the other jobs wait for it.
rule compile_kernels:
    output:
        report=f"{RESULTS}/dem/kernels.json",
    log:
        f"{LOGS}/dem/compile_kernels.log",
    benchmark:
        f"{BENCHMARKS}/compile_kernels/compile_kernels.tsv"
    priority: 1
    conda:
        "../../envs/millprint.yaml"
    threads: 1
    params:
        with_threads=any(threads_of(case, CONFIG.dem) > 1 for case in CASES.values()),
        library=library("compile_kernels.py"),
    message:
        "Compiling the DEM kernels"
    script:
        "../../scripts/compile_kernels.py"


rule run_dem_case:
    input:
        kernels=ancient(f"{RESULTS}/dem/kernels.json"),
        sources=lambda wildcards: MILLS[wildcards.mill].source_files,
    output:
        run=f"{RESULTS}/dem/{{mill}}/{{contact}}/{{case}}/run.h5",
        summary=f"{RESULTS}/dem/{{mill}}/{{contact}}/{{case}}/summary.json",
    log:
        f"{LOGS}/dem/{{mill}}/{{contact}}/{{case}}.log",
    benchmark:
        f"{BENCHMARKS}/run_dem_case/{{mill}}/{{contact}}/{{case}}.tsv"
    retries: RETRIES
    conda:
        "../../envs/millprint.yaml"
    threads: lambda wildcards: threads_of(case_of(wildcards), CONFIG.dem)
    resources:
        runtime=minutes_of,
    params:
        case=lambda wildcards: case_of(wildcards).model_dump(mode="json"),
        mill=lambda wildcards: MILLS[wildcards.mill].model_dump(mode="json"),
        contact=lambda wildcards: CONTACTS[wildcards.contact].model_dump(mode="json"),
        settings=settings("dem"),
        library=library("run_dem_case.py"),
    message:
        "DEM {wildcards.mill}/{wildcards.contact}/{wildcards.case}"
    script:
        "../../scripts/run_dem_case.py"
