"""Stores the verdicts of a run, and writes them into README, paper and pages: python tools/store_verdicts.py.

The verdicts and the surrogate with its baselines get this machine's processor, the commit of the tree that the run
lies in, and the date; a run on the same processor takes the place of the earlier one. Whoever runs the thesis on
another machine is then told which verdicts differ from those in config/data/verdicts_elsewhere.tsv. Of the newest
stored run, the blocks of TEXTS between two comments are written, and the numbers of config/data/stated_numbers.tsv.
"""

import argparse
import datetime
import re
import textwrap
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import pandas as pd

from millprint.config.checks import stop_on_bad_input
from millprint.config.load import read_yaml
from millprint.config.setup_models import FILES
from millprint.estimate.judge import AGREES, DIFFERS, NOT_RUN, OPEN, VERDICTS
from millprint.run.files import read_table, write_table
from millprint.run.tables import Text, read_measured
from millprint.thesis.claims.conclusions import (
    HOLDINGS,
    HOLDS,
    MACHINE,
    OURS,
    in_prose,
    judge_conclusions,
    read_conclusions,
    read_stored,
    store,
    this_machine,
)
from millprint.thesis.claims.evidence import ASSUMED, CERTAIN, NATURES
from millprint.thesis.claims.tabulate import count_natures, read_claims
from millprint.thesis.surrogate.measures import against_baselines, told_against
from millprint.validation.measured import read_measurements
from millprint.validation.setups import setup_named
from millprint.validation.verdicts import EVERY, tabulate_coverage

DATA = Path("config/data")
TABLE = str(DATA / "verdicts_elsewhere.tsv")
BASELINES, TIMINGS = "docs/why/surrogate_baselines.tsv", "benchmarks/timings.tsv"
VALIDATION = "docs/why/validation_verdicts.tsv"
# A block of a text, between comments with its name.
BLOCK = re.compile(r"(<!-- (?P<name>\w+): python tools/store_verdicts.py -->\n).*?(<!-- end -->)", re.S)
TEXTS = ("README.md", "paper.md", "docs/why/claims.md", "docs/why/surrogate.md", "docs/why/validation.md")
# Rows and columns of the tables of docs/why/surrogate.md, by the names in BASELINES.
TESTS = {"trained": "of the training", "motion1": "unseen: motion 1", "motion2": "unseen: motion 2",
         "post": "unseen: jar with a post"}  # fmt: skip
MODELS = {
    "thesis": "networks", "no_network": "no network", "scaled_power": "scaled power", "scaled_motion": "scaled motion",
    "long_step": "DEM, step of 8e-6 s", "other_seed": "another seed of the DEM",
}  # fmt: skip
STATED = ("document", "text", "source", "rows", "column")


# By stored table: that of a run, and the column whose values in a run take the place of earlier rows.
STORED_TABLES = {
    BASELINES: ("surrogate/baselines.tsv", "processor"),
    VALIDATION: ("validation/verdicts.tsv", "setup"),
}


def store_tables(results: Path, machine: dict[str, str]) -> list[str]:
    """Put the tables that the run in the folder `results` has in the place of the stored ones; returns which."""
    done = []
    for path, (source, replaced) in STORED_TABLES.items():
        if (results / source).exists():
            own = read_table(results / source).assign(**machine)
            own = own[own["reason"] != NOT_RUN] if "reason" in own else own
            earlier = read_table(path) if Path(path).exists() else own.iloc[:0]
            earlier = earlier[~earlier[replaced].isin(own[replaced])]
            write_table(pd.concat([earlier, own], ignore_index=True), path)
            done.append(path)
    return done


