"""Run times of all jobs of a run, from their benchmarks or, without one, from their logs."""

import re
from pathlib import Path

import pandas as pd

from millprint.run.files import read_table

RUNTIME_COLUMNS = ["stage", "job", "wall_s", "processor_s", "memory_MB"]
# The line that millprint.run.job writes at the end of a job.
DONE = re.compile(r": done in ([\d.]+) s$", re.MULTILINE)


def _row(folder: Path, path: Path, **times: float) -> dict:
    inside = path.relative_to(folder).with_suffix("")
    return {"stage": inside.parts[0], "job": "/".join(inside.parts[1:]) or inside.name, **times}


def _benchmarks(folder: Path) -> list[dict]:
    found = []
    for path in sorted(folder.rglob("*.tsv")):
        table = read_table(path, numeric=["s", "cpu_time", "max_rss"])
        row = table.iloc[-1]
        found.append(_row(folder, path, wall_s=row["s"], processor_s=row["cpu_time"], memory_MB=row["max_rss"]))
    return found


def _logs(folder: Path) -> list[dict]:
    found = []
    for path in sorted(folder.rglob("*.log")):
        times = DONE.findall(path.read_text(errors="replace"))
        if times:
            found.append(_row(folder, path, wall_s=float(times[-1])))
    return found


def tabulate_runtimes(benchmarks: Path, logs: Path) -> pd.DataFrame:
    """A row for every job that has ended: stage, job, wall_s and, of those with a benchmark, processor_s, memory_MB.

    benchmarks: the folder of Snakemake's benchmark files; logs: that of the jobs' own logs, laid out alike.
    """
    rows = _benchmarks(Path(benchmarks))
    known = {(row["stage"], row["job"]) for row in rows}
    rows += [row for row in _logs(Path(logs)) if (row["stage"], row["job"]) not in known]
    table = pd.DataFrame(rows, columns=RUNTIME_COLUMNS)
    return table.sort_values(["stage", "job"], ignore_index=True)


def sum_stages(runtimes: pd.DataFrame) -> pd.DataFrame:
    """Jobs, wall time and processor time [min] of every stage, and the longest job."""
    groups = runtimes.groupby("stage", sort=False)
    longest = runtimes.loc[groups["wall_s"].idxmax()].set_index("stage")
    return pd.DataFrame(
        {
            "jobs": groups.size(),
            "wall_min": groups["wall_s"].sum() / 60,
            "processor_min": groups["processor_s"].sum(min_count=1) / 60,
            "longest_job": longest["job"],
            "longest_s": longest["wall_s"],
        }
    ).reset_index()
