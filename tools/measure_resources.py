"""Writes time and memory of every rule into a cluster profile, from the benchmarks of a run.

The time is TIMES that of the longest job. The memory is MARGIN times that of the largest job, plus that of Snakemake.
Rules that need no more than the default of the profile are left out. The rules of simulations set their own time and
memory, and those of trainings their own time (workflow/rules/dem.smk, surrogate.smk).
"""

import argparse
import math
from pathlib import Path

import pandas as pd

from millprint.config.checks import stop_on_bad_input
from millprint.config.errors import ConfigError
from millprint.run.files import read_table, whole_file

MARK = "# --- measured ---\n"
# default-resources of the profile [min], [MB].
DEFAULT_MIN, DEFAULT_MB = 30, 1500
TIMES, STEP_MIN = 4, 15
MARGIN, SNAKEMAKE_MB, STEP_MB = 1.5, 300, 250
# Nothing else may run on the node during the timing.
FURTHER = {"time_surrogates": {"slurm_extra": "\"'--exclusive'\""}}
OWN_TIME = ("train_surrogate",)
OWN_TIME_AND_MEMORY = ("run_dem_case",)


def read_benchmarks(folder: Path) -> pd.DataFrame:
    """A row for each job: rule (the folder of its benchmark), time [s], largest resident memory [MB]."""
    rows = []
    for path in sorted(folder.rglob("*.tsv")):
        table = read_table(path, numeric=["s", "max_rss"])
        rows.append((path.relative_to(folder).parts[0], table["s"].max(), table["max_rss"].max()))
    if not rows:
        raise ConfigError(f"{folder}: no benchmarks; run the workflow first")
    return pd.DataFrame(rows, columns=["rule", "s", "max_rss"])


def resources_text(jobs: pd.DataFrame, source: str) -> str:
    """The text of the section set-resources of a profile."""
    lines = [f"# From {source}: {len(jobs)} jobs.", "set-resources:"]
    for rule, own in jobs.groupby("rule"):
        seconds, memory = own["s"].max(), own["max_rss"].max()
        asked_mb = STEP_MB * math.ceil((MARGIN * memory + SNAKEMAKE_MB) / STEP_MB)
        minutes = STEP_MIN * math.ceil(TIMES * seconds / 60 / STEP_MIN)
        asked = {}
        if minutes > DEFAULT_MIN and rule not in OWN_TIME + OWN_TIME_AND_MEMORY:
            asked["runtime"] = minutes
        if asked_mb > DEFAULT_MB and rule not in OWN_TIME_AND_MEMORY:
            asked["mem_mb"] = asked_mb
        asked |= FURTHER.get(rule, {})
        if asked:
            lines.append(f"  {rule}: # {len(own)} measured, up to {seconds:.0f} s and {memory:.0f} MB")
            lines += [f"    {name}: {value}" for name, value in asked.items()]
    return "\n".join(lines) + "\n"


def main(benchmarks: str, profile: str) -> None:
    """Write the measured part of a profile."""
    folder, path = Path(benchmarks), Path(profile)
    run = folder.parent / "report/run.yaml"
    name = run.read_text().split("name: ", 1)[1].split("\n", 1)[0] if run.is_file() else "a part of one"
    kept = path.read_text().split(MARK)[0]
    text = resources_text(read_benchmarks(folder), f"the run {name}")
    with whole_file(path) as partial:
        partial.write_text(kept + MARK + text)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("benchmarks", nargs="?", default="results/benchmarks", help="folder (default: %(default)s)")
    parser.add_argument("profile", nargs="?", default="profiles/slurm/config.yaml", help="file (default: %(default)s)")
    given = parser.parse_args()
    with stop_on_bad_input():
        main(given.benchmarks, given.profile)
