"""The registry of the claims: code that finds a claim's value, the rows that decide it, tolerances and verdicts."""

import math
import re
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from decimal import ROUND_DOWN, ROUND_HALF_UP, Decimal, InvalidOperation
from fnmatch import fnmatch
from pathlib import Path

import pandas as pd

from millprint.config.errors import ConfigError
from millprint.run.files import read_json, read_table
from millprint.statistics.quantiles import FEWEST_REPEATS, spread_of

# By the value itself.
REPRODUCED, DEVIATES, ERRATUM, NOT_RUN = "reproduced", "deviates", "erratum", "not run"
VERDICTS = (REPRODUCED, ERRATUM, DEVIATES, NOT_RUN)

# By the interval, of claims that have one; these two besides REPRODUCED and DEVIATES.
UNDECIDED, TOO_WIDE, TOO_FEW = "undecided", "wider than the tolerance", "too few repeats"
INTERVAL_VERDICTS = (REPRODUCED, DEVIATES, UNDECIDED, TOO_WIDE, TOO_FEW)
# Another run may fall on either side of the tolerance.
OPEN_VERDICTS = (UNDECIDED, TOO_WIDE, TOO_FEW)


# Values of the column `nature` of claims.tsv, ordered by how much a match proves, least first.
NATURES = {
    "read": "read from a table of the thesis and printed back",
    "arithmetic": "arithmetic on printed numbers",
    "put_in": "put in and read back",
    "fitted": "fitted to the printed value",
    "simulated": "simulated",
    "trained": "trained",
    "timed": "a run time",
}
# The same on every machine, because they do not depend on chance.
CERTAIN = ("read", "arithmetic")
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
_ORDERS = {"<=": lambda a, b: a <= b, ">=": lambda a, b: a >= b, "<": lambda a, b: a < b, ">": lambda a, b: a > b}


def agrees(published: str, tolerance: str, value: float | str) -> bool:
    """Whether `value` meets `published` within `tolerance`.

    Tolerances: `printed` (the published digits, rounded or truncated), `15%` (relative), `0.01` (absolute),
    `<=15%` and `>=3` (a bound on the value itself, for a percentage in per cent), `20..35` (a range), `recover` (5 %),
    `report` (10 %, or the same word), and any word, which must be equal. Of a pair, such as 0.30/0.045, each number.
    Raises ValueError for a number instead of a word, or the reverse.
    """
    parts = pairs(published, str(value))
    if len(parts) > 1:
        return all(agrees(theirs, tolerance, ours) for theirs, ours in parts)
    bound, within = BOUND.fullmatch(tolerance), RANGE.fullmatch(tolerance)
    if bound:
        return _ORDERS[bound[1]](float(value), float(bound[2]))
    if within:
        return float(within[1]) <= float(value) <= float(within[2])
    if not is_number(published):
        return str(value) == published
    value = float(value)
    if not math.isfinite(value):
        return False
    if tolerance == "printed":
        return _has_digits(published, value)
    return abs(value - float(published)) <= _reach(published, tolerance) * (1 + 1e-12)


def pairs(published: str, *others: str) -> list[tuple[str, ...]]:
    """The numbers of a pair such as 0.30/0.045 with those of the others; one tuple for a value that is not a pair."""
    split = published.split("/")
    if len(split) == 1 or not all(map(is_number, split)):
        return [(published, *others)]
    return list(zip(split, *(other.split("/") for other in others), strict=True))


def allowed_width(published: str, tolerance: str) -> float:
    """The width of what a tolerance allows about a printed number; infinite for a bound and for a word."""
    if within := RANGE.fullmatch(tolerance):
        return float(within[2]) - float(within[1])
    if BOUND.fullmatch(tolerance) or not is_number(published):
        return math.inf
    # Rounded: half a unit to either side; truncated: a whole one to one side.
    return 1.5 * float(_unit(published)) if tolerance == "printed" else 2 * _reach(published, tolerance)


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


def _has_digits(published: str, value: float) -> bool:
    step = _unit(published)
    # repr carries the shortest digits that give the number back, so 0.145 is not read as 0.14499999.
    exact = Decimal(repr(round(value, 12)))
    return Decimal(published) in (exact.quantize(step, ROUND_HALF_UP), exact.quantize(step, ROUND_DOWN))


