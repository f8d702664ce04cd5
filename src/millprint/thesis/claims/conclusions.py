"""What each chapter concludes and whether it holds, and the verdicts of other machines.

Every conclusion rests on claims, and is only as sure as they are. The processor decides how sums are rounded, and
chaotic simulations and trainings magnify that. So a claim whose interval decides nothing may have another verdict
elsewhere; a claim that its interval decides should have the same verdict everywhere.
"""

import platform
from fnmatch import fnmatchcase
from pathlib import Path

import pandas as pd

from millprint.estimate.judge import AGREES, DIFFERS, OPEN, VERDICTS, Verdict, judge_all
from millprint.run.files import write_table
from millprint.run.tables import Text, read_measured, refuse_rows
from millprint.thesis.claims.tolerances import CERTAIN, ERRATUM, TIMED

CONCLUSION_COLUMNS = ["chapter", "locus", "conclusion", "claims"]
VERBS = {AGREES: ("agrees", "agree"), DIFFERS: ("differs", "differ"), OPEN: ("is open", "are open")}
TABLE_COLUMNS = ["chapter", "locus", "conclusion", "verdict", "reason", "claims", *VERDICTS, "against"]


def chapter_name(chapter: str) -> str:
    """A chapter, or the appendix A, in words."""
    return f"chapter {chapter}" if chapter != "A" else "appendix A"


def read_conclusions(path: str | Path, ids: pd.Series) -> pd.DataFrame:
    """The conclusions, with the ids of their claims as a list in `claims`.

    Raises ConfigError as `millprint.run.tables.read_measured`, for a row without claims, and for a name of claims
    that none of `ids` has.
    """
    table = read_measured(path, [Text(name) for name in CONCLUSION_COLUMNS])
    refuse_rows(table, path, "claims", table["claims"].isna(), "name the claims that it rests on")
    named = table["claims"].str.split()
    for place, patterns in named.items():
        lacking = [pattern for pattern in patterns if not any(fnmatchcase(name, pattern) for name in ids)]
        refuse_rows(
            table, path, "claims", table.index == place if lacking else [], f"no claim is {' or '.join(lacking)}"
        )
    owned = [[name for name in ids if any(fnmatchcase(name, own) for own in patterns)] for patterns in named]
    return table.assign(claims=owned)


def judge_conclusions(conclusions: pd.DataFrame, claims: pd.DataFrame) -> pd.DataFrame:
    """A row for each conclusion, with TABLE_COLUMNS.

    claims: as `tabulate_claims`. A claim counts by its interval, which says whether it holds, or else by its value.
    verdict: that of the least sure claim that was run; claims: how many were run; VERDICTS: how many have each verdict;
    against: the ids of those that differ.
    """
    own = claims.set_index("id")
    rows = []
    for row in conclusions.itertuples():
        run = own.loc[row.claims]
        run = run[run["verdict"] != OPEN]
        words = run["interval_verdict"].where(run["interval_verdict"] != "", run["verdict"])
        found = judge_all(Verdict(word, "") for word in words)
        counts = [int((words == word).sum()) for word in VERDICTS]
        count = counts[VERDICTS.index(found.word)]
        reason = f"{count} of {len(run)} claims {VERBS[found.word][count > 1]}" if len(run) else found.reason
        against = ", ".join(run.index[words == DIFFERS])
        place = chapter_name(row.chapter), row.locus, row.conclusion
        rows.append((*place, found.word, reason, len(run), *counts, against))
    return pd.DataFrame(rows, columns=TABLE_COLUMNS)


def _deviates(claims: pd.DataFrame) -> pd.Series:
    """Which values differ from a printed one that nothing else in the thesis contradicts."""
    return (claims["verdict"] == DIFFERS) & ~claims["reason"].str.startswith(ERRATUM)


def deviating_everywhere(claims: pd.DataFrame, stored: pd.DataFrame, run: str) -> list[str]:
    """The claims whose value differs in this run and in the stored ones of this name on every other machine.

    claims: as `tabulate_claims`; stored: as `read_stored`. Of a claim that is the same on every machine, this run says
    all. Errata are none of these: there the thesis contradicts itself.
    """
    held = set(stored.loc[(stored["run"] == run) & ~_deviates(stored), "id"])
    return [name for name in claims.loc[_deviates(claims), "id"] if name not in held]


def in_prose(name: str, claims: pd.DataFrame) -> str:
    """A claim that differs, as a sentence: what is printed and what was found."""
    claim = claims.set_index("id").loc[name]
    unit = "" if claim["unit"] == "-" else f" {claim['unit']}"
    bound = any(sign in claim["tolerance"] for sign in "<>")
    printed = claim["tolerance"].rstrip("%") if bound else claim["published"]
    unit = f"{unit or ' %'}" if claim["tolerance"].endswith("%") and bound else unit
    return f"{claim['quantity']}: {_short(claim['reproduced'])}{unit} for {printed}{unit} ({name})"


