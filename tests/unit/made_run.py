"""A small run made by hand: what jobs and Snakemake would have left in a folder."""

import json
from base64 import urlsafe_b64encode
from pathlib import Path

import yaml

from millprint.provenance.crate import write_crate
from millprint.provenance.lineage import METADATA, read_jobs
from millprint.run.digest import write_record

CONFIG = {
    "name": "made",
    "results": "results",
    "mill": "emax",
    "contacts": ["calibrated", "steel"],
    "data": {"screening": "config/data/screening.tsv"},
    "provenance": {"agent": "", "orcid": "", "affiliation": "", "licence": ""},
}
RUN = "results/report/run.yaml"
BEGIN, END = 1_700_000_000.0, 1_700_000_060.0
MILL, SNAKEFILE = "config/mills/emax.yaml", "workflow/Snakefile"
# By output: rule, inputs, log, begin and end.
JOBS = {
    "results/doe/runs.tsv": ("read_runs", ["config/data/screening.tsv"], "doe/read_runs", BEGIN, BEGIN + 9.6),
    # A name with a sign that an address writes in another way.
    "results/doe/mean yield.svg": ("plot_runs", ["results/doe/runs.tsv"], "doe/plot_runs", BEGIN + 10, END),
    RUN: ("record_run", [], "report/record_run", BEGIN, BEGIN + 1),
}
TARGETS = ["results/doe/mean yield.svg", RUN]


def write(path: str, text: str) -> None:
    Path(path).parent.mkdir(parents=True, exist_ok=True)
    Path(path).write_text(text)


def keep_record(path: str, record: dict) -> None:
    """Write a record as Snakemake does, under a name that is cut where it is too long for a file."""
    name = urlsafe_b64encode(path.encode()).decode()
    parts = [name[i : i + 254] for i in range(0, len(name), 254)]
    place = METADATA.joinpath(*(f"@{part}" for part in parts[:-1]), parts[-1])
    write(str(place), json.dumps(record))


def make_run(config: dict = CONFIG) -> None:
    """Leave a finished run in the current folder."""
    for path in ("config/data/screening.tsv", MILL, SNAKEFILE, *JOBS):
        write(path, f"content of {path}\n")
    write(RUN, yaml.safe_dump(config))
    for output, (rule, inputs, log, begin, end) in JOBS.items():
        keep_record(output, {"rule": rule, "input": inputs, "starttime": begin, "endtime": end})
        write(f"results/logs/{log}.log", "x: begin\nx: done in 1.0 s\n")
        write_record(Path(f"results/logs/{log}.json"), [output])
    write("results/benchmarks/plot.tsv", "s\n1\n")
    write("results/.gitkeep", "")


def describe_run(targets=TARGETS) -> int:
    return write_crate("results", targets, [MILL], [SNAKEFILE], read_jobs())
