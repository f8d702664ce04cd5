"""Tumbling mills of the validation: their simulations, one after another in a process."""


rule simulate_tumbling:
    input:
        kernels=ancient(f"{RESULTS}/dem/kernels.json"),
        measured=CONFIG.validation.measured,
    output:
        runs=f"{RESULTS}/validation/{{setup}}/runs.tsv",
        charge=f"{RESULTS}/validation/{{setup}}/charge.tsv",
    log:
        f"{LOGS}/validation/simulate_{{setup}}.log",
    benchmark:
        f"{BENCHMARKS}/simulate_tumbling/{{setup}}.tsv"
    wildcard_constraints:
        setup=any_of(CONFIG.validation.tumbling),
    resources:
        processor_s=lambda wildcards: likely_s(simulated_inside(wildcards.setup)),
    params:
        settings=lambda wildcards: setup_inputs(wildcards.setup)["settings"],
        mill=lambda wildcards: setup_inputs(wildcards.setup)["mill"],
        contacts=lambda wildcards: setup_inputs(wildcards.setup)["contacts"],
        dem=settings("dem"),
    message:
        "Simulating tumbling mill {wildcards.setup} at every speed"
    script:
        "../../scripts/simulate_tumbling.py"
