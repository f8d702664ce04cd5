"""What each chapter concludes, whether our numbers agree and whether it holds, and the verdicts of other machines.

Every conclusion rests on claims, and is only as sure as they are. The processor decides how sums are rounded, and
chaotic simulations and trainings magnify that. So a claim whose interval decides nothing may have another verdict
elsewhere; a claim that its interval decides should have the same verdict everywhere.
"""

from fnmatch import fnmatchcase
from pathlib import Path

import pandas as pd

from millprint.estimate.judge import AGREES, DIFFERS, NOT_RUN, OPEN, VERDICTS
from millprint.run.tables import Text, read_measured, refuse_rows
from millprint.thesis.claims.evidence import ASSUMED, ERRATUM, TIMED

CONCLUSION_COLUMNS = ["chapter", "locus", "conclusion", "claims"]
# Some of its claims agree, and others differ.
IN_PART = "in part"
VERBS = {AGREES: ("agrees", "agree"), DIFFERS: ("differs", "differ"), OPEN: ("is open", "are open")}
# The verdicts on a conclusion, as a sentence goes on with them.
HOLDINGS = {AGREES: "hold", IN_PART: "hold in part", DIFFERS: "do not hold", OPEN: "are open"}
OURS, HOLDS = "our_number", "it_holds"
TABLE_COLUMNS = ["chapter", "locus", "conclusion", OURS, HOLDS, "reason", "claims", *VERDICTS, "against"]


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

    claims: as `tabulate_claims`. our_number: the verdict of `verdict_on_all` by the values; it_holds: that by the
    intervals, or the value of what has none. There a value that was fitted or put in shows nothing by agreeing and
    does not count. A claim that was not run is open. claims: how many there are; VERDICTS: how many have each verdict
    that counts for it_holds; against: the ids of those that differ.
    """
    own = claims.set_index("id")
    rows = []
    for row in conclusions.itertuples():
        all_of_it = own.loc[row.claims]
        words = all_of_it["interval_verdict"].where(all_of_it["interval_verdict"] != "", all_of_it["verdict"])
        assumed = all_of_it["nature"].isin(ASSUMED) & (words == AGREES)
        counts = {word: int((words[~assumed] == word).sum()) for word in VERDICTS}
        parts = [f"{number} {VERBS[word][number > 1]}" for word, number in counts.items() if number]
        parts += [f"{assumed.sum()} fitted or put in"] if assumed.any() else []
        reason = NOT_RUN if (all_of_it["verdict"] == OPEN).all() else f"claims: {', '.join(parts)}"
        verdicts = verdict_on_all(all_of_it["verdict"]), verdict_on_all(words[~assumed])
        place = chapter_name(row.chapter), row.locus, row.conclusion
        rows.append((*place, *verdicts, reason, len(words), *counts.values(), ", ".join(words.index[words == DIFFERS])))
    return pd.DataFrame(rows, columns=TABLE_COLUMNS)


def verdict_on_all(words: pd.Series) -> str:
    """The verdict on a conclusion by those on its claims.

    It differs if one does and none agrees, and holds in part if one does and another agrees; else it is open if one is,
    or if there is none.
    """
    found = set(words)
    if DIFFERS in found:
        return IN_PART if AGREES in found else DIFFERS
    return AGREES if found == {AGREES} else OPEN


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


MACHINE = ["processor", "instructions", "commit", "date"]
STORED = ["run", "id", "verdict", "interval_verdict", "reason", "reproduced", "lower", "upper"]
WORDS = dict.fromkeys(("verdict", "interval_verdict"), VERDICTS)
STORED_COLUMNS = [*STORED, *MACHINE]
EXPECTED, UNEXPECTED, OF_MACHINE = "an interval decides nothing", "not expected", "a run time is of its machine"
DIFFERENCES = ["id", "verdict", "verdict_elsewhere", "reason", *MACHINE]


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
