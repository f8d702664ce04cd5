"""Simulations by LAMMPS, with `dem.engine: lammps`: a job of several ranks for each case."""

if CONFIG.dem.engine == "lammps":

    ruleorder: run_lammps_case > run_dem_case

else:

    ruleorder: run_dem_case > run_lammps_case


rule run_lammps_case:
    input:
        sources=lambda wildcards: shape_files(wildcards.mill),
    output:
        run=f"{CASE}/run.h5",
        summary=f"{CASE}/summary.json",
    log:
        f"{LOGS}/dem/{{mill}}/{{contact}}/{{case}}.log",
    benchmark:
        f"{BENCHMARKS}/run_lammps_case/{{mill}}/{{contact}}/{{case}}.tsv"
    # On this machine a rank takes a core; a cluster starts `tasks` of one core each.
    threads: CONFIG.dem.lammps.ranks
    # Each attempt continues where the last one ended. `mpi` is the program that starts the ranks, such as srun. Neither
    # it nor `command` nor `tasks` is a parameter: with another number of ranks nothing is simulated again.
    resources:
        mpi="mpirun",
        command=CONFIG.dem.lammps.command,
        tasks=CONFIG.dem.lammps.ranks,
        cpus_per_task=1,
        runtime=lambda wildcards, attempt: lammps_at(wildcards).requested_min(attempt),
        mem_mb=lambda wildcards, attempt: attempt * lammps_at(wildcards).memory_mb,
        processor_s=lambda wildcards: math.ceil(lammps_at(wildcards).processor_s),
        disk_mb=lambda wildcards: likely_mb([case_at(wildcards)]),
    params:
        # Without a record of what it kept: its tolerances are compared.
        identity=lambda wildcards: [identity_at(wildcards), CONFIG.dem.overlap_max, CONFIG.dem.closure_max],
        case=lambda wildcards, output: case_at(wildcards).model_dump(mode="json"),
        mill=lambda wildcards, output: dumped(mill_named(wildcards.mill)),
        contact=lambda wildcards, output: CONTACTS[wildcards.contact].model_dump(mode="json"),
        settings=lambda wildcards, output: CONFIG.dem.model_dump(mode="json", exclude={"lammps"}),
    message:
        "Simulating {wildcards.mill}/{wildcards.contact}/{wildcards.case} by LAMMPS"
    script:
        "../../scripts/run_lammps_case.py"
