"""Designs of experiments: full and regular fractional ones, their aliases, and the runs against the plan.

The alias algebra: effects are words, words are exponents modulo the number of levels. With p levels (p prime), the word
A B2 stands for the p - 1 degrees of freedom of the contrasts between the p groups of runs with equal (a + 2 b) mod p. A
word and its multiples are the same effect, so the first exponent is made 1. Two effects are aliases if their quotient
is in the subgroup that the generators span. Factors with another number of levels have an algebra of their own, and a
word over both is the product of its two parts. Factors of a number of levels that no generator makes are complete, and
their effects are not split into components: the exponent is 1 for the whole effect.

Libraries of designs (pyDOE3) make fractions of two levels and no alias table of three; at two levels they give the
same runs.

The measured runs, checked against the factors of the design, and the contrasts of their levels.
"""

from collections.abc import Sequence
from itertools import combinations, product
from math import comb, prod

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from millprint.config.doe import PRIMES, DesignConfig, Factor, Generator
from millprint.config.errors import ConfigError
from millprint.run.tables import CASE, Number, Text, read_measured, refuse_copies, refuse_rows

YIELD = "yield_percent"
RUN_ORDER = "run_order"
PERCENT_YIELD = Number(YIELD, 0, 100)


def _codes(frame: pd.DataFrame, factor: Factor, path: str) -> np.ndarray:
    """Level codes (runs,) of one factor's settings; refuses a value that is not one of its levels."""
    settings = frame[factor.column].to_numpy()[:, None]
    if factor.numeric:
        near = np.isclose(settings, np.asarray(factor.levels)[None, :], rtol=1e-6, atol=1e-12)
    else:
        near = settings == np.asarray(factor.levels, dtype=object)[None, :]
    known = ", ".join(factor.text(code) for code in range(len(factor.levels)))
    why = f"must be one of the levels of factor {factor.symbol} ({known})"
    refuse_rows(frame, path, factor.column, ~near.any(axis=1), why)
    return near.argmax(axis=1)


def read_runs(path: str, factors: Sequence[Factor], positive: Sequence[str] = ()) -> pd.DataFrame:
    """Read the measured runs: columns case (text), the settings, yield_percent, and a level code a factor.

    Columns `treatment` and `run_order` are kept where there are any; `positive` names further columns that must hold
    numbers above 0. Raises ConfigError, in one line, for a missing column, a text in a numeric column, a case that
    appears twice, a setting that is not a level, a yield outside 0 to 100 %, copies of runs, and equal yields.
    """
    numeric = [factor.column for factor in factors if factor.numeric and factor.column not in positive]
    names = [factor.column for factor in factors if not factor.numeric]
    frame = read_measured(
        path,
        [
            *(Text(name, unique=name == CASE) for name in dict.fromkeys([CASE, *names])),
            *map(Number, numeric),
            *(Number(name, 0, above=True) for name in positive),
            PERCENT_YIELD,
            Number(RUN_ORDER, optional=True),
        ],
    )
    if RUN_ORDER in frame:
        order = frame[RUN_ORDER]
        bad = order.duplicated() | (order != order.round())
        refuse_rows(frame, path, RUN_ORDER, bad, "must be a whole number that no other run has")
    for factor in factors:
        frame[factor.symbol] = _codes(frame, factor, path)
    if frame[YIELD].nunique() == 1:
        raise ConfigError(f"{path}: column {YIELD} = {frame[YIELD].iloc[0]:g} in all rows: there is nothing to explain")
    refuse_copies(frame, path, list(dict.fromkeys([*(factor.column for factor in factors), *positive])), YIELD)
    if "treatment" in frame:
        # A code such as 0011 may have been read as the number 11.
        frame["treatment"] = frame["treatment"].astype(str).str.zfill(len(factors))
    return frame


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


# The exponent of each factor, in the order of the factors.
Word = tuple[int, ...]


def length(word: Word) -> int:
    """The number of letters of a word."""
    return sum(exponent > 0 for exponent in word)


def _by_length(word: Word) -> tuple:
    return length(word), [-exponent for exponent in word]


