"""Writes what the jobs of a finished run took, for the estimates of `make plan`, from its benchmarks and files.

The rows of the run in scripts/millprint/plan/measured.tsv are replaced.
Jobs that have not run are left out, and so are simulations, whose costs are calculated.
"""

import argparse
import csv
import sys
import time

from millprint.files import read_table, whole_file
from millprint.kernel import processor_type
from millprint.plan.costs import TABLE, Row, measured_rows
from millprint.plan.jobs import PlannedJob
from millprint.report.runtimes import DONE
from plan_run import read_plan


def measured(job: PlannedJob, run: str) -> Row | None:
    """What a job took by its benchmark or, without one, by its log; None if it has not run."""
    if job.missing or not job.outputs or job.log is None:
        return None
    size = sum(path.stat().st_size for path in job.outputs) / 1e6
    if job.benchmark and job.benchmark.exists():
        last = read_table(job.benchmark, numeric=["s", "cpu_time", "max_rss"]).iloc[-1]
        # Jobs of less than a second have no processor time.
        seconds = last["cpu_time"] if last["cpu_time"] > 0 else last["s"]
        return Row(run, job.rule, job.name, seconds, last["max_rss"], size)
    found = DONE.findall(job.log.read_text()) if job.log.exists() else []
    # Without a benchmark, the time of the work itself: its process has taken a second more to start.
    return Row(run, job.rule, job.name, float(found[-1]) + 1.0, 300.0, size) if found else None


def main(run: str, words: list[str]) -> int:
    found = read_plan(words)
    if found is None:
        return 1
    rows = [row for job in found[0] if not job.cases and (row := measured(job, run))]
    kept = [row for row in measured_rows() if row.run != run] if TABLE.exists() else []
    machine = processor_type().split("-")[0]
    with whole_file(TABLE) as partial, partial.open("w", newline="") as file:
        file.write(f"# measured on a processor of type {machine}, {time.strftime('%B %Y')}\n")
        writer = csv.writer(file, delimiter="\t", lineterminator="\n")
        writer.writerow(["run", "rule", "job", "processor_s", "memory_MB", "disk_MB"])
        for row in sorted([*kept, *rows], key=lambda row: (row.run, row.rule, row.job)):
            values = f"{row.processor_s:.1f}", f"{row.memory_mb:.0f}", f"{row.disk_mb:.2f}"
            writer.writerow([row.run, row.rule, row.job, *values])
    print(f"{TABLE}: {len(rows)} jobs of the run {run}, {len(kept)} of others")
    return 0


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("run", help="name of the run (key `name`), such as thesis")
    parser.add_argument(
        "words", nargs=argparse.REMAINDER, help="targets and arguments of Snakemake as in that run, such as --cores 2"
    )
    given = parser.parse_args()
    sys.exit(main(given.run, given.words))
