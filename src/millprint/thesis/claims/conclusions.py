"""What each chapter concludes, and whether it stands: every conclusion rests on claims, and theirs are its verdicts."""

from fnmatch import fnmatchcase
from pathlib import Path

import pandas as pd

from millprint.run.tables import Text, read_measured, refuse_rows
from millprint.thesis.claims.claim_verdicts import DEVIATES, ERRATUM, NOT_RUN, OPEN_VERDICTS, REPRODUCED

COLUMNS = ["chapter", "locus", "conclusion", "claims"]
STANDS, PARTLY, FALLS, UNKNOWN = "stands", "stands in part", "does not stand", "not run"
STATUSES = (STANDS, PARTLY, FALLS, UNKNOWN)
TABLE_COLUMNS = ["chapter", "locus", "conclusion", "stands", "claims", "reproduced", "missed", "open", "against"]


def chapter_name(chapter: str) -> str:
    """A chapter, or the appendix A, in words."""
    return f"chapter {chapter}" if chapter != "A" else "appendix A"


def read_conclusions(path: str | Path, ids: pd.Series) -> pd.DataFrame:
    """The conclusions, with the ids of their claims as a list in `claims`.

    Raises ConfigError as `millprint.run.tables.read_measured`, and for a name of claims that none of `ids` has.
    """
    table = read_measured(path, [Text(name) for name in COLUMNS])
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

    claims: as `tabulate_claims`. stands: one of STATUSES, by the claims that were run: all, some or none reproduced;
    claims, reproduced, missed: how many were run, are reproduced, and are not; open: how many have an interval that
    decides nothing; against: the ids of those that are not reproduced.
    """
    own = claims.set_index("id")
    rows = []
    for row in conclusions.itertuples():
        run = own.loc[row.claims]
        run = run[run["verdict"] != NOT_RUN]
        missed = run.index[run["verdict"].isin([DEVIATES, ERRATUM])]
        hits = int((run["verdict"] == REPRODUCED).sum())
        status = UNKNOWN if run.empty else FALLS if not hits else PARTLY if len(missed) else STANDS
        undecided = int(run["interval_verdict"].isin(OPEN_VERDICTS).sum())
        told = chapter_name(row.chapter), row.locus, row.conclusion, status
        rows.append((*told, len(run), hits, len(missed), undecided, ", ".join(missed)))
    return pd.DataFrame(rows, columns=TABLE_COLUMNS)


def deviating_everywhere(claims: pd.DataFrame, stored: pd.DataFrame, run: str) -> list[str]:
    """The claims that deviate in this run and in the stored ones of this name on every other machine.

    claims: as `tabulate_claims`; stored: as `read_stored`. Of a claim that is the same on every machine, this run says
    all. Errata are none of these: there the thesis contradicts itself.
    """
    here = claims.loc[claims["verdict"] == DEVIATES, "id"]
    others = stored[stored["run"] == run].groupby("id")["verdict"]
    held = {name for name, verdicts in others if (verdicts != DEVIATES).any()}
    return [name for name in here if name not in held]


def in_prose(name: str, claims: pd.DataFrame) -> str:
    """A claim that deviates, as a sentence: what is printed and what was found."""
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
