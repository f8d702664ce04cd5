"""Writes the Workflow Run RO-Crate of a run beside its results: python scripts/write_crate.py [RESULTS].

The rule of this script describes the run of its configuration. Called in a terminal, in the folder of a run, it
describes everything that jobs have made in RESULTS (default: results), also for further targets, when all have ended.
"""

import argparse
from pathlib import Path

from millprint.config.checks import stop_on_bad_input
from millprint.provenance.crate_files import read_configuration, write_crate
from millprint.provenance.finished import check_finished, recipe_of, targets_of
from millprint.provenance.inside import CRATE
from millprint.provenance.lineage import read_jobs
from millprint.run import files
from millprint.run.job import job
from millprint.run.output_digests import write_record

# The rule of this script, and where its job records what it wrote.
RULE, RECORD = "write_crate", "logs/report/write_crate.json"


def main(results: str) -> str:
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
    return f"{folder / CRATE}: {count} files; python scripts/check_crate.py FOLDER checks a copy"


if "snakemake" in globals():
    with job(snakemake.log[0], "write crate") as logger:
        given = snakemake.params
        targets = [*snakemake.input.targets, snakemake.input.configuration]
        count = write_crate(given.results, targets, list(given.sources), list(given.snakefiles), read_jobs())
        logger.info("%s: %d files", snakemake.output.crate, count)
elif __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("results", nargs="?", default="results", help="folder of the run (default: %(default)s)")
    with stop_on_bad_input():
        print(main(parser.parse_args().results))
