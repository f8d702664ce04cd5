"""Appendix A: the effect of each part of the surrogate."""


rule tabulate_ablations:
    input:
        metrics=[path for variant in CONFIG.surrogate.ablations for path in measured_trainings(variant)],
        histories=[
            f"{SURROGATE}/{CONFIG.surrogate.weights_of(variant)}/loss.tsv" for variant in CONFIG.surrogate.ablations
        ],
        claims=CONFIG.data.claims,
    output:
        ablations=f"{SURROGATE}/ablations.tsv",
    log:
        f"{LOGS}/surrogate/tabulate_ablations.log",
    localrule: True
    params:
        trainings={variant: CONFIG.surrogate.trainings_of(variant) for variant in CONFIG.surrogate.ablations},
        changes={variant: changes(variant) for variant in CONFIG.surrogate.ablations},
        length_s={
            variant: CONFIG.surrogate.rollout_of(variant, CONFIG.surrogate.trained_test).length_s
            for variant in CONFIG.surrogate.ablations
        },
    message:
        "Tabulating every ablation next to the statement of the thesis"
    script:
        "../../scripts/tabulate_ablations.py"


rule plot_ablations:
    input:
        ablations=rules.tabulate_ablations.output.ablations,
    output:
        svg=report(
            f"{SURROGATE}/ablations.svg",
            caption="../report/surrogate_ablations.rst",
            category="Appendix A",
            labels={"figure": "ablations (Figs A.1 to A.8)"},
        ),
        png=f"{SURROGATE}/ablations.png",
    log:
        f"{LOGS}/surrogate/plot_ablations.log",
    localrule: True
    message:
        "Drawing the ablations of appendix A"
    script:
        "../../scripts/plot_ablations.py"


ABLATION_OUTPUTS = [*rules.tabulate_ablations.output, *rules.plot_ablations.output]


rule ablations:
    input:
        ABLATION_OUTPUTS,
    localrule: True
    message:
        "The ablations are complete"
