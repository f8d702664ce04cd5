"""Wet-lab calculations for a TSV of your own readings. Example:

    millprint wet-lab yield readings.tsv results.tsv

Each calculation reads the column case and:

yield      gas_volume_ml, temperature_k, pressure_pa, limiting_mass_g; optional water_head_mm (water higher inside than
           outside) and standard deviations gas_volume_error_ml, temperature_error_k, pressure_error_pa,
           limiting_mass_error_g
half-life  ph, temperature_k; optional wait_h
charge     bpr, molar_ratio, and ball_mass_g or balls, ball_diameter_mm, ball_density_kg_m3
wear       ball_diameter_mm, speed_rpm, time_h, bpr, unused_mass_g, used_mass_g; optional wear_g; no case

For yield and charge the reaction and purities come from doe.chemistry of --config, the configuration of the thesis if
there is one; doe.gas says whether the gas holds water vapour.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from millprint.cli.commands import parser_of
from millprint.config.arguments import check_written
from millprint.config.doe import WetLabConfig
from millprint.config.errors import ConfigError
from millprint.config.load import read_part
from millprint.run.files import write_table

if TYPE_CHECKING:
    import pandas as pd

CALCULATIONS = ("yield", "half-life", "charge", "wear")
WITHOUT_REACTION = ("half-life", "wear")
CONFIG = "config/config.yaml"


def main(arguments: list[str], name: str = "wet-lab") -> None:
    """Calculate one table."""
    parser = parser_of(name, __doc__)
    parser.add_argument("calculation", choices=CALCULATIONS)
    parser.add_argument("readings", help="TSV with the readings")
    parser.add_argument("results", help="TSV to write: the readings with the calculated columns")
    parser.add_argument("--config", help=f"YAML file with doe.chemistry and doe.gas (default: {CONFIG})")
    parser.add_argument("--dry-gas", action="store_true", help="the gas holds no water vapour")
    options = parser.parse_args(arguments)
    from millprint.thesis.doe import wet_lab
    from millprint.thesis.doe.chemistry import check_formulas

    config = options.config or CONFIG
    check_written(options.results, options.readings, config)
    if options.calculation in WITHOUT_REACTION:
        read = {"half-life": wet_lab.solution_table, "wear": lambda path: wet_lab.wear_table(wet_lab.read_wear(path))}
        _write(read[options.calculation](options.readings), options.results)
        return
    if options.config is None and not Path(CONFIG).exists():
        raise ConfigError(f"{CONFIG}: no such file; name one with your reaction, doe.chemistry, by --config FILE")
    settings = read_part(config, "doe", WetLabConfig)
    check_formulas(settings.chemistry, f"{config}: chemistry")
    if options.dry_gas:
        dry = settings.gas.model_copy(update={"saturated": False})
        settings = settings.model_copy(update={"gas": dry})
    if options.calculation == "yield":
        table = wet_lab.yield_table(options.readings, settings.chemistry, settings.gas)
    else:
        table = wet_lab.charge_table(options.readings, settings.chemistry)
    _write(table, options.results)


def _write(table: pd.DataFrame, path: str) -> None:
    write_table(table, path)
    print(f"{path}: {len(table)} rows")