def _short(value: str) -> str:
    try:
        return f"{float(value):.3g}"
    except ValueError:
        return value


MACHINE = ["processor", "instructions", "date"]
STORED = ["run", "id", "verdict", "interval_verdict", "reason", "reproduced", "lower", "upper"]
WORDS = dict.fromkeys(("verdict", "interval_verdict"), VERDICTS)
STORED_COLUMNS = [*STORED, *MACHINE]
# The widest vector instructions of a processor, which decide in which order sums are taken; widest first.
INSTRUCTIONS = {"avx512f": "AVX-512", "avx2": "AVX2", "avx": "AVX", "sve": "SVE", "neon": "NEON"}
EXPECTED, UNEXPECTED, OF_MACHINE = "an interval decides nothing", "not expected", "a run time is of its machine"
DIFFERENCES = ["id", "verdict", "verdict_elsewhere", "reason", *MACHINE]


def this_machine(date: str) -> dict[str, str]:
    """The processor of this machine, its vector instructions, and a date, by MACHINE."""
    # Slow to import.
    from llvmlite import binding

    features = binding.get_host_cpu_features()
    widest = next((title for name, title in INSTRUCTIONS.items() if features.get(name)), platform.machine())
    return dict(zip(MACHINE, (binding.get_host_cpu_name(), widest, date), strict=True))


def read_stored(path: str | Path) -> pd.DataFrame:
    """The stored verdicts, with STORED_COLUMNS.

    Raises ConfigError, in one line, for a table that lacks a column, has another verdict, or has two verdicts of one
    processor on a claim of a run.
    """
    # A claim without an interval has no verdict by interval.
    columns = [Text(name, WORDS.get(name, ()), may_be_blank=name == "interval_verdict") for name in STORED_COLUMNS]
    table = read_measured(path, columns, fewest_rows=0)[STORED_COLUMNS].fillna("")
    twice = table.duplicated(["run", "id", "processor"])
    refuse_rows(table, path, "id", twice, "this run has a verdict of this processor on it in a row above")
    return table


def with_run(stored: pd.DataFrame, claims: pd.DataFrame, run: str, machine: dict[str, str]) -> pd.DataFrame:
    """The stored verdicts with those of a run in place of any that the same machine gave to the same run before.

    claims: as `millprint.thesis.claims.tabulate.tabulate_claims`; only what is simulated, trained or timed is stored,
    since the rest is the same everywhere.
    """
    own = claims[~claims["nature"].isin(CERTAIN) & (claims["verdict"] != OPEN)]
    rows = own.assign(run=run, **machine)[STORED_COLUMNS]
    same = (stored["run"] == run) & (stored["processor"] == machine["processor"]) & stored["id"].isin(rows["id"])
    return pd.concat([stored[~same], rows], ignore_index=True).fillna("")


def store(path: str | Path, claims: pd.DataFrame, run: str, date: str) -> int:
    """Write the verdicts of a run on this machine into the table of stored ones; returns how many."""
    machine = this_machine(date)
    table = with_run(read_stored(path), claims, run, machine)
    write_table(table, path)
    return int(((table["run"] == run) & (table["processor"] == machine["processor"])).sum())


def compare_verdicts(claims: pd.DataFrame, stored: pd.DataFrame, run: str) -> pd.DataFrame:
    """A row, with DIFFERENCES, for each stored verdict of a run of this name that differs here."""
    own = claims.set_index("id")
    rows = []
    for row in stored[(stored["run"] == run) & stored["id"].isin(own.index)].to_dict("records"):
        here = own.loc[row["id"]]
        if here["verdict"] in (row["verdict"], OPEN):
            continue
        is_open = OPEN in (here["interval_verdict"], row["interval_verdict"])
        reason = OF_MACHINE if here["nature"] == TIMED else EXPECTED if is_open else UNEXPECTED
        rows.append(row | {"verdict": here["verdict"], "verdict_elsewhere": row["verdict"], "reason": reason})
    return pd.DataFrame(rows, columns=DIFFERENCES)


def in_a_line(differences: pd.DataFrame, stored: pd.DataFrame, run: str) -> str:
    """What differs from the stored verdicts, as one line for people."""
    known = stored[stored["run"] == run]
    if known.empty:
        return f"verdicts of other machines: none is stored of the run {run}"
    machines = known.groupby(MACHINE, sort=False).size()
    told = "; ".join(f"{number} of {', '.join(machine)}" for machine, number in machines.items())
    beginning = f"verdicts of other machines ({told})"
    if differences.empty:
        return f"{beginning}: none differs here"
    each = ", ".join(
        f"{row.id} ({row.verdict} here, {row.verdict_elsewhere} there: {row.reason})"
        for row in differences.itertuples()
    )
    odd = int((differences["reason"] == UNEXPECTED).sum())
    end = f"{odd} of them not expected" if odd else "all of them expected"
    return f"{beginning}: {len(differences)} differ here, {end}: {each}"
