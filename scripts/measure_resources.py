"""Writes time and memory of every rule into a cluster profile, from the benchmarks of a run.

    python scripts/measure_resources.py [results/benchmarks] [workflow/profiles/slurm/config.yaml]

Time is TIMES the longest job, memory MARGIN times the largest and what its Snakemake takes beside it; FEWEST_MIN and
FEWEST_MB at least, for a run of larger cases than those measured. Simulations and trainings know their time themselves
(workflow/rules/dem.smk, surrogate.smk).
"""

import math
import sys
from pathlib import Path

import pandas as pd

from millprint.config.checks import stop_on_bad_input
from millprint.errors import ConfigError
from millprint.files import read_table, whole_file

MARK = "# --- measured ---\n"
TIMES, FEWEST_MIN, STEP_MIN = 4, 30, 15
MARGIN, FEWEST_MB, SNAKEMAKE_MB, STEP_MB = 1.5, 1500, 300, 250
OWN_TIME = ("run_dem_case", "train_surrogate")


def read_benchmarks(folder: Path) -> pd.DataFrame:
    """A row a job: rule, seconds, largest resident memory [MB]; the rule is the name of the benchmark's folder."""
    rows = []
    for path in sorted(folder.rglob("*.tsv")):
        table = read_table(path, numeric=["s", "max_rss"])
        rows.append((path.relative_to(folder).parts[0], table["s"].max(), table["max_rss"].max()))
    if not rows:
        raise ConfigError(f"{folder}: no benchmarks; run the workflow first")
    return pd.DataFrame(rows, columns=["rule", "s", "max_rss"])


def resources_text(jobs: pd.DataFrame, source: str) -> str:
    """The section set-resources of a profile."""
    lines = [f"# From {source}: {len(jobs)} jobs.", "set-resources:"]
    for rule, own in jobs.groupby("rule"):
        seconds, memory = own["s"].max(), own["max_rss"].max()
        asked_mb = max(FEWEST_MB, STEP_MB * math.ceil((MARGIN * memory + SNAKEMAKE_MB) / STEP_MB))
        lines.append(f"  {rule}: # {len(own)} measured, up to {seconds:.0f} s and {memory:.0f} MB")
        if rule not in OWN_TIME:
            minutes = max(FEWEST_MIN, STEP_MIN * math.ceil(TIMES * seconds / 60 / STEP_MIN))
            lines.append(f"    runtime: {minutes}")
        lines.append(f"    mem_mb: {asked_mb}")
    return "\n".join(lines) + "\n"


def main(benchmarks: str = "results/benchmarks", profile: str = "workflow/profiles/slurm/config.yaml") -> None:
    folder, path = Path(benchmarks), Path(profile)
    run = folder.parent / "report/run.yaml"
    name = run.read_text().split("name: ", 1)[1].split("\n", 1)[0] if run.is_file() else "a part of one"
    kept = path.read_text().split(MARK)[0]
    text = resources_text(read_benchmarks(folder), f"the run {name}")
    with whole_file(path) as partial:
        partial.write_text(kept + MARK + text)


if __name__ == "__main__":
    with stop_on_bad_input():
        main(*sys.argv[1:])
