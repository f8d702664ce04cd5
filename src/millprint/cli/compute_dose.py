"""Dose of your own runs: the energy that a gram of powder has seen, with its parts, and its hits.

    millprint dose my_runs.tsv planetary --out my_doses.tsv

The table has the columns case, mill, powder_mass_g, time_h, fill_ratio, speed_rpm, ball_diameter_mm, and yield_percent
if there is one. Name each of its mills, if it was run here or comes with a fingerprint, or give its fingerprint.json.
With five yields or more, first-order, Avrami and threshold kinetics over time and over each dose are fitted, compared
by AICc, and printed with a verdict.
"""

from pathlib import Path

from millprint.cli.commands import parser_of
from millprint.config.arguments import check_written
from millprint.config.errors import ConfigError
from millprint.observables.definitions import POWER
from millprint.run.files import write_table


def main(arguments: list[str], name: str = "dose") -> None:
    """Print the doses, and kinetics where there are enough yields; with --out, write the doses."""
    parser = parser_of(name, __doc__)
    parser.add_argument("runs", type=Path, help="TSV with a row for each run")
    parser.add_argument("fingerprints", nargs="+", metavar="MILL", help="the mills, or their fingerprint.json")
    parser.add_argument(
        "--results", default="results", metavar="FOLDER", help="where mills were run (default: %(default)s)"
    )
    parser.add_argument("--out", type=Path, help="TSV file for the doses")
    options = parser.parse_args(arguments)
    from millprint.config.included import SOURCES
    from millprint.dose.kinetics import (
        AXES,
        DOSE_OF,
        HITS,
        TIME,
        YIELD,
        fit_kinetics,
        own_doses,
        said_of_dose,
        said_of_shear,
    )
    from millprint.fingerprint.model import LAYERS, NO_IMPACTS, Fingerprint
    from millprint.fingerprint.readers import find_fingerprint

    paths = [find_fingerprint(mill, options.results, SOURCES) for mill in options.fingerprints]
    check_written(options.out, options.runs, *paths)
    known = {own.about["mill"]: own for own in map(Fingerprint.read, paths)}
    table = own_doses(options.runs, known)
    if options.out:
        write_table(table, options.out)
    shown = ["case", "mill", TIME, *DOSE_OF, HITS, POWER, "outside"]
    print(table[shown].to_string(index=False, float_format="{:.4g}".format, na_rep="not known"))
    if still := ", ".join(table["case"][table["outside"].str.contains(LAYERS)]):
        print(f"{still}: {NO_IMPACTS}")
    for said in filter(None, (own.few_turns_in_words() for own in known.values())):
        print(said)
    if YIELD in table:
        told = table[table[list(AXES)].notna().all(axis=1)]
        if len(told) < len(table):
            print(f"kinetics of the {len(told)} runs of which every dose is known")
        try:
            kinetics = fit_kinetics(told)
        except ConfigError as reason:
            # The doses are right all the same.
            print(f"no kinetics: {reason}")
            return
        print(kinetics.to_string(index=False, float_format="{:.4g}".format, na_rep="-"))
        print(said_of_dose(told, kinetics, str(options.runs)), said_of_shear(told))
