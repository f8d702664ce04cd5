"""Analyses the runs of a design. Example:

    millprint analyse my_design.yaml my_runs.tsv my_results

The YAML file is that of `millprint design`, with the terms of the analysis of variance in `model`. Optional keys are
`repeatability_percent` and `interactions`, as in the section `doe` of config/config.yaml.
The TSV has the columns case, those of the factors, yield_percent and, if known, run_order. The command writes the
tables and figures of results/doe that follow from these: aliases, audit, analysis of variance, contested
terms, residuals, interactions.
"""

from pathlib import Path

from millprint.cli.commands import parser_of
from millprint.config.doe import AnalysisConfig
from millprint.config.load import read_part
from millprint.run.files import read_table, write_table


def write_tables(config: AnalysisConfig, runs: str, folder: Path) -> list[str]:
    """Write the tables, and return one line for each departure of the runs from the design."""
    from millprint.thesis.doe.residuals import VARIANCE, analysis_paths, design_paths, write_analysis, write_design
    from millprint.thesis.doe.variance import pareto_table

    departures = write_design(runs, design_paths(folder), config)
    paths = analysis_paths(folder)
    write_analysis(runs, paths, config)
    printed, corrected = (read_table(paths[name], text=["term"]) for name in VARIANCE)
    ranking = pareto_table(printed, corrected, printed_p={})
    write_table(ranking, folder / "pareto.tsv")
    return departures


def draw_figures(config: AnalysisConfig, folder: Path) -> None:
    """Draw the figures from the tables in `folder`."""
    from millprint.figures.style import save
    from millprint.thesis.figures.chapter2_figures import interactions, pareto, residuals

    factors = {factor.symbol: factor for factor in config.factors}
    labels = {symbol: factor.label for symbol, factor in factors.items()}
    figures = {
        "pareto": pareto(read_table(folder / "pareto.tsv", text=["source"]), labels),
        "residuals": residuals(read_table(folder / "residuals.tsv", text=["case"])),
    }
    means = read_table(folder / "interactions.tsv", text=["figure"])
    for panel in config.interactions:
        figures[f"interaction_{panel.name}"] = interactions(means[means["figure"] == panel.name], factors)
    for name, figure in figures.items():
        save(figure, folder / f"{name}.svg", folder / f"{name}.png")


def main(arguments: list[str], name: str = "analyse") -> None:
    """Analyse one table of runs."""
    parser = parser_of(name, __doc__)
    parser.add_argument("design", help="YAML file with the factors and the model")
    parser.add_argument("runs", help="TSV with the measured runs")
    parser.add_argument("folder", help="folder to write to")
    options = parser.parse_args(arguments)
    folder = Path(options.folder)
    config = read_part(options.design, "doe", AnalysisConfig)
    departures = write_tables(config, options.runs, folder)
    draw_figures(config, folder)
    for line in departures:
        print(f"departs from the design: {line}")
    print(f"{folder}: tables and figures of {options.runs}")
