"""Measures how cost grows: planning a run, fitting and asking a fingerprint, pages, simulations. Use an idle machine.

    python scripts/measure_growth.py [PART ...] [--cases 300 3000 30000] [--conditions 100 1000 10000]
        [--balls 24 764 20000 200000] [--threads 1 2] [--pages results/report/explorer.html ...]

Without a PART, all of planning, fingerprint, pages and simulation. It writes growth.tsv and a figure to --results;
rows that are not measured again stay. With --store it keeps them in config/data/growth.tsv, from which `make reference`
writes a page, with the figure beside it. What takes longer than --limit seconds is given up.
"""

import argparse
import sys
from collections.abc import Iterator
from pathlib import Path

import pandas as pd

from millprint.config.checks import stop_on_bad_input
from millprint.errors import ConfigError, MillprintError
from millprint.figures.growth import PANELS, draw_growth
from millprint.files import write_table
from millprint.growth.measure import (
    find_browser,
    measure_fingerprints,
    measure_pages,
    measure_planning,
    measure_simulations,
)
from millprint.growth.table import GROWTH_COLUMNS, PICTURE, STORED, kept_rows, read_growth, this_machine
from millprint.machine import prepare_environment

ROOT = Path(__file__).resolve().parents[1]


def read_arguments(words: list[str]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("parts", nargs="*", metavar="PART", help=", ".join(PANELS))
    parser.add_argument("--cases", nargs="+", type=int, default=[300, 3000, 30000])
    parser.add_argument("--conditions", nargs="+", type=int, default=[100, 300, 1000, 3000, 10000])
    parser.add_argument("--balls", nargs="+", type=int, default=[24, 191, 764, 20000, 200000])
    parser.add_argument("--threads", nargs="+", type=int, default=[1])
    parser.add_argument("--pages", nargs="+", type=Path, default=[])
    parser.add_argument("--descriptors", type=Path, default=Path("results/fingerprint/descriptors.tsv"))
    parser.add_argument("--results", type=Path, default=Path("results/growth"))
    parser.add_argument("--store", action="store_true", help=f"keep what is measured in {STORED}")
    parser.add_argument("--limit", type=float, default=1800.0, help="wall time of one measurement [s]")
    options = parser.parse_args(words)
    if unknown := set(options.parts) - set(PANELS):
        raise ConfigError(
            f"measure_growth.py: unknown part {', '.join(sorted(unknown))}; there are {', '.join(PANELS)}"
        )
    return options


def measured(options: argparse.Namespace, part: str) -> Iterator[dict]:
    """The rows of a part."""
    if part == "planning":
        return measure_planning(ROOT / "Snakefile", ROOT / "config/mills", options.cases, options.limit)
    if part == "fingerprint":
        return measure_fingerprints(options.descriptors, options.conditions, options.limit)
    if part == "pages":
        found = options.pages or sorted(Path("results").glob("report/*.html"))
        return measure_pages(found, find_browser(), options.limit)
    if part == "simulation":
        return measure_simulations(ROOT / "config/bench.yaml", options.balls, options.threads, options.limit)
    raise ValueError(f"unknown part {part}")


def main(words: list[str]) -> None:
    options = read_arguments(words)
    prepare_environment()
    path = ROOT / STORED if options.store else options.results / "growth.tsv"
    picture = ROOT / PICTURE if options.store else options.results / "growth.png"
    kept = read_growth(path) if path.exists() else pd.DataFrame(columns=GROWTH_COLUMNS)
    machine = this_machine()
    for part in options.parts or list(PANELS):
        for row in measured(options, part):
            print(f"{part}, {row['what']}, {row['size']:g} {row['unit']}: {row['processor_s']} s", file=sys.stderr)
            # After each, since the last ones take longest.
            kept = kept_rows(kept, [{**row, **machine}])
            write_table(kept, path)
    draw_growth(read_growth(path), options.results / "growth.svg", picture)


if __name__ == "__main__":
    try:
        with stop_on_bad_input():
            main(sys.argv[1:])
    except MillprintError as error:
        sys.exit(f"error: {error}")
