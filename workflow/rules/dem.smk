"""Simulations: compile the kernels once, run every case of the sweeps."""


rule compile_kernels:
    output:
        report=f"{RESULTS}/dem/kernels.json",
    log:
        f"{LOGS}/dem/compile_kernels.log",
    conda:
        "../../envs/millprint.yaml"
    threads: 1
    params:
        library=library("compile_kernels.py"),
    message:
        "Compiling the DEM kernels"
    script:
        "../../scripts/compile_kernels.py"


rule run_dem_case:
    input:
        kernels=ancient(f"{RESULTS}/dem/kernels.json"),
        meshes=lambda wildcards: MILLS[wildcards.mill].mesh_files,
    output:
        run=f"{RESULTS}/dem/{{mill}}/{{contact}}/{{case}}/run.h5",
        summary=f"{RESULTS}/dem/{{mill}}/{{contact}}/{{case}}/summary.json",
    log:
        f"{LOGS}/dem/{{mill}}/{{contact}}/{{case}}.log",
    benchmark:
        f"{BENCHMARKS}/dem/{{mill}}/{{contact}}/{{case}}.tsv"
    conda:
        "../../envs/millprint.yaml"
    threads: 1
    params:
        case=lambda wildcards: CASES[f"{wildcards.mill}/{wildcards.contact}/{wildcards.case}"].model_dump(mode="json"),
        mill=lambda wildcards: MILLS[wildcards.mill].model_dump(mode="json"),
        contact=lambda wildcards: CONTACTS[wildcards.contact].model_dump(mode="json"),
        settings=settings("dem"),
        library=library("run_dem_case.py"),
    message:
        "DEM {wildcards.mill}/{wildcards.contact}/{wildcards.case}"
    script:
        "../../scripts/run_dem_case.py"
