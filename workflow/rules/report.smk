"""Pages of the report: claims, sortable tables, runtimes and the explorer."""

from millprint.thesis.report.catalogue import TABLES

STAGE_FILES = {str(output) for output in STAGE_OUTPUTS}
# By chapter, without tables that this run does not make, such as that of the time step if no sweep varies it.
SHOWN_TABLES = {
    chapter: paths
    for chapter, tables in TABLES.items()
    # The page of the validation has a rule of its own, since a run without chapters can make it too.
    if chapter.isdigit()
    and (paths := [path for listed in tables if (path := f"{RESULTS}/{listed.path}") in STAGE_FILES])
}


rule draw_claims:
    input:
        stages=STAGE_OUTPUTS,
        claims=CONFIG.data.claims,
        summaries=rules.tabulate_descriptors.input.summaries,
        of_modulus=summaries_over("young_moduli_gpa"),
    output:
        intervals=f"{RESULTS}/report/intervals.tsv",
    log:
        f"{LOGS}/report/draw_claims.log",
    benchmark:
        f"{BENCHMARKS}/draw_claims/draw_claims.tsv"
    params:
        results=lambda wildcards, output: str(Path(output.intervals).parents[1]),
        settings=settings("claims"),
        trainings=TRAININGS,
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


rule tabulate_claims:
    input:
        stages=STAGE_OUTPUTS,
        claims=CONFIG.data.claims,
        intervals=rules.draw_claims.output.intervals,
        verdicts=CONFIG.data.verdicts,
        conclusions=CONFIG.data.conclusions,
    output:
        summary=shown(
            f"{RESULTS}/report/summary.html", "summary", "Claims", {"shows": "which conclusions stand, errata"}
        ),
        page=shown(f"{RESULTS}/report/claims.html", "claims", "Claims", {"shows": "every claim, to sort and filter"}),
        svg=shown(
            f"{RESULTS}/report/claims_by_chapter.svg",
            "claims_by_chapter",
            "Claims",
            {"shows": "verdicts by chapter (figure)"},
        ),
        claims=f"{RESULTS}/report/claims.tsv",
        conclusions=f"{RESULTS}/report/conclusions.tsv",
        # What the first page of report.html includes.
        front=f"{RESULTS}/report/conclusions.rst",
        counts=f"{RESULTS}/report/claims_by_chapter.tsv",
        natures=f"{RESULTS}/report/claims_by_nature.tsv",
        errata=f"{RESULTS}/report/errata.tsv",
        elsewhere=f"{RESULTS}/report/verdicts_elsewhere.tsv",
        png=f"{RESULTS}/report/claims_by_chapter.png",
    log:
        f"{LOGS}/report/tabulate_claims.log",
    localrule: True
    params:
        name=CONFIG.name,
        results=lambda wildcards, output: str(Path(output.claims).parents[1]),
    message:
        "Comparing every claim of the thesis with the computed value"
    script:
        "../../scripts/tabulate_claims.py"


rule tabulate_pages:
    input:
        stages=STAGE_OUTPUTS,
        tables=[path for paths in SHOWN_TABLES.values() for path in paths],
    output:
        pages=[
            shown(
                f"{RESULTS}/report/tables_{chapter}.html",
                "tables",
                f"Chapter {chapter}",
                {"figure": "tables", "shows": f"tables of chapter {chapter}, to sort and filter"},
            )
            for chapter in SHOWN_TABLES
        ],
        html=shown(
            f"{RESULTS}/report/runtimes.html",
            "runtimes",
            "Runtime and versions",
            {"shows": "every job's time, versions, commit"},
        ),
        runtimes=f"{RESULTS}/report/runtimes.tsv",
    log:
        f"{LOGS}/report/tabulate_pages.log",
    localrule: True
    params:
        chapters=list(SHOWN_TABLES),
        name=CONFIG.name,
        results=lambda wildcards, output: str(Path(output.html).parents[1]),
        benchmarks=BENCHMARKS,
        logs=LOGS,
    message:
        "Writing a page of tables for each chapter, and adding up the run times of all jobs"
    script:
        "../../scripts/tabulate_pages.py"


rule build_explorer:
    input:
        **{f"other_{key}": paths for key, paths in explored(CONFIG.mills.explored).items()},
        fingerprints=[predicting_chapter(contact) for contact in CONFIG.contacts],
        yield_model=f"{RESULTS}/yield/models/averaged_gpr_final.json",
        spectra=rules.tabulate_spectra.output.spectra,
        summaries=rules.tabulate_spectra.output.summary,
        temperatures=rules.balance_heat.output.temperatures.format(mill=CONFIG.mill),
        limits=rules.balance_heat.output.limits.format(mill=CONFIG.mill),
        sources=MILLS[CONFIG.mill].source_files,
    output:
        html=shown(
            f"{RESULTS}/report/explorer.html",
            "explorer",
            "Explorer",
            {"shows": "sliders: descriptors, power, yield; nearest conditions"},
        ),
    log:
        f"{LOGS}/report/build_explorer.log",
    localrule: True
    params:
        about={
            **EXPLORED_WITH,
            "own_rule": CONFIG.fingerprint.counting_rule,
            "mill": dumped(MILLS[CONFIG.mill]),
            "request": CONFIG.fingerprint.inverse.model_dump(mode="json"),
            "prediction": CONFIG.yields.prediction.model_dump(mode="json"),
            "level": CONFIG.yields.interval_level,
        },
        others=[dumped(mill_named(name)) for name in CONFIG.mills.explored],
    message:
        "Building the explorer, a page that needs no server"
    script:
        "../../scripts/build_explorer.py"


REPORT_PAGES = [
    *rules.tabulate_claims.output,
    *rules.tabulate_pages.output,
    rules.build_explorer.output.html,
]
