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


def draw(
    printed: str, corrected: str, residual_table: str, claims: str, outputs: dict[str, str], factors: list[Factor]
) -> None:
    """Write the ranking and both figures; `outputs` has the paths pareto, pareto_figure, residuals_figure."""
    names = {factor.symbol: factor.label for factor in factors}
    second = read_table(corrected, numeric=["sum_of_squares"], text=["sums", "term"])
    ranking = pareto_table(read_table(printed, text=["source", "term"]), second, published_p(claims))
    write_table(ranking, outputs["pareto"])
    save(pareto(ranking, names), *outputs["pareto_figure"])
    table = read_table(residual_table, numeric=["residual_percent"], text=["case"])
    save(residuals(table), *outputs["residuals_figure"])


def draw_interactions(means: str, names: list[str], paths: list[str], factors: list[Factor]) -> None:
    """Draw the panels of every figure in `names`: the mean yield for each combination of two factors' levels."""
    table = read_table(means, numeric=["axis_code", "curve_code", "mean_yield_percent"], text=["figure"])
    known = {factor.symbol: factor for factor in factors}
    for name, files in zip(names, in_pairs(paths), strict=True):
        save(interactions(table[table["figure"] == name], known), *files)


if "snakemake" in globals():
    inputs, outputs, own = snakemake.input, snakemake.output, snakemake.params
    settings = AnalysisConfig(**own.settings)
    with job(snakemake.log[0], "analyse variance"):
        write_analysis(inputs.screening, dict(outputs.items()), settings)
        draw(
            outputs.printed,
            outputs.corrected,
            outputs.residuals,
            inputs.claims,
            dict(outputs.items()),
            settings.factors,
        )
        draw_interactions(outputs.interactions, own.interactions, outputs.interaction_figures, settings.factors)
