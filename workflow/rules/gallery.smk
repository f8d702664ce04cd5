"""The gallery: every figure of the run on one page, with caption, tables and origin."""


def reported_figures(paths) -> list[dict]:
    """Path in the results, category, labels and caption of those paths that the report shows as a picture."""
    flagged = [
        (item, item.flags["report"]) for each in workflow.rules for item in each.output if "report" in item.flags
    ]
    found = []
    for path in dict.fromkeys(str(path) for path in paths):
        if not path.endswith((".svg", ".png")):
            continue
        for item, about in flagged:
            if item.match(path):
                inside = str(Path(path).relative_to(RESULTS))
                with workflow.sourcecache.open(about.caption, "r") as file:
                    caption = file.read()
                listed = {"path": inside, "stage": about.category, "labels": about.labels, "caption": caption}
                found.append(listed)
                break
    return found


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
        library=library("build_gallery.py"),
    message:
        "Collecting every figure with its caption, its tables, and how it was made"
    script:
        "../../scripts/build_gallery.py"


rule gallery:
    input:
        rules.build_gallery.output,
    localrule: True
