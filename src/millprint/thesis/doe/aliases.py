"""What is confounded with what: exactly for the regular fraction, in shared degrees of freedom for any runs."""

from itertools import combinations

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from millprint.config.design import DesignConfig, Factor
from millprint.thesis.doe.factorial_designs import defining_relation, level_codes
from millprint.thesis.doe.fraction import Fraction, length


def alias_table(config: DesignConfig) -> pd.DataFrame:
    """Aliases of every main effect and two-factor interaction (component) modulo the defining relation.

    The first row, I, is the defining relation itself. An effect is clear if it has no alias of one or two letters.
    Interactions of factors without a fraction are not split into components. The aliases have no signs: in a fraction
    with I = -ABD, an estimate of A is one of A - BD.
    """
    fraction = Fraction(config)
    rows = [("I", 0, 1, "", " = ".join(defining_relation(config)), "")]
    for word in fraction.low_order_words():
        others = fraction.aliases(word)
        low = " = ".join(fraction.spell(other) for other in others if length(other) <= 2)
        every = " = ".join(map(fraction.spell, others))
        clear = "no" if low else "yes"
        rows.append((fraction.spell(word), length(word), fraction.degrees_of_freedom(word), low, every, clear))
    return pd.DataFrame(
        rows, columns=["effect", "letters", "degrees_of_freedom", "aliases_up_to_two_letters", "aliases", "clear"]
    )


def interaction_partners(config: DesignConfig, term: str) -> list[str]:
    """The two-factor interactions that share a component with the interaction `term` (A:B), itself included."""
    fraction, own = Fraction(config), set(term.split(":"))
    found = {"".join(symbol for symbol in fraction.symbols if symbol in own)}
    for word in fraction.low_order_words():
        if set(fraction.letters(word)) == own:
            found |= {"".join(fraction.letters(other)) for other in fraction.aliases(word) if length(other) == 2}
    return sorted(found)


def contrasts(values: ArrayLike) -> np.ndarray:
    """Orthonormal polynomial contrasts of levels at `values`: (levels, levels - 1), linear first.

    Equally spaced, three of them are the -1, 0, 1 and 1, -2, 1 of thesis Table 2.4, each over its length.
    """
    places = np.asarray(values, dtype=float)
    centred = (places - places.mean()) / np.ptp(places)
    basis = np.linalg.qr(np.vander(centred, len(places), increasing=True))[0][:, 1:]
    return basis * np.sign(basis[-1])


def level_contrasts(factor: Factor) -> np.ndarray:
    """The contrasts of a factor's levels: (levels, levels - 1). Those of names have no order, but span the levels."""
    return contrasts(factor.levels if factor.numeric else range(len(factor.levels)))


def term_columns(config: DesignConfig, codes: pd.DataFrame, term: str) -> np.ndarray:
    """Contrast columns of a term such as A or A:B: (runs, degrees of freedom)."""
    columns = np.ones((len(codes), 1))
    for symbol in term.split(":"):
        own = level_contrasts(config.factor(symbol))[codes[symbol].to_numpy()]
        columns = (columns[:, :, None] * own[:, None, :]).reshape(len(codes), -1)
    return columns


def _basis(columns: np.ndarray) -> np.ndarray:
    """Orthonormal basis of the columns without their means."""
    left, singular, _ = np.linalg.svd(columns - columns.mean(axis=0), full_matrices=False)
    return left[:, singular > 1e-10 * max(singular.max(initial=0), 1)]


def shared_degrees_of_freedom(left: np.ndarray, right: np.ndarray) -> float:
    """Degrees of freedom that two sets of contrast columns share: the sum of their squared canonical correlations."""
    return float(np.sum((_basis(left).T @ _basis(right)) ** 2))


def confounding_table(config: DesignConfig, runs: pd.DataFrame) -> pd.DataFrame:
    """Degrees of freedom shared by every two main effects and two-factor interactions, as designed and as run.

    Only pairs that share something in either are listed.
    """
    symbols = config.symbols
    terms = [*symbols, *(":".join(pair) for pair in combinations(symbols, 2))]
    designed = {term: term_columns(config, level_codes(config), term) for term in terms}
    run = {term: term_columns(config, runs, term) for term in terms}
    rows = []
    for one, two in combinations(terms, 2):
        shared = [shared_degrees_of_freedom(columns[one], columns[two]) for columns in (designed, run)]
        shared = [0.0 if value < 1e-9 else value for value in shared]
        if any(shared):
            rows.append((one, two, designed[one].shape[1], designed[two].shape[1], *shared))
    columns = ["effect", "with", "degrees_of_freedom", "degrees_of_freedom_with", "shared_as_designed", "shared_as_run"]
    return pd.DataFrame(rows, columns=columns)
