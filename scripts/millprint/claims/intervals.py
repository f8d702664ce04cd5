"""The interval of a claim: what its value would be if chance were drawn again, by the claim's own code.

Another processor rounds otherwise, and a mill of balls is chaotic: its run is another draw. So is the training of a
network. A claim is therefore computed again with other tables in the place of those that decide it.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pandas as pd

from millprint.claims.chapter6 import TRAININGS
from millprint.claims.compare import is_number
from millprint.claims.evidence import Evidence, Finding, Interval, find_claim
from millprint.claims.tabulate import collect_findings, read_claims
from millprint.files import read_table
from millprint.progress import progress
from millprint.repeats import LEVEL, student
from millprint.surrogate.spread import with_failures

WINDOWS = "bootstrap of windows"
# Claims of these kinds have an interval; what is computed from data has none.
UNCERTAIN = ("simulated", "trained")

Value = float | str
Tables = dict[str, pd.DataFrame]


@dataclass(frozen=True)
class Repeated:
    """Tables that stand in for files of the results, drawn again and again.

    origin: what is drawn, as the claims say it; tables: of each draw, by path from the results folder; between: the
    interval of a claim's values over the draws.
    """

    origin: str
    tables: Sequence[Tables]
    between: Callable[[Value, list[Value], float], Interval]

    def decides(self, finding: Finding) -> bool:
        """Whether the value of a claim follows from one of these tables."""
        return any(source.path in self.tables[0] for source in finding.sources) if self.tables else False


def quantiles(values: Sequence[float], level: float = LEVEL) -> tuple[float, float]:
    """The middle of many draws."""
    low, high = np.quantile(np.asarray(values, dtype=float), [(1 - level) / 2, (1 + level) / 2])
    return float(low), float(high)


def over_repeats(value: Value, values: list[Value], level: float, origin: str = TRAININGS) -> Interval:
    """The interval over a few repeats, such as trainings, the value among them: `student`.

    Of statements, the first that is other than the value is the lower end.
    """
    if not all(is_number(one) for one in [value, *values]):
        return Interval(next((one for one in values if one != value), value), value, origin)
    return _holding(value, student([float(one) for one in values], level), origin)


def over_draws(value: Value, values: list[Value], level: float, origin: str = WINDOWS) -> Interval:
    """The interval over many draws: `quantiles`, moved so that their median is the value, which removes a bias.

    A draw has fewer different revolutions than its run, so that its spread is too small; a largest value is too large.
    Of statements, the commonest other one is the lower end where it is drawn more often than each end of an interval
    is left out, (1 - level) / 2.
    """
    if not all(is_number(one) for one in [value, *values]):
        others = pd.Series([one for one in values if one != value], dtype=object).value_counts()
        often = len(others) and others.sum() > (1 - level) / 2 * len(values)
        return Interval(str(others.index[0]) if often else value, value, origin)
    found = [float(one) for one in values]
    low, high = quantiles(found, level)
    bias = float(np.median(found)) - float(value)
    return _holding(value, (low - bias, high - bias), origin)


def _holding(value: Value, ends: tuple[float, float], origin: str) -> Interval:
    return Interval(min(ends[0], float(value)), max(ends[1], float(value)), origin)


def values_of(name: str, evidence: Evidence, tables: Sequence[Tables]) -> list[Value]:
    """The values of a claim with each of these tables in the place of the files; without draws that do not give one."""
    found = [find_claim(replace(evidence, id=name, sources=[], tables=evidence.tables | own)).value for own in tables]
    # A number that is not one is unequal to itself.
    return [value for value in found if value is not None and value == value]


def tabulate_intervals(
    results: str | Path, claims_path: str | Path, repeated: Sequence[Repeated], level: float = LEVEL
) -> pd.DataFrame:
    """A row for each claim that is simulated or trained and has an interval: id, lower, upper, interval_from, repeats.

    A claim that no repeated table decides keeps the interval that its own code states. Raises ConfigError as
    `millprint.claims.tabulate.read_claims`.
    """
    claims, findings = read_claims(claims_path), collect_findings(results, claims_path)
    uncertain = [name for name in claims.index[claims["kind"].isin(UNCERTAIN)] if findings[name].value is not None]
    evidence = Evidence(Path(results), Path(claims_path).parent, claims["value"])
    rows = []
    with progress(len(uncertain), None, "claim") as bar:
        for name in uncertain:
            finding, interval, repeats = findings[name], findings[name].interval, 0
            for one in repeated:
                if not one.decides(finding):
                    continue
                values = values_of(name, evidence, one.tables)
                if len(values) >= 2 and finding.value is not None:
                    interval, repeats = one.between(finding.value, values, level), len(values)
                break
            if interval is not None:
                interval = interval.within(finding.limits)
                ends = {"lower": interval.lower, "upper": interval.upper, "interval_from": interval.origin}
                rows.append({"id": name, **ends, "repeats": repeats or ""})
            bar.update()
    return pd.DataFrame(rows, columns=["id", "lower", "upper", "interval_from", "repeats"])


def repeated_trainings(results: str | Path, trainings: dict[str, list[str]]) -> list[Repeated]:
    """The measures of the trainings of each surrogate in the place of those of the first.

    trainings: by the name of a surrogate, the names of all of its trainings, itself first. One that failed counts as
    infinitely far off: it opens the interval, whose other end is of those that held.
    """
    found = []
    for name, names in trainings.items():
        path = f"surrogate/{name}/metrics.tsv"
        files = [Path(results) / f"surrogate/{one}/metrics.tsv" for one in names]
        if len(files) > 1 and all(file.exists() for file in files):
            tables = [{path: with_failures(read_table(file))} for file in files]
            found.append(Repeated(TRAININGS, tables, over_repeats))
    return found
