"""The table of claims: every claim with the computed value, its interval and its verdict."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from fnmatch import fnmatch
from pathlib import Path

import numpy as np
import pandas as pd

from millprint.config.errors import ConfigError
from millprint.estimate.estimates import LEVEL, Estimate, Interval, spread_of
from millprint.estimate.judge import VERDICTS, judge
from millprint.fingerprint.bands import Factors
from millprint.run.files import read_table
from millprint.run.job import progress
from millprint.run.tables import Text, read_measured, refuse_rows
from millprint.thesis.claims import chapter2, chapter3, chapter4, chapter5, chapter6  # noqa: F401
from millprint.thesis.claims.chapter6 import TRAININGS
from millprint.thesis.claims.conclusions import chapter_name
from millprint.thesis.claims.evidence import (
    BASES,
    CERTAIN,
    DERIVED,
    ERRATUM,
    FORMS,
    NATURES,
    TIMED,
    Evidence,
    Finding,
    Repeats,
    deviation,
    find_claim,
    form_of,
    is_number,
    jars_that_meet,
    judge_repeats,
    judge_value,
    reason_of,
)
from millprint.thesis.surrogate.measures import failed_tests

# Importing a chapter registers its claims.

CLAIM_COLUMNS = ["id", "locus", "quantity", "value", "unit", "nature", "basis", "tolerance", "note"]
# What is known of deviations, by ids of claims, and the tables that show it. No cause is named.
JAR = (
    "the thesis does not give the jar's shape; fingerprint/fit.tsv has what a step of each of its parameters moves, "
    "report/claims_by_jar.tsv what other jars that fit as well give"
)
WHERE_TO_LOOK = {
    **dict.fromkeys(("3.curve.*", "3.cycle.*", "3.reference.*"), JAR),
    "3.*.f": "the thesis states no counting rule; fingerprint/counting_rules.tsv has the frequency by each rule",
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

    intervals: as `millprint.thesis.claims.tabulate.tabulate_intervals`; a claim that they lack keeps what its
    own code says. jars: as `millprint.thesis.claims.tabulate.tabulate_jars`. One that is missed has the note of
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
            counts = None if pd.isna(row.repeats) else int(row.repeats), int(row.failed)
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
    table["explanation"] = [_explanation(claim.note, finding) for claim, finding in pairs]
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


def _explanation(note: str, finding: Finding) -> str:
    failed = finding.repeats.failed if finding.repeats else 0
    misses = f"{failed} of {finding.repeats.of} repeats failed, which are misses" if failed else ""  # type: ignore[union-attr]
    contradiction = f"{finding.contradiction};" if finding.contradiction else ""
    return " ".join(f"{contradiction} {'; '.join(filter(None, (finding.explanation, note, misses)))}".split())


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


WINDOWS = "bootstrap of windows"
# What the claims ask of a roll-out that ran away; its other measures mean nothing.
COURSE = ("stable", "balls_left", "mean_square_speed_ratio")

INTERVAL_COLUMNS = ["id", "lower", "upper", "interval_from", "repeats", "failed"]

Value = float | str
Tables = dict[str, pd.DataFrame]


@dataclass(frozen=True)
class Repeated:
    """Tables that stand in for files of the results, drawn again and again.

    tables: of each draw, by path from the results folder; between: the interval of a claim's values over the draws.
    """

    tables: Sequence[Tables]
    between: Callable[[Value, list[Value], float], Repeats]

    def decides(self, finding: Finding) -> bool:
        """Whether the value of a claim follows from one of these tables."""
        return any(source.path in self.tables[0] for source in finding.sources) if self.tables else False


def quantiles(values: Sequence[float], level: float = LEVEL) -> tuple[float, float]:
    """The middle of many draws."""
    low, high = np.quantile(np.asarray(values, dtype=float), [(1 - level) / 2, (1 + level) / 2])
    return float(low), float(high)


def over_repeats(value: Value, values: list[Value], level: float, origin: str = TRAININGS) -> Repeats:
    """The interval of one more repeat, such as a training: `spread_of`. Of statements, another is the lower end."""
    if not all(map(is_number, values)):
        return Repeats(next((one for one in values if one != value), value), value, origin, len(values))
    found = [float(one) for one in values]
    lower, upper = spread_of(found, level, one_more=True) if len(found) > 1 else (found[0], found[0])
    return Repeats(lower, upper, origin, len(found))


def over_draws(value: Value, values: list[Value], level: float, origin: str = WINDOWS) -> Repeats:
    """The interval over many draws: `quantiles`, moved so that their median is the value, which removes a bias.

    A draw has fewer different revolutions than its run, so that its spread is too small; a largest value is too large.
    Of statements, the commonest other one is the lower end where it is drawn more often than each end of an interval
    is left out, (1 - level) / 2.
    """
    if not all(is_number(one) for one in [value, *values]):
        others = pd.Series([one for one in values if one != value], dtype=object).value_counts()
        often = len(others) and others.sum() > (1 - level) / 2 * len(values)
        return Repeats(str(others.index[0]) if often else value, value, origin, len(values))
    found = [float(one) for one in values]
    low, high = quantiles(found, level)
    bias = float(np.median(found)) - float(value)
    return Repeats(min(low - bias, float(value)), max(high - bias, float(value)), origin, len(values))


def findings_of(name: str, evidence: Evidence, tables: Sequence[Tables]) -> list[Finding]:
    """What a claim finds with each of these tables in the place of the files; without those that do not decide it."""
    found = [find_claim(replace(evidence, id=name, sources=[], tables=evidence.tables | own)) for own in tables]
    return [one for one in found if one.value is not None]


def interval_from(found: Sequence[Finding], finding: Finding, repeated: Repeated, level: float) -> Repeats:
    """The interval of a claim over its repeats. One that failed is counted, and is in neither end.

    A repeat with a value that is not finite counts as failed.
    """
    values = [one.value for one in found if not one.failed and one.value is not None and _is_known(one.value)]
    failed = len(found) - len(values)
    if not values or finding.value is None:
        return Repeats(math.inf, math.inf, TRAININGS, len(found), failed)
    value = values[0] if finding.failed or not _is_known(finding.value) else finding.value
    interval = repeated.between(value, values, level)
    return replace(interval, of=len(found), failed=failed).within(finding.limits)


def _is_known(value: Value) -> bool:
    return not is_number(value) or math.isfinite(float(value))


def tabulate_intervals(
    results: str | Path, claims_path: str | Path, repeated: Sequence[Repeated], level: float = LEVEL
) -> pd.DataFrame:
    """A row for each claim that chance has a part in and that has an interval, with INTERVAL_COLUMNS.

    A claim whose own code states an interval keeps it. Raises ConfigError as
    `millprint.thesis.claims.tabulate.read_claims`.
    """
    claims, findings = read_claims(claims_path), collect_findings(results, claims_path)
    certain = claims["nature"].isin([*CERTAIN, TIMED])
    uncertain = [name for name in claims.index[~certain] if findings[name].value is not None]
    evidence = Evidence(Path(results), Path(claims_path).parent, claims["value"])
    rows = []
    with progress(len(uncertain), None, "claim") as bar:
        for name in uncertain:
            interval = _interval_of(name, findings[name], evidence, repeated, level)
            if interval is not None:
                rows.append(dict(zip(INTERVAL_COLUMNS, (name, *vars(interval).values()), strict=True)))
            bar.update()
    return pd.DataFrame(rows, columns=INTERVAL_COLUMNS)


def _interval_of(
    name: str, finding: Finding, evidence: Evidence, repeated: Sequence[Repeated], level: float
) -> Repeats | None:
    own = next((one for one in repeated if one.decides(finding)), None) if finding.repeats is None else None
    found = findings_of(name, evidence, own.tables) if own else []
    return interval_from(found, finding, own, level) if own and len(found) > 1 else finding.repeats


JAR_TABLE = ["id", "jar", "counting_rule", "value", "verdict"]


def tabulate_jars(
    results: str | Path, claims_path: str | Path, jars: pd.DataFrame, tables: Sequence[Tables]
) -> pd.DataFrame:
    """What each jar and counting rule that fits equally well says for each claim that it decides, with JAR_TABLE.

    jars: as `millprint.thesis.fit.open_shape.read_equal_jars`; tables: of each of its rows, in place of the files. A
    claim that these tables cannot decide, as of another contact set, has no row. Raises ConfigError as `read_claims`.
    """
    claims, findings = read_claims(claims_path), collect_findings(results, claims_path)
    evidence = Evidence(Path(results), Path(claims_path).parent, claims["value"])
    rows = []
    for name in claims.index[~claims["nature"].isin([*CERTAIN, TIMED])]:
        if findings[name].value is None or not any(source.path in tables[0] for source in findings[name].sources):
            continue
        found = findings_of(name, evidence, tables)
        if len(found) < len(tables):
            continue
        asked = claims.at[name, "value"], claims.at[name, "tolerance"]
        for own, one in zip(jars.itertuples(), found, strict=True):
            rows.append((name, own.jar, own.counting_rule, one.value, judge_value(*asked, one).word))
    return pd.DataFrame(rows, columns=JAR_TABLE)


def repeated_trainings(results: str | Path, trainings: dict[str, list[str]]) -> list[Repeated]:
    """The measures of the trainings of each surrogate in the place of those of the first.

    trainings: by the name of a surrogate, the names of all of its trainings, itself first.
    """
    found = []
    for name, names in trainings.items():
        path = f"surrogate/{name}/metrics.tsv"
        files = [Path(results) / f"surrogate/{one}/metrics.tsv" for one in names]
        if len(files) > 1 and all(file.exists() for file in files):
            found.append(Repeated([{path: without_sizes(read_table(file))} for file in files], over_repeats))
    return found


def without_sizes(metrics: pd.DataFrame) -> pd.DataFrame:
    """The rows of metrics.tsv of one training, with no size in the tests in which its roll-out ran away."""
    lost = metrics["test"].isin(failed_tests(metrics)) & ~metrics["measure"].isin(COURSE)
    return metrics.assign(value=metrics["value"].mask(lost, np.inf))


CASE = "4.case."
# Quantity of Table 4.2: column of partition/table_4_2.tsv, and the unit that it is printed in.
COLUMNS = {
    "f": ("specific_frequency_hz", 1.0),
    "P": ("power_W", 1.0),
    "En": ("normal_energy_J", 1e-4),
    "Et": ("tangential_energy_J", 1e-4),
    "ratio": ("ratio", 1.0),
}
REFERENCE_FILL = 0.10
COLUMNS_OF_TABLE = [
    "id", "locus", "quantity", "unit", "fill_ratio", "factor_of", "published", "ours", "deviation_percent",
    "lower", "upper", "verdict",
]  # fmt: skip


@dataclass(frozen=True)
class Place:
    """The quantity of CURVES that a printed value goes with, and its fill ratio."""

    quantity: str
    fill_ratio: float


def place_of(claim: str, cycle_fill_ratio: float, cases: dict[str, float]) -> Place | None:
    """The place of a claim; None for one that no factor applies to. cases: fill ratios of Table 4.2 by name."""
    about, _, quantity = claim.rpartition(".")
    if about.startswith("3.curve.0."):
        return Place(quantity, float(about.removeprefix("3.curve.")))
    if about.startswith("3.cycle."):
        return Place(f"P{quantity}", cycle_fill_ratio)
    if about == "3.reference":
        return Place(quantity, REFERENCE_FILL)
    case = about.removeprefix(CASE)
    # The speed of the cases of equal power follows from the curves.
    if about.startswith(CASE) and case in cases and not case.startswith("power") and quantity in COLUMNS:
        return Place(quantity, cases[case])
    return None


def tabulate_contact_intervals(
    results: str | Path, claims_path: str | Path, factors: Factors, cycle_fill_ratio: float
) -> pd.DataFrame:
    """A row for each printed value that comes from the DEM, with COLUMNS_OF_TABLE.

    published: as printed; ours: what the run in the folder `results` computed, of chapter 4 with our own curves; lower,
    upper: ours times the factors of the contact parameters; verdict: whether the printed value lies between them. The
    factors are those of one ball size and speed, which the scaling carries to the others. Values that the run has not
    computed, and fill ratios beyond those of the factors, have no interval.
    """
    claims = read_claims(claims_path)
    findings = collect_findings(results, claims_path, "3.c") | collect_findings(results, claims_path, "3.reference")
    regimes = read_table(Path(results) / "partition/table_4_2.tsv", text=["curves", "case"])
    regimes = regimes[regimes["curves"] == "ours"].set_index("case")
    cases = regimes["fill_ratio"].astype(float).to_dict()
    rows = []
    for claim in claims.itertuples():
        place = place_of(claim.id, cycle_fill_ratio, cases)
        if place is None:
            continue
        if claim.id.startswith(CASE):
            case, _, quantity = claim.id.removeprefix(CASE).rpartition(".")
            column, unit = COLUMNS[quantity]
            ours = float(regimes.at[case, column]) / unit
        else:
            value = findings[claim.id].value
            ours = np.nan if value is None else float(value)
        published = float(claim.value)
        lower, upper = ours * factors.at(np.array([place.fill_ratio]))[place.quantity][:, 0]
        estimate = Estimate(ours, claim.unit).having({} if np.isnan(lower) else {"contact": Interval(lower, upper)})
        rows.append(
            {
                **{name: getattr(claim, name) for name in ("id", "locus", "quantity", "unit")},
                "fill_ratio": place.fill_ratio,
                "factor_of": place.quantity,
                "published": published,
                "ours": ours,
                "deviation_percent": 100 * (ours / published - 1),
                "lower": lower,
                "upper": upper,
                "verdict": judge(estimate, Estimate(published, claim.unit)).word,
            }
        )
    return pd.DataFrame(rows, columns=COLUMNS_OF_TABLE)