def newest_run(root: Path) -> tuple[pd.DataFrame, pd.DataFrame, str]:
    """The claims with the verdicts of the newest stored run of the thesis, its conclusions, and where it ran."""
    claims, stored = read_claims(root / DATA / "claims.tsv").reset_index(drop=True), read_stored(root / TABLE)
    own = stored[stored["run"] == "thesis"].sort_values("date", kind="stable")
    # Arithmetic is the same on every machine.
    certain = own["id"].isin(claims.loc[claims["nature"].isin(CERTAIN), "id"])
    own = own[certain | (own["processor"] == own.loc[~certain, "processor"].iloc[-1])]
    machine = dict(zip(MACHINE, own.loc[~certain, MACHINE].value_counts().index[0], strict=True))
    own = own.drop_duplicates("id", keep="last")
    table = claims.rename(columns={"value": "published"}).merge(own, on="id", how="left")
    table = table.fillna({"verdict": OPEN} | dict.fromkeys(("interval_verdict", "reason", "reproduced"), ""))
    conclusions = judge_conclusions(read_conclusions(root / DATA / "conclusions.tsv", table["id"]), table)
    place = f"{machine['processor']}, {machine['instructions']}, commit {machine['commit'][:8]}, {machine['date']}"
    return table, conclusions, place


def blocks_of(root: Path) -> dict[str, str]:
    """What the newest run says, by the name of a block."""
    claims, conclusions, place = newest_run(root)
    natures = claims["nature"].value_counts()
    run = claims[(claims["verdict"] != OPEN) & ~claims["nature"].isin(CERTAIN)]
    decided = run["interval_verdict"].value_counts().reindex(list(VERDICTS), fill_value=0)
    held = conclusions[HOLDS].value_counts()
    nature = claims.set_index("id")["nature"]
    rests_on = [
        nature[ids].value_counts().reindex(list(NATURES)).dropna().astype(int)
        for ids in read_conclusions(root / DATA / "conclusions.tsv", claims["id"])["claims"]
    ]
    empty = sum(
        word == AGREES and set(own.index) <= {*CERTAIN, *ASSUMED}
        for word, own in zip(conclusions[HOLDS], rests_on, strict=True)
    )
    told = ", ".join(f"{words} ({held[word]})" for word, words in HOLDINGS.items() if word in held)
    numbers = (
        f"It judges {count_natures(claims)}. {len(conclusions)} conclusions rest on them. By the newest whole run that "
        f"is stored ({place}), they {told}. Of those that hold, {empty} rest on nothing but arithmetic on printed "
        f"numbers, and {held[AGREES] - empty} on simulations or trainings too. Of {len(run)} claims of "
        f"that run that are not arithmetic, {(run['verdict'] == AGREES).sum()} agree by their value; of "
        f"{decided.sum()} with an interval, {decided[AGREES]} agree by it, {decided[DIFFERS]} differ, and "
        f"{decided[OPEN]} are open."
    )
    meanings = [(f"`{name}`", words, natures[name]) for name, words in NATURES.items()]
    judged = [
        (
            f"{row.chapter.removeprefix('chapter ')}: {row.conclusion}",
            getattr(row, OURS),
            getattr(row, HOLDS),
            ", ".join(f"{number} {name.replace('_', ' ')}" for name, number in own.items()),
            "; ".join(in_prose(name, claims) for name in filter(None, row.against.split(", "))),
        )
        for row, own in zip(conclusions.itertuples(), rests_on, strict=True)
    ]
    head = ["conclusion", "our number", "it holds", "claims under it", "ours for theirs, where it differs"]
    processor = place.partition(",")[0]
    against = told_against(against_baselines(longest_rollouts(root, processor), "thesis"))
    return {
        "networks": textwrap.fill(against, 120),
        "numbers": textwrap.fill(numbers, 120),
        "natures": in_markdown(["nature", "how its value comes about", "claims"], meanings),
        "conclusions": f"Of the run {place}:\n\n{in_markdown(head, judged)}",
        "surrogate": surrogate_tables(root, processor),
    }


def longest_rollouts(root: Path, processor: str) -> pd.DataFrame:
    """What the networks and their baselines were off by on a processor, over the longest roll-outs."""
    own = read_table(root / BASELINES)
    own = own[own["processor"] == processor]
    return own[own["length_s"] == own["length_s"].max()]


