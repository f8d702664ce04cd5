"""Wet-lab calculations for a TSV of your own readings. Example:

    millprint wet-lab yield readings.tsv results.tsv

Each calculation reads the column case and:

yield      gas_volume_ml, temperature_k, pressure_pa, limiting_mass_g; optional water_head_mm (water higher inside than
           outside) and standard deviations gas_volume_error_ml, temperature_error_k, pressure_error_pa,
           limiting_mass_error_g
half-life  ph, temperature_k; optional wait_h
charge     bpr, molar_ratio, and ball_mass_g or balls, ball_diameter_mm, ball_density_kg_m3
wear       ball_diameter_mm, speed_rpm, time_h, bpr, unused_mass_g, used_mass_g; optional wear_g; no case

The reaction and purities come from doe.chemistry of the configuration; doe.gas says whether the gas holds water vapour.
"""

from millprint.cli.commands import parser_of
from millprint.config.arguments import check_written
from millprint.config.doe import WetLabConfig
from millprint.config.load import read_part
from millprint.run.files import write_table

CALCULATIONS = ("yield", "half-life", "charge", "wear")


def main(arguments: list[str], name: str = "wet-lab") -> None:
    """Calculate one table."""
    parser = parser_of(name, __doc__)
    parser.add_argument("calculation", choices=CALCULATIONS)
    parser.add_argument("readings", help="TSV with the readings")
    parser.add_argument("results", help="TSV to write: the readings with the calculated columns")
    parser.add_argument("--config", default="config/config.yaml", help="YAML file with doe.chemistry and doe.gas")
    parser.add_argument("--dry-gas", action="store_true", help="the gas holds no water vapour")
    options = parser.parse_args(arguments)
    from millprint.thesis.doe import wet_lab
    from millprint.thesis.doe.chemistry import check_formulas

    check_written(options.results, options.readings, options.config)
    settings = read_part(options.config, "doe", WetLabConfig)
    check_formulas(settings.chemistry, f"{options.config}: chemistry")
    if options.dry_gas:
        dry = settings.gas.model_copy(update={"saturated": False})
        settings = settings.model_copy(update={"gas": dry})
    if options.calculation == "yield":
        table = wet_lab.yield_table(options.readings, settings.chemistry, settings.gas)
    elif options.calculation == "half-life":
        table = wet_lab.solution_table(options.readings)
    elif options.calculation == "charge":
        table = wet_lab.charge_table(options.readings, settings.chemistry)
    else:
        table = wet_lab.wear_table(wet_lab.read_wear(options.readings))
    write_table(table, options.results)
    print(f"{options.results}: {len(table)} rows")
