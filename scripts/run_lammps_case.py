"""Simulates a case by LAMMPS.

Settings: dem; the case, its mill and its contact set.
Inputs: `sources`: the files of the mill's geometry and motion.
Outputs: `run` (run.h5) and `summary` (summary.json). A stopped case continues from a restart file in the folder lammps/
next to them, which also keeps the input and the log.
"""

from millprint.config.contact_set import ContactConfig
from millprint.config.mill import MillConfig
from millprint.config.sweep import Case
from millprint.config.workflow import EngineConfig
from millprint.dem.lammps.lammps_case import run_lammps
from millprint.run.job import job

if "snakemake" in globals():
    given, output = snakemake.params.simulation, snakemake.output
    case, mill, contact = Case(**given["case"]), MillConfig(**given["mill"]), ContactConfig(**given["contact"])
    resources = snakemake.resources
    dem = EngineConfig(**given["settings"], lammps={"command": resources.command, "ranks": resources.tasks})
    with job(snakemake.log[0], f"LAMMPS {case.path}", given["benchmark"]):
        run_lammps(case, mill, contact, dem, output.run, output.summary, launcher=resources.mpi)
