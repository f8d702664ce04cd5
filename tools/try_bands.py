"""Asks the bands of finished fingerprints for new seeds: python -m tools.try_bands FOLDER RUN.yaml ... [--seeds 7].

FOLDER is where `millprint fingerprint RUN.yaml` was run. The lowest and the highest fill ratio, each at the other end
of the speeds, are simulated with new seeds; the eight conditions between, with new seeds too, are of the run. Writes a
row for each mill to docs/why/band_trials.tsv, and the table of docs/why/uncertainty.md.
"""

import argparse
import contextlib
import re
from datetime import date
from pathlib import Path

import numpy as np
import pandas as pd
from tools.run_tables import places, this_machine

from millprint.cases.of_mill import HELD_OUT_SEED
from millprint.cases.simulate import simulate_cases
from millprint.cases.table import CaseTable, Why
from millprint.config.checks import load_workflow
from millprint.config.included import SOURCES, read_run
from millprint.config.sweep import Case
from millprint.estimate.judge import AGREES
from millprint.fingerprint.coverage import describe_each, predict_held_out
from millprint.fingerprint.model import Fingerprint
from millprint.fingerprint.readers import read_summaries
from millprint.run.files import read_json, read_table, whole_file, write_table

ROOT = Path(__file__).parents[1]
TABLE, PAGE = (ROOT / "docs/why" / name for name in ("band_trials.tsv", "uncertainty.md"))
POWER = "Pw"


def ends_of(cases: list[Case]) -> list[Case]:
    """A case of the lowest fill ratio at the highest speed, and of the highest fill ratio at the lowest speed."""
    return [max(cases, key=lambda case: (sign * case.fill_ratio, -sign * case.speed_hz)) for sign in (-1, 1)]


def counted(rows: pd.DataFrame, place: str) -> dict[str, object]:
    """Bands that are known and those that held, of all and of the power of the walls, and half of its band [%]."""
    known = rows.dropna(subset=["lower", "upper"])
    power, held = known[known["quantity"] == POWER], known["verdict"] == AGREES
    half = 100 * np.median(np.sqrt(power["upper"] / power["lower"]) - 1)
    return {
        f"{place}_bands": len(known), f"{place}_held": held.sum(), f"{place}_unknown": len(rows) - len(known),
        f"{place}_powers": len(power), f"{place}_powers_held": held[power.index].sum(), f"{place}_half_percent": half,
    }  # fmt: skip


def try_run(run: str, seeds: int) -> dict[str, object]:
    """A row of the table, for a run in the present folder."""
    config, mills, contacts, _ = load_workflow(read_run(run), [run], SOURCES)
    mill, contact, results = mills[config.mill], contacts[config.mills.contact_set], Path(config.results)
    own = CaseTable(config, mills, contacts).cases(Why.MILL, mill.name)
    fingerprint = Fingerprint.read(results / "mills" / mill.name / "fingerprint.json")
    later = range(2 * HELD_OUT_SEED, 2 * HELD_OUT_SEED + seeds)
    new = [case.model_copy(update={"seed": seed}) for case in ends_of(list(own.values())) for seed in later]
    folder = results / "new_seeds"
    simulate_cases({case.name: case for case in new}, mill, contact, config.dem, folder, 1)
    found = describe_each(read_summaries(folder / case.name / "summary.json" for case in new), config.mills.rule)
    summaries = [read_json(results / "dem" / path / "summary.json") for path in own]
    balls = sorted(summary["balls"] for summary in summaries)
    return {
        "mill": mill.name,
        "motion": mill.motion.kind if not mill.inserts else "stirred",
        "shape": mill.geometry.kind,
        "precision": config.mills.precision,
        "balls": f"{balls[0]} to {balls[-1]}",
        **counted(predict_held_out(fingerprint, found), "simulated"),
        **counted(read_table(results / "mills" / mill.name / "held_out.tsv"), "between"),
        "processor_s": sum(summary["processor_s"] for summary in summaries),
        **this_machine(date.today().isoformat(), ROOT),
    }


def block(trials: pd.DataFrame) -> str:
    """The table of the page, and the sums of its rows."""
    lines = [
        f"{places(trials)}:",
        "",
        "| mill | balls | held, where simulated: all; power | half of the power's band (median, %) | held, between "
        "| not known, of both | processor time of the simulations (s) |",
        "|---|---|---|---|---|---|---|",
    ]
    for row in trials.itertuples():
        lines.append(
            f"| {row.mill} ({row.motion.replace('_', ' ')}, {row.shape}) | {row.balls} | "
            f"{row.simulated_held} of {row.simulated_bands}; {row.simulated_powers_held} of {row.simulated_powers} | "
            f"{row.simulated_half_percent:.2g} | {row.between_held} of {row.between_bands} | "
            f"{row.simulated_unknown}, {row.between_unknown} | {row.processor_s:.0f} |"
        )
    total = trials.sum(numeric_only=True)
    shares = ", ".join(
        f"{where} {total[f'{place}_held']:.0f} of {total[f'{place}_bands']:.0f} bands "
        f"({100 * total[f'{place}_held'] / total[f'{place}_bands']:.0f} %)"
        for place, where in (("simulated", "where simulated"), ("between", "between"))
    )
    return "\n".join([*lines, "", f"Together, {shares} of all quantities held.", ""])


def main() -> None:
    """Try the runs, and write the table and its page."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("runs", nargs="+", metavar="RUN.yaml")
    parser.add_argument("--seeds", type=int, default=7)
    options = parser.parse_args()
    with contextlib.chdir(options.folder):
        rows = pd.DataFrame([try_run(run, options.seeds) for run in options.runs])
    if TABLE.exists():
        before = read_table(TABLE)
        rows = pd.concat([before[~before["mill"].isin(rows["mill"])], rows], ignore_index=True)
    write_table(rows, TABLE)
    page = re.compile(r"(<!-- table: python -m tools.try_bands -->\n).*?(<!-- end -->)", re.S)
    text = PAGE.read_text()
    with whole_file(PAGE) as draft:
        draft.write_text(page.sub(lambda found: found[1] + block(read_table(TABLE)) + found[2], text))


if __name__ == "__main__":
    main()
