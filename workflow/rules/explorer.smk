"""The explorer of any mill, and of all mills of the box: fingerprints, spectra and temperatures on one page."""


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
    message:
        "Building the explorer of {BOX}, a page that needs no server"


rule explorer:
    input:
        rules.explore_mill.output.html.format(mill=CONFIG.mill),
    localrule: True
    message:
        "The explorer is complete"