# By path from the results folder: the rule that writes the file, and the function that computes its content. Where one
# column has a function of its own, its name follows the path. Functions are named, not imported: claims read files, and
# what computed these would bring most of the library.
ORIGINS: dict[str, tuple[str, str]] = {
    "doe/fraction.json": ("tabulate_experiments", "millprint.thesis.doe.factorial_designs.describe"),
    "doe/audit.tsv": ("tabulate_experiments", "millprint.thesis.doe.factorial_designs.audit_table"),
    "doe/anova_printed.tsv": ("analyse_variance", "millprint.thesis.doe.variance.printed_table"),
    "doe/interactions.tsv": ("analyse_variance", "millprint.thesis.doe.variance.interaction_table"),
    "doe/residuals.tsv": ("analyse_variance", "millprint.thesis.doe.residuals.residual_table"),
    "doe/pareto.tsv": ("analyse_variance", "millprint.thesis.doe.variance.pareto_table"),
    "doe/half_life.tsv": ("tabulate_experiments", "millprint.thesis.doe.wet_lab.half_life_table"),
    "doe/wear.tsv": ("tabulate_experiments", "millprint.thesis.doe.wet_lab.wear_table"),
    "calibration/drop_test.tsv": ("calibrate_restitution", "millprint.thesis.calibration.drop.simulate_drops"),
    "calibration/*/friction_fit.tsv": ("fit_friction", "millprint.thesis.calibration.friction_fit.fit_experiment"),
    "convergence/modulus.tsv": ("tabulate_convergence", "millprint.dem.convergence.convergence_table"),
    "dem/*/summary.json": ("run_dem_case", "millprint.dem.summary.summarise"),
    "fingerprint/descriptors.tsv": ("fit_master_curves", "millprint.fingerprint.descriptors.tabulate_descriptors"),
    "fingerprint/cycles.tsv": ("fit_master_curves", "millprint.thesis.curves.cycles.tabulate_cycles"),
    "fingerprint/means_*.tsv": ("fit_master_curves", "millprint.thesis.curves.scaling.average_curves"),
    "fingerprint/collapse.tsv": ("fit_master_curves", "millprint.thesis.curves.collapse.tabulate_collapse"),
    "fingerprint/inverse.tsv": ("fit_master_curves", "millprint.thesis.curves.scaling.invert_speed"),
    "partition/table_4_2.tsv yield_percent": ("partition_dissipation", "millprint.thesis.curves.regimes.read_regimes"),
    "partition/table_4_2.tsv": ("partition_dissipation", "millprint.thesis.curves.regimes.design_cases"),
    "partition/table_4_3.tsv": ("partition_dissipation", "millprint.thesis.curves.energy.compare_with_prior"),
    "partition/table_4_4.tsv": ("partition_dissipation", "millprint.thesis.curves.energy.specific_yields"),
    "partition/table_4_5.tsv": ("partition_dissipation", "millprint.thesis.curves.energy.energy_leverage"),
    "partition/slopes.tsv": ("partition_dissipation", "millprint.thesis.curves.energy.fit_slopes"),
    "yield/scores_by_scheme.tsv": ("evaluate_yield_models", "millprint.thesis.yields.evaluation.score_table"),
    "yield/out_of_domain.tsv": ("evaluate_yield_models", "millprint.thesis.yields.evaluation.predictions"),
    "yield/time_variance.tsv": ("evaluate_yield_models", "millprint.thesis.yields.evaluation.time_variance"),
    "yield/shap_ranking.tsv": ("evaluate_yield_models", "millprint.thesis.yields.evaluation.rank_features"),
    "surrogate/*/metrics.tsv": ("evaluate_surrogate", "millprint.thesis.surrogate.rollout_evaluation.evaluate"),
    "surrogate/runtime.tsv dem_seconds_for_15_s": (
        "time_surrogates",
        "millprint.thesis.surrogate.timing.simulation_seconds",
    ),
    "surrogate/runtime.tsv": ("time_surrogates", "millprint.thesis.surrogate.timing.time_rollouts"),
    "surrogate/wall_contacts.tsv": (
        "build_surrogate_dataset",
        "millprint.thesis.surrogate.measure_tables.wall_contact_table",
    ),
    "surrogate/ablations.tsv": ("tabulate_ablations", "millprint.thesis.surrogate.measure_tables.ablation_table"),
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
    """A source in a file of the results. Raises KeyError for a file that ORIGINS does not have."""
    for pattern, (rule, function) in ORIGINS.items():
        if fnmatch(path, pattern) or pattern == f"{path} {columns}":
            return Source(path, columns, rows, rule, function)
    raise KeyError(f"{path}: no file of claims.sources.ORIGINS")


@dataclass(frozen=True)
class Interval:
    """Between which values a claim's value would lie if chance were drawn again, and what was drawn.

    lower, upper: two numbers, or two words (the same one twice if it is certain), or pairs such as 0.29/0.044;
    repeats: how many draws, trainings or seeds it is of; failed: how many of these failed; they do not enter lower and
    upper.
    """

    lower: float | str
    upper: float | str
    origin: str
    repeats: int
    failed: int = 0

    def within(self, limits: tuple[float, float]) -> "Interval":
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
    interval: of a value that is simulated or trained; None of one that is computed from data.
    explanation: how it was computed, from how many runs, or why it was not run.
    contradiction: what else the thesis prints that cannot hold together with the claim; a value that is not reproduced
    is then an erratum.
    sources: the rows of the results that decide the value.
    limits: what a number of this kind can be at all, such as -1 to 1 of a correlation; its interval ends there.
    failed: whether what was to be measured failed, such as a roll-out that ran away: a miss, whatever its number.
    """

    value: float | str | None
    explanation: str = ""
    contradiction: Contradiction | None = None
    sources: tuple[Source, ...] = ()
    interval: Interval | None = None
    limits: tuple[float, float] = (-math.inf, math.inf)
    failed: bool = False


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

    def rows(self, path: str, columns: str, where: str = "", lacking: str = "") -> pd.DataFrame:
        """The rows that decide the claim, at least one; they become its source.

        columns: names, separated by commas, of the columns that are used; path and where as in `table`.
        Raises NotRun if there is no such row, with the message `lacking` where the file is there.
        """
        files = [str(file.relative_to(self.results)) for file in sorted(self.results.glob(path))]
        read = [source_in(name, columns, where) for name in files or [path]]
        self.sources.extend(read)
        if not files:
            raise NotRun(f"rule {read[0].rule} has not written {path}")
        table = self.table(path, where)
        if table.empty:
            raise NotRun(lacking or f"{path} has no row with {where}")
        return table

    def row(self, path: str, columns: str, where: str = "", lacking: str = "") -> pd.Series:
        """The first of `rows`."""
        return self.rows(path, columns, where, lacking).iloc[0]

    def cite(self, path: str, names: str, function: Callable) -> None:
        """Make a file of the project, such as config/mills/emax.yaml, the source of a value that is computed here.

        names: what in the file is used; function: what computes the value from it.
        """
        own_name = f"{function.__module__}.{function.__qualname__}"
        self.sources.append(Source(path, names, "", "write_pages", own_name))


@dataclass(frozen=True)
class Claim:
    """A claim and the code for it.

    parts: what the id says, such as {"speed": "600"}; find, explain_deviation: called with the evidence and the parts.
    """

    id: str
    parts: dict[str, str]
    find: Callable[..., Finding]
    explain_deviation: Callable[..., str] | None = None


CLAIMS: dict[str, Claim] = {}


def claim(template: str, ids: str = "", explain_deviation: Callable[..., str] | None = None) -> Callable:
    """Register the decorated function as the code of one claim, or of several whose ids have one form.

    template: the id, or the form of the ids with the names of their parts, as in 3.cycle.{diameter}mm.{speed};
    ids: all ids of that form, separated by blanks; explain_deviation: says in words why such a value deviates.
    Raises ValueError for an id of another form, and for one that is registered already.
    """
    pattern = re.sub(r"\\{(\w+)\\}", r"(?P<\1>.+)", re.escape(template))

    def register(find: Callable[..., Finding]) -> Callable[..., Finding]:
        for name in ids.split() or [template]:
            match = re.fullmatch(pattern, name)
            if match is None:
                raise ValueError(f"claim {name}: its id is not of the form {template}")
            if name in CLAIMS:
                raise ValueError(f"claim {name}: it is registered twice")
            CLAIMS[name] = Claim(name, match.groupdict(), find, explain_deviation)
        return find

    return register


def find_claim(evidence: Evidence) -> Finding:
    """The finding of the claim `evidence.id`. Raises ConfigError for an id that no code is registered for."""
    if evidence.id not in CLAIMS:
        raise ConfigError(f"{evidence.data / 'claims.tsv'}: column id = {evidence.id}: no code computes this claim")
    own = CLAIMS[evidence.id]
    try:
        found = own.find(evidence, **own.parts)
    except NotRun as lacking:
        found = Finding(None, f"not run: {lacking}")
    return replace(found, sources=tuple(evidence.sources))


def in_words(table: pd.DataFrame, form: str, separator: str = ", ") -> str:
    """The rows of a table as text; form: of one row, as `str.format` takes it: "{f:.0f} 1/s at {speed_rpm:g} rpm"."""
    return separator.join(form.format(**row) for row in table.to_dict("records"))


def yes_no(holds: bool, explanation: str) -> Finding:
    """The finding of a claim that holds or does not."""
    return Finding("yes" if holds else "no", explanation)


def interval_of(values: list[float], origin: str) -> Interval | None:
    """The interval of the mean of a few repeats, such as seeds; None of one."""
    return Interval(*spread_of(values), origin, len(values)) if len(values) > 1 else None


def as_printed(evidence: Evidence, ids: str) -> bool:
    """Whether this run's own numbers are the printed ones of all these claims, separated by blanks, to the digit.

    An erratum rests on them: where the input is not what the thesis prints, it says nothing of the thesis.
    """
    found = {name: find_claim(replace(evidence, id=name, sources=[])).value for name in ids.split()}
    return all(value is not None and agrees(evidence.printed[name], "printed", value) for name, value in found.items())


def verdict(published: str, tolerance: str, finding: Finding) -> str:
    """One of VERDICTS, by the value.

    A value within the tolerance is reproduced, whatever else the thesis prints. Else it is an erratum where two printed
    places cannot both hold, and deviates where they can.
    """
    if finding.value is None:
        return NOT_RUN
    if agrees(published, tolerance, finding.value):
        return REPRODUCED
    return ERRATUM if finding.contradiction else DEVIATES


def interval_verdict(published: str, tolerance: str, finding: Finding) -> str:
    """One of INTERVAL_VERDICTS; empty for a claim without an interval.

    Fewer than FEWEST_REPEATS decide nothing. `reproduced` if the interval lies inside the tolerance and no repeat
    failed, `deviates` if it lies outside, and else undecided, or too wide where it is wider than what is allowed.
    """
    interval = finding.interval
    if finding.value is None or interval is None:
        return ""
    if interval.repeats < FEWEST_REPEATS:
        return TOO_FEW
    if interval.failed == interval.repeats:
        return DEVIATES
    parts = pairs(published, str(interval.lower), str(interval.upper))
    found = [_of_ends(theirs, lower, upper, tolerance) for theirs, lower, upper in parts]
    worst = next((one for one in (DEVIATES, TOO_WIDE, UNDECIDED) if one in found), REPRODUCED)
    # A repeat that failed is a miss, so that the others cannot all be hits.
    return UNDECIDED if worst == REPRODUCED and interval.failed else worst


def _of_ends(published: str, lower: str, upper: str, tolerance: str) -> str:
    inside = [agrees(published, tolerance, end) for end in (lower, upper)]
    if all(inside):
        return REPRODUCED
    numbers = is_number(lower) and is_number(upper)
    # A tolerance allows one connected range. If it is about a printed number, the range contains that number.
    about = numbers and is_number(published) and not BOUND.fullmatch(tolerance) and not RANGE.fullmatch(tolerance)
    around = about and float(lower) <= float(published) <= float(upper)
    if not any(inside) and not around and not _holds_range(tolerance, lower, upper):
        return DEVIATES
    wide = numbers and float(upper) - float(lower) > allowed_width(published, tolerance)
    return TOO_WIDE if wide else UNDECIDED


def _holds_range(tolerance: str, lower: str, upper: str) -> bool:
    """Whether an interval holds the range that a tolerance names."""
    within = RANGE.fullmatch(tolerance)
    return within is not None and float(lower) <= float(within[1]) and float(within[2]) <= float(upper)
