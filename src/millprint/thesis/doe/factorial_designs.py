"""Full factorial and regular fractional designs, the randomised order of their runs, and the best generators."""

from itertools import combinations, product
from math import comb, prod

import numpy as np
import pandas as pd

from millprint.config.design import PRIMES, DesignConfig
from millprint.config.errors import ConfigError
from millprint.thesis.doe.fraction import Fraction, length

# Largest number of sets of generators; their comparison takes a few seconds.
MOST_SETS = 20_000


def full_factorial_runs(config: DesignConfig) -> int:
    """Runs of the full factorial, the product of the levels: m^x for equal levels (thesis Eq. 2.8)."""
    return prod(len(factor.levels) for factor in config.factors)


def complete(config: DesignConfig, codes: pd.DataFrame) -> pd.DataFrame:
    """Fill the generated factors' level codes (0, 1, 2...) from those of the base factors."""
    codes = codes.copy()
    for generator in config.parsed_generators:
        levels = len(config.factor(generator.factor).levels)
        total = sum(number * codes[symbol] for symbol, number in generator.coefficients.items())
        codes[generator.factor] = (total + generator.shift(levels)) % levels
    return codes[config.symbols]


def as_designed(config: DesignConfig, runs: pd.DataFrame) -> pd.DataFrame:
    """The runs with the generated factors at the levels that their generators give."""
    return runs.assign(**complete(config, runs[config.symbols]).to_dict("series"))


def level_codes(config: DesignConfig) -> pd.DataFrame:
    """Level codes of the design in standard order, the last base factor fastest: a column for each factor."""
    base = config.base_factors
    rows = product(*(range(len(factor.levels)) for factor in base))
    return complete(config, pd.DataFrame(rows, columns=[factor.symbol for factor in base]))


def planned_codes(config: DesignConfig) -> pd.DataFrame:
    """Level codes of every run of the design, its replicates one after the other."""
    return pd.concat([level_codes(config)] * config.replicates, ignore_index=True)


def treatments(codes: pd.DataFrame) -> pd.Series:
    """The treatment code of each run, its level codes in a row, such as 0112."""
    return codes.astype(int).astype(str).agg("".join, axis=1)


def defining_relation(config: DesignConfig) -> list[str]:
    """The defining words as they hold in this fraction: -ABD of two levels where the product of signs is -1.

    Of more levels, a word that is not zero modulo their number is followed by its value, as in ABCD2(1).
    """
    fraction, first = Fraction(config), level_codes(config).iloc[0]
    relation = []
    for word in fraction.defining_words():
        text = fraction.spell(word)
        numbers = {levels for levels, power in zip(fraction.levels, word, strict=True) if power}
        value = sum(power * first[symbol] for power, symbol in zip(word, fraction.symbols, strict=True))
        if numbers == {2}:
            text = ("-" if (value + length(word)) % 2 else "") + text
        elif len(numbers) == 1 and value % min(numbers):
            text += f"({value % min(numbers)})"
        relation.append(text)
    return relation


def design_table(config: DesignConfig) -> pd.DataFrame:
    """The design with its settings: case, replicate, place in the randomised order, treatment, settings, level codes.

    The order is one permutation of all the runs, so that replicates are not run side by side.
    """
    codes = planned_codes(config)
    order = np.random.default_rng(config.order_seed).permutation(len(codes)) + 1
    settings = {factor.column: [factor.levels[code] for code in codes[factor.symbol]] for factor in config.factors}
    return pd.DataFrame(
        {
            "case": np.arange(1, len(codes) + 1),
            "replicate": 1 + np.arange(len(codes)) // (len(codes) // config.replicates),
            "run_order": order,
            "treatment": treatments(codes),
            **settings,
            **codes.to_dict("series"),
        }
    )


def describe(config: DesignConfig) -> dict:
    """The fraction as plain values: runs, generators, defining relation, resolution, lengths of its words."""
    fraction = Fraction(config)
    return {
        "factors": len(config.factors),
        "levels": list(fraction.levels),
        "full_factorial_runs": full_factorial_runs(config),
        "runs": len(planned_codes(config)),
        "replicates": config.replicates,
        "generators": config.generators,
        "defining_words": defining_relation(config),
        "resolution": fraction.resolution(),
        "defining_words_of_length": {str(number): count for number, count in fraction.word_lengths().items()},
        "order_seed": config.order_seed,
    }


def _candidates(base: int, levels: int) -> list[tuple[int, ...]]:
    """Coefficients of the base factors, two of them at least, the longest first.

    The first is 1: a multiple of a generator only renames the levels of the factor that it makes.
    """
    found = [
        row
        for row in product(range(levels), repeat=base)
        if np.count_nonzero(row) > 1 and next(number for number in row if number) == 1
    ]
    return sorted(found, key=lambda row: (-np.count_nonzero(row), row))


def _word_lengths(chosen: np.ndarray, multiples: np.ndarray, levels: int) -> tuple[int, ...]:
    """Words of length 1, 2, 3... in the defining relation: chosen (made, base), multiples (words, made)."""
    words = np.hstack([multiples @ chosen % levels, -multiples % levels])
    return tuple(np.bincount((words > 0).sum(axis=1), minlength=words.shape[1] + 1)[1:])


def best_generators(config: DesignConfig, made: list[str]) -> list[str]:
    """Generators of the factors `made` with the highest resolution and then the fewest shortest words.

    Minimum aberration (Fries and Hunter, Technometrics 22, 601, 1980), by comparing every set. The factors in `made`
    have the same number of levels, and the base factors are the others with that number. Raises ConfigError for an
    unknown factor, levels of which no regular fraction can be made, too few base factors, or too many sets.
    """
    if unknown := [symbol for symbol in made if symbol not in config.symbols]:
        raise ConfigError(f"factor {unknown[0]}: no such factor; must be one of {', '.join(config.symbols)}")
    numbers = {len(config.factor(symbol).levels) for symbol in made}
    levels = numbers.pop()
    if numbers or levels not in PRIMES:
        raise ConfigError(f"factors {', '.join(made)}: must have the same number of levels, 2, 3, 5 or 7")
    base = [factor.symbol for factor in config.factors if len(factor.levels) == levels and factor.symbol not in made]
    candidates = _candidates(len(base), levels)
    if len(candidates) < len(made):
        raise ConfigError(
            f"factors {', '.join(made)}: {len(base)} base factors of {levels} levels make {len(candidates)} of them; "
            "generate fewer factors"
        )
    if comb(len(candidates), len(made)) > MOST_SETS:
        raise ConfigError(f"factors {', '.join(made)}: too many sets of generators to compare; write them yourself")
    multiples = np.array(list(product(range(levels), repeat=len(made))))[1:]
    best = min(combinations(candidates, len(made)), key=lambda rows: _word_lengths(np.array(rows), multiples, levels))
    return [f"{symbol} = {_sum(base, row, levels)}" for symbol, row in zip(made, best, strict=True)]


def _sum(base: list[str], row: tuple[int, ...], levels: int) -> str:
    if levels == 2:
        return "".join(symbol for symbol, number in zip(base, row, strict=True) if number)
    terms = [f"{number if number > 1 else ''}{symbol}" for symbol, number in zip(base, row, strict=True) if number]
    return " + ".join(terms)
