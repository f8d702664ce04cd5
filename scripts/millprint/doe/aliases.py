"""What is confounded with what: exactly for the regular fraction, in shared degrees of freedom for any runs."""

from itertools import combinations

import numpy as np
import pandas as pd

from millprint.config.doe import DoeConfig
from millprint.doe.design import level_codes
from millprint.doe.words import aliases, defining_subgroup, defining_words, length, low_order_words, spell


def alias_table(config: DoeConfig) -> pd.DataFrame:
    """Aliases of every main effect and two-factor interaction component modulo the defining relation.

    The first row, I, is the defining relation itself. A component is clear if it has no alias of one or two
    letters. A full factorial has whole interactions in place of components, and no aliases.
    """
    symbols = config.symbols
    subgroup = defining_subgroup(config) if config.generators else []
    levels = len(config.factors[0].levels)
    words = [spell(word, symbols) for word in defining_words(config)] if config.generators else []
    rows = [("I", 0, 1, "", " = ".join(words), "")]
    if not subgroup:
        for size in (1, 2):
            for chosen in combinations(config.factors, size):
                freedom = int(np.prod([len(factor.levels) - 1 for factor in chosen]))
                rows.append(("".join(factor.symbol for factor in chosen), size, freedom, "", "", "yes"))
    for word in low_order_words(len(symbols), levels) if subgroup else []:
        others = aliases(word, subgroup, levels)
        low = [spell(other, symbols) for other in others if length(other) <= 2]
        every = [spell(other, symbols) for other in others]
        clear = "no" if low else "yes"
        rows.append((spell(word, symbols), length(word), levels - 1, " = ".join(low), " = ".join(every), clear))
    return pd.DataFrame(
        rows, columns=["effect", "letters", "degrees_of_freedom", "aliases_up_to_two_letters", "aliases", "clear"]
    )


def interaction_partners(config: DoeConfig, term: str) -> list[str]:
    """The two-factor interactions that share a component with the interaction `term` (A:B), itself included."""
    symbols, levels = config.symbols, len(config.factors[0].levels)
    own = tuple(term.split(":"))
    found = {tuple(sorted(own))}
    subgroup = defining_subgroup(config) if config.generators else []
    for word in low_order_words(len(symbols), levels) if subgroup else []:
        letters = {symbol for symbol, power in zip(symbols, word, strict=True) if power}
        if letters == set(own):
            for other in aliases(word, subgroup, levels):
                if length(other) == 2:
                    found.add(tuple(symbol for symbol, power in zip(symbols, other, strict=True) if power))
    return sorted("".join(pair) for pair in found)


def contrasts(levels: int) -> np.ndarray:
    """Orthonormal polynomial contrasts of `levels` equally spaced levels: (levels, levels - 1), linear first."""
    powers = np.vander(np.arange(levels) - (levels - 1) / 2, levels, increasing=True)
    basis = np.linalg.qr(powers)[0][:, 1:]
    return basis * np.sign(basis[-1])


def term_columns(config: DoeConfig, codes: pd.DataFrame, term: str) -> np.ndarray:
    """Contrast columns of a term such as A or A:B: (runs, degrees of freedom)."""
    columns = np.ones((len(codes), 1))
    for symbol in term.split(":"):
        own = contrasts(len(config.factor(symbol).levels))[codes[symbol].to_numpy()]
        columns = (columns[:, :, None] * own[:, None, :]).reshape(len(codes), -1)
    return columns


def _basis(columns: np.ndarray) -> np.ndarray:
    """Orthonormal basis of the columns without their means."""
    left, singular, _ = np.linalg.svd(columns - columns.mean(axis=0), full_matrices=False)
    return left[:, singular > 1e-10 * max(singular.max(initial=0), 1)]


def shared_freedom(left: np.ndarray, right: np.ndarray) -> float:
    """Degrees of freedom that two sets of contrast columns share: the sum of their squared canonical correlations."""
    return float(np.sum((_basis(left).T @ _basis(right)) ** 2))


def confounding_table(config: DoeConfig, runs: pd.DataFrame) -> pd.DataFrame:
    """Degrees of freedom shared by every two main effects and two-factor interactions, as designed and as run.

    Only pairs that share something in either are listed.
    """
    symbols = config.symbols
    terms = [*symbols, *(":".join(pair) for pair in combinations(symbols, 2))]
    designed = {term: term_columns(config, level_codes(config), term) for term in terms}
    run = {term: term_columns(config, runs, term) for term in terms}
    rows = []
    for one, two in combinations(terms, 2):
        shared = [shared_freedom(columns[one], columns[two]) for columns in (designed, run)]
        shared = [0.0 if value < 1e-9 else value for value in shared]
        if any(shared):
            rows.append((one, two, designed[one].shape[1], designed[two].shape[1], *shared))
    columns = ["effect", "with", "degrees_of_freedom", "degrees_of_freedom_with", "shared_as_designed", "shared_as_run"]
    return pd.DataFrame(rows, columns=columns)
