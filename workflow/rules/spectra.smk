"""What a chemist reads off any mill: energy spectra of the conditions of its own sweep."""


rule tabulate_mill_spectra:
    input:
        summaries=lambda wildcards: mill_summaries(wildcards.mill),
        runs=lambda wildcards: records_of(mill_summaries(wildcards.mill)),
    output:
        spectra=f"{DOSE}/{{mill}}/spectra.tsv",
        summary=f"{DOSE}/{{mill}}/spectra_summary.tsv",
    log:
        f"{LOGS}/dose/{{mill}}_spectra.log",
    benchmark:
        f"{BENCHMARKS}/tabulate_mill_spectra/{{mill}}.tsv"
    params:
        rules=SPECTRA_RULES,
        settings=CONFIG.dose.spectra.model_dump(mode="json"),
        library=library("tabulate_spectra.py"),
    message:
        "Tabulating the energy spectra of mill {wildcards.mill}"
    script:
        "../../scripts/tabulate_spectra.py"


rule plot_mill_spectra:
    input:
        spectra=rules.tabulate_mill_spectra.output.spectra,
    output:
        svg=report(
            f"{DOSE}/{{mill}}/spectra.svg",
            caption="../report/spectra.rst",
            category="Dose",
            labels={"mill": "{mill}", "figure": "energy spectra"},
        ),
        png=f"{DOSE}/{{mill}}/spectra.png",
    log:
        f"{LOGS}/dose/{{mill}}_plot_spectra.log",
    localrule: True
    params:
        title=lambda wildcards: mill_named(wildcards.mill).title,
        rule=CONFIG.fingerprint.counting_rule,
        chosen={},
        library=library("plot_spectra.py"),
    message:
        "Drawing the energy spectra of mill {wildcards.mill}"
    script:
        "../../scripts/plot_spectra.py"


MILL_SPECTRA = [
    output.format(mill=CONFIG.mill) for output in (*rules.tabulate_mill_spectra.output, *rules.plot_mill_spectra.output)
]
