"""Analyses the variance of the screening runs: as printed, as corrected, confounded terms, and residuals; draws it.

Settings: doe.
Inputs: `screening` and `claims`.
Outputs: `printed` and `corrected` variance, `contested`, `rival_models`, `residual_parts`, `detectable`,
`residuals`, `lack_of_fit`, `interactions`, `pareto`, and the figures.
"""

from millprint.config.doe import AnalysisConfig, Factor
from millprint.figures.style import in_pairs, save
from millprint.run.files import read_table, write_table
from millprint.run.job import job
from millprint.run.tables import Text, read_measured
from millprint.thesis.doe.residuals import write_analysis
from millprint.thesis.doe.variance import pareto_table
from millprint.thesis.figures.chapter2_figures import interactions, pareto, residuals


def published_p(claims: str) -> dict[str, float]:
    """Published p-values of Table 2.5 by term, such as `AB, CD`, from the table of claims."""
    frame = read_measured(claims, [Text("id"), Text("quantity"), Text("value")])
    own = frame[frame["id"].str.fullmatch(r"2\.anova\.\w+\.p")]
    return dict(zip(own["quantity"].str.removeprefix("p-value of "), own["value"].astype(float), strict=True))


def draw(given, made, interactions_of: list[str], factors: dict[str, Factor]) -> None:
    """Write the ranking of the terms, and draw it, the residuals, and the panels of every figure of interactions."""
    second = read_table(made.corrected, text=["sums", "term"])
    ranking = pareto_table(read_table(made.printed, text=["source", "term"]), second, published_p(given.claims))
    write_table(ranking, made.pareto)
    save(pareto(ranking, {symbol: factor.label for symbol, factor in factors.items()}), *made.pareto_figure)
    save(residuals(read_table(made.residuals, text=["case"])), *made.residuals_figure)
    means = read_table(made.interactions, text=["figure"])
    for name, files in zip(interactions_of, in_pairs(made.interaction_figures), strict=True):
        save(interactions(means[means["figure"] == name], factors), *files)


if "snakemake" in globals():
    given, made, own = snakemake.input, snakemake.output, snakemake.params
    settings = AnalysisConfig(**own.settings)
    with job(snakemake.log[0], "analyse variance"):
        write_analysis(given.screening, dict(made.items()), settings)
        draw(given, made, own.interactions, {factor.symbol: factor for factor in settings.factors})
