"""Chapter 2: the screening design, its analysis of variance, wet-lab arithmetic, and the literature."""

from millprint.config.doe import AnalysisConfig, DesignConfig

DOE = f"{RESULTS}/doe"
FACTORS = [factor.model_dump(mode="json") for factor in CONFIG.doe.factors]


rule tabulate_experiments:
    input:
        screening=CONFIG.data.screening,
        weighings=CONFIG.data.wear,
        studies=SOURCES.find(CONFIG.doe.literature),
        yields=SOURCES.find(CONFIG.doe.literature_yields),
    output:
        design=f"{DOE}/design.tsv",
        fraction=f"{DOE}/fraction.json",
        aliases=f"{DOE}/aliases.tsv",
        audit=f"{DOE}/audit.tsv",
        half_life=f"{DOE}/half_life.tsv",
        wear=f"{DOE}/wear.tsv",
        missingness=f"{DOE}/missingness.tsv",
        checks=f"{DOE}/literature_checks.tsv",
        figure=figures(f"{DOE}/literature"),
        tsv=f"{DOE}/literature.tsv",
        missingness_figure=figures(f"{DOE}/missingness"),
    log:
        f"{LOGS}/doe/tabulate_experiments.log",
    localrule: True
    params:
        design=CONFIG.doe.part(DesignConfig),
    message:
        "Checking the runs in {input.screening} against the design; tabulating half-lives, wear and the literature"
    script:
        "../../scripts/tabulate_experiments.py"


rule analyse_variance:
    input:
        screening=CONFIG.data.screening,
        claims=CONFIG.data.claims,
    output:
        printed=f"{DOE}/anova_printed.tsv",
        corrected=f"{DOE}/anova_corrected.tsv",
        contested=f"{DOE}/contested.tsv",
        residual_parts=f"{DOE}/residual_parts.tsv",
        detectable=f"{DOE}/detectable.tsv",
        residuals=f"{DOE}/residuals.tsv",
        lack_of_fit=f"{DOE}/lack_of_fit.tsv",
        interactions=f"{DOE}/interactions.tsv",
        pareto=f"{DOE}/pareto.tsv",
        pareto_figure=figures(f"{DOE}/pareto"),
        residuals_figure=figures(f"{DOE}/residuals"),
        interaction_figures=[
            path
            for each in CONFIG.doe.interactions
            for path in figures(f"{DOE}/interaction_{each.name}", title=each.title)
        ],
    log:
        f"{LOGS}/doe/analyse_variance.log",
    localrule: True
    params:
        settings=CONFIG.doe.part(AnalysisConfig),
        interactions=[each.name for each in CONFIG.doe.interactions],
    message:
        "Analysing the variance of the yields in {input.screening}, and drawing its factors, residuals and interactions"
    script:
        "../../scripts/analyse_variance.py"


DOE_OUTPUTS = [*rules.tabulate_experiments.output, *rules.analyse_variance.output]
