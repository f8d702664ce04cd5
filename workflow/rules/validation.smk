"""What others measured, predicted without a fit: set-ups, verdicts, and their page of the report."""

from importlib.util import find_spec

VALIDATION = f"{RESULTS}/validation"

# A dry run refuses a table of one's own as the run does; the included one is checked before the first job.
if CONFIG.validation.is_own and workflow.is_main_process and find_spec("pandas"):
    from millprint.validation.measured import check_measured

    with stop_on_bad_input():
        check_measured(CONFIG.validation.measured, SETTINGS)


rule simulate_tumbling:
    input:
        kernels=ancient(f"{RESULTS}/dem/kernels.json"),
        measured=local(CONFIG.validation.measured),
    output:
        runs=f"{VALIDATION}/{{setup}}/runs.tsv",
        charge=f"{VALIDATION}/{{setup}}/charge.tsv",
    log:
        f"{LOGS}/validation/simulate_{{setup}}.log",
    benchmark:
        f"{BENCHMARKS}/simulate_tumbling/{{setup}}.tsv"
    wildcard_constraints:
        setup=any_of(CONFIG.validation.tumbling),
    resources:
        processor_s=lambda wildcards: TABLE.processor_s(rows_of("IN_SET_UP", wildcards.setup)),
    params:
        identity=lambda wildcards: identity_of_setup(wildcards.setup),
        settings=lambda wildcards: setup_inputs(wildcards.setup)["settings"],
        mill=lambda wildcards, output: setup_inputs(wildcards.setup)["mill"],
        contacts=lambda wildcards, output: setup_inputs(wildcards.setup)["contacts"],
        dem=lambda wildcards, output: settings("dem"),
    message:
        "Simulating tumbling mill {wildcards.setup} at every speed"
    script:
        "../../scripts/predict_setup.py"


# Set-ups whose flowing bed is drawn.
BEDS = [name for name in ("bead_drum", "repose_drum") if name in CONFIG.validation.chosen]


use rule simulate_tumbling as predict_setup with:
    input:
        kernels=ancient(f"{RESULTS}/dem/kernels.json"),
        measured=local(CONFIG.validation.measured),
        other_codes=SOURCES.find(CONFIG.validation.other_codes),
        runs=lambda wildcards: setup_runs(wildcards.setup),
        tables=lambda wildcards: own_tables(wildcards.setup),
    output:
        predictions=f"{VALIDATION}/{{setup}}/predictions.tsv",
    log:
        f"{LOGS}/validation/predict_{{setup}}.log",
    benchmark:
        f"{BENCHMARKS}/predict_setup/{{setup}}.tsv"
    wildcard_constraints:
        setup=any_of(SETTINGS),
    resources:
        processor_s=lambda wildcards: (
            0
            if wildcards.setup in CONFIG.validation.tumbling
            else TABLE.processor_s(rows_of("IN_SET_UP", wildcards.setup))
            + round(CONFIG.validation.chosen[wildcards.setup].further_s)
        ),
    params:
        runs=lambda wildcards, output: str(Path(output.predictions).parents[2] / "dem"),
        folder=lambda wildcards, output: str(Path(output.predictions).parent),
    message:
        "Predicting set-up {wildcards.setup}"


# Verdicts and figures both come from the predictions.
rule judge_setups:
    input:
        predictions=expand(rules.predict_setup.output.predictions, setup=CONFIG.validation.chosen),
        runs=expand(rules.simulate_tumbling.output.runs, setup=CONFIG.validation.tumbling),
        charges=expand(rules.simulate_tumbling.output.charge, setup=CONFIG.validation.tumbling),
        beds=[files_of(rows_of("SET_UP", name)[:1], "run.h5") for name in BEDS],
        measured=local(CONFIG.validation.measured),
    output:
        verdicts=f"{VALIDATION}/verdicts.tsv",
        counts=f"{VALIDATION}/counts.tsv",
        coverage=f"{VALIDATION}/coverage.tsv",
        assumptions=f"{VALIDATION}/assumptions.tsv",
        page=shown(f"{VALIDATION}/tables.html"),
        figures=figures(*(f"{VALIDATION}/{name}/predictions" for name in CONFIG.validation.chosen)),
        # Only the first quantity, for a page.
        first=[f"{VALIDATION}/{name}/first.{kind}" for name in CONFIG.validation.chosen for kind in ("svg", "png")],
        charges=figures(*(f"{VALIDATION}/{name}/charge" for name in CONFIG.validation.tumbling)),
        intervals=expand(f"{VALIDATION}/{{setup}}/intervals.tsv", setup=CONFIG.validation.tumbling),
        beds=figures(*(f"{VALIDATION}/{name}/bed" for name in BEDS)),
        bed_tsvs=expand(f"{VALIDATION}/{{setup}}/bed.tsv", setup=BEDS),
    log:
        f"{LOGS}/validation/judge_setups.log",
    localrule: True
    params:
        setups={name: setup_inputs(name) for name in CONFIG.validation.chosen},
        tumbling=CONFIG.validation.tumbling,
        beds={name: bed_sizes(name) for name in BEDS},
        chapter="Validation",
        name=CONFIG.name,
        results=lambda wildcards, output: str(Path(output.page).parents[1]),
    message:
        "Comparing every measured number with its prediction, and drawing both"
    script:
        "../../scripts/judge_setups.py"


VALIDATION_OUTPUTS = [*expand(rules.predict_setup.output, setup=CONFIG.validation.chosen), *rules.judge_setups.output]


rule validation:
    """Machines and impacts that others measured, predicted, with a verdict on each number."""
    input:
        VALIDATION_OUTPUTS,
