"""The explorer of any mill, and of all mills of the box: fingerprints, spectra and temperatures on one page."""

EXPLORED_WITH = {
    "name": CONFIG.name,
    "spectra": CONFIG.dose.spectra.model_dump(mode="json"),
    "rule": CONFIG.fingerprint.counting_rule,
    "heat": CONFIG.dose.heat.model_dump(mode="json"),
}
# What a page takes from each mill, by the names of `millprint.explorer.simulated`.
OF_MILL = {
    "spectra": rules.tabulate_mill_spectra.output.spectra,
    "summary": rules.tabulate_mill_spectra.output.summary,
    "temperatures": rules.balance_heat.output.temperatures,
    "limits": rules.balance_heat.output.limits,
}


def explored(names) -> dict[str, list[str]]:
    """The files that the page of some mills is made from, in the order of the mills."""
    files = {key: [path.format(mill=name) for name in names] for key, path in OF_MILL.items()}
    return {"fingerprint": [predicting(name) for name in names], **files}


rule explore_mill:
    input:
        unpack(lambda wildcards: explored([wildcards.mill])),
        sources=lambda wildcards: mill_named(wildcards.mill).source_files,
    output:
        html=report(
            f"{MILL}/explorer.html",
            caption="../report/mill_explorer.rst",
            category="Mills",
            labels={"mill": "{mill}", "figure": "explorer"},
        ),
    log:
        f"{LOGS}/mills/{{mill}}_explorer.log",
    localrule: True
    params:
        mills=lambda wildcards: [dumped(mill_named(wildcards.mill))],
        about=EXPLORED_WITH,
        library=library("explore_mills.py"),
    message:
        "Building the explorer of mill {wildcards.mill}, a page that needs no server"
    script:
        "../../scripts/explore_mills.py"


use rule explore_mill as explore_mills with:
    input:
        **explored(BOX),
        sources=[path for name in BOX for path in mill_named(name).source_files],
    output:
        html=report(
            f"{RESULTS}/mills/explorer.html",
            caption="../report/mills_explorer.rst",
            category="Mills",
            labels={"mill": "all", "figure": "explorer"},
        ),
    log:
        f"{LOGS}/mills/explorer.log",
    params:
        mills=[dumped(mill_named(name)) for name in BOX],
        about=EXPLORED_WITH,
        library=library("explore_mills.py"),
    message:
        "Building the explorer of {BOX}, a page that needs no server"


rule explorer:
    input:
        rules.explore_mill.output.html.format(mill=CONFIG.mill),
    localrule: True
