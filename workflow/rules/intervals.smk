"""Fingerprints with the intervals by contact parameters, and by the shape of a fitted jar; their sheets."""

from millprint.fit import FEWEST_JARS, fitted_mill

INTERVALS = f"{RESULTS}/uncertainty/{{mill}}"
FIT_SEARCH = f"{RESULTS}/fingerprint/fit_search.tsv"


def shape_of(wildcards) -> list[str]:
    """The file of a fitted jar's shape, if the target `fit` has run: nothing else waits for its search."""
    fitted = fitted_mill(CONFIG, MILLS) if CHAPTERS else None
    if fitted is None or fitted.name != wildcards.mill or CONFIG.fit.screening.jars < FEWEST_JARS:
        return []
    return [f"{RESULTS}/uncertainty/{fitted.name}/shape.json"] if Path(FIT_SEARCH).exists() else []


rule add_uncertainty:
    input:
        fingerprint=rules.describe_mill.output.fingerprint,
        contact=f"{INTERVALS}/contact.json",
        shape=shape_of,
    output:
        fingerprint=f"{INTERVALS}/fingerprint.json",
    log:
        f"{LOGS}/uncertainty/{{mill}}_add.log",
    localrule: True
    params:
        library=library("add_uncertainty.py"),
    message:
        "Adding the intervals by contact parameters to the fingerprint of mill {wildcards.mill}"
    script:
        "../../scripts/add_uncertainty.py"


rule tabulate_uncertainty:
    input:
        fingerprint=rules.add_uncertainty.output.fingerprint,
        collapse=rules.describe_mill.output.collapse,
        zones=rules.describe_mill.output.zones,
        descriptors=rules.describe_mill.output.descriptors,
        curves=rules.describe_mill.output.curves,
    output:
        sheet=f"{INTERVALS}/fingerprint.tsv",
        curves=f"{INTERVALS}/curves.tsv",
    log:
        f"{LOGS}/uncertainty/{{mill}}_tabulate.log",
    localrule: True
    params:
        mill=lambda wildcards: dumped(mill_named(wildcards.mill)),
        library=library("tabulate_uncertainty.py"),
    message:
        "Tabulating the fingerprint of mill {wildcards.mill} with every interval"
    script:
        "../../scripts/tabulate_uncertainty.py"


rule draw_uncertain_sheet:
    input:
        sources=lambda wildcards: mill_named(wildcards.mill).source_files,
        sheet=rules.tabulate_uncertainty.output.sheet,
        descriptors=rules.describe_mill.output.descriptors,
        curves=rules.tabulate_uncertainty.output.curves,
    output:
        svg=report(
            f"{INTERVALS}/fingerprint.svg",
            caption="../report/uncertain_fingerprint.rst",
            category="Mills",
            labels={"mill": "{mill}", "figure": "fingerprint with every interval"},
        ),
        png=f"{INTERVALS}/fingerprint.png",
        pdf=f"{INTERVALS}/fingerprint.pdf",
    log:
        f"{LOGS}/uncertainty/{{mill}}_sheet.log",
    localrule: True
    params:
        mill=lambda wildcards: dumped(mill_named(wildcards.mill)),
        library=library("draw_sheet.py"),
    message:
        "Drawing the fingerprint of mill {wildcards.mill} with every interval on one page"
    script:
        "../../scripts/draw_sheet.py"


# The fingerprints of chapter 3 are from more simulations than the mill's own sweep; the factors hold for both.
rule add_uncertainty_to_chapter:
    input:
        fingerprint=f"{RESULTS}/fingerprint/fingerprint_{{contact}}.json",
        contact=f"{INTERVALS}/contact.json",
        shape=shape_of,
    output:
        fingerprint=f"{INTERVALS}/fingerprint_{{contact}}.json",
    log:
        f"{LOGS}/uncertainty/{{mill}}_add_{{contact}}.log",
    localrule: True
    params:
        library=library("add_uncertainty.py"),
    message:
        "Adding the intervals by contact parameters to the curves of contact set {wildcards.contact}"
    script:
        "../../scripts/add_uncertainty.py"


def predicting_chapter(contact: str) -> str:
    """The fingerprint of chapter 3 of a contact set: with all its intervals if the whole run has their analysis."""
    analysed = CONFIG.mill in CONFIG.uncertainty.mills and contact == CONFIG.mills.contact_set
    folder = f"{RESULTS}/uncertainty/{CONFIG.mill}" if analysed else f"{RESULTS}/fingerprint"
    return f"{folder}/fingerprint_{contact}.json"


def intervals_of(mills) -> list[str]:
    """The fingerprints with intervals of some mills, and their sheets."""
    files = [*rules.add_uncertainty.output, *rules.tabulate_uncertainty.output, *rules.draw_uncertain_sheet.output]
    own = [f"{RESULTS}/uncertainty/{CONFIG.mill}/fingerprint_{CONFIG.mills.contact_set}.json"]
    # The curves of chapter 3 are those of the run's mill.
    return [*expand(files, mill=mills), *(own if CHAPTERS and CONFIG.mill in mills else [])]
