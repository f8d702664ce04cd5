"""Simulates a case.

Settings: dem; the case, its mill and its contact set, and their `identity`.
Inputs: `sources`: the files of the mill's geometry and motion.
Outputs: `run` (run.h5) and `summary` (summary.json). A stopped case continues from restart.h5 in their folder. The
tolerances that the run kept are in tolerances.json there.
"""

from millprint.cases.server import is_served

if "snakemake" in globals() and not is_served():
    import sys
    from pathlib import Path

    from millprint.config.contact_set import ContactConfig
    from millprint.config.identity import TOLERANCES, tolerances_of
    from millprint.config.mill import MillConfig
    from millprint.config.sweep import Case, DemConfig, threads_of
    from millprint.dem.run import run_case
    from millprint.run.files import write_json
    from millprint.run.job import job

    given, output = snakemake.params.simulation, snakemake.output
    case, mill, contact = Case(**given["case"]), MillConfig(**given["mill"]), ContactConfig(**given["contact"])
    dem = DemConfig(**given["settings"])
    wanted = threads_of(case, dem)
    if snakemake.threads < wanted:
        print(
            f"warning: {case.path} has {wanted} threads and gets {snakemake.threads} cores, "
            "so that it is slower; raise --cores",
            file=sys.stderr,
        )
    with job(snakemake.log[0], f"DEM {case.path}", given["benchmark"]):
        summary = run_case(case, mill, contact, dem, output.run, output.summary, cores=snakemake.threads)
        kept = tolerances_of(case, dem, summary, snakemake.params.identity["tolerances"])
        write_json(kept, Path(output.run).with_name(TOLERANCES))
