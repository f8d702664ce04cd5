"""Intervals by contact parameters: simulations with drawn parameters, their analysis, and the fingerprint with them."""

from millprint.thesis.fit import FEWEST_JARS, fitted_mill

UNCERTAINTY = f"{RESULTS}/uncertainty/{{mill}}"


# The contact set of the predictions, then those that are compared with it.
UNCERTAIN_CONTACTS = list(dict.fromkeys([CONFIG.mills.contact_set, *CONFIG.contacts]))


rule sample_contacts:
    input:
        kernels=ancient(f"{RESULTS}/dem/kernels.json"),
        sources=lambda wildcards: shape_files(wildcards.mill),
        sweep=derived_sweep,
    output:
        samples=f"{UNCERTAINTY}/samples/{{number}}.tsv",
    log:
        f"{LOGS}/uncertainty/{{mill}}_sample_{{number}}.log",
    benchmark:
        f"{BENCHMARKS}/sample_contacts/{{mill}}_{{number}}.tsv"
    wildcard_constraints:
        number=r"\d+",
    resources:
        # A mill without a sweep gets one during the run, and is not counted before.
        processor_s=lambda wildcards: TABLE.processor_s(rows_of("SAMPLE", wildcards.mill)),
    params:
        identity=lambda wildcards: identity_inside(
            [mill_named(wildcards.mill)], [CONTACTS[CONFIG.mills.contact_set]], [CONFIG.fingerprint.counting_rule]
        ),
        mill=lambda wildcards, output: dumped(mill_named(wildcards.mill)),
        sweep=own_sweep,
        contact=lambda wildcards, output: CONTACTS[CONFIG.mills.contact_set].model_dump(mode="json"),
        mills=CONFIG.mills.model_dump(mode="json", include={"contact", "settle_s"}),
        dem=lambda wildcards, output: settings("dem"),
        counting_rule=CONFIG.fingerprint.counting_rule,
        # The other keys do not change a simulation.
        settings=CONFIG.uncertainty.model_dump(mode="json", exclude={"mills", "base_samples", "draws"}),
    message:
        "Simulating mill {wildcards.mill} with other contact parameters, job {wildcards.number}"
    script:
        "../../scripts/sample_contacts.py"


rule measure_uncertainty:
    input:
        samples=[f"{UNCERTAINTY}/samples/{number}.tsv" for number in range(CONFIG.uncertainty.jobs)],
        sweep=derived_sweep,
    output:
        samples=f"{UNCERTAINTY}/samples.tsv",
        emulator=f"{UNCERTAINTY}/emulator.tsv",
        indices=f"{UNCERTAINTY}/indices.tsv",
        intervals=f"{UNCERTAINTY}/intervals.tsv",
        sets=f"{UNCERTAINTY}/sets.tsv",
        contact=f"{UNCERTAINTY}/contact.json",
    log:
        f"{LOGS}/uncertainty/{{mill}}_measure.log",
    benchmark:
        f"{BENCHMARKS}/measure_uncertainty/{{mill}}.tsv"
    params:
        mill=lambda wildcards: dumped(mill_named(wildcards.mill)),
        sweep=own_sweep,
        contacts=[CONTACTS[name].model_dump(mode="json") for name in UNCERTAIN_CONTACTS],
        settings=CONFIG.uncertainty.model_dump(mode="json", exclude={"mills"}),
    message:
        "Calculating Sobol indices and intervals of mill {wildcards.mill}"
    script:
        "../../scripts/measure_uncertainty.py"


rule add_uncertainty:
    input:
        sources=lambda wildcards: shape_files(wildcards.mill),
        fingerprint=rules.describe_mill.output.fingerprint,
        contact=rules.measure_uncertainty.output.contact,
        shape=lambda wildcards: shape_of(wildcards.mill),
        collapse=rules.describe_mill.output.collapse,
        zones=rules.describe_mill.output.zones,
        descriptors=rules.describe_mill.output.descriptors,
        curves=rules.describe_mill.output.curves,
        spectra=rules.describe_mill.output.spectra,
        spectra_summary=rules.describe_mill.output.spectra_summary,
        indices=rules.measure_uncertainty.output.indices,
        intervals=rules.measure_uncertainty.output.intervals,
        sets=rules.measure_uncertainty.output.sets,
        limits=rules.balance_heat.output.limits,
    output:
        fingerprint=f"{UNCERTAINTY}/fingerprint.json",
        sheet=f"{UNCERTAINTY}/fingerprint.tsv",
        curves=f"{UNCERTAINTY}/curves.tsv",
        indices_figure=figures(f"{UNCERTAINTY}/indices"),
        intervals_figure=figures(f"{UNCERTAINTY}/intervals"),
        sheet_figure=figures(f"{UNCERTAINTY}/fingerprint"),
        sheet_pdf=f"{UNCERTAINTY}/fingerprint.pdf",
    log:
        f"{LOGS}/uncertainty/{{mill}}_add.log",
    localrule: True
    params:
        mill=lambda wildcards: dumped(mill_named(wildcards.mill)),
    message:
        "Adding the intervals by contact parameters to the fingerprint of mill {wildcards.mill}, and drawing them"
    script:
        "../../scripts/add_uncertainty.py"


# Part of a whole run.
UNCERTAINTY_OUTPUTS = uncertainty_of(CONFIG.uncertainty.mills)


rule uncertainty:
    """What friction, restitution and stiffness that nobody has measured leave open."""
    input:
        uncertainty_of([CONFIG.mill]),
