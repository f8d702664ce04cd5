"""Checks a folder of results, or a copy of it, against the crate in it: python scripts/check_crate.py [FOLDER].

A line for each file that is missing, changed or additional. The exit status is 0 if there is none, 1 if there is one or
if the folder has no crate. Logs, benchmarks and report.html are not checked: every further run writes them anew.
"""

import argparse
import sys
from pathlib import Path

from millprint.config.checks import stop_on_bad_input
from millprint.provenance.check import check_folder


def main(words: list[str]) -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", nargs="?", default="results", help="folder with a crate (default: %(default)s)")
    folder = Path(parser.parse_args(words).folder)
    with stop_on_bad_input():
        count, faults = check_folder(folder)
    for fault in faults:
        print(fault)
    print(
        f"{folder}: {count} files checked, {len(faults)} not as the crate says"
        if faults
        else f"{folder}: all {count} files are as the crate says"
    )
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
