"""Plots the analysis of variance: the Pareto plot and the residuals."""

from millprint.doe.pareto import pareto_table
from millprint.figures.chapter2 import pareto, residuals
from millprint.figures.style import save
from millprint.files import read_table, write_table
from millprint.job import job


def published_p(claims: str) -> dict[str, float]:
    """Published p-values of Table 2.5 by source, such as `AB, CD`, from the table of claims."""
    frame = read_table(claims, text=["id", "quantity", "value"])
    own = frame[frame["id"].str.fullmatch(r"2\.anova\.\w+\.p")]
    return dict(zip(own["quantity"].str.removeprefix("p-value of "), own["value"].astype(float), strict=True))


def main(printed: str, residual_table: str, claims: str, pareto_table_path: str, figures: dict[str, str]) -> None:
    """Write the ranking and both figures; `figures` holds the paths pareto_svg, pareto_png, residuals_svg..."""
    ranking = pareto_table(read_table(printed, text=["source"]), published_p(claims))
    write_table(ranking, pareto_table_path)
    save(pareto(ranking), figures["pareto_svg"], figures["pareto_png"])
    table = read_table(residual_table, numeric=["residual_percent"], text=["case"])
    save(residuals(table), figures["residuals_svg"], figures["residuals_png"])


if "snakemake" in globals():
    with job(snakemake.log[0], "plot variance"):
        outputs = dict(snakemake.output.items())
        main(
            snakemake.input.printed,
            snakemake.input.residuals,
            snakemake.input.claims,
            outputs.pop("pareto"),
            outputs,
        )
