"""Stores the verdicts of a run with this machine's processor and today's date: python scripts/store_verdicts.py.

Whoever runs the thesis on another machine is then told which verdicts differ from those in
config/data/verdicts_elsewhere.tsv. A run on the same processor takes the place of the earlier one.
"""

import argparse
import datetime
from pathlib import Path

from millprint.claims.elsewhere import store
from millprint.config.checks import stop_on_bad_input
from millprint.config.strict_yaml import read_yaml
from millprint.files import read_table

TABLE = "config/data/verdicts_elsewhere.tsv"


def main(results: str, table: str, date: str) -> str:
    """Store the verdicts of the run in the folder `results`; returns what was done, in words."""
    report = Path(results) / "report"
    run = read_yaml(str(report / "run.yaml"))["name"]
    text = ["id", "verdict", "interval_verdict", "nature", "reproduced", "lower", "upper"]
    number = store(table, read_table(report / "claims.tsv", text=text), run, date)
    return f"{table}: {number} verdicts of the run {run} on this machine, {date}"


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--results", default="results", help="folder of the run (default: %(default)s)")
    parser.add_argument("--table", default=TABLE, help="where verdicts are stored (default: %(default)s)")
    given = parser.parse_args()
    with stop_on_bad_input():
        print(main(given.results, given.table, datetime.date.today().isoformat()))
