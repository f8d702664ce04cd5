"""Full factorial and regular fractional designs, and the randomised order of their runs."""

from itertools import product
from math import prod

import numpy as np
import pandas as pd

from millprint.config.design import DesignConfig
from millprint.doe.words import alphabet, defining_words, length, resolution, spell, word_lengths


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

    Of more levels, a word that is not zero modulo their number has its value beside it, as in ABCD2(1).
    """
    letters, first = alphabet(config), level_codes(config).iloc[0]
    relation = []
    for word in defining_words(config):
        text = spell(word, letters)
        numbers = {levels for levels, power in zip(letters.levels, word, strict=True) if power}
        value = sum(power * first[symbol] for power, symbol in zip(word, letters.symbols, strict=True))
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
    """The fraction in words and numbers: runs, generators, defining relation, resolution, lengths of its words."""
    return {
        "factors": len(config.factors),
        "levels": [len(factor.levels) for factor in config.factors],
        "full_factorial_runs": full_factorial_runs(config),
        "runs": len(planned_codes(config)),
        "replicates": config.replicates,
        "generators": config.generators,
        "defining_words": defining_relation(config),
        "resolution": resolution(config),
        "defining_words_of_length": {str(number): count for number, count in word_lengths(config).items()},
        "order_seed": config.order_seed,
    }
