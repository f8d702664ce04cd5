"""Stores the verdicts of a run, and writes them into README, paper and pages: python tools/store_verdicts.py.

The verdicts and the tables of run_tables.py get this machine's processor, the commit of the tree that the run
lies in, and the date; a run on the same processor takes the place of the earlier one. Whoever runs the thesis on
another machine is then told which verdicts differ from those in config/data/verdicts_elsewhere.tsv. Of the newest
stored run, the blocks of TEXTS between two comments are written, and the numbers of config/data/stated_numbers.tsv.
"""

import argparse
import datetime
import re
import sys
import textwrap
from pathlib import Path
from typing import Any

import pandas as pd

from millprint.config.checks import stop_on_bad_input
from millprint.config.load import read_yaml
from millprint.estimate.judge import AGREES, DIFFERS, OPEN, VERDICTS
from millprint.run.files import read_table, write_table
from millprint.run.tables import Text, read_measured
from millprint.thesis.claims.conclusions import (
    HOLDINGS,
    HOLDS,
    MACHINE,
    OURS,
    STORED_COLUMNS,
    in_prose,
    judge_conclusions,
    read_conclusions,
    read_stored,
)
from millprint.thesis.claims.evidence import ASSUMED, CERTAIN, NATURES
from millprint.thesis.claims.tabulate import count_natures, read_claims

# The folder of tools is only on the path of a test.
sys.path.insert(0, str(Path(__file__).parents[1]))
from tools.run_tables import BLOCKS as RUN_BLOCKS
from tools.run_tables import in_markdown, store_tables, this_machine

DATA = Path("config/data")
TABLE = str(DATA / "verdicts_elsewhere.tsv")
# A block of a text, between comments with its name.
BLOCK = re.compile(r"(<!-- (?P<name>\w+): python tools/store_verdicts.py -->\n).*?(<!-- end -->)", re.S)
TEXTS = (
    "README.md",
    "paper.md",
    "docs/first_hour.md",
    "docs/reference/comparison.md",
    *(f"docs/how_to/{name}.md" for name in ("lammps", "speed")),
    *(f"docs/why/{name}.md" for name in ("claims", "contact", "surrogate", "uncertainty", "validation", "yields")),
)
STATED = ("document", "text", "source", "rows", "column")


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
    return {
        "numbers": textwrap.fill(numbers, 120),
        "natures": in_markdown(["nature", "how its value comes about", "claims"], meanings),
        "conclusions": f"Of the run {place}:\n\n{in_markdown(head, judged)}",
    }


def written(root: Path, document: str) -> str:
    """The text of a document with its blocks, and its numbers of stated_numbers.tsv, as the stored tables have them."""
    text = (root / document).read_text()

    def block(found: re.Match[str]) -> str:
        name = found["name"]
        return f"{found[1]}{RUN_BLOCKS[name](root) if name in RUN_BLOCKS else blocks_of(root)[name]}\n{found[3]}"

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


def with_run(stored: pd.DataFrame, claims: pd.DataFrame, run: str, machine: dict[str, str]) -> pd.DataFrame:
    """The stored verdicts with those of a run in place of all that the same machine gave to the same run before.

    claims: as `tabulate_claims`; what was not run is not stored.
    """
    own = claims[claims["verdict"] != OPEN]
    rows = own.assign(run=run, **machine)[STORED_COLUMNS]
    same = (stored["run"] == run) & (stored["processor"] == machine["processor"])
    return pd.concat([stored[~same], rows], ignore_index=True).fillna("")


def store(path: str | Path, claims: pd.DataFrame, run: str, machine: dict[str, str]) -> int:
    """Write the verdicts of a run on a machine into the table of stored ones; returns how many."""
    table = with_run(read_stored(path), claims, run, machine)
    write_table(table, path)
    return int(((table["run"] == run) & (table["processor"] == machine["processor"])).sum())


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
