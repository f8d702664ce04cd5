"""Numbers of a card as text: three digits, intervals, and units as people write them."""

from millprint.card.card_model import Ends, Estimate, Quantity, Temperature
from millprint.run.numbers import prefix_of, three


def in_words(quantity: Quantity, ends: Ends | None = None) -> str:
    """A quantity with its unit and an interval: "221 µJ (203 to 240)"."""
    factor, unit = prefix_of(quantity.value, quantity.unit)
    text = three(factor * quantity.value) + ("" if unit == "-" else f" {unit}")
    return text if ends is None else f"{text} ({between(ends, factor)})"


def between(ends: Ends | Temperature | Estimate, factor: float = 1.0) -> str:
    """The ends of an interval: "203 to 240"."""
    return f"{three(factor * ends.lower)} to {three(factor * ends.upper)}"
