"""The alias algebra of regular fractions: effects as words, words as exponents modulo the number of levels.

With p levels (p prime), the word A B2 stands for the p - 1 degrees of freedom of the contrasts between the p
groups of runs with equal (a + 2 b) mod p. A word and its multiples are the same effect, so that the first exponent
is made 1. Two effects are aliases if their quotient is in the subgroup that the generators span.
"""

from itertools import combinations, product

from millprint.config.doe import DoeConfig

Word = tuple[int, ...]


def normalised(word: Word, levels: int) -> Word:
    """The multiple of `word` whose first exponent that is not zero is 1; the empty word stays as it is."""
    first = next((exponent for exponent in word if exponent), 1)
    inverse = pow(first, -1, levels)
    return tuple(exponent * inverse % levels for exponent in word)


def add(left: Word, right: Word, levels: int) -> Word:
    """The product of two effects: the sum of their exponents modulo `levels`."""
    return tuple((a + b) % levels for a, b in zip(left, right, strict=True))


def spell(word: Word, symbols: list[str]) -> str:
    """A word in letters, such as AB2; I for the empty word."""
    letters = [f"{symbol}{power if power > 1 else ''}" for symbol, power in zip(symbols, word, strict=True) if power]
    return "".join(letters) or "I"


def length(word: Word) -> int:
    """The number of letters of a word."""
    return sum(exponent > 0 for exponent in word)


def defining_subgroup(config: DoeConfig) -> list[Word]:
    """Every word that is constant over the fraction, the empty one first: the span of A + B + C - D and its like."""
    levels = len(config.factors[0].levels)
    symbols = config.symbols
    basis = []
    for generator in config.parsed_generators:
        word = [generator.coefficients.get(symbol, 0) % levels for symbol in symbols]
        word[symbols.index(generator.factor)] = levels - 1
        basis.append(word)
    subgroup = [
        tuple(
            sum(factor * word[place] for factor, word in zip(factors, basis, strict=True)) % levels
            for place in range(len(symbols))
        )
        for factors in product(range(levels), repeat=len(basis))
    ]
    return sorted(subgroup, key=lambda word: (length(word), word))


def defining_words(config: DoeConfig) -> list[Word]:
    """The defining relation: each word of the subgroup once, without its multiples and without the empty word."""
    levels = len(config.factors[0].levels)
    words = {normalised(word, levels) for word in defining_subgroup(config) if any(word)}
    return sorted(words, key=lambda word: (length(word), [-exponent for exponent in word]))


def resolution(config: DoeConfig) -> int | None:
    """The length of the shortest defining word; None for a full factorial, where nothing is confounded."""
    return min((length(word) for word in defining_words(config)), default=None)


def aliases(word: Word, subgroup: list[Word], levels: int) -> list[Word]:
    """The effects that cannot be told from `word` in the fraction, `word` itself left out, shortest first."""
    found = {normalised(add(word, other, levels), levels) for other in subgroup}
    found.discard(normalised(word, levels))
    return sorted(found, key=lambda other: (length(other), [-exponent for exponent in other]))


def low_order_words(factors: int, levels: int) -> list[Word]:
    """Every main effect and every two-factor interaction component (such as AB and AB2) of `factors` factors."""
    mains = [tuple(int(place == one) for place in range(factors)) for one in range(factors)]
    pairs = [
        tuple(1 if place == one else power if place == two else 0 for place in range(factors))
        for one, two in combinations(range(factors), 2)
        for power in range(1, levels)
    ]
    return mains + pairs
