"""Fingerprints with the intervals by contact parameters, and by the shape of a fitted jar."""


rule add_uncertainty:
    input:
        fingerprint=rules.describe_mill.output.fingerprint,
        contact=f"{INTERVALS}/contact.json",
        shape=shape_of,
        collapse=rules.describe_mill.output.collapse,
        zones=rules.describe_mill.output.zones,
        descriptors=rules.describe_mill.output.descriptors,
        curves=rules.describe_mill.output.curves,
        spectra_summary=rules.describe_mill.output.spectra_summary,
    output:
        fingerprint=f"{INTERVALS}/fingerprint.json",
        sheet=f"{INTERVALS}/fingerprint.tsv",
        curves=f"{INTERVALS}/curves.tsv",
    log:
        f"{LOGS}/uncertainty/{{mill}}_add.log",
    localrule: True
    params:
        mill=lambda wildcards: dumped(mill_named(wildcards.mill)),
        library=library("add_uncertainty.py"),
    message:
        "Adding the intervals by contact parameters to the fingerprint of mill {wildcards.mill}, and tabulating it"
    script:
        "../../scripts/add_uncertainty.py"


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
        mill=None,
        library=library("add_uncertainty.py"),
    message:
        "Adding the intervals by contact parameters to the curves of contact set {wildcards.contact}"
    script:
        "../../scripts/add_uncertainty.py"
