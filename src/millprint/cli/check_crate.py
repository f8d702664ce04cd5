"""Checks a folder of results, or a copy of it, against the crate in it.

    millprint check-crate /archive/results

A line for each file that is missing, changed or additional. The exit status is 0 if there is none, 1 if there is one or
if the folder has no crate. Logs, benchmarks and report.html are not checked: every further run writes them anew.
"""

from pathlib import Path

from millprint.cli.commands import parser_of
from millprint.provenance.check import check_folder


def main(arguments: list[str], name: str = "check-crate") -> int:
    """Check one folder."""
    parser = parser_of(name, __doc__)
    parser.add_argument("folder", nargs="?", default="results", help="folder with a crate (default: %(default)s)")
    folder = Path(parser.parse_args(arguments).folder)
    count, faults = check_folder(folder)
    for fault in faults:
        print(fault)
    print(
        f"{folder}: {count} files checked, {len(faults)} not as the crate says"
        if faults
        else f"{folder}: all {count} files are as the crate says"
    )
    return 1 if faults else 0
