"""The table of every claim of the thesis, with what was computed and a verdict."""

from dataclasses import replace
from fnmatch import fnmatch
from pathlib import Path

import pandas as pd

from millprint.config.errors import ConfigError
from millprint.estimate.judge import VERDICTS
from millprint.run.tables import Text, read_measured, refuse_rows

# Importing a chapter registers its claims.
from millprint.thesis.claims import chapter2, chapter3, chapter3_curves, chapter4, chapter5, chapter6  # noqa: F401
from millprint.thesis.claims.conclusions import chapter_name
from millprint.thesis.claims.evidence import (
    FORMS,
    Evidence,
    Finding,
    Repeats,
    find_claim,
    form_of,
)
from millprint.thesis.claims.tolerances import (
    BASES,
    DERIVED,
    ERRATUM,
    NATURES,
    deviation,
    is_number,
    jars_that_meet,
    judge_repeats,
    judge_value,
    reason_of,
)

CLAIM_COLUMNS = ["id", "locus", "quantity", "value", "unit", "nature", "basis", "tolerance", "note"]
# What is known of deviations, by ids of claims, and the tables that show it. No cause is named.
JAR = (
    "the jar's shape is not published; fingerprint/fit.tsv has what a step of each of its parameters moves, "
    "report/claims_by_jar.tsv what other jars that fit as well give"
)
WHERE_TO_LOOK = {
    **dict.fromkeys(("3.curve.*", "3.cycle.*", "3.reference.*"), JAR),
    "3.*.f": "the counting rule is not published; fingerprint/counting_rules.tsv has the frequency by each rule",
    "3.size.*": "not explained: no counting rule enters a dissipation per revolution",
}
# Of the values by the jars that fit as well: the smallest and the largest, and how many meet the claim, as "3 of 8".
JAR_COLUMNS = ["jars_lower", "jars_upper", "jars_meeting"]
# Columns of the table of verdicts: part of an interval.
INTERVAL_PARTS = {"lower": "lower", "upper": "upper", "interval_from": "how", "repeats": "of", "failed": "failed"}


def read_claims(path: str | Path) -> pd.DataFrame:
    """The claims by id, all columns as text, so that every printed digit is kept.

    Raises ConfigError for an id without code and code without an id, and for an unknown nature or basis.
    """
    claims = read_measured(path, list(map(Text, CLAIM_COLUMNS))).fillna("").set_index("id", drop=False)
    forms = {name: form_of(name) for name in claims.index}
    for word, ids in (
        ("lacks", set(FORMS) - {form.template for form in forms.values() if form}),
        ("names twice", set(claims.index[claims.index.duplicated()])),
        ("has, without code that computes them:", {name for name, form in forms.items() if form is None}),
    ):
        if ids:
            raise ConfigError(f"{path}: column id {word} {', '.join(sorted(ids))}")
    for column, known in (("nature", NATURES), ("basis", BASES)):
        refuse_rows(claims, path, column, ~claims[column].isin(list(known)), f"must be one of {', '.join(known)}")
    return claims


def collect_findings(
    results: str | Path,
    claims_path: str | Path,
    beginning: str = "",
    intervals: pd.DataFrame | None = None,
    jars: pd.DataFrame | None = None,
) -> dict[str, Finding]:
    """What the run in the folder `results` says for each claim whose id has this beginning, by id.

    intervals: as `millprint.thesis.claims.claim_intervals.tabulate_intervals`; a claim that they lack keeps what its
    own code says. jars: as `millprint.thesis.claims.claim_intervals.tabulate_jars`. One that is missed has the note of
    WHERE_TO_LOOK. Raises ConfigError as `read_claims`.
    """
    claims, data, found = read_claims(claims_path), Path(claims_path).parent, {}
    drawn = {} if intervals is None else {row.id: row for row in intervals.itertuples()}
    by_jar = {} if jars is None else jars.groupby("id")["value"].agg(tuple).to_dict()
    read: dict[str, pd.DataFrame] = {}
    for name in claims.index[claims.index.str.startswith(beginning)]:
        evidence = Evidence(Path(results), data, claims["value"], name, tables=read)
        finding = find_claim(evidence)
        if finding.value is not None and (row := drawn.get(name)):
            counts = int(row.repeats), int(row.failed)
            finding = replace(finding, repeats=Repeats(_end(row.lower), _end(row.upper), row.interval_from, *counts))
        if finding.value is not None and name in by_jar:
            finding = replace(finding, jars=tuple(_end(value) for value in by_jar[name]))
        asked = claims.at[name, "value"], claims.at[name, "tolerance"], finding
        verdicts = judge_value(*asked), judge_repeats(*asked)
        if finding.value is not None and not all(each.agrees or each.reason == ERRATUM for each in verdicts if each):
            notes = [note for ids, note in WHERE_TO_LOOK.items() if fnmatch(name, ids)]
            words = (finding.explanation, *notes)
            finding = replace(finding, explanation="; ".join(filter(None, words)))
        found[name] = finding
    return found


