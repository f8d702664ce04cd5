"""Writes the Workflow Run RO-Crate of a finished run next to its results.

    millprint crate results

Called in the folder of a run, it describes everything that jobs have made in RESULTS (default: results), also for
further targets, when all have ended. The target `crate` of the workflow describes the run of its configuration.
"""

from pathlib import Path

from millprint.cli.commands import parser_of
from millprint.provenance.crate_files import check_finished, read_configuration, recipe_of, targets_of, write_crate
from millprint.provenance.inside import CRATE
from millprint.provenance.lineage import read_jobs
from millprint.run import files
from millprint.run.output_digests import write_record

# The rule of this script, and where its job records what it wrote.
RULE, RECORD = "write_crate", "logs/report/write_crate.json"


def describe(results: str) -> str:
    """Describe everything in the folder `results`; returns what was done, in words."""
    folder = Path(results)
    read_configuration(folder)
    jobs = read_jobs()
    check_finished(folder)
    targets = targets_of(folder, jobs, RULE)
    sources, snakefiles = recipe_of(folder)
    files.written.clear()
    count = write_crate(results, targets, sources, snakefiles, jobs)
    write_record(folder / RECORD, files.written)
    return f"{folder / CRATE}: {count} files; millprint check-crate FOLDER checks a copy"


def main(arguments: list[str], name: str = "crate") -> None:
    """Describe a finished run."""
    parser = parser_of(name, __doc__)
    parser.add_argument("results", nargs="?", default="results", help="folder of the run (default: %(default)s)")
    print(describe(parser.parse_args(arguments).results))