def surrogate_tables(root: Path, processor: str) -> str:
    """The longest roll-outs of networks and baselines in three tables."""
    own = longest_rollouts(root, processor)
    printed = own.groupby("test")["thesis_percent"].first()

    def table(column: str, last: dict[str, str] | None = None) -> str:
        text = (
            own[column].map("{:.3g}".format).mask(own[column].isna(), "none").mask(own["ran_away"] == "yes", "ran away")
        )
        cells = text.groupby([own["test"], own["model"]]).agg(", ".join)
        lines = [
            [words, *(cells[test, model] for model in MODELS), *([last[test]] if last else [])]
            for test, words in TESTS.items()
        ]
        return in_markdown(["motion", *MODELS.values(), *(["printed in the thesis"] if last else [])], lines)

    stated = {test: "not stated" if pd.isna(printed[test]) else f"{printed[test]:g}" for test in TESTS}
    return "\n\n".join([
        f"A run of the whole thesis on {processor}, each test over {own['length_s'].iloc[0]:g} s. Error of the "
        "dissipated energy in per cent, a number for each training:",
        table("dissipation_error_percent", stated),
        "A small error of a sum can be two errors that cancel. Mean square speed of the balls over the DEM's:",
        table("mean_square_speed_ratio"),
        "Pearson's r between the energies dissipated in each 5 ms and the DEM's (`none`: the power is constant):",
        table("increments_5ms_r"),
    ])  # fmt: skip


def in_markdown(head: list[str], rows: Iterable[Iterable[object]]) -> str:
    """A table as Markdown."""
    lines, bar = [head, ["---"] * len(head), *rows], "\\|"
    return "\n".join(f"| {' | '.join(str(cell).replace('|', bar) for cell in line)} |" for line in lines)


def places(table: pd.DataFrame) -> str:
    """Where and when the rows of a stored table were made, in words."""
    rows = table[MACHINE].astype(str).drop_duplicates().itertuples(index=False)
    return "; ".join(f"{row.processor}, {row.instructions}, commit {row.commit}, {row.date}" for row in rows)


def validation_block(root: Path) -> str:
    """What is met of each quantity of each set-up, and how often intervals hold."""
    table = read_table(root / VALIDATION)
    rows = []
    for (setup, quantity, kind), own in table.groupby(["setup", "quantity", "class"], sort=False):
        if own["predicted"].isna().all():
            continue
        differs = own["verdict"] == DIFFERS
        explained = int(own.loc[differs, "explanation"].str.startswith("met by").sum())
        ratio = own["ratio"].dropna()
        spread = "" if ratio.empty else _span(ratio.min(), ratio.max())
        counts = len(own), int((own["verdict"] == AGREES).sum()), int(differs.sum()), explained
        rows.append((setup_named(str(setup)).title, quantity, kind, *counts, spread))
    head = ["set-up", "quantity", "compared with", "numbers", "agree", "differ", "explained", "ours over theirs"]
    held = [
        [
            EVERY if row.setup == EVERY else setup_named(row.setup).title,
            row.interval,
            row.held,
            row.numbers,
            f"{row.share:.2f}, {row.lower:.2f} to {row.upper:.2f}",
            row.overlapping,
        ]
        for row in tabulate_coverage(table).itertuples()
    ]
    held_head = ["set-up", "interval by", "held", "of", "share, 95 % interval", "reached by the measured interval"]
    words = "`explained`: by another contact law or contact set, of those that differ."
    measured = set(read_measurements(root / DATA / "measured.tsv", FILES)["setup"]) - set(table["setup"])
    lacking = "; ".join(setup_named(name).title for name in FILES if name in measured)
    missing = f" Not run since then: {lacking}." if lacking else ""
    told = textwrap.fill(f"Of runs on {places(table)}. {words}{missing}", 120)
    return "\n\n".join([told, in_markdown(head, rows), in_markdown(held_head, held)])


def _span(lower: float, upper: float) -> str:
    """Two numbers, or one where they are printed alike."""
    ends = [f"{end:.2f}" for end in (lower, upper)]
    return ends[0] if ends[0] == ends[1] else " to ".join(ends)


