"""Analyses the runs of a design: `python scripts/analyse_design.py my_design.yaml my_runs.tsv my_results/`.

The YAML file is that of make_design.py, with the terms of the analysis of variance in `model`. Optional keys are
`confidence`, `simulations`, `repeatability_percent` and `interactions`, as in the section `doe` of config/config.yaml.
The TSV has the columns case, those of the factors, yield_percent and, if known, run_order. The script writes the tables
and figures of results/doe that follow from these: aliases, audit, analysis of variance, trends, contested terms,
residuals, interactions.
"""

import argparse
from pathlib import Path

import analyse_variance
import tabulate_experiments
from millprint.config.checks import stop_on_bad_input
from millprint.config.doe import AnalysisConfig
from millprint.config.load import read_part
from millprint.figures.style import save
from millprint.run.files import read_table, write_table
from millprint.thesis.doe.variance import pareto_table
from millprint.thesis.figures.chapter2_figures import interactions, pareto, residuals


def write_tables(config: AnalysisConfig, runs: str, folder: Path) -> list[str]:
    """Write the tables, and return one line for each departure of the runs from the design."""
    departures = tabulate_experiments.make_design(runs, tabulate_experiments.design_paths(folder), config)
    paths = analyse_variance.paths_in(folder)
    analyse_variance.main(runs, paths, config)
    both = [read_table(paths[name], text=["term"]) for name in analyse_variance.VARIANCE]
    ranking = pareto_table(*both, printed_p={})
    write_table(ranking, folder / "pareto.tsv")
    return departures


def draw_figures(config: AnalysisConfig, folder: Path) -> None:
    """Draw the figures from the tables in `folder`."""
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


def main(arguments: list[str] | None = None) -> None:
    """Analyse one table of runs."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("design", help="YAML file with the factors and the model")
    parser.add_argument("runs", help="TSV with the measured runs")
    parser.add_argument("folder", help="folder to write to")
    options = parser.parse_args(arguments)
    folder = Path(options.folder)
    with stop_on_bad_input():
        config = read_part(options.design, "doe", AnalysisConfig)
        departures = write_tables(config, options.runs, folder)
        draw_figures(config, folder)
    for line in departures:
        print(f"departs from the design: {line}")
    print(f"{folder}: tables and figures of {options.runs}")


if __name__ == "__main__":
    main()
