"""Wear of the balls and iron in the powder for runs of your own, by Archard's law. Example:

    millprint wear results/dem/MILL/CONTACT/CASE --bpr 30 --hours 12.5

Each folder has run.h5 and summary.json; seeds of one condition are averaged. The coefficient is that of the thesis's
weighings (`snakemake --cores 2 dose`), so that it holds for its steel and its powder; for another material it is an
order of magnitude. The printed range is that between the coefficients of the single weighings.
"""

from pathlib import Path

from millprint.cli.commands import parser_of
from millprint.config.arguments import check_written, value_of_key
from millprint.config.dose import ChargeConfig, WearConfig
from millprint.config.errors import ConfigError
from millprint.config.included import SOURCES
from millprint.run.files import write_table

SHOWN = {
    "mill": "mill",
    "ball_diameter_mm": "ball/mm",
    "fill_ratio": "fill",
    "speed_rpm": "rpm",
    "material": "material",
    "wear_g": "wear/g",
    "powder_percent": "of powder %",
    "iron_percent": "iron %",
    "seen_lower_iron_percent": "from",
    "seen_upper_iron_percent": "to",
}


def main(arguments: list[str], name: str = "wear") -> None:
    """Predict and print the wear."""
    defaults = WearConfig()
    parser = parser_of(name, __doc__)
    parser.add_argument("runs", nargs="+", help="folders with run.h5 and summary.json")
    parser.add_argument("--bpr", type=value_of_key(ChargeConfig, "bpr"), required=True, help="ball-to-powder ratio")
    parser.add_argument("--hours", type=value_of_key(ChargeConfig, "time_h"), required=True, help="milling time [h]")
    parser.add_argument("--material", action="append", help="of balls and jar; left out: all of the table")
    parser.add_argument("--coefficient", default="results/dose/wear_coefficient.json", help="fitted coefficient")
    parser.add_argument("--materials", default=SOURCES.find(defaults.materials), help="table of materials")
    parser.add_argument("--out", help="TSV for the whole table")
    options = parser.parse_args(arguments)
    import pandas as pd

    from millprint.dose.wear import mean_conditions, predict_wear, read_coefficient, read_materials, tabulate_sliding

    check_written(options.out, options.materials, options.coefficient)
    charge = ChargeConfig(bpr=options.bpr, time_h=options.hours)
    materials = read_materials(options.materials)
    for name in options.material or []:
        if name not in materials.index:
            raise ConfigError(f"--material {name}: not in {options.materials}; it has {', '.join(materials.index)}")
    if not Path(options.coefficient).exists():
        raise ConfigError(
            f"{options.coefficient}: no such file; `snakemake --cores 2 dose` in the project's folder fits it: name "
            "its file by --coefficient FILE"
        )
    result = read_coefficient(options.coefficient)
    paths = [(str(Path(run) / "run.h5"), str(Path(run) / "summary.json")) for run in options.runs]
    conditions = mean_conditions(tabulate_sliding(paths))
    chosen = materials.loc[options.material or list(materials.index)]
    table = predict_wear(conditions, chosen, [charge], result, None)
    if options.out:
        write_table(table, options.out)
    with pd.option_context("display.width", 200):
        print(table[list(SHOWN)].rename(columns=SHOWN).to_string(index=False, float_format="{:.3g}".format))
    for note in dict.fromkeys(table["note"]):
        print(f"note: {note}")