def tabulate_claims(claims_path: str | Path, findings: dict[str, Finding]) -> pd.DataFrame:
    """A row for every claim in the order of `claims_path`.

    Columns: id, locus, quantity, published, unit, nature, basis, tolerance, reproduced; INTERVAL_PARTS of its interval;
    JAR_COLUMNS; deviation [%]; verdict, by the value; interval_verdict; reason, of both; explanation; and source: file,
    rows, columns, rule and function of what decides the claim. Raises ConfigError as `read_claims`.
    """
    claims = read_claims(claims_path)
    found = [findings[name] for name in claims.index]
    table = claims.drop(columns="note").rename(columns={"value": "published"}).reset_index(drop=True)
    table["reproduced"] = [_text(finding.value) for finding in found]
    for column, part in INTERVAL_PARTS.items():
        table[column] = [_text(getattr(finding.repeats, part, "")) for finding in found]
    pairs = list(zip(claims.itertuples(), found, strict=True))
    table[JAR_COLUMNS] = [_by_jars(claim.value, claim.tolerance, finding.jars) for claim, finding in pairs]
    table["deviation"] = [_text(deviation(claim.value, finding.value), digits=3) for claim, finding in pairs]
    by_value = [judge_value(claim.value, claim.tolerance, finding) for claim, finding in pairs]
    by_repeats = [judge_repeats(claim.value, claim.tolerance, finding) for claim, finding in pairs]
    table["verdict"] = [verdict.word for verdict in by_value]
    table["interval_verdict"] = [verdict.word if verdict else "" for verdict in by_repeats]
    table["reason"] = list(map(reason_of, by_value, by_repeats))
    table["explanation"] = [_explanation(finding) for finding in found]
    table["source"] = ["; ".join(map(str, finding.sources)) for finding in found]
    return table


def chapter_of(claim: str) -> str:
    """The chapter, in words, of a claim's id."""
    return chapter_name(claim.split(".")[0])


def count_verdicts(table: pd.DataFrame, by: str = "chapter") -> pd.DataFrame:
    """Number of claims by chapter, or by nature, and verdict: that column, claims, and a column for every verdict."""
    groups = table["id"].map(chapter_of) if by == "chapter" else table[by]
    counts = pd.crosstab(groups, table["verdict"]).reindex(columns=list(VERDICTS), fill_value=0)
    counts.insert(0, "claims", counts.sum(axis=1))
    # By the first claim of each, so that the appendix comes last.
    order = groups.unique() if by == "chapter" else [nature for nature in NATURES if nature in counts.index]
    return counts.loc[order].rename_axis(index=by, columns=None).reset_index()


def count_natures(claims: pd.DataFrame) -> str:
    """How many claims there are of each nature, and how many of them are derived, in words."""
    counts = claims["nature"].value_counts()
    parts = ", ".join(f"{counts[nature]} {meaning}" for nature, meaning in NATURES.items() if nature in counts)
    derived = int((claims["basis"] == DERIVED).sum())
    return f"{len(claims)} claims, {derived} of them derived from two printed numbers: {parts}"


def _explanation(finding: Finding) -> str:
    failed = finding.repeats.failed if finding.repeats else 0
    misses = f"{failed} of {finding.repeats.of} repeats failed, which are misses" if failed else ""  # type: ignore[union-attr]
    contradiction = f"{finding.contradiction};" if finding.contradiction else ""
    return " ".join(f"{contradiction} {'; '.join(filter(None, (finding.explanation, misses)))}".split())


def _by_jars(published: str, tolerance: str, jars: tuple[float | str, ...]) -> tuple[str, str, str]:
    """JAR_COLUMNS of a claim; empty without jars. Words are in the order of the alphabet."""
    if not jars:
        return "", "", ""
    met = f"{jars_that_meet(published, tolerance, jars)} of {len(jars)}"
    return _text(min(jars)), _text(max(jars)), met


def _end(text: float | str) -> float | str:
    """An end of an interval, which a file has as text: a number, or else a word or a pair."""
    return float(text) if is_number(text) else text


def _text(value: float | str | None, digits: int = 6) -> str:
    if value is None:
        return ""
    return value if isinstance(value, str) else f"{value:.{digits}g}"