class Fraction:
    """The words of a design: factors are letters, and a word is an effect.

    symbols, levels: letter and number of levels of each factor. fractional: the numbers of levels that a generator
    makes. subgroup: every word that is constant over the fraction, the empty one first: the span of A + B + C - D and
    the other generators.
    """

    def __init__(self, config: DesignConfig) -> None:
        self.symbols = tuple(config.symbols)
        self.levels = tuple(len(factor.levels) for factor in config.factors)
        level_of = dict(zip(self.symbols, self.levels, strict=True))
        generators = config.parsed_generators
        self.fractional = frozenset(level_of[generator.factor] for generator in generators)
        words = [{**generator.coefficients, generator.factor: -1} for generator in generators]
        multiples = product(*(range(level_of[generator.factor]) for generator in generators))
        spanned = {
            tuple(
                sum(number * word.get(symbol, 0) for number, word in zip(numbers, words, strict=True)) % levels
                for symbol, levels in level_of.items()
            )
            for numbers in multiples
        }
        self.subgroup = sorted(spanned, key=lambda word: (length(word), word))

    def _places(self, number: int) -> list[int]:
        """Places of the factors with a number of levels."""
        return [place for place, levels in enumerate(self.levels) if levels == number]

    def normalised(self, word: Word) -> Word:
        """The multiple of `word` whose first exponent is 1 for each number of levels; the empty word stays empty."""
        result = list(word)
        for number in self.fractional:
            places = self._places(number)
            first = next((word[place] for place in places if word[place]), 1)
            inverse = pow(first, -1, number)
            for place in places:
                result[place] = word[place] * inverse % number
        return tuple(result)

    def times(self, left: Word, right: Word) -> Word:
        """The product of two effects: the sum of their exponents, each modulo its factor's number of levels."""
        return tuple((a + b) % levels for a, b, levels in zip(left, right, self.levels, strict=True))

    def letters(self, word: Word) -> list[str]:
        """The letters of a word, without their exponents."""
        return [symbol for symbol, power in zip(self.symbols, word, strict=True) if power]

    def spell(self, word: Word) -> str:
        """A word in letters, such as AB2; I for the empty word."""
        pairs = zip(self.symbols, word, strict=True)
        return "".join(f"{symbol}{power if power > 1 else ''}" for symbol, power in pairs if power) or "I"

    def degrees_of_freedom(self, word: Word) -> int:
        """Degrees of freedom of the effect of a word."""
        parts = [number - 1 for number in self.fractional if any(word[place] for place in self._places(number))]
        used = [levels for levels, power in zip(self.levels, word, strict=True) if power]
        return prod([*parts, *(levels - 1 for levels in used if levels not in self.fractional)])

    def defining_words(self) -> list[Word]:
        """The defining relation: each word of the subgroup once, without its multiples and without the empty word."""
        return sorted({self.normalised(word) for word in self.subgroup if any(word)}, key=_by_length)

    def word_lengths(self) -> dict[int, int]:
        """How many defining words there are of each length: of two fractions of a resolution, fewer short ones win.

        The shortest length is the resolution. Fries and Hunter, Technometrics 22, 601 (1980).
        """
        lengths = [length(word) for word in self.defining_words()]
        return {number: lengths.count(number) for number in sorted(set(lengths))}

    def resolution(self) -> int | None:
        """The length of the shortest defining word; None for a full factorial, where nothing is confounded."""
        return min(self.word_lengths(), default=None)

    def aliases(self, word: Word) -> list[Word]:
        """The effects that the fraction cannot tell from `word`, shortest first, without `word` itself."""
        found = {self.normalised(self.times(word, other)) for other in self.subgroup}
        return sorted(found - {self.normalised(word)}, key=_by_length)

    def low_order_words(self) -> list[Word]:
        """Every main effect, and every two-factor interaction or component of it (AB and AB2 in a fraction)."""
        places = range(len(self.symbols))
        mains = [tuple(int(place == one) for place in places) for one in places]
        pairs = []
        for one, two in combinations(places, 2):
            split = self.levels[one] == self.levels[two] and self.levels[one] in self.fractional
            for power in range(1, self.levels[two] if split else 2):
                pairs.append(tuple({one: 1, two: power}.get(place, 0) for place in places))
        return mains + pairs


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


def _basis(columns: np.ndarray) -> np.ndarray:
    """Orthonormal basis of the columns without their means."""
    left, singular, _ = np.linalg.svd(columns - columns.mean(axis=0), full_matrices=False)
    return left[:, singular > 1e-10 * max(singular.max(initial=0), 1)]


def shared_degrees_of_freedom(left: np.ndarray, right: np.ndarray) -> float:
    """Degrees of freedom that two sets of contrast columns share: the sum of their squared canonical correlations."""
    return float(np.sum((_basis(left).T @ _basis(right)) ** 2))


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
