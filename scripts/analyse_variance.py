"""Analyses the variance of the screening runs: as printed, as corrected, confounded terms, and residuals; draws it.

params: section `doe` as `settings`, and the figures of `interactions`. input: `screening` and `claims`.
output: the tables of VARIANCE and TABLES, and the figures.
"""

from pathlib import Path

from millprint.config.design import Factor
from millprint.config.doe import AnalysisConfig
from millprint.figures.style import save
from millprint.run.files import read_table, write_table
from millprint.run.job import job
from millprint.thesis.doe.contested import contested_table, residual_parts_table, rival_models_table
from millprint.thesis.doe.least_squares import fit_factors
from millprint.thesis.doe.residuals import lack_of_fit_table, residual_checks, residual_table
from millprint.thesis.doe.runs import read_runs
from millprint.thesis.doe.trends import interaction_table, trend_table
from millprint.thesis.doe.variance import corrected_table, detectable_table, pareto_table, printed_table
from millprint.thesis.figures.chapter2_figures import interactions, pareto, residuals

# The tables of the analysis that follow the analysis of variance, by the names of the rule's outputs.
TABLES = (
    "trends",
    "contested",
    "rival_models",
    "residual_parts",
    "detectable",
    "residuals",
    "residual_checks",
    "lack_of_fit",
    "interactions",
)
# Tables of the variance, by the names of the rule's outputs: the file that holds each.
VARIANCE = {"printed": "anova_printed", "corrected": "anova_corrected"}


def paths_in(folder: str | Path) -> dict[str, str]:
    """The path of every table of the analysis in a folder."""
    files = {**{name: name for name in TABLES}, **VARIANCE}
    return {name: str(Path(folder) / f"{file}.tsv") for name, file in files.items()}


def main(screening: str, tables: dict[str, str], settings: AnalysisConfig) -> None:
    """Write the tables of the analysis; `tables` has the path of each."""
    runs = read_runs(screening, settings.factors)
    fit = fit_factors(settings, runs)
    write_table(printed_table(settings, runs), tables["printed"])
    write_table(corrected_table(settings, runs), tables["corrected"])
    write_table(trend_table(settings, runs), tables["trends"])
    write_table(contested_table(settings, runs), tables["contested"])
    write_table(rival_models_table(settings, runs), tables["rival_models"])
    write_table(residual_parts_table(settings, runs), tables["residual_parts"])
    write_table(detectable_table(settings, runs), tables["detectable"])
    write_table(residual_table(runs, fit), tables["residuals"])
    checks = residual_checks(settings, runs, fit, settings.simulations, settings.order_seed)
    write_table(checks, tables["residual_checks"])
    write_table(lack_of_fit_table(settings, runs, fit), tables["lack_of_fit"])
    write_table(interaction_table(settings, runs), tables["interactions"])


def published_p(claims: str) -> dict[str, float]:
    """Published p-values of Table 2.5 by term, such as `AB, CD`, from the table of claims."""
    frame = read_table(claims, text=["id", "quantity", "value"])
    own = frame[frame["id"].str.fullmatch(r"2\.anova\.\w+\.p")]
    return dict(zip(own["quantity"].str.removeprefix("p-value of "), own["value"].astype(float), strict=True))


def draw(
    printed: str,
    corrected: str,
    residual_table: str,
    claims: str,
    outputs: dict[str, str],
    factors: list[Factor],
) -> None:
    """Write the ranking and both figures; `outputs` has the paths pareto, pareto_svg, pareto_png, residuals_svg, ..."""
    names = {factor.symbol: factor.label for factor in factors}
    second = read_table(corrected, numeric=["sum_of_squares"], text=["sums", "term"])
    ranking = pareto_table(read_table(printed, text=["source", "term"]), second, published_p(claims))
    write_table(ranking, outputs["pareto"])
    save(pareto(ranking, names), outputs["pareto_svg"], outputs["pareto_png"])
    table = read_table(residual_table, numeric=["residual_percent"], text=["case"])
    save(residuals(table), outputs["residuals_svg"], outputs["residuals_png"])


def draw_interactions(means: str, names: list[str], svgs: list[str], pngs: list[str], factors: list[Factor]) -> None:
    """Draw the panels of every figure in `names`: the mean yield for each combination of two factors' levels."""
    table = read_table(means, numeric=["axis_code", "curve_code", "mean_yield_percent"], text=["figure"])
    known = {factor.symbol: factor for factor in factors}
    for name, svg, png in zip(names, svgs, pngs, strict=True):
        save(interactions(table[table["figure"] == name], known), svg, png)


if "snakemake" in globals():
    inputs, outputs, own = snakemake.input, snakemake.output, snakemake.params
    settings = AnalysisConfig(**own.settings)
    with job(snakemake.log[0], "analyse variance"):
        main(inputs.screening, dict(outputs.items()), settings)
        draw(
            outputs.printed,
            outputs.corrected,
            outputs.residuals,
            inputs.claims,
            dict(outputs.items()),
            settings.factors,
        )
        figures = outputs.interaction_svgs, outputs.interaction_pngs, settings.factors
        draw_interactions(outputs.interactions, own.interactions, *figures)
