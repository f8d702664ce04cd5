"""Says what a run would do, before anything runs: simulations, jobs, time, memory and disk.

    python scripts/plan_run.py [TARGET ...] [ARGUMENTS OF SNAKEMAKE]

The arguments are those of your run, such as --cores 4 --configfile config/smoke.yaml --config mill=planetary. Nothing
is changed. With several targets, each is also estimated by itself.
"""

import io
import os
import shlex
import sys
from contextlib import redirect_stdout
from pathlib import Path
from typing import Any

from snakemake.api import SnakemakeApi
from snakemake.cli import parse_args, parse_config
from snakemake.settings.enums import PrintDag
from snakemake.settings.types import (
    ConfigSettings,
    DAGSettings,
    DeploymentSettings,
    OutputSettings,
    Quietness,
    ResourceSettings,
    StorageSettings,
    WorkflowSettings,
)

from millprint.config.contact import ContactConfig
from millprint.config.mill import MillConfig
from millprint.config.sweep import Case, DemConfig
from millprint.plan.estimate import estimate_plan, free_mb
from millprint.plan.jobs import PlannedJob, planned_case
from millprint.plan.text import plan_text

QUIET = {Quietness.RULES, Quietness.PROGRESS, Quietness.HOST, Quietness.REASON}


def read_plan(words: list[str]) -> tuple[list[PlannedJob], dict[str, int], dict, int] | None:
    """The jobs of the run with these arguments of Snakemake, places of its targets, configuration, number of cores.

    None if Snakemake refuses them; then it has said why.
    """
    _, args = parse_args(words)
    cores = args.cores or args.jobs or os.cpu_count() or 1
    with SnakemakeApi(OutputSettings(quiet=QUIET, enable_file_logging=False)) as api:
        try:
            workflow_api = api.workflow(
                resource_settings=ResourceSettings(cores=cores, overwrite_threads=args.set_threads),
                config_settings=ConfigSettings(parse_config(args.config), args.configfile, config_args=args.config),
                storage_settings=StorageSettings(),
                workflow_settings=WorkflowSettings(),
                deployment_settings=DeploymentSettings(),
                snakefile=args.snakefile,
                workdir=args.directory,
            )
            dag_api = workflow_api.dag(
                DAGSettings(
                    targets=args.targets,
                    forcetargets=args.force,
                    forceall=args.forceall,
                    forcerun=args.forcerun,
                    until=args.until,
                    omit_from=args.omit_from,
                    force_incomplete=args.rerun_incomplete,
                    rerun_triggers=args.rerun_triggers,
                    max_checksum_file_size=args.max_checksum_file_size,
                    print_dag_as=str(PrintDag.DOT),
                )
            )
            # The graph is made as for `snakemake --dag`, which changes nothing; its text is not of interest.
            with redirect_stdout(io.StringIO()):
                dag_api.printdag()
            # Snakemake shows the graph itself to nobody else.
            workflow = workflow_api._workflow
            jobs = list(workflow.dag.jobs)
            places = {job: place for place, job in enumerate(jobs)}
            planned = [translate(job, workflow.dag, places, workflow.globals) for job in jobs]
            # Snakemake keeps them in no order; here they stand as they were given.
            named = {name: places[job] for job in workflow.dag.targetjobs for name in target_names(job, words)}
            targets = dict(sorted(named.items(), key=lambda each: words.index(each[0]) if each[0] in words else -1))
            found = planned, targets, dict(workflow.globals["config"]), cores
        except Exception as error:
            api.print_exception(error)
            return None
    # Snakemake has come back from the working folder of the run, where the files of the plan are.
    os.chdir(args.directory or ".")
    return found


def target_names(job: Any, words: list[str]) -> list[str]:
    """The files of a job that were asked for; if none was, its first file, or the name of its rule."""
    files = [str(file) for file in job.output]
    return [file for file in files if file in words] or files[:1] or [job.rule.name]


def translate(job: Any, dag: Any, places: dict, names: dict) -> PlannedJob:
    """A job of Snakemake as a record. The jobs of a target itself have no stage."""
    log = Path(job.log[0]) if job.log else None
    outputs = tuple(Path(str(file)) for file in job.output)
    benchmark = Path(str(job.benchmark)) if job.benchmark else None
    if benchmark:
        own = benchmark.relative_to(names["BENCHMARKS"]).with_suffix("").parts[1:]
    else:
        own = log.relative_to(names["LOGS"]).with_suffix("").parts[1:] if log else (job.rule.name,)
    return PlannedJob(
        rule=job.rule.name,
        stage=log.relative_to(names["LOGS"]).parts[0] if log else "",
        name="/".join(own),
        needed=dag.needrun(job),
        missing=not all(path.exists() for path in outputs),
        threads=job.threads,
        after=tuple(places[before] for before in dag.dependencies[job]),
        benchmark=benchmark,
        log=log,
        outputs=outputs,
        cases=simulations_of(job),
    )


def simulations_of(job: Any) -> tuple:
    """The cases of a job of the DEM, which its rule gives to its script as plain values; none of any other job."""
    given = job.params.get("given")
    if not isinstance(given, dict) or "cases" not in given:
        return ()
    dem = DemConfig(**job.params.settings)
    mills = {name: MillConfig(**plain) for name, plain in given["mills"].items()}
    contacts = {name: ContactConfig(**plain) for name, plain in given["contacts"].items()}
    return tuple(
        planned_case(case, dem, mills[case.mill], contacts[case.contact], Path(summary).exists())
        for case, summary in zip((Case(**plain) for plain in given["cases"]), job.output.summary, strict=True)
    )


def main(words: list[str]) -> int:
    if "--help" in words or "-h" in words:
        print(__doc__)
        return 0
    found = read_plan(words)
    if found is None:
        return 1
    jobs, targets, config, cores = found
    estimate = estimate_plan(jobs, config["name"], dict.fromkeys([cores, 1, 4, 16]))
    shown = words[:-1] if words[-1:] == ["--"] else words
    command = shlex.join(["snakemake", *([] if "--cores" in words else ["--cores", str(cores)]), *shown])
    results = config["results"].rstrip("/")
    print(plan_text(estimate, targets, cores, results, free_mb(results), command))
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
