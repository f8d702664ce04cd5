"""The table of every claim of the thesis, with what was computed and a verdict."""

from pathlib import Path

import pandas as pd

from millprint.claims import chapter2, chapter3, chapter4, chapter5, chapter6
from millprint.claims.compare import VERDICTS, deviation, verdict
from millprint.claims.finding import Finding
from millprint.errors import ConfigError
from millprint.files import read_table

CHAPTERS = (chapter2, chapter3, chapter4, chapter5, chapter6)
CLAIM_COLUMNS = ["id", "locus", "quantity", "value", "unit", "kind", "tolerance", "note"]


def collect_findings(results: Path, data: Path) -> dict[str, Finding]:
    """What every chapter says of its claims, by claim id."""
    found: dict[str, Finding] = {}
    for chapter in CHAPTERS:
        found.update(chapter.findings(results, data))
    return found


def tabulate_claims(claims_path: str | Path, findings: dict[str, Finding]) -> pd.DataFrame:
    """A row for every claim in the order of `claims_path`.

    Columns: id, locus, quantity, published, unit, kind, tolerance, reproduced, deviation [%], verdict, explanation.
    Raises ConfigError for a finding of no known claim; a claim with no finding is an error of the library.
    """
    claims = read_table(claims_path, text=CLAIM_COLUMNS).fillna("")
    unknown = sorted(set(findings) - set(claims["id"]))
    if unknown:
        raise ConfigError(f"{claims_path}: column id lacks {', '.join(unknown)}, for which a value was computed")
    rows = []
    for claim in claims.itertuples():
        finding = findings[claim.id]
        rows.append(
            {
                "id": claim.id,
                "locus": claim.locus,
                "quantity": claim.quantity,
                "published": claim.value,
                "unit": claim.unit,
                "kind": claim.kind,
                "tolerance": claim.tolerance,
                "reproduced": _text(finding.value),
                "deviation": _text(deviation(claim.value, finding.value), digits=3),
                "verdict": verdict(claim.value, claim.tolerance, finding),
                "explanation": " ".join(f"{finding.erratum} {finding.explanation}".split()),
            }
        )
    return pd.DataFrame(rows)


def chapter_of(claim: str) -> str:
    """The chapter, in words, of a claim's id."""
    name = claim.split(".")[0]
    return f"chapter {name}" if name != "A" else "appendix A"


def count_verdicts(table: pd.DataFrame) -> pd.DataFrame:
    """Number of claims by chapter and verdict: chapter, claims, and a column for every verdict; chapters first."""
    counts = pd.crosstab(table["id"].map(chapter_of), table["verdict"]).reindex(columns=list(VERDICTS), fill_value=0)
    counts.insert(0, "claims", counts.sum(axis=1))
    # By the first claim of each, so that the appendix comes last.
    ordered = counts.loc[table["id"].map(chapter_of).unique()]
    return ordered.rename_axis(index="chapter", columns=None).reset_index()


def _text(value: float | str | None, digits: int = 6) -> str:
    if value is None:
        return ""
    return value if isinstance(value, str) else f"{value:.{digits}g}"
