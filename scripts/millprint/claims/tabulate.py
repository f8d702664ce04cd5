"""The table of every claim of the thesis, with what was computed and a verdict."""

from dataclasses import replace
from pathlib import Path

import pandas as pd

# Importing a chapter registers its claims.
from millprint.claims import chapter2, chapter3, chapter3_curves, chapter4, chapter5, chapter6  # noqa: F401
from millprint.claims.compare import deviation, is_number, verdict
from millprint.claims.evidence import CLAIMS, Evidence, Finding, Interval, find_claim
from millprint.claims.verdicts import DEVIATES, UNDECIDED, VERDICTS, in_short
from millprint.errors import ConfigError
from millprint.files import read_table

CLAIM_COLUMNS = ["id", "locus", "quantity", "value", "unit", "kind", "tolerance", "note"]


def read_claims(path: str | Path) -> pd.DataFrame:
    """The claims by id, all columns as text. Raises ConfigError where the ids are not those that have code."""
    claims = read_table(path, text=CLAIM_COLUMNS).fillna("").set_index("id", drop=False)
    for word, ids in (
        ("lacks", set(CLAIMS) - set(claims.index)),
        ("names twice", set(claims.index[claims.index.duplicated()])),
        ("has, without code that computes them:", set(claims.index) - set(CLAIMS)),
    ):
        if ids:
            raise ConfigError(f"{path}: column id {word} {', '.join(sorted(ids))}")
    return claims


def collect_findings(
    results: str | Path, claims_path: str | Path, beginning: str = "", intervals: pd.DataFrame | None = None
) -> dict[str, Finding]:
    """What the run in the folder `results` says of each claim whose id has this beginning, by id.

    intervals: as `millprint.claims.intervals.tabulate_intervals`; a claim that they lack keeps what its own code says.
    A value that deviates is explained further, where the results show a reason. Raises ConfigError as `read_claims`.
    """
    claims, data, found = read_claims(claims_path), Path(claims_path).parent, {}
    drawn = {} if intervals is None else {row.id: row for row in intervals.itertuples()}
    read: dict[str, pd.DataFrame] = {}
    for name in claims.index[claims.index.str.startswith(beginning)]:
        evidence = Evidence(Path(results), data, claims["value"], name, tables=read)
        finding, own = find_claim(evidence), CLAIMS[name]
        if finding.value is not None and (row := drawn.get(name)):
            finding = replace(finding, interval=Interval(_end(row.lower), _end(row.upper), row.interval_from))
        judged = verdict(claims.at[name, "value"], claims.at[name, "tolerance"], finding)
        if judged in (DEVIATES, UNDECIDED) and own.explain_deviation is not None:
            words = (finding.explanation, own.explain_deviation(evidence, **own.parts))
            finding = replace(finding, explanation="; ".join(filter(None, words)))
        found[name] = finding
    return found


def tabulate_claims(claims_path: str | Path, findings: dict[str, Finding]) -> pd.DataFrame:
    """A row for every claim in the order of `claims_path`.

    Columns: id, locus, quantity, published, unit, kind, tolerance, reproduced, lower, upper and interval_from of its
    interval, deviation [%], verdict, explanation, and source: file, rows, columns, rule and function of what decides
    the claim. Raises ConfigError as `read_claims`.
    """
    claims = read_claims(claims_path)
    found = [findings[name] for name in claims.index]
    table = claims.drop(columns="note").rename(columns={"value": "published"}).reset_index(drop=True)
    table["reproduced"] = [_text(finding.value) for finding in found]
    none = Interval("", "", "")
    for column, part in (("lower", "lower"), ("upper", "upper"), ("interval_from", "origin")):
        table[column] = [_text(getattr(finding.interval or none, part)) for finding in found]
    pairs = list(zip(claims.itertuples(), found, strict=True))
    table["deviation"] = [_text(deviation(claim.value, finding.value), digits=3) for claim, finding in pairs]
    table["verdict"] = [verdict(claim.value, claim.tolerance, finding) for claim, finding in pairs]
    table["explanation"] = [" ".join(f"{finding.erratum} {finding.explanation}".split()) for finding in found]
    table["source"] = ["; ".join(map(str, finding.sources)) for finding in found]
    return table


def chapter_of(claim: str) -> str:
    """The chapter, in words, of a claim's id."""
    name = claim.split(".")[0]
    return f"chapter {name}" if name != "A" else "appendix A"


def count_verdicts(table: pd.DataFrame) -> pd.DataFrame:
    """Number of claims by chapter and verdict: chapter, claims, and a column for every verdict, by its first words."""
    chapters = table["id"].map(chapter_of)
    columns = list(map(in_short, VERDICTS))
    counts = pd.crosstab(chapters, table["verdict"].map(in_short)).reindex(columns=columns, fill_value=0)
    counts.insert(0, "claims", counts.sum(axis=1))
    # By the first claim of each, so that the appendix comes last.
    return counts.loc[chapters.unique()].rename_axis(index="chapter", columns=None).reset_index()


def _end(text: float | str) -> float | str:
    """An end of an interval, which a file has as text: a number, or else a word or a pair."""
    return float(text) if is_number(text) else text


def _text(value: float | str | None, digits: int = 6) -> str:
    if value is None:
        return ""
    return value if isinstance(value, str) else f"{value:.{digits}g}"
