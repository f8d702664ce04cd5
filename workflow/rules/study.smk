"""Targets of any mill that do more for the thesis: `convergence` and `dose`."""

STUDY = f"{RESULTS}/convergence/{{mill}}"


rule study_settings:
    input:
        summaries=lambda wildcards: study_summaries(wildcards.mill),
    output:
        table=f"{STUDY}/study.tsv",
        window=f"{STUDY}/window.tsv",
        verdict=f"{STUDY}/verdict.json",
        line=f"{STUDY}/verdict.txt",
        svg=shown(f"{STUDY}/study.svg"),
        png=f"{STUDY}/study.png",
    log:
        f"{LOGS}/convergence/{{mill}}_study.log",
    localrule: True
    params:
        folder=f"{RESULTS}/dem",
        variants=lambda wildcards: study_plan(wildcards.mill),
        sweep_seeds=lambda wildcards: len(sweep_of_mill(wildcards.mill).sweep.seeds),
        counting_rule=CONFIG.mills.rule,
        study=CONFIG.convergence.study.model_dump(mode="json"),
    message:
        "Comparing time step, stiffness, facets, window and seeds of mill {wildcards.mill}"
    script:
        "../../scripts/study_settings.py"


rule convergence:
    """Whether time step, stiffness, window and number of seeds are good enough."""
    input:
        CONVERGENCE_OUTPUTS if CHAPTERS else [],
        [output.format(mill=CONFIG.mill) for output in rules.study_settings.output],
    localrule: True
    message:
        "The study of the settings is complete"


# Written by the jobs of the fingerprint.
MILL_SPECTRA = [
    path.format(mill=CONFIG.mill)
    for path in (*rules.describe_mill.output, *rules.draw_fingerprint.output)
    if path.startswith(f"{DOSE}/")
]


rule dose:
    """Energy spectra; for the thesis also dose, kinetics and wear."""
    input:
        DOSE_OUTPUTS if CHAPTERS else MILL_SPECTRA,
    localrule: True
    message:
        "Energy spectra and dose are complete"
