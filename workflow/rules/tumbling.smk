"""Tumbling mills of the validation: their simulations, one after another in a process, and pictures of the charge."""


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
    params:
        settings=lambda wildcards: setup_inputs(wildcards.setup)["settings"],
        mill=lambda wildcards: setup_inputs(wildcards.setup)["mill"],
        contacts=lambda wildcards: setup_inputs(wildcards.setup)["contacts"],
        dem=settings("dem"),
        library=library("simulate_tumbling.py"),
    message:
        "Simulating tumbling mill {wildcards.setup} at every speed"
    script:
        "../../scripts/simulate_tumbling.py"


rule plot_charge:
    input:
        runs=rules.simulate_tumbling.output.runs,
        charge=rules.simulate_tumbling.output.charge,
    output:
        svg=report(
            f"{RESULTS}/validation/{{setup}}/charge.svg",
            caption="../report/validation_charge.rst",
            category="Validation",
            labels={"figure": "{setup}", "shows": "the charge at several speeds, with toe and shoulder"},
        ),
        png=f"{RESULTS}/validation/{{setup}}/charge.png",
        intervals=f"{RESULTS}/validation/{{setup}}/intervals.tsv",
    log:
        f"{LOGS}/validation/plot_charge_{{setup}}.log",
    wildcard_constraints:
        setup=any_of(CONFIG.validation.tumbling),
    localrule: True
    params:
        settings=lambda wildcards: setup_inputs(wildcards.setup)["settings"],
        mill=lambda wildcards: setup_inputs(wildcards.setup)["mill"],
        library=library("plot_charge.py"),
    message:
        "Drawing the charge of {wildcards.setup}"
    script:
        "../../scripts/plot_charge.py"
