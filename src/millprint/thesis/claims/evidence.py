"""The registry of the claims: code that finds a claim's value, and the rows that decide it.

What a tolerance allows, the verdicts on a claim by its value and by its repeats, and words for what a claim is.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from decimal import Decimal, InvalidOperation
from fnmatch import fnmatch
from functools import cache, cached_property
from pathlib import Path

import pandas as pd
import yaml

from millprint.config.errors import ConfigError
from millprint.estimate.estimates import Estimate, Interval, spread_of
from millprint.estimate.judge import DIFFERS, OPEN, Allowed, Verdict, judge, judge_all
from millprint.run.files import read_json, read_table
from millprint.run.tables import Number, Text, read_measured

# The reason of a value that differs where two printed places cannot both hold.
ERRATUM = "erratum"

# Values of the column `nature` of claims.tsv, ordered by how much a match proves, least first.
NATURES = {
    "arithmetic": "arithmetic on printed numbers, or read from a table of the thesis and printed back",
    "put_in": "put in and read back",
    "fitted": "fitted to the printed value, or with settings that were read off it",
    "simulated": "simulated",
    "trained": "trained",
    "timed": "run times",
}
# The same on every machine, because they do not depend on chance.
CERTAIN = ("arithmetic",)
# A match of these shows nothing of the thesis.
ASSUMED = ("put_in", "fitted")
TIMED = "timed"

# Values of the column `basis`.
STATED, DERIVED = "stated", "derived"
BASES = {
    STATED: "printed in the thesis, as a number or as a statement",
    DERIVED: "not printed: follows from two printed numbers (a mean from its standard deviation and variation)",
}


# Relative bounds for fitted pairs (tolerance `recover`) and for claims with the tolerance `report`.
RECOVER_BOUND = 0.05
REPORT_BOUND = 0.10

# A bound on the value itself, and a range that it must lie in.
BOUND = re.compile(r"(<=|>=|<|>)\s*([-+.\deE]+)%?")
RANGE = re.compile(r"([-+.\deE]+)\.\.([-+.\deE]+)")


def agrees(published: str, tolerance: str, value: float | str) -> bool:
    """Whether `value` meets `published` within `tolerance` (`allowed`); of a pair, such as 0.30/0.045, each number.

    Raises ValueError for a number instead of a word, or the reverse.
    """
    parts = pairs(published, str(value))
    return all(allowed(one, tolerance).holds(reading(one, tolerance, ours)) for one, ours in parts)


def allowed(published: str, tolerance: str) -> Allowed:
    """The values that meet a printed number or word, as `reading` gives them, within a tolerance.

    Tolerances: `printed` (the published digits, rounded or truncated), `15%` (relative), `0.01` (absolute),
    `<=15%` and `>=3` (a bound on the value itself, for a percentage in per cent), `20..35` (a range), `recover` (5 %),
    `report` (10 %, or the same word), and any word, which must be equal.
    """
    if bound := BOUND.fullmatch(tolerance):
        end, is_open = float(bound[2]), len(bound[1]) == 1
        return Allowed(upper=end, open_upper=is_open) if bound[1][0] == "<" else Allowed(end, open_lower=is_open)
    if within := RANGE.fullmatch(tolerance):
        return Allowed(float(within[1]), float(within[2]))
    if not is_number(published):
        return Allowed(lower=1.0)
    if tolerance != "printed":
        reach = _reach(published, tolerance) * (1 + 1e-12)
        return Allowed(float(published) - reach, float(published) + reach)
    # Rounded: half a unit to either side; truncated: a whole one, away from 0.
    number, unit = Decimal(published), _unit(published)
    if not number:
        return Allowed(-float(unit), float(unit), open_lower=True, open_upper=True)
    near, far = float(abs(number) - unit / 2), float(abs(number) + unit)
    return Allowed(near, far, open_upper=True) if number > 0 else Allowed(-far, -near, open_lower=True)


def reading(published: str, tolerance: str, value: float | str) -> float:
    """A value as a number: of a word 1 if it is the published one, else 0."""
    if not (BOUND.fullmatch(tolerance) or RANGE.fullmatch(tolerance) or is_number(published)):
        return float(str(value) == published)
    # So 0.145 is not read as 0.14499999.
    return round(float(value), 12) if tolerance == "printed" and math.isfinite(float(value)) else float(value)


def pairs(published: str, *others: str) -> list[tuple[str, ...]]:
    """The numbers of a pair such as 0.30/0.045 with those of the others; one tuple for a value that is not a pair."""
    split = published.split("/")
    if len(split) == 1 or not all(map(is_number, split)):
        return [(published, *others)]
    return list(zip(split, *(other.split("/") for other in others), strict=True))


def deviation(published: str, value: float | str | None) -> float | None:
    """Relative deviation from the published number, in per cent; None where one is not a number or the latter is 0."""
    if value is None or not is_number(published) or not is_number(value) or float(published) == 0:
        return None
    if not math.isfinite(float(value)):
        return None
    return 100 * (float(value) - float(published)) / abs(float(published))


def is_number(text: float | str) -> bool:
    """Whether a value or a text is a number, infinite ones included."""
    try:
        return not Decimal(str(text)).is_nan()
    except InvalidOperation:
        return False


def _reach(published: str, tolerance: str) -> float:
    """How far a value may be from a printed number to either side."""
    size = abs(float(published)) or 1.0
    if tolerance in ("recover", "report"):
        return (RECOVER_BOUND if tolerance == "recover" else REPORT_BOUND) * size
    return float(tolerance[:-1]) / 100 * size if tolerance.endswith("%") else float(tolerance)


def _unit(published: str) -> Decimal:
    """One unit of the last printed digit."""
    exponent = Decimal(published).as_tuple().exponent
    assert isinstance(exponent, int), "only infinity and what is not a number have a letter there"
    return Decimal(1).scaleb(exponent)


def judge_value(published: str, tolerance: str, finding: Finding) -> Verdict:
    """The verdict on a claim by only its value: it says whether our number agrees, not whether it holds.

    A value within the tolerance agrees, whatever else the thesis prints. One that differs is an erratum where two
    printed places cannot both hold.
    """
    if finding.value is None:
        return judge(None, Allowed())
    found = judge_all(
        judge(Estimate(reading(one, tolerance, ours), ""), allowed(one, tolerance))
        for one, ours in pairs(published, str(finding.value))
    )
    return Verdict(DIFFERS, ERRATUM) if found.word == DIFFERS and finding.contradiction else found


def judge_repeats(published: str, tolerance: str, finding: Finding) -> Verdict | None:
    """The verdict on a claim by its interval and by the jars that fit as well, which says whether the claim holds.

    A claim that some of these jars meet and others do not is open, and so is one that a smaller run than the thesis's
    misses. None without an interval and without jars.
    """
    found = _judge_with_jars(published, tolerance, finding)
    missed = (found or judge_value(published, tolerance, finding)).word == DIFFERS
    return Verdict(OPEN, finding.smaller) if missed and finding.smaller else found


def _judge_with_jars(published: str, tolerance: str, finding: Finding) -> Verdict | None:
    alone, jars = _judge_interval(published, tolerance, finding), finding.jars
    if finding.value is None or not jars:
        return alone
    found, met = _judge_interval(published, tolerance, finding, jars), jars_that_meet(published, tolerance, jars)
    if found and found.word == OPEN and (met < len(jars) or alone is None or alone.word != OPEN):
        return Verdict(OPEN, f"{met} of {len(jars)} jars and counting rules that fit equally well meet it")
    return found


def jars_that_meet(published: str, tolerance: str, jars: Sequence[float | str]) -> int:
    """How many of the values of a claim by jar meet it."""
    return sum(agrees(published, tolerance, value) for value in jars)


def _judge_interval(
    published: str, tolerance: str, finding: Finding, jars: Sequence[float | str] = ()
) -> Verdict | None:
    own = finding.repeats
    if finding.value is None or (own is None and not jars):
        return None
    of, failed = (own.of, own.failed) if own else (None, 0)
    if of is not None and failed == of:
        return judge(Estimate(math.inf, "", of=of, failed=failed), Allowed())
    found = []
    ends = [own.lower, own.upper] if own else []
    for one, *texts in pairs(published, *map(str, [finding.value, *ends, *jars])):
        value, *values = (reading(one, tolerance, text) for text in texts)
        known = {"repeats": Interval(*sorted(values[:2]))} if own else {}
        if jars:
            by_jar = [value, *values[len(ends) :]]
            known["shape"] = Interval(min(by_jar), max(by_jar))
        estimate = Estimate(value, "", of=of, failed=failed).having(known)
        found.append(judge(estimate, allowed(one, tolerance)))
    return judge_all(found)


def reason_of(value: Verdict, repeats: Verdict | None) -> str:
    """The reason of both verdicts, once where the interval says the same as the value."""
    return "; ".join(dict.fromkeys(each.reason for each in (value, repeats) if each))


@cache
def origins() -> dict[str, tuple[str, str]]:
    """The rule that writes each file, and the function that computes its content; see the head of origins.yaml."""
    listed = yaml.safe_load(Path(__file__).with_name("origins.yaml").read_text(encoding="utf-8"))
    return {
        f"{folder}/{file}": (rule, f"millprint.{function}")
        for folder, files in listed.items()
        for file, (rule, function) in files.items()
    }


@dataclass(frozen=True)
class Source:
    """Where a value comes from.

    path: of the file, from the results folder, or of a file of the project; columns: names, separated by commas;
    rows: a condition on the columns, as `pandas.DataFrame.query` takes it, empty for every row; rule: what writes the
    file; for a simulation run_dem_case, also where a job of another rule run_dem_... holds several, and for the errors
    of a network evaluate_surrogate; function: what computes
    its content.
    """

    path: str
    columns: str
    rows: str
    rule: str
    function: str

    def __str__(self) -> str:
        return f"{self.path}{self.details}"

    @property
    def details(self) -> str:
        """All but the path, in words."""
        rows = f" [{self.rows}]" if self.rows else ""
        return f"{rows} {self.columns} (rule {self.rule}, {self.function})"


def source_in(path: str, columns: str, rows: str = "") -> Source:
    """A source in a file of the results. Raises KeyError for a file that origins.yaml does not have."""
    for pattern, (rule, function) in origins().items():
        if fnmatch(path, pattern) or pattern == f"{path} {columns}":
            return Source(path, columns, rows, rule, function)
    raise KeyError(f"{path}: no file of origins.yaml")


@dataclass(frozen=True)
class Repeats:
    """Between which values a claim's value would lie if chance were drawn again, and what was drawn; or bounds of it.

    lower, upper: two numbers, or two words (the same one twice if it is certain), or pairs such as 0.29/0.044;
    how: what was drawn, or whence the bounds are; of: how many draws, trainings or seeds, None of bounds; failed: how
    many of these failed; they do not enter lower and upper.
    """

    lower: float | str
    upper: float | str
    how: str
    of: int | None
    failed: int = 0

    def within(self, limits: tuple[float, float]) -> Repeats:
        """The part of an interval of numbers that the quantity can take at all; words stay as they are."""
        if isinstance(self.lower, str) or isinstance(self.upper, str):
            return self
        return replace(self, lower=max(self.lower, limits[0]), upper=min(self.upper, limits[1]))


@dataclass(frozen=True)
class Contradiction:
    """Two printed places that cannot both hold: that of the claim, and another one.

    place: the other one, with what it prints; check: the calculation that shows it, only from printed numbers.
    """

    place: str
    check: str

    def __str__(self) -> str:
        return f"contradicts {self.place}: {self.check}"


@dataclass(frozen=True)
class Finding:
    """The computed value for one claim.

    value: the computed number or word, in the unit of the claim; None if it was not run.
    repeats: of a value that is simulated or trained; None of one that is computed from data.
    jars: the value by each jar and counting rule that fits as well as the run's (`millprint.thesis.fit.open_shape`).
    explanation: how it was computed, from how many runs, or why it was not run.
    contradiction: what else the thesis prints that cannot hold together with the claim; a value that differs is then
    an erratum.
    sources: the rows of the results that decide the value.
    limits: what a number of this kind can be at all, such as -1 to 1 of a correlation; its interval ends there.
    failed: whether what was to be measured failed, such as a roll-out that ran away: a miss, whatever its number.
    smaller: in what the run is smaller than the thesis's, in words, where a miss then says nothing of the thesis.
    """

    value: float | str | None
    explanation: str = ""
    contradiction: Contradiction | None = None
    sources: tuple[Source, ...] = ()
    repeats: Repeats | None = None
    jars: tuple[float | str, ...] = ()
    limits: tuple[float, float] = (-math.inf, math.inf)
    failed: bool = False
    smaller: str = ""


class NotRun(Exception):
    """The run has not computed a value that a claim needs; the message says what is missing."""


@dataclass(frozen=True)
class Evidence:
    """What the code of one claim reads: the results of a run, and the values that the thesis prints.

    results: folder of the run; data: folder of claims.tsv; printed: every claim's printed value, as text, by id;
    id: the claim; sources: every row that its code has read to find the value, filled by `rows`, `row` and `cite`;
    tables: by path, those that were read before, or that stand in the place of a file; conditions: a cache of evaluated
    row conditions, each with the columns that it names and the rows that it holds for.
    """

    results: Path
    data: Path
    printed: pd.Series
    id: str = ""
    sources: list[Source] = field(default_factory=list)
    tables: dict[str, pd.DataFrame] = field(default_factory=dict)
    conditions: dict[str, tuple[pd.DataFrame, pd.Series]] = field(default_factory=dict)

    def table(self, path: str, where: str = "") -> pd.DataFrame:
        """Rows of a table of the results, only for an explanation; empty where the run did not write the table.

        path: from the results folder; several files if it is a pattern such as calibration/*/friction_fit.tsv.
        A JSON file is a table of one row. where: a condition on the columns, as `pandas.DataFrame.query` takes it.
        """
        if path not in self.tables:
            paths = sorted(self.results.glob(path))
            tables = [pd.DataFrame([read_json(p)]) if p.suffix == ".json" else read_table(p) for p in paths]
            self.tables[path] = pd.concat(tables, ignore_index=True) if tables else pd.DataFrame()
        table = self.tables[path]
        return table[self._holds(table, where)] if where and len(table.columns) else table.copy()

    def _holds(self, table: pd.DataFrame, where: str) -> pd.Series:
        """Whether a condition holds, by row.

        Its columns hardly ever differ between hundreds of draws of a table: while they are the same, so is the answer.
        """
        named = set(re.findall(r"\w+", where))
        used = table[[name for name in table.columns if name in named]]
        before = self.conditions.get(where)
        if before is None or not before[0].equals(used):
            before = self.conditions[where] = (used, used.eval(where, engine="python"))
        return before[1]

    def rows(self, path: str, columns: str, where: str = "") -> pd.DataFrame:
        """The rows that decide the claim, at least one; they become its source.

        columns: names, separated by commas, of the columns that are used; path and where as in `table`.
        Raises NotRun if there is no such row.
        """
        files = [str(file.relative_to(self.results)) for file in sorted(self.results.glob(path))]
        read = [source_in(name, columns, where) for name in files or [path]]
        self.sources.extend(read)
        if not files:
            raise NotRun(f"rule {read[0].rule} has not written {path}")
        table = self.table(path, where)
        if table.empty:
            raise NotRun(f"{path} has no row with {where}")
        return table

    def row(self, path: str, columns: str, where: str = "") -> pd.Series:
        """The first of `rows`."""
        return self.rows(path, columns, where).iloc[0]

    def cite(self, path: str, names: str, function: Callable) -> None:
        """Make a file of the project, such as config/mills/emax.yaml, the source of a value that is computed here.

        names: what in the file is used; function: what computes the value from it.
        """
        own_name = f"{function.__module__}.{function.__qualname__}"
        self.sources.append(Source(path, names, "", "write_pages", own_name))


@dataclass(frozen=True)
class Form:
    """A form of ids, and the code for every claim whose id has it.

    template: an id, or one with the names of its parts, as in 3.cycle.{diameter}mm.{speed}.{letter}; find: called with
    the evidence and the parts.
    """

    template: str
    find: Callable[..., Finding]

    def parts(self, name: str) -> dict[str, str] | None:
        """What an id says, such as {"speed": "600"}; None for an id of another form."""
        match = self._pattern.fullmatch(name)
        return match and match.groupdict()

    @cached_property
    def _pattern(self) -> re.Pattern[str]:
        return re.compile(re.sub(r"\\{(\w+)\\}", r"(?P<\1>.+)", re.escape(self.template)))

    @property
    def fixed(self) -> int:
        """The length of the text that all ids of this form have in common."""
        return len(re.sub(r"{\w+}", "", self.template))


FORMS: dict[str, Form] = {}


def claim(template: str) -> Callable:
    """Register the decorated function as the code of the claims whose ids in claims.tsv have this form; see `Form`.

    Raises ValueError for a form that is registered already.
    """

    def register(find: Callable[..., Finding]) -> Callable[..., Finding]:
        if template in FORMS:
            raise ValueError(f"claim {template}: it is registered twice")
        FORMS[template] = Form(template, find)
        return find

    return register


def look_up(
    template: str,
    path: str,
    column: str,
    where: str = "",
    told: str = "",
    factor: float = 1.0,
    **names: Mapping[str, str],
) -> None:
    """Register claims whose value is a column of one row of a table, times a factor.

    column, where, told: with the parts of the id in braces, `told` with the columns of the row too; names: what the
    table calls a part of the id, by the part's name. Raises ValueError as `claim`.
    """

    def find(evidence: Evidence, **parts: str) -> Finding:
        words = {name: names.get(name, {}).get(part, part) for name, part in parts.items()}
        value = column.format(**words)
        row = evidence.row(path, value, where.format(**words))
        return Finding(factor * float(row[value]), told.format(**{**row, **words}))

    claim(template)(find)


@cache
def form_of(name: str) -> Form | None:
    """The form of a claim's id; of several the one that fixes most of it, as 2.wear.{speed}.g of 2.wear.1200.g."""
    return max(
        (form for form in FORMS.values() if form.parts(name) is not None), key=lambda form: form.fixed, default=None
    )


def find_claim(evidence: Evidence) -> Finding:
    """The finding of the claim `evidence.id`. Raises ConfigError for an id that no code is registered for."""
    form = form_of(evidence.id)
    if form is None:
        raise ConfigError(f"{evidence.data / 'claims.tsv'}: column id = {evidence.id}: no code computes this claim")
    try:
        found = form.find(evidence, **form.parts(evidence.id) or {})
    except NotRun as lacking:
        found = Finding(None, f"not run: {lacking}")
    return replace(found, sources=tuple(evidence.sources))


def datum(evidence: Evidence, path: str, key: str, value: int, column: str) -> float:
    """A number in the only row of a table of the project with this key; it becomes the source.

    path: such as config/data/screening.tsv. Raises NotRun if there is no such row.
    """
    evidence.cite(path, f"{column} of {key} {value}", read_measured)
    table = read_measured(evidence.data / Path(path).name, [Text(key), Number(column, may_be_blank=True)])
    own = table.loc[table[key] == str(value), column]
    if own.empty:
        raise NotRun(f"{path} has no {key} {value}")
    return float(own.iloc[0])


def in_words(table: pd.DataFrame, form: str, separator: str = ", ") -> str:
    """The rows of a table as text; form: of one row, as `str.format` takes it: "{f:.0f} 1/s at {speed_rpm:g} rpm"."""
    return separator.join(form.format(**row) for row in table.to_dict("records"))


def yes_no(holds: bool, explanation: str) -> Finding:
    """The finding of a claim that holds or does not."""
    return Finding("yes" if holds else "no", explanation)


def repeats_of(values: list[float], how: str, one_more: bool = False) -> Repeats | None:
    """The interval of the mean of a few repeats, or of `one_more`, such as a seed; None of one."""
    return Repeats(*spread_of(values, one_more=one_more), how, len(values)) if len(values) > 1 else None


def as_printed(evidence: Evidence, ids: str) -> bool:
    """Whether this run's own numbers are the printed ones of all these claims, separated by blanks, to the digit.

    An erratum rests on them: where the input is not what the thesis prints, it says nothing of the thesis.
    """
    found = {name: find_claim(replace(evidence, id=name, sources=[])).value for name in ids.split()}
    return all(value is not None and agrees(evidence.printed[name], "printed", value) for name, value in found.items())


def change_percent(before: float, after: float) -> float:
    """By how much a number has changed, over what it was [%]."""
    return 100 * (after / before - 1)


def in_points(first: float, second: float) -> str:
    """Two yields [%] whose difference the thesis prints in per cent and means in points, in words."""
    return f"{second:g} % after {first:g} %; of the first it is {change_percent(first, second):+.1f} %"


def change_contradicted(evidence: Evidence, rests: str, place: str, sign: int = 1) -> Contradiction | None:
    """The contradiction of a printed change [%] with the two printed claims `rests`, which stand in `place`.

    sign: -1 for a change that is printed as a fall. None where what is printed agrees with them, and where this run
    does not have the numbers that are printed for these.
    """
    first, second = (float(evidence.printed[name]) for name in rests.split())
    change = change_percent(first, second)
    if agrees(evidence.printed[evidence.id], "printed", sign * change) or not as_printed(evidence, rests):
        return None
    of_second = 100 * (second - first) / second
    check = f"from {first:g} to {second:g} is {change:+.1f} % of the first and {of_second:+.1f} % of the second"
    return Contradiction(place, f"{check}; the difference is {second - first:+g}")
