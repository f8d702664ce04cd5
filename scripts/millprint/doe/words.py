"""The alias algebra of regular fractions: effects as words, words as exponents modulo the number of levels.

With p levels (p prime), the word A B2 stands for the p - 1 degrees of freedom of the contrasts between the p
groups of runs with equal (a + 2 b) mod p. A word and its multiples are the same effect, so that the first exponent
is made 1. Two effects are aliases if their quotient is in the subgroup that the generators span. Factors with
another number of levels have an algebra of their own, and a word over both is the product of its two parts. Where
no generator makes a factor of some number of levels, those factors are complete and no effect is split into
components: the exponent is 1 for the whole effect.

Libraries of designs (pyDOE3) make fractions of two levels and no alias table of three; at two levels they give the
same runs.
"""

from dataclasses import dataclass
from itertools import combinations, product
from math import prod

from millprint.config.design import DesignConfig

Word = tuple[int, ...]


@dataclass(frozen=True)
class Alphabet:
    """The factors as the letters of words: their symbols, numbers of levels, and which numbers are fractionated."""

    symbols: tuple[str, ...]
    levels: tuple[int, ...]
    fractional: frozenset[int]

    def places(self, number: int) -> list[int]:
        """The places of the factors with a number of levels."""
        return [place for place, own in enumerate(self.levels) if own == number]

    def whole(self, place: int) -> bool:
        """Whether the factor at a place is complete, its effects not split into components."""
        return self.levels[place] not in self.fractional


def alphabet(config: DesignConfig) -> Alphabet:
    """The alphabet of a design."""
    levels = tuple(len(factor.levels) for factor in config.factors)
    made = frozenset(len(config.factor(generator.factor).levels) for generator in config.parsed_generators)
    return Alphabet(tuple(config.symbols), levels, made)


def normalised(word: Word, letters: Alphabet) -> Word:
    """The multiple of `word` whose first exponent of each number of levels is 1; the empty word stays as it is."""
    result = list(word)
    for number in letters.fractional:
        places = letters.places(number)
        first = next((word[place] for place in places if word[place]), 1)
        inverse = pow(first, -1, number)
        for place in places:
            result[place] = word[place] * inverse % number
    return tuple(result)


def add(left: Word, right: Word, letters: Alphabet) -> Word:
    """The product of two effects: the sum of their exponents, each modulo its factor's number of levels."""
    return tuple((a + b) % levels for a, b, levels in zip(left, right, letters.levels, strict=True))


def spell(word: Word, letters: Alphabet) -> str:
    """A word in letters, such as AB2; I for the empty word."""
    pairs = zip(letters.symbols, word, strict=True)
    return "".join(f"{symbol}{power if power > 1 else ''}" for symbol, power in pairs if power) or "I"


def length(word: Word) -> int:
    """The number of letters of a word."""
    return sum(exponent > 0 for exponent in word)


def freedom(word: Word, letters: Alphabet) -> int:
    """Degrees of freedom of the effect that a word stands for."""
    parts = [number - 1 for number in letters.fractional if any(word[place] for place in letters.places(number))]
    parts += [letters.levels[place] - 1 for place, power in enumerate(word) if power and letters.whole(place)]
    return prod(parts)


def defining_subgroup(config: DesignConfig) -> list[Word]:
    """Every word that is constant over the fraction, the empty one first: the span of A + B + C - D and its like."""
    letters = alphabet(config)
    generators = config.parsed_generators
    basis, orders = [], []
    for generator in generators:
        levels = len(config.factor(generator.factor).levels)
        word = [generator.coefficients.get(symbol, 0) % levels for symbol in letters.symbols]
        word[letters.symbols.index(generator.factor)] = levels - 1
        basis.append(word)
        orders.append(levels)
    subgroup = {
        tuple(
            sum(factor * word[place] for factor, word in zip(factors, basis, strict=True)) % letters.levels[place]
            for place in range(len(letters.symbols))
        )
        for factors in product(*map(range, orders))
    }
    return sorted(subgroup, key=lambda word: (length(word), word))


def _by_length(word: Word) -> tuple:
    return length(word), [-exponent for exponent in word]


def defining_words(config: DesignConfig) -> list[Word]:
    """The defining relation: each word of the subgroup once, without its multiples and without the empty word."""
    letters = alphabet(config)
    words = {normalised(word, letters) for word in defining_subgroup(config) if any(word)}
    return sorted(words, key=_by_length)


def resolution(config: DesignConfig) -> int | None:
    """The length of the shortest defining word; None for a full factorial, where nothing is confounded."""
    return min((length(word) for word in defining_words(config)), default=None)


def word_lengths(config: DesignConfig) -> dict[int, int]:
    """How many defining words there are of each length: of two fractions of a resolution, fewer short ones is better.

    Fries and Hunter, Technometrics 22, 601 (1980).
    """
    lengths = [length(word) for word in defining_words(config)]
    return {number: lengths.count(number) for number in sorted(set(lengths))}


def aliases(word: Word, subgroup: list[Word], letters: Alphabet) -> list[Word]:
    """The effects that cannot be told from `word` in the fraction, `word` itself left out, shortest first."""
    found = {normalised(add(word, other, letters), letters) for other in subgroup}
    found.discard(normalised(word, letters))
    return sorted(found, key=_by_length)


def low_order_words(letters: Alphabet) -> list[Word]:
    """Every main effect and two-factor interaction, one between factors of a fraction in components (AB and AB2)."""
    count = len(letters.symbols)
    mains = [tuple(int(place == one) for place in range(count)) for one in range(count)]
    pairs = []
    for one, two in combinations(range(count), 2):
        split = letters.levels[one] == letters.levels[two] and not letters.whole(one)
        for power in range(1, letters.levels[two] if split else 2):
            pairs.append(tuple(1 if place == one else power if place == two else 0 for place in range(count)))
    return mains + pairs
