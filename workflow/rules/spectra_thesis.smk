"""What a chemist reads off the thesis's mill: energy spectra of its sweeps."""


rule tabulate_spectra:
    input:
        summaries=lambda wildcards: swept_summaries(wildcards.contact),
        runs=lambda wildcards: records_of(swept_summaries(wildcards.contact)),
    output:
        spectra=f"{DOSE}/spectra_{{contact}}.tsv",
        summary=f"{DOSE}/spectra_summary_{{contact}}.tsv",
    log:
        f"{LOGS}/dose/tabulate_spectra_{{contact}}.log",
    benchmark:
        f"{BENCHMARKS}/tabulate_spectra/{{contact}}.tsv"
    params:
        rules=SPECTRA_RULES,
        settings=CONFIG.dose.spectra.model_dump(mode="json"),
        library=library("tabulate_spectra.py"),
    message:
        "Tabulating the energy spectra of contact set {wildcards.contact}"
    script:
        "../../scripts/tabulate_spectra.py"


rule plot_spectra:
    input:
        spectra=rules.tabulate_spectra.output.spectra,
    output:
        svg=report(
            f"{DOSE}/spectra_{{contact}}.svg",
            caption="../report/spectra.rst",
            category="Chapter 3",
            labels={"figure": "energy spectra", "shows": "energies of single collisions, {contact}"},
        ),
        png=f"{DOSE}/spectra_{{contact}}.png",
    log:
        f"{LOGS}/dose/plot_spectra_{{contact}}.log",
    localrule: True
    params:
        title=lambda wildcards: f"{MILLS[CONFIG.mill].title}, contact set {wildcards.contact}",
        rule=CONFIG.fingerprint.counting_rule,
        chosen=CONFIG.fingerprint.maps.model_dump(mode="json"),
        library=library("plot_spectra.py"),
    message:
        "Drawing the energy spectra of contact set {wildcards.contact}"
    script:
        "../../scripts/plot_spectra.py"


SPECTRA_OUTPUTS = [
    *expand(rules.tabulate_spectra.output, contact=CONFIG.contacts),
    *expand(rules.plot_spectra.output, contact=CONFIG.contacts),
]
