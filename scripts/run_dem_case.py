"""Simulates the cases of a job, one after another; those that are finished stay as they are."""

import sys
from pathlib import Path
from typing import NamedTuple

from millprint.config.contact import ContactConfig
from millprint.config.mill import MillConfig
from millprint.config.sweep import Case, DemConfig, threads_of
from millprint.dem.batches import is_finished, origin_digest, set_apart, take_back
from millprint.dem.run import run_case
from millprint.job import job


class Given(NamedTuple):
    """What a case is simulated with."""

    mill: MillConfig
    contact: ContactConfig
    dem: DemConfig
    threads: int


def simulate(case: Case, given: Given, files: tuple[str, str], log: str, origin: str) -> bool:
    """Simulate a case unless it is finished; False if it failed, after its log and a line on stderr have said why."""
    if is_finished(origin, log, files):
        return True
    wanted = threads_of(case, given.dem)
    if given.threads < wanted:
        print(
            f"warning: {case.path} has {wanted} threads and gets {given.threads} cores, "
            "so that it is slower; raise --cores",
            file=sys.stderr,
        )
    try:
        with job(log, f"DEM {case.path}", origin):
            run_case(case, given.mill, given.contact, given.dem, *files, cores=given.threads)
    except SystemExit:
        return False
    return True


if "snakemake" in globals():
    plain, output, settings = snakemake.params.given, snakemake.output, snakemake.params.settings
    cases = [Case(**values) for values in plain["cases"]]
    done: dict[str, tuple[str, str]] = {}
    for case, log, *files in zip(cases, plain["logs"], output.run, output.summary, strict=True):
        take_back(files)
        mill, contact = plain["mills"][case.mill], plain["contacts"][case.contact]
        values = [case.model_dump(mode="json"), mill, contact, settings, snakemake.params.program]
        origin = origin_digest(values, plain["sources"][case.mill])
        given = Given(MillConfig(**mill), ContactConfig(**contact), DemConfig(**settings), snakemake.threads)
        if simulate(case, given, tuple(files), log, origin):
            done[case.path] = tuple(files)
    if snakemake.log[0] not in plain["logs"]:
        lines = [f"{'done' if case.path in done else 'failed'}: {case.path}" for case in cases]
        Path(snakemake.log[0]).write_text("\n".join(lines) + "\n")
    if len(done) < len(cases):
        for files in done.values():
            set_apart(files)
        raise SystemExit(1)
