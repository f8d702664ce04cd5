"""For the gallery: which figures the report of Snakemake shows, with their captions."""


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
