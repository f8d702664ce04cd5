"""Intervals by contact parameters for the chapters: their fingerprint, and the thesis's values that come from the DEM."""


# The fingerprint of chapter 3 is from more simulations than the mill's own sweep; the factors hold for both.
rule add_uncertainty_to_chapters:
    input:
        # Figures decide nothing, nor do the tables beside them.
        chapters=[
            *(path for path in FINGERPRINT_OUTPUTS if path.endswith((".tsv", ".json")) and "/figures/" not in path),
            f"{RESULTS}/partition/table_4_2.tsv",
        ],
        fingerprint=f"{FINGERPRINT}/fingerprint_{CONFIG.mills.contact_set}.json",
        contact=rules.measure_uncertainty.output.contact.format(mill=CONFIG.mill),
        shape=shape_of(CONFIG.mill),
        claims=CONFIG.data.claims,
    output:
        fingerprint=f"{UNCERTAINTY}/fingerprint_{{contact}}.json".format(
            mill=CONFIG.mill, contact=CONFIG.mills.contact_set
        ),
        thesis=f"{UNCERTAINTY}/thesis.tsv".format(mill=CONFIG.mill),
    log:
        f"{LOGS}/uncertainty/add_to_chapters.log",
    localrule: True
    params:
        results=lambda wildcards, output: str(Path(output.thesis).parents[2]),
        cycle_fill_ratio=CONFIG.fingerprint.cycle_fill_ratio,
    message:
        "Adding the intervals by contact parameters to the curves of chapter 3 and to printed values"
    script:
        "../../scripts/add_uncertainty_to_chapters.py"


UNCERTAINTY_THESIS_OUTPUTS = (
    [*rules.add_uncertainty_to_chapters.output] if CONFIG.mill in CONFIG.uncertainty.mills else []
)
