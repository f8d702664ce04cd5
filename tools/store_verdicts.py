"""Stores the verdicts of a run, and the surrogate with its baselines: python tools/store_verdicts.py.

Both with this machine's processor; a run on the same one takes the place of the earlier one. Whoever runs the thesis on
another machine is then told which verdicts differ from those in config/data/verdicts_elsewhere.tsv. The tables of
docs/why/surrogate.md are those of docs/why/surrogate_baselines.tsv.
"""

import argparse
import datetime
from pathlib import Path

from millprint.config.checks import stop_on_bad_input
from millprint.config.strict_yaml import read_yaml
from millprint.run.files import read_table, write_table
from millprint.thesis.claims.conclusions import store, this_machine
from millprint.thesis.surrogate.measure_tables import with_machine

TABLE = "config/data/verdicts_elsewhere.tsv"
BASELINES = "docs/why/surrogate_baselines.tsv"


def store_baselines(results: str, stored: str) -> None:
    """Put the surrogate's table of the run in the place of what this machine stored before."""
    own, machine = read_table(f"{results}/surrogate/baselines.tsv"), this_machine("")["processor"]
    write_table(with_machine(read_table(stored), own, machine), stored)


def main(results: str, table: str, date: str) -> str:
    """Store the verdicts of the run in the folder `results`; returns what was done, in words."""
    report = Path(results) / "report"
    run = read_yaml(str(report / "run.yaml"))["name"]
    text = ["id", "verdict", "interval_verdict", "reason", "nature", "reproduced", "lower", "upper"]
    if Path(results, "surrogate/baselines.tsv").exists():
        store_baselines(results, BASELINES)
    number = store(table, read_table(report / "claims.tsv", text=text), run, date)
    return f"{table}: {number} verdicts of the run {run} on this machine, {date}"


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--results", default="results", help="folder of the run (default: %(default)s)")
    parser.add_argument("--table", default=TABLE, help="where verdicts are stored (default: %(default)s)")
    given = parser.parse_args()
    with stop_on_bad_input():
        print(main(given.results, given.table, datetime.date.today().isoformat()))
