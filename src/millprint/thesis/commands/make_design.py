"""Makes a design of experiments. Example:

    millprint design my_design.yaml my_design

The YAML file has the keys factors (symbol, column, label, levels), generators, order_seed and, optionally, replicates,
as the section `doe` of config/config.yaml. With that file the command makes the design of the thesis. The file may
also have the keys of `millprint analyse`. The command writes design.tsv (treatments, settings and the randomised order
of the runs), aliases.tsv (the defining relation and the confounded terms) and fraction.json (resolution, lengths of
the defining words).
"""

from pathlib import Path

from millprint.cli.commands import parser_of
from millprint.config.doe import AnalysisConfig, DesignConfig
from millprint.config.load import check_model, read_part
from millprint.run.files import write_json, write_table


def main(arguments: list[str], name: str = "design") -> None:
    """Write the tables of the design."""
    parser = parser_of(name, __doc__)
    parser.add_argument("design", help="YAML file with the factors")
    parser.add_argument("folder", help="folder to write to")
    parser.add_argument(
        "--generate", nargs="+", default=[], metavar="FACTOR", help="factors for which the best generators are searched"
    )
    options = parser.parse_args(arguments)
    from millprint.thesis.doe.factorial_designs import alias_table, best_generators, describe, design_table

    config = read_part(options.design, "doe", DesignConfig, whole=AnalysisConfig)
    if options.generate:
        generators = best_generators(config, options.generate)
        config = check_model({**config.model_dump(), "generators": generators}, DesignConfig, options.design)
    folder = Path(options.folder)
    description = describe(config)
    write_table(design_table(config), folder / "design.tsv")
    write_table(alias_table(config), folder / "aliases.tsv")
    write_json(description, folder / "fraction.json")
    words = " = ".join(["I", *description["defining_words"]])
    print(f"{folder}: {description['runs']} runs of {description['full_factorial_runs']}; ", end="")
    print(
        f"{', '.join(config.generators)}; {words}; resolution {description['resolution']}" if words != "I" else "full"
    )
