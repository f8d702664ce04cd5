"""The alias algebra of regular fractions: effects as words, words as exponents modulo the number of levels.

With p levels (p prime), the word A B2 stands for the p - 1 degrees of freedom of the contrasts between the p
groups of runs with equal (a + 2 b) mod p. A word and its multiples are the same effect, so the first exponent is made
1. Two effects are aliases if their quotient is in the subgroup that the generators span. Factors with another number
of levels have an algebra of their own, and a word over both is the product of its two parts. Factors of a number of
levels that no generator makes are complete, and their effects are not split into components: the exponent is 1 for
the whole effect.

Libraries of designs (pyDOE3) make fractions of two levels and no alias table of three; at two levels they give the
same runs.
"""

from itertools import combinations, product
from math import prod

from millprint.config.design import DesignConfig

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
