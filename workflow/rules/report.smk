"""The table of claims, and one HTML file that opens offline."""


rule record_run:
    output:
        run=f"{RESULTS}/report/run.yaml",
    log:
        f"{LOGS}/report/record_run.log",
    localrule: True
    conda:
        "../../envs/millprint.yaml"
    params:
        config=config,
        library=library("record_run.py"),
    message:
        "Recording the configuration of the run and the versions of its packages"
    script:
        "../../scripts/record_run.py"


rule tabulate_claims:
    input:
        stages=STAGE_OUTPUTS,
        claims=CONFIG.data.claims,
    output:
        claims=report(
            f"{RESULTS}/report/claims.tsv",
            caption="../report/claims.rst",
            category="Claims",
            labels={"table": "every claim of the thesis"},
        ),
        summary=report(
            f"{RESULTS}/report/claims_by_chapter.tsv",
            caption="../report/claims.rst",
            category="Claims",
            labels={"table": "verdicts by chapter"},
        ),
        svg=report(
            f"{RESULTS}/report/claims_by_chapter.svg",
            caption="../report/claims.rst",
            category="Claims",
            labels={"figure": "verdicts by chapter"},
        ),
        png=f"{RESULTS}/report/claims_by_chapter.png",
    log:
        f"{LOGS}/report/tabulate_claims.log",
    localrule: True
    conda:
        "../../envs/millprint.yaml"
    params:
        results=lambda wildcards, output: str(Path(output.claims).parents[1]),
        library=library("tabulate_claims.py"),
    message:
        "Holding every claim of the thesis against what was computed"
    script:
        "../../scripts/tabulate_claims.py"


# Snakemake writes its report only after a run, so this last job calls it on all that the run has made.
rule build_report:
    input:
        stages=STAGE_OUTPUTS,
        claims=rules.tabulate_claims.output.claims,
        run=rules.record_run.output.run,
    output:
        html=f"{RESULTS}/report/report.html",
    log:
        f"{LOGS}/report/build_report.log",
    localrule: True
    conda:
        "../../envs/millprint.yaml"
    params:
        snakefile=workflow.main_snakefile,
    message:
        "Building the report, which opens offline"
    shell:
        "snakemake --snakefile {params.snakefile:q} --configfile {input.run:q} --nolock --cores 1"
        " --report {output.html:q} {input.claims:q} > {log:q} 2>&1"
