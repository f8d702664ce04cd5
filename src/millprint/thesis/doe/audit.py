"""The runs as they were done against the design as it was planned."""

from itertools import combinations

import numpy as np
import pandas as pd

from millprint.config.design import DesignConfig, Generator
from millprint.thesis.doe.aliases import shared_degrees_of_freedom, term_columns
from millprint.thesis.doe.factorial_designs import complete, level_codes, planned_codes, treatments

Row = tuple[str, str, str, str, str, str]
# The column `wanted` holds what the design planned.
AUDIT_COLUMNS = ["check", "subject", "found", "wanted", "departs", "note"]


def _row(check: str, subject: str, found: object, planned: object, note: str = "") -> Row:
    return check, subject, str(found), str(planned), "yes" if str(found) != str(planned) else "no", note


def _likely_treatment(treatment: str, never_run: list[str]) -> str:
    """A note on the treatments of the design that were not run and differ from `treatment` in one setting."""
    near = [other for other in never_run if sum(a != b for a, b in zip(treatment, other, strict=True)) == 1]
    if not near:
        return ""
    return f"run as {treatment}; {' or '.join(near)}, one setting away, is in the design and was not run"


def _generator_rows(config: DesignConfig, runs: pd.DataFrame, generator: Generator, never_run: list[str]) -> list[Row]:
    """The runs in which a generated factor has another level than its generator gives."""
    text = next(text for text in config.generators if text.strip().startswith(generator.factor))
    factor = config.factor(generator.factor)

    def setting(code: int) -> str:
        return f"{factor.symbol} = {code} ({factor.column} {factor.text(code)})"

    planned, found = complete(config, runs[config.symbols])[factor.symbol], runs[factor.symbol]
    codes = treatments(runs[config.symbols])
    rows = [
        _row(
            f"generator {text}",
            f"case {runs.loc[row, 'case']}",
            setting(found[row]),
            setting(planned[row]),
            note=_likely_treatment(codes[row], never_run),
        )
        for row in runs.index[found != planned]
    ]
    return rows or [_row(f"generator {text}", "every case", "holds", "holds")]


def audit_table(config: DesignConfig, runs: pd.DataFrame) -> pd.DataFrame:
    """Every check of the runs against the design, a row each, with AUDIT_COLUMNS.

    Numbers of runs, treatment codes, generators, treatments that were never run or repeated, runs at each level from
    low to high, and degrees of freedom that two main effects share: zero if the factors are orthogonal.
    """
    done, planned = treatments(runs[config.symbols]), treatments(level_codes(config))
    counts = done.value_counts()
    never_run = [treatment for treatment in planned if treatment not in counts]
    rows = [_row("number of runs", "design", len(runs), len(planned_codes(config)))]
    if "treatment" in runs:
        rows += [
            _row("treatment code", f"case {runs.loc[row, 'case']}", runs.loc[row, "treatment"], done[row])
            for row in runs.index[runs["treatment"] != done]
        ] or [_row("treatment code", "every case", "matches the settings", "matches the settings")]
    for generator in config.parsed_generators:
        rows += _generator_rows(config, runs, generator, never_run)
    rows += [_row("treatment never run", treatment, 0, config.replicates) for treatment in never_run]
    rows += [
        _row("treatment repeated", treatment, count, config.replicates)
        for treatment, count in counts.sort_index().items()
        if count != config.replicates and (count > 1 or treatment in set(planned))
    ]
    for factor in config.factors:
        levels = [
            "/".join(map(str, np.bincount(codes[factor.symbol], minlength=len(factor.levels))))
            for codes in (runs, planned_codes(config))
        ]
        rows.append(_row("runs at each level", f"factor {factor.symbol}", *levels))
    for pair in combinations(config.symbols, 2):
        # Rounded first, because an orthogonal pair shares some 1e-33.
        shared = [
            f"{round(shared_degrees_of_freedom(*(term_columns(config, codes, one) for one in pair)), 9):.3g}"
            for codes in (runs, level_codes(config))
        ]
        rows.append(_row("shared degrees of freedom", " and ".join(pair), *shared))
    return pd.DataFrame(rows, columns=AUDIT_COLUMNS)
