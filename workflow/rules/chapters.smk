"""The thesis: a target for each chapter, the list of all their files, and the pages of the report."""

from millprint.run.outputs import listed_tables


include: "doe.smk"
include: "calibration.smk"
include: "fingerprint.smk"
include: "partition.smk"
include: "yields.smk"
include: "surrogate.smk"


STAGE_OUTPUTS = [
    *DOE_OUTPUTS,
    *CONVERGENCE_OUTPUTS,
    *VIEW_OUTPUTS,
    *CALIBRATION_OUTPUTS,
    *FINGERPRINT_OUTPUTS,
    *FIT_OUTPUTS,
    *rules.partition_dissipation.output,
    *YIELD_OUTPUTS,
    *DOSE_OUTPUTS,
    *SURROGATE_OUTPUTS,
    *UNCERTAINTY_OUTPUTS,
    *UNCERTAINTY_THESIS_OUTPUTS,
    *HEAT_OUTPUTS,
    # Nine more trainings, each as long as that of the variant `thesis`.
    *(rules.ablations.output if "ablations" in CONFIG.also else []),
    # A smoke test runs every mill of the box once; the thesis does not use them.
    *(BOX_OUTPUTS if CONFIG.mills.first_case_only else []),
    *(VALIDATION_OUTPUTS if "validation" in CONFIG.also else []),
]


rule chapter2:
    """Chapter 2: the design of the screening runs and its analysis."""
    input:
        DOE_OUTPUTS,


rule chapter3:
    """Chapter 3: calibration, simulations and master curves."""
    input:
        CALIBRATION_OUTPUTS,
        FINGERPRINT_OUTPUTS,
        FIT_OUTPUTS,
        CONVERGENCE_OUTPUTS,
        VIEW_OUTPUTS,


rule chapter4:
    """Chapter 4: shares of shear and compression."""
    input:
        rules.partition_dissipation.output,


rule chapter5:
    """Chapter 5: yield models and the next experiments."""
    input:
        YIELD_OUTPUTS,


rule chapter6:
    """Chapter 6: the surrogates of the DEM."""
    input:
        SURROGATE_OUTPUTS,


STAGE_FILES = {str(output) for output in STAGE_OUTPUTS}
# By chapter, without tables that this run does not make, such as that of the time step if no sweep varies it.
SHOWN_TABLES = {
    chapter: paths
    for chapter, tables in listed_tables().items()
    # The page of the validation has a rule of its own, since a run without chapters can make it too.
    if chapter.isdigit()
    and (paths := [path for listed in tables if (path := f"{RESULTS}/{listed.path}") in STAGE_FILES])
}


rule draw_claims:
    input:
        **EQUAL_JARS,
        stages=STAGE_OUTPUTS,
        claims=CONFIG.data.claims,
        summaries=rules.fit_master_curves.input.summaries,
        of_modulus=summaries_over("young_moduli_gpa"),
        runs=records_of([*rules.fit_master_curves.input.summaries, *summaries_over("young_moduli_gpa")]),
    output:
        intervals=f"{RESULTS}/report/intervals.tsv",
        by_jar=f"{RESULTS}/report/claims_by_jar.tsv",
    log:
        f"{LOGS}/report/draw_claims.log",
    benchmark:
        f"{BENCHMARKS}/draw_claims/draw_claims.tsv"
    params:
        results=lambda wildcards, output: str(Path(output.intervals).parents[1]),
        settings=settings("claims"),
        rules=rules_named(),
        trainings=TRAININGS,
        contact=CONFIG.fit.search.contact if CONFIG.fit else "",
        tables={
            "mill": CONFIG.mill,
            "contacts": CONFIG.contacts,
            "counting_rule": CONFIG.fingerprint.counting_rule,
            "further_rules": CONFIG.convergence.counting_rules,
        },
    message:
        "Drawing simulations again, for the intervals of the claims"
    script:
        "../../scripts/draw_claims.py"


rule write_pages:
    input:
        stages=STAGE_OUTPUTS,
        claims=CONFIG.data.claims,
        intervals=rules.draw_claims.output.intervals,
        by_jar=rules.draw_claims.output.by_jar,
        verdicts=SOURCES.find(CONFIG.data.verdicts),
        conclusions=SOURCES.find(CONFIG.data.conclusions),
        tables=[path for paths in SHOWN_TABLES.values() for path in paths],
    output:
        summary=shown(f"{RESULTS}/report/summary.html"),
        page=shown(f"{RESULTS}/report/claims.html"),
        claims=f"{RESULTS}/report/claims.tsv",
        conclusions=f"{RESULTS}/report/conclusions.tsv",
        # What the first page of report.html includes.
        front=f"{RESULTS}/report/conclusions.rst",
        counts=f"{RESULTS}/report/claims_by_chapter.tsv",
        natures=f"{RESULTS}/report/claims_by_nature.tsv",
        errata=f"{RESULTS}/report/errata.tsv",
        elsewhere=f"{RESULTS}/report/verdicts_elsewhere.tsv",
        pages=[shown(f"{RESULTS}/report/tables_{chapter}.html") for chapter in SHOWN_TABLES],
        html=shown(f"{RESULTS}/report/runtimes.html"),
        runtimes=f"{RESULTS}/report/runtimes.tsv",
    log:
        f"{LOGS}/report/write_pages.log",
    localrule: True
    params:
        name=CONFIG.name,
        results=lambda wildcards, output: str(Path(output.claims).parents[1]),
        chapters=list(SHOWN_TABLES),
        benchmarks=BENCHMARKS,
        logs=LOGS,
    message:
        "Comparing every claim of the thesis with the computed value; writing the tables and run times as pages"
    script:
        "../../scripts/write_pages.py"


rule build_explorer:
    input:
        own_fingerprints=[predicting_chapter(contact) for contact in CONFIG.contacts],
        yield_model=f"{RESULTS}/yield/models/averaged_gpr_final.json",
        own_spectra=rules.tabulate_spectra.output.spectra,
        own_summaries=rules.tabulate_spectra.output.summary,
        own_temperatures=rules.balance_heat.output.temperatures.format(mill=CONFIG.mill),
        own_limits=rules.balance_heat.output.limits.format(mill=CONFIG.mill),
        sources=shape_files(CONFIG.mill),
    output:
        html=shown(f"{RESULTS}/report/explorer.html"),
    log:
        f"{LOGS}/report/build_explorer.log",
    localrule: True
    params:
        about=EXPLORED_WITH,
        chapters={
            "rule": CONFIG.fingerprint.counting_rule,
            "mill": dumped(MILLS[CONFIG.mill]),
            "request": settings("fingerprint.inverse"),
            "prediction": settings("yields.prediction"),
            "level": CONFIG.yields.interval_level,
        },
    message:
        "Building the explorer, a page that needs no server"
    script:
        "../../scripts/build_explorer.py"


REPORT_PAGES = [*rules.write_pages.output, rules.build_explorer.output.html]
