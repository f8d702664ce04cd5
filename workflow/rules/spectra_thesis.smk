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
        rules=SPECTRA_RULES,
        settings=CONFIG.dose.spectra.model_dump(mode="json"),
        library=library("tabulate_spectra.py"),
    message:
        "Tabulating the energy spectra of {CONFIG.contacts}"
    script:
        "../../scripts/tabulate_spectra.py"


rule plot_spectra:
    input:
        spectra=rules.tabulate_spectra.output.spectra,
    output:
        svgs=[
            report(
                f"{DOSE}/spectra_{contact}.svg",
                caption="../report/spectra.rst",
                category="Chapter 3",
                labels={"figure": "energy spectra", "shows": f"energies of single collisions, {contact}"},
            )
            for contact in CONFIG.contacts
        ],
        pngs=expand(f"{DOSE}/spectra_{{contact}}.png", contact=CONFIG.contacts),
    log:
        f"{LOGS}/dose/plot_spectra.log",
    localrule: True
    params:
        titles=[f"{MILLS[CONFIG.mill].title}, contact set {contact}" for contact in CONFIG.contacts],
        rule=CONFIG.fingerprint.counting_rule,
        chosen=CONFIG.fingerprint.maps.model_dump(mode="json"),
        library=library("plot_spectra.py"),
    message:
        "Drawing the energy spectra of {CONFIG.contacts}"
    script:
        "../../scripts/plot_spectra.py"


SPECTRA_OUTPUTS = [*rules.tabulate_spectra.output, *rules.plot_spectra.output]
