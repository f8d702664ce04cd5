"""Compares results with the records of a run, and describes a finished run as a Workflow Run RO-Crate.

    millprint verify results
    millprint crate results
    millprint check-crate /archive/results

`verify` lists the files that have changed since their jobs wrote them. `crate`, called in the folder of a run,
describes everything that jobs have made in RESULTS (default: results), also for further targets, when all have ended;
the target `crate` of the workflow describes the run of its configuration. `check-crate` compares a folder of results,
or a copy of it, with the crate in it: a line for each file that is missing, changed or additional. Logs, benchmarks and
report.html are not checked, since every further run writes them anew. The exit status is 1 if a file is not as it
should be.
"""

from pathlib import Path

from millprint.cli.commands import parser_of
from millprint.config.errors import ConfigError
from millprint.provenance.lineage import CRATE, check_folder, read_jobs
from millprint.run import files
from millprint.run.digest import report_damaged, write_record

# The rule that writes a crate, and where its job records what it wrote.
RULE, RECORD = "write_crate", "logs/report/write_crate.json"


def main(arguments: list[str], name: str) -> int:
    """Check or describe one folder; returns the exit status."""
    parser = parser_of(name, __doc__)
    parser.add_argument("results", nargs="?", default="results", help="folder of results (default: %(default)s)")
    results = parser.parse_args(arguments).results
    return {"verify": verify, "crate": describe, "check-crate": check_crate}[name](results)


def verify(results: str) -> int:
    """Check the files of a folder by the records of their jobs."""
    if not Path(results).is_dir():
        raise ConfigError(f"{results}: no such folder; give the folder of the results of a run")
    if report_damaged(Path(results) / "logs"):
        return 1
    print(f"checked: every file in {results} is as its job wrote it")
    return 0


def describe(results: str) -> int:
    """Describe everything in a folder."""
    from millprint.provenance.crate import check_finished, read_configuration, recipe_of, targets_of, write_crate

    folder = Path(results)
    read_configuration(folder)
    jobs = read_jobs()
    check_finished(folder)
    targets = targets_of(folder, jobs, RULE)
    sources, snakefiles = recipe_of(folder)
    files.written.clear()
    count = write_crate(results, targets, sources, snakefiles, jobs)
    write_record(folder / RECORD, files.written)
    print(f"{folder / CRATE}: {count} files; millprint check-crate FOLDER checks a copy")
    return 0


def check_crate(results: str) -> int:
    """Check a folder by the crate in it."""
    count, faults = check_folder(Path(results))
    print(*faults, *([f"{results}: all {count} files are as the crate says"] if not faults else []), sep="\n")
    if faults:
        print(f"{results}: {count} files checked, {len(faults)} not as the crate says")
    return 1 if faults else 0
