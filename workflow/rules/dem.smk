"""Simulations: compile the kernels once, then each case in a job; files for ParaView, animations."""


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
    # Two processes share the work.
    threads: 2
    message:
        "Compiling the DEM kernels, once for this machine: about half a minute"
    script:
        "../../scripts/compile_kernels.py"


LAMMPS = CONFIG.dem.engine == "lammps"


# Every row of the table with a folder in results/dem. With `dem.engine: lammps`, a job has several ranks.
rule run_dem_case:
    input:
        **({} if LAMMPS else {"kernels": ancient(f"{RESULTS}/dem/kernels.json")}),
        sources=lambda wildcards: shape_files(wildcards.mill),
    output:
        run=f"{CASE}/run.h5",
        summary=f"{CASE}/summary.json",
    log:
        f"{LOGS}/dem/{{mill}}/{{contact}}/{{case}}.log",
    priority: lambda wildcards: int(path_at(wildcards) in SURROGATE_CASES)
    # On a cluster, short cases share a job; `group-components` of the profile sets their number.
    group:
        lambda wildcards: None if LAMMPS or resources_at(wildcards).needs_own_job else "simulations"
    # A rank takes a core of this machine; a cluster starts `tasks` of one core each.
    threads: lambda wildcards: resources_at(wildcards).threads
    # Each attempt continues where the last one ended, and gets more time and memory. `mpi` is the program that starts the
    # ranks, such as srun. Neither it nor `command` nor `tasks` is a parameter: another number of ranks reruns nothing.
    resources:
        **(
            {
                "mpi": "mpirun",
                "command": CONFIG.dem.lammps.command,
                "tasks": CONFIG.dem.lammps.ranks,
                "cpus_per_task": 1,
            }
            if LAMMPS
            else {}
        ),
        runtime=lambda wildcards, attempt: resources_at(wildcards).requested_min(attempt),
        mem_mb=lambda wildcards, attempt: attempt * resources_at(wildcards).memory_mb,
    # Only `identity` is compared: Snakemake leaves functions of the output out. A run of LAMMPS records nothing of what it
    # kept, so that its tolerances are compared. Snakemake's time to plan grows with the number of functions.
    params:
        identity=identity_at,
        tolerances=CONFIG.dem.model_dump(mode="json", include={"overlap_max", "closure_max"}) if LAMMPS else None,
        simulation=lambda wildcards, output: simulation_at(wildcards),
    message:
        "Simulating {wildcards.mill}/{wildcards.contact}/{wildcards.case}"
    script:
        "../../scripts/run_lammps_case.py" if LAMMPS else "../../scripts/run_dem_case.py"


SWEPT = rows_of("SWEEP", *(sweep.name for sweep in CONFIG.sweeps))


rule simulations:
    """The simulations of `sweeps`, by either engine, with a table."""
    input:
        summaries=files_of(SWEPT),
        runs=files_of(SWEPT, "run.h5"),
    output:
        table=f"{RESULTS}/dem/simulations.tsv",
    log:
        f"{LOGS}/dem/simulations.log",
    benchmark:
        f"{BENCHMARKS}/simulations/simulations.tsv"
    message:
        "Tabulating the simulations of the sweeps"
    script:
        "../../scripts/tabulate_simulations.py"


rule export_run:
    input:
        run=f"{CASE}/run.h5",
    output:
        balls=f"{CASE}/run.vtkhdf",
        walls=f"{CASE}/run_walls.vtkhdf",
        contacts=f"{CASE}/run_contacts.vtkhdf",
    log:
        f"{LOGS}/view/{{mill}}/{{contact}}/{{case}}_export.log",
    benchmark:
        f"{BENCHMARKS}/export_run/{{mill}}/{{contact}}/{{case}}.tsv"
    message:
        "Writing {wildcards.mill}/{wildcards.contact}/{wildcards.case} for ParaView"
    script:
        "../../scripts/view_run.py"


use rule export_run as animate_run with:
    output:
        gif=f"{CASE}/mill.gif",
        # Snakemake's report shows a PNG, even an animated one, but offers a GIF only as a download.
        png=shown(f"{CASE}/mill.png"),
    log:
        f"{LOGS}/view/{{mill}}/{{contact}}/{{case}}_animate.log",
    benchmark:
        f"{BENCHMARKS}/animate_run/{{mill}}/{{contact}}/{{case}}.tsv"
    params:
        settings=settings("view"),
    message:
        "Animating {wildcards.mill}/{wildcards.contact}/{wildcards.case}"


VIEW_OUTPUTS = [
    path for row in SWEPT if row.owner == "movie" for file in ("mill.gif", "mill.png") for path in files_of([row], file)
]
