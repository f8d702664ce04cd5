"""The gallery of a run, and its record as a Workflow Run RO-Crate: results/ro-crate-metadata.json."""

from os.path import relpath

from millprint.config.load import CONTACT_FOLDER, MILL_FOLDER


rule gallery:
    """A page with every figure of the run."""
    input:
        RUN_OUTPUTS,
    output:
        html=shown(f"{RESULTS}/report/gallery.html"),
    log:
        f"{LOGS}/report/gallery.log",
    localrule: True
    params:
        figures=lambda wildcards, input, output: reported_figures(input, Path(output.html).parents[1]),
        results=lambda wildcards, output: str(Path(output.html).parents[1]),
    message:
        "Collecting every figure with its caption, its tables, and how it was made"
    script:
        "../../scripts/record_run.py"


# The main one first. As seen from here: a run that is moved with its project stays the same run.
SNAKEFILES = [
    relpath(file)
    for file in dict.fromkeys(
        [
            shipped("workflow/Snakefile"),
            *(str(each.snakefile) for each in workflow.rules if each.name not in RULES_OF_OTHERS),
        ]
    )
]


rule record_run:
    output:
        run=f"{RESULTS}/report/run.yaml",
    log:
        f"{LOGS}/report/record_run.log",
    localrule: True
    params:
        config=config,
    message:
        "Recording the configuration of the run and the versions of its packages"
    script:
        "../../scripts/record_run.py"


rule write_crate:
    input:
        targets=[*RUN_OUTPUTS, *rules.gallery.output],
        configuration=rules.record_run.output.run,
    output:
        crate=shown(f"{RESULTS}/ro-crate-metadata.json"),
        sources=directory(f"{RESULTS}/crate"),
    log:
        f"{LOGS}/report/write_crate.log",
    localrule: True
    params:
        results=lambda wildcards, output: str(Path(output.crate).parent),
        sources=[
            *map(relpath, CONFIG_FILES),
            *(relpath(SOURCES.find(f"{MILL_FOLDER}/{name}.yaml")) for name in CHECKED_MILLS),
            *(relpath(SOURCES.find(f"{CONTACT_FOLDER}/{name}.yaml")) for name in CONTACTS),
        ],
        snakefiles=SNAKEFILES,
    message:
        "Describing the run, its inputs and all of its files in an RO-Crate"
    script:
        "../../scripts/record_run.py"


rule crate:
    """The record of the run, an RO-Crate."""
    input:
        rules.write_crate.output,
