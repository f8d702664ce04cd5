"""Simulations: compile the kernels once, then run each case, or the short seeds or conditions of a sweep in a job."""


# It runs first, since half of the other jobs wait for it, and only once. After an edit of the library, each simulation
# that runs again compiles what has changed. If this rule ran again, Snakemake 9 would skip those simulations: it plans
# nothing behind an ancient input that another job makes (Snakemake issue 4166).
rule compile_kernels:
    output:
        report=f"{RESULTS}/dem/kernels.json",
    log:
        f"{LOGS}/dem/compile_kernels.log",
    benchmark:
        f"{BENCHMARKS}/compile_kernels/compile_kernels.tsv"
    priority: 1
    message:
        "Compiling the DEM kernels, once for this machine: a minute or two"
    script:
        "../../scripts/compile_kernels.py"


rule run_dem_case:
    input:
        kernels=ancient(f"{RESULTS}/dem/kernels.json"),
        sources=lambda wildcards: mill_named(wildcards.mill).source_files,
    output:
        run=[f"{CASE}/run.h5"],
        summary=[f"{CASE}/summary.json"],
    log:
        f"{LOGS}/dem/{{mill}}/{{contact}}/{{case}}.log",
    benchmark:
        f"{BENCHMARKS}/run_dem_case/{{mill}}/{{contact}}/{{case}}.tsv"
    wildcard_constraints:
        mill=IN_OWN_JOB,
        case=none_of(LONG_CASES),
    priority: lambda wildcards: urgency([case_at(wildcards)])
    threads: lambda wildcards: resources_at(wildcards).threads
    # Each attempt continues where the last one ended, and gets more time and memory.
    resources:
        runtime=lambda wildcards, attempt: attempt * resources_at(wildcards).runtime_min,
        mem_mb=lambda wildcards, attempt: attempt * resources_at(wildcards).memory_mb,
        processor_s=lambda wildcards: likely_s([case_at(wildcards)]),
        disk_mb=lambda wildcards: likely_mb([case_at(wildcards)]),
    params:
        given=lambda wildcards: simulated_from([case_at(wildcards)]),
        settings=settings("dem"),
        library=library("run_dem_case.py"),
    message:
        "Simulating {wildcards.mill}/{wildcards.contact}/{wildcards.case}"
    script:
        "../../scripts/run_dem_case.py"


# The same rule under another name, so that a cluster profile can group short simulations and leave long ones alone.
use rule run_dem_case as run_long_dem_case with:
    benchmark:
        f"{BENCHMARKS}/run_long_dem_case/{{mill}}/{{contact}}/{{case}}.tsv"
    wildcard_constraints:
        case=any_of(LONG_CASES),


# The seeds of a condition, where they are short. The script leaves those that are finished as they are, so Snakemake must
# not remove them before the job (`update`). Conditions with the same seeds share a rule.
for seeds, conditions in SEED_RULES.items():

    rule:
        name:
            f"run_dem_seeds_{'_'.join(map(str, seeds))}"
        input:
            kernels=ancient(f"{RESULTS}/dem/kernels.json"),
            sources=lambda wildcards: files_of(seeds_of(wildcards)),
        output:
            run=[update(f"{RESULTS}/dem/{{condition}}_s{seed}/run.h5") for seed in seeds],
            summary=[update(f"{RESULTS}/dem/{{condition}}_s{seed}/summary.json") for seed in seeds],
        log:
            f"{LOGS}/dem/{{condition}}_seeds.log",
        benchmark:
            f"{BENCHMARKS}/run_dem_case/{{condition}}.tsv"
        wildcard_constraints:
            condition=conditions,
        priority: lambda wildcards: urgency(seeds_of(wildcards))
        # The groups of a cluster's profile name rules; these have names of their own.
        group:
            "simulations"
        resources:
            runtime=lambda wildcards, attempt: attempt * together(seeds_of(wildcards)).runtime_min,
            mem_mb=lambda wildcards, attempt: attempt * together(seeds_of(wildcards)).memory_mb,
            processor_s=lambda wildcards: likely_s(seeds_of(wildcards)),
            disk_mb=lambda wildcards: likely_mb(seeds_of(wildcards)),
        params:
            given=lambda wildcards: simulated_from(seeds_of(wildcards)),
            settings=settings("dem"),
            library=library("run_dem_case.py"),
        message:
            "Simulating {wildcards.condition}, every seed"
        script:
            "../../scripts/run_dem_case.py"


# Short conditions of a sweep, several in a job; the script is the same.
for number, batch in enumerate(BATCHES, 1):

    rule:
        name:
            f"run_dem_batch_{number}"
        input:
            kernels=ancient(f"{RESULTS}/dem/kernels.json"),
            sources=of_cases(files_of, batch),
        output:
            run=[update(f"{RESULTS}/dem/{case.path}/run.h5") for case in batch],
            summary=[update(f"{RESULTS}/dem/{case.path}/summary.json") for case in batch],
        log:
            f"{LOGS}/dem/{batch[0].path}_and_others.log",
        benchmark:
            f"{BENCHMARKS}/run_dem_case/{batch[0].path}_and_others.tsv"
        priority: urgency(batch)
        # The groups of a cluster's profile name rules; these have names of their own.
        group:
            "simulations"
        resources:
            runtime=lambda wildcards, attempt, batch=batch: attempt * together(batch).runtime_min,
            mem_mb=lambda wildcards, attempt, batch=batch: attempt * together(batch).memory_mb,
            processor_s=likely_s(batch),
            disk_mb=likely_mb(batch),
        params:
            given=of_cases(simulated_from, batch),
            settings=settings("dem"),
            library=library("run_dem_case.py"),
        message:
            f"Simulating {title_of(batch)}"
        script:
            "../../scripts/run_dem_case.py"
