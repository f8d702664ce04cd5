"""What planning a run of many simulations costs, and how much of it is Snakemake's own part."""

import sys
from collections.abc import Iterator
from pathlib import Path

import yaml

# 20 fill ratios and 15 settings, of speed and ball size, give the cases with the seeds.
FILLS = [round(0.06 + 0.01 * step, 2) for step in range(20)]
SPEEDS = [float(speed) for speed in range(200, 410, 21)]
SIZES_MM = [10.0, 9.0, 8.0, 7.0, 6.0, 5.0]

# The same jobs with nothing behind them: one waits for the first, a last one for all.
PLAIN = """rule all:
    input: [f"cases/{{number}}" for number in range({jobs})]
    output: "all"
    shell: "touch {{output}}"
rule first:
    output: "first"
    shell: "touch {{output}}"
rule case:
    input: "first"
    output: "cases/{{number}}"
    log: "logs/{{number}}"
    params: number=lambda wildcards: wildcards.number
    shell: "touch {{output}}"
"""


def write_project(folder: Path, mills: Path, cases: int) -> int:
    """Write a configuration and a mill with about so many cases to a new folder; returns how many it has.

    mills: the folder of the mills of the box; the planetary mill gets the sweep.
    """
    mill = yaml.safe_load((mills / "planetary.yaml").read_text())
    seeds = max(1, round(cases / (len(FILLS) * 15)))
    fills = FILLS if cases >= 300 else FILLS[: max(3, round(cases / 15))]
    mill["name"] = "grown"
    mill["sweep"] = {
        "speeds_rpm": SPEEDS[:10],
        "ball_diameters_mm": SIZES_MM,
        "fill_ratios": fills,
        "seeds": list(range(seeds)),
    }
    (folder / "config/mills").mkdir(parents=True)
    (folder / "config/mills/grown.yaml").write_text(yaml.safe_dump(mill))
    (folder / "config/config.yaml").write_text(yaml.safe_dump({"name": "growth", "mill": "grown"}))
    return len(fills) * 15 * seeds


def write_plain(folder: Path, jobs: int) -> None:
    """Write a workflow of so many empty jobs to a new folder."""
    folder.mkdir()
    (folder / "Snakefile").write_text(PLAIN.format(jobs=jobs))


def commands(snakefile: Path, plain: Path, whole: Path, run_plain: bool) -> Iterator[tuple[str, Path, list[str]]]:
    """What is measured: its name, its folder and its command. All have the options of our profile."""
    profile = snakefile.parent / "profiles/default"
    snakemake = [sys.executable, "-m", "snakemake", "--workflow-profile", str(profile)]
    ours = ["--snakefile", str(snakefile)]
    yield "reading the Snakefile", whole, [*snakemake, *ours, "--list-target-rules"]
    yield "dry run", whole, [*snakemake, *ours, "-n", "--quiet", "rules", "--", "fingerprint"]
    yield "dry run, Snakemake alone", plain, [*snakemake, "-n", "--quiet", "rules"]
    if run_plain:
        yield "scheduling, Snakemake alone", plain, [*snakemake, "--cores", "1", "--quiet"]