def speed(root: Path) -> str:
    """How many times as long as ours a step of LAMMPS took, on each processor that was timed."""
    table = read_table(root / TIMINGS)
    own = table[table["code"] == "LAMMPS"].round({"ratio_to_us": 1})
    told = []
    for (processor, commit, date), rows in own.groupby(["processor", "commit", "date"], sort=False):
        times, balls = (", ".join(map(str, rows[name])) for name in ("ratio_to_us", "balls"))
        place = f"{processor.partition(',')[0]}, {rows['instructions'].iloc[0]} (commit {commit[:8]}, {date})"
        told.append(f"{times} times as long with {balls} balls on {place}")
    return textwrap.fill(f"LAMMPS took {'; '.join(told)}.", 120)


# Blocks that do not depend on the verdicts of the thesis.
OWN_BLOCKS = {"speed": speed, "validation": validation_block}


def written(root: Path, document: str) -> str:
    """The text of a document with its blocks, and its numbers of stated_numbers.tsv, as the stored tables have them."""
    text, blocks = (root / document).read_text(), blocks_of(root)

    def block(found: re.Match[str]) -> str:
        name = found["name"]
        return f"{found[1]}{OWN_BLOCKS[name](root) if name in OWN_BLOCKS else blocks[name]}\n{found[3]}"

    text = BLOCK.sub(block, text)
    stated = read_measured(root / DATA / "stated_numbers.tsv", [Text(name, may_be_blank=True) for name in STATED])
    for row in stated[stated["document"] == document].fillna("").itertuples():
        before, after = (r"\s+".join(map(re.escape, part.split(" "))) for part in row.text.split("{}"))
        place = re.compile(f"({before})(-?[\\d.,]*\\d)({after})")
        if not place.search(text):
            raise ValueError(f"{document}: no number between {row.text!r}")
        text = place.sub(lambda found: f"{found[1]}{_like(found[2], number_of(root, row))}{found[3]}", text)  # noqa: B023
    return text


def number_of(root: Path, row: Any) -> float:
    """The number that a row of stated_numbers.tsv names: the first of a column, or of the newest rows."""
    lines = [line for line in (root / row.source).read_text().splitlines() if not line.startswith("#")]
    table = pd.DataFrame([line.split("\t") for line in lines[1:]], columns=lines[0].split("\t"))
    table = table.query(row.rows, engine="python") if row.rows else table
    table = table.sort_values("date", ascending=False, kind="stable") if "date" in table else table
    found = re.search(r"-?\d+(?:\.\d+)?(?:e-?\d+)?", table[row.column].iloc[0])
    assert found is not None, f"{row.source}: {row.column} has no number"
    return float(found[0])


def _like(old: str, value: float) -> str:
    """A number with as many decimals as the old one."""
    return f"{value:.{len(old.partition('.')[2])}f}"


def main(results: str, table: str, date: str) -> str:
    """Store what the run in the folder `results` has; returns what was done, in words."""
    machine, done = this_machine(date, results), store_tables(Path(results), this_machine(date, results))
    report = Path(results) / "report"
    if (report / "claims.tsv").exists():
        run = read_yaml(str(report / "run.yaml"))["name"]
        text = ["id", "verdict", "interval_verdict", "reason", "nature", "reproduced", "lower", "upper"]
        number = store(table, read_table(report / "claims.tsv", text=text), run, machine)
        done.append(f"{table} ({number} verdicts of the run {run})")
    return f"{', '.join(machine.values())}: {', '.join(done) or 'nothing'}"


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--results", default="results", help="folder of the run (default: %(default)s)")
    parser.add_argument("--table", default=TABLE, help="where verdicts are stored (default: %(default)s)")
    parser.add_argument("--texts", action="store_true", help="store nothing, and only write the texts again")
    given = parser.parse_args()
    with stop_on_bad_input():
        if not given.texts:
            print(main(given.results, given.table, datetime.date.today().isoformat()))
        for document in TEXTS:
            Path(document).write_text(written(Path(), document))
