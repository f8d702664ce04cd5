"""The best generators for the factors that a design cannot afford to vary freely."""

from itertools import combinations, product
from math import comb

import numpy as np

from millprint.config.design import PRIMES, DesignConfig
from millprint.errors import ConfigError

# Sets of generators that are compared in a few seconds.
MOST_SETS = 20_000


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
        raise ConfigError(f"factor {unknown[0]}: no such factor; one of {', '.join(config.symbols)} is wanted")
    numbers = {len(config.factor(symbol).levels) for symbol in made}
    levels = numbers.pop()
    if numbers or levels not in PRIMES:
        raise ConfigError(f"factors {', '.join(made)}: the same number of levels, 2, 3, 5 or 7, is wanted")
    base = [factor.symbol for factor in config.factors if len(factor.levels) == levels and factor.symbol not in made]
    candidates = _candidates(len(base), levels)
    if len(candidates) < len(made):
        raise ConfigError(
            f"factors {', '.join(made)}: {len(base)} base factors of {levels} levels make {len(candidates)} of them; "
            "fewer generated factors are wanted"
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
