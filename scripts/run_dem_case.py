"""Simulates the cases of a job, one after another; those that are finished stay as they are."""

import sys
from pathlib import Path

from millprint.config.contact import ContactConfig
from millprint.config.mill import MillConfig
from millprint.config.sweep import Case, DemConfig, threads_of
from millprint.dem.run import run_case
from millprint.dem.seeds import is_finished, origin_digest, set_apart, take_back
from millprint.job import job
from millprint.records import digest


def simulate(case: Case, given, threads: int, files: tuple[str, str], log: str, origin: str) -> bool:
    """Simulate a case unless it is finished; False if it failed, after its log and a line on stderr have said why."""
    if is_finished(origin, log, files):
        return True
    dem = DemConfig(**given.settings)
    if threads < threads_of(case, dem):
        print(
            f"warning: {case.path} has {threads_of(case, dem)} threads and gets {threads} cores, "
            "so that it is slower; raise --cores",
            file=sys.stderr,
        )
    try:
        with job(log, f"DEM {case.path}", origin):
            run_case(case, MillConfig(**given.mill), ContactConfig(**given.contact), dem, *files, cores=threads)
    except SystemExit:
        return False
    return True


if "snakemake" in globals():
    given, output = snakemake.params, snakemake.output
    cases = [Case(**plain) for plain in given.cases]
    done: dict[str, tuple[str, str]] = {}
    for case, log, *files in zip(cases, given.logs, output.run, output.summary, strict=True):
        take_back(files)
        values = [case.model_dump(mode="json"), given.mill, given.contact, given.settings, given.library]
        origin = origin_digest([*values, digest(__file__)], snakemake.input.sources)
        if simulate(case, given, snakemake.threads, tuple(files), log, origin):
            done[case.path] = tuple(files)
    if snakemake.log[0] not in given.logs:
        lines = [f"{'done' if case.path in done else 'failed'}: {case.path}" for case in cases]
        Path(snakemake.log[0]).write_text("\n".join(lines) + "\n")
    if len(done) < len(cases):
        for files in done.values():
            set_apart(files)
        raise SystemExit(1)
