"""Full factorial and regular fractional designs, and the randomised order of their runs."""

from itertools import product
from math import prod

import numpy as np
import pandas as pd

from millprint.config.doe import DoeConfig
from millprint.doe.words import defining_words, resolution, spell


def full_factorial_runs(config: DoeConfig) -> int:
    """Runs of the full factorial, the product of the levels: m^x for equal levels (thesis Eq. 2.8)."""
    return prod(len(factor.levels) for factor in config.factors)


def complete(config: DoeConfig, codes: pd.DataFrame) -> pd.DataFrame:
    """Fill the generated factors' level codes (0, 1, 2...) from those of the base factors."""
    codes = codes.copy()
    for generator in config.parsed_generators:
        total = sum(number * codes[symbol] for symbol, number in generator.coefficients.items())
        codes[generator.factor] = total % len(config.factor(generator.factor).levels)
    return codes[config.symbols]


def level_codes(config: DoeConfig) -> pd.DataFrame:
    """Level codes of the design in standard order, the last base factor fastest: a column for each factor."""
    base = config.base_factors
    rows = product(*(range(len(factor.levels)) for factor in base))
    return complete(config, pd.DataFrame(rows, columns=[factor.symbol for factor in base]))


def treatments(codes: pd.DataFrame) -> pd.Series:
    """The treatment code of each run, its level codes in a row, such as 0112."""
    return codes.astype(int).astype(str).agg("".join, axis=1)


def design_table(config: DoeConfig) -> pd.DataFrame:
    """The design with its settings: case, place in the randomised order, treatment code, settings, level codes."""
    codes = level_codes(config)
    order = np.random.default_rng(config.order_seed).permutation(len(codes)) + 1
    settings = {factor.column: np.asarray(factor.levels)[codes[factor.symbol].to_numpy()] for factor in config.factors}
    return pd.DataFrame(
        {
            "case": np.arange(1, len(codes) + 1),
            "run_order": order,
            "treatment": treatments(codes),
            **settings,
            **codes.to_dict("series"),
        }
    )


def describe(config: DoeConfig) -> dict:
    """The fraction in a few words and numbers: runs, generators, defining relation, resolution."""
    return {
        "factors": len(config.factors),
        "levels": [len(factor.levels) for factor in config.factors],
        "full_factorial_runs": full_factorial_runs(config),
        "runs": len(level_codes(config)),
        "generators": config.generators,
        "defining_words": [spell(word, config.symbols) for word in defining_words(config)],
        "resolution": resolution(config),
        "order_seed": config.order_seed,
    }
