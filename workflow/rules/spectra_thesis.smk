"""What a chemist reads off the thesis's mill: energy spectra of its sweeps, by contact set."""


rule tabulate_spectra:
    input:
        summaries=[path for contact in CONFIG.contacts for path in swept_summaries(contact)],
        runs=[path for contact in CONFIG.contacts for path in records_of(swept_summaries(contact))],
    output:
        spectra=expand(f"{DOSE}/spectra_{{contact}}.tsv", contact=CONFIG.contacts),
        summary=expand(f"{DOSE}/spectra_summary_{{contact}}.tsv", contact=CONFIG.contacts),
    log:
        f"{LOGS}/dose/tabulate_spectra.log",
    benchmark:
        f"{BENCHMARKS}/tabulate_spectra/tabulate_spectra.tsv"
    params:
        runs={contact: records_of(swept_summaries(contact)) for contact in CONFIG.contacts},
        rules=spectra_rules(CONFIG.fingerprint.counting_rule),
        settings=CONFIG.dose.spectra.model_dump(mode="json"),
    message:
        "Tabulating the energy spectra of {CONFIG.contacts}"
    script:
        "../../scripts/tabulate_spectra.py"
