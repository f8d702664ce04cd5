"""The design as it was run against the design as it was meant."""

from itertools import combinations

import pandas as pd

from millprint.config.design import DesignConfig, Generator
from millprint.doe.aliases import shared_degrees_of_freedom, term_columns
from millprint.doe.design import complete, level_codes, planned_codes, treatments

Row = tuple[str, str, str, str, str, str]
COLUMNS = ["check", "subject", "found", "wanted", "departs", "note"]


def _setting(config: DesignConfig, symbol: str, code: int) -> str:
    factor = config.factor(symbol)
    return f"{symbol} = {code} ({factor.column} {factor.text(code)})"


def _row(check: str, subject: str, found: object, wanted: object, note: str = "") -> Row:
    return check, subject, str(found), str(wanted), "yes" if str(found) != str(wanted) else "no", note


def _likely_treatment(treatment: str, never_run: list[str]) -> str:
    """Says which treatments of the design, not run otherwise, are one level away from the one that was run."""
    near = [other for other in never_run if sum(a != b for a, b in zip(treatment, other, strict=True)) == 1]
    if not near:
        return ""
    return f"run as {treatment}; {' or '.join(near)}, one setting away, is in the design and was not run"


def _generator_rows(config: DesignConfig, runs: pd.DataFrame, generator: Generator, never_run: list[str]) -> list[Row]:
    text = next(text for text in config.generators if text.strip().startswith(generator.factor))
    wanted = complete(config, runs[config.symbols])[generator.factor]
    found = runs[generator.factor]
    codes = treatments(runs[config.symbols])
    rows = [
        _row(
            f"generator {text}",
            f"case {runs.loc[row, 'case']}",
            _setting(config, generator.factor, found[row]),
            _setting(config, generator.factor, wanted[row]),
            note=_likely_treatment(codes[row], never_run),
        )
        for row in runs.index[found != wanted]
    ]
    return rows or [_row(f"generator {text}", "every case", "holds", "holds")]


def _balance_rows(config: DesignConfig, runs: pd.DataFrame) -> list[Row]:
    """Runs at each level of each factor, low to high."""
    rows = []
    for factor in config.factors:
        counts = [
            "/".join(str(int((codes[factor.symbol] == code).sum())) for code in range(len(factor.levels)))
            for codes in (runs, planned_codes(config))
        ]
        rows.append(_row("runs at each level", f"factor {factor.symbol}", *counts))
    return rows


def _orthogonality_rows(config: DesignConfig, runs: pd.DataFrame) -> list[Row]:
    """Degrees of freedom that the main effects share; zero where the factors are orthogonal."""
    rows = []
    for one, two in combinations(config.symbols, 2):
        shared = (
            shared_degrees_of_freedom(term_columns(config, codes, one), term_columns(config, codes, two))
            for codes in (runs, level_codes(config))
        )
        # Rounded first, for an orthogonal pair shares some 1e-33.
        found, wanted = (f"{round(value, 9):.3g}" for value in shared)
        rows.append(_row("shared degrees of freedom", f"{one} and {two}", found, wanted))
    return rows


def audit_table(config: DesignConfig, runs: pd.DataFrame) -> pd.DataFrame:
    """Every check of the runs against the design, a row each: check, subject, found, wanted, departs, note."""
    done, meant = treatments(runs[config.symbols]), treatments(level_codes(config))
    counts = done.value_counts()
    never_run = [treatment for treatment in meant if treatment not in counts]
    rows = [_row("number of runs", "design", len(runs), len(planned_codes(config)))]
    if "treatment" in runs:
        wrong = runs.index[runs["treatment"] != done]
        rows += [
            _row("treatment code", f"case {runs.loc[row, 'case']}", runs.loc[row, "treatment"], done[row])
            for row in wrong
        ] or [_row("treatment code", "every case", "matches the settings", "matches the settings")]
    for generator in config.parsed_generators:
        rows += _generator_rows(config, runs, generator, never_run)
    rows += [_row("treatment never run", treatment, 0, config.replicates) for treatment in never_run]
    rows += [
        _row("treatment repeated", treatment, count, config.replicates)
        for treatment, count in counts.sort_index().items()
        if count != config.replicates and (count > 1 or treatment in set(meant))
    ]
    return pd.DataFrame(rows + _balance_rows(config, runs) + _orthogonality_rows(config, runs), columns=COLUMNS)
