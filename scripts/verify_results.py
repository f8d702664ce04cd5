"""Checks the locks and files that earlier runs left behind, and repairs them.

    python scripts/verify_results.py [RESULTS] [--repair | --keep] [-- SNAKEMAKE ARGUMENTS]

The locks of a killed run are removed by `snakemake --unlock`, but not if another run is or may be alive. Files in
RESULTS (default: results) that have changed since their jobs wrote them are listed. In a terminal you are asked what to
do with them. Otherwise nothing is changed without an option:

    --repair  renames them to NAME.damaged and makes them again, and nothing else
    --keep    keeps them as they are and records them as results

The Snakemake arguments are those of your runs, such as --cores 2 --configfile config/smoke.yaml, without targets. The
exit status is 0 if nothing is wrong or everything is repaired, else 1.
"""

import argparse
import os
import sys
from pathlib import Path

from millprint.liveness import LIVING, runs_of
from millprint.records import damaged_files
from millprint.verify.repair import KEEP, MAKE_AGAIN, mend_files
from millprint.verify.runner import Snakemake, mend_locks, say


def read_arguments(words: list[str]) -> tuple[argparse.Namespace, list[str]]:
    """The options of this script, and the arguments for Snakemake after `--`."""
    parser = argparse.ArgumentParser(
        description=__doc__, usage=argparse.SUPPRESS, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("results", nargs="?", default="results", help=argparse.SUPPRESS)
    either = parser.add_mutually_exclusive_group()
    either.add_argument("--repair", dest="choice", action="store_const", const=MAKE_AGAIN, help=argparse.SUPPRESS)
    either.add_argument("--keep", dest="choice", action="store_const", const=KEEP, help=argparse.SUPPRESS)
    cut = words.index("--") if "--" in words else len(words)
    arguments = words[cut + 1 :]
    if "--" in arguments:
        parser.error("the arguments of Snakemake must have no targets: the damaged files are the targets")
    return parser.parse_args(words[:cut]), arguments


def verify(results: str, choice: str | None, snakemake: Snakemake, command: list[str]) -> bool:
    """Check locks and recorded files in the current folder, and repair them as requested; True if all is well then."""
    runs, logs = runs_of(), Path(results) / "logs"
    unlocked = mend_locks(runs, snakemake)
    damages = damaged_files(logs)
    for damage in damages:
        say(f"found: {damage}")
    if not unlocked:
        return False
    if not damages:
        say(f"checked: every file in {results} that a job recorded in {logs} is unchanged")
        return True
    if choice and any(run.state == LIVING for run in runs):
        say("nothing was changed: wait until the other run has ended")
        return False
    return mend_files(damages, choice, snakemake, command)


def main(words: list[str]) -> int:
    options, arguments = read_arguments(words)
    python = os.path.relpath(sys.executable) if sys.prefix != sys.base_prefix else "python"
    command = [python, sys.argv[0], *(word for word in words if word not in ("--repair", "--keep"))]
    snakemake = Snakemake(arguments)
    os.chdir(snakemake.folder)
    try:
        return 0 if verify(options.results, options.choice, snakemake, command) else 1
    except OSError as error:
        print(f"error: {error.filename}: {error.strerror}", file=sys.stderr)
        return 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
