"""The explorer of any mill: its fingerprint on a page that needs no server."""


rule explore_mill:
    input:
        fingerprint=lambda wildcards: predicting(wildcards.mill),
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
        about=lambda wildcards: {"name": CONFIG.name, "title": mill_named(wildcards.mill).title},
        library=library("explore_mill.py"),
    message:
        "Building the explorer of mill {wildcards.mill}, a page that needs no server"
    script:
        "../../scripts/explore_mill.py"


rule explorer:
    input:
        rules.explore_mill.output.html.format(mill=CONFIG.mill),
    localrule: True
