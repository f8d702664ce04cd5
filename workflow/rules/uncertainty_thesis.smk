"""The thesis's values that come from the DEM, next to ours and their intervals by contact parameters alone."""

UNCERTAINTY_THESIS_OUTPUTS = []

if CONFIG.mill in CONFIG.uncertainty.mills:

    rule tabulate_contact_intervals:
        input:
            # Figures decide nothing, nor do the tables beside them.
            chapters=[
                *(
                    path
                    for path in FINGERPRINT_OUTPUTS
                    if path.endswith((".tsv", ".json")) and "/figures/" not in path
                ),
                f"{RESULTS}/partition/table_4_2.tsv",
            ],
            fingerprint=f"{FINGERPRINT}/fingerprint_{CONFIG.mills.contact_set}.json",
            contact=rules.measure_uncertainty.output.contact.format(mill=CONFIG.mill),
            claims=CONFIG.data.claims,
        output:
            thesis=f"{UNCERTAINTY}/thesis.tsv".format(mill=CONFIG.mill),
        log:
            f"{LOGS}/uncertainty/tabulate_contact_intervals.log",
        localrule: True
        params:
            results=lambda wildcards, output: str(Path(output.thesis).parents[2]),
            cycle_fill_ratio=CONFIG.fingerprint.cycle_fill_ratio,
            library=library("tabulate_contact_intervals.py"),
        message:
            "Comparing printed values with the intervals by contact parameters"
        script:
            "../../scripts/tabulate_contact_intervals.py"

    UNCERTAINTY_THESIS_OUTPUTS += rules.tabulate_contact_intervals.output
