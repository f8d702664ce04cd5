"""The gallery: every figure of the run on one page, with caption, tables and origin."""


rule build_gallery:
    input:
        RUN_OUTPUTS,
    output:
        html=report(
            f"{RESULTS}/report/gallery.html",
            caption="../report/gallery.rst",
            category="Figures and tables",
            labels={"shows": "every figure with its data and origin"},
        ),
    log:
        f"{LOGS}/report/build_gallery.log",
    localrule: True
    params:
        figures=lambda wildcards, input: reported_figures(input),
        results=lambda wildcards, output: str(Path(output.html).parents[1]),
    message:
        "Collecting every figure with its caption, its tables, and how it was made"
    script:
        "../../scripts/build_gallery.py"


rule gallery:
    input:
        rules.build_gallery.output,
    localrule: True
    message:
        "The gallery is complete"
