"""Numbers as text: three digits, and SI prefixes."""

import math

# SI prefixes for small and large numbers.
PREFIXES = {-9: "n", -6: "µ", -3: "m", 0: "", 3: "k", 6: "M"}
# Units that take a prefix.
PREFIXED = ("J", "W", "N", "W/kg")
NOT_KNOWN = "not known"


def three(value: float) -> str:
    """A number with three digits, without an exponent where it is between a thousandth and a million.

    NOT_KNOWN for what is not a number, such as a quantity without a curve.
    """
    if value == 0:
        return "0"
    if math.isnan(value):
        return NOT_KNOWN
    rounded = float(f"{value:.3g}")
    if not 1e-3 <= abs(rounded) < 1e6:
        return f"{value:.2e}"
    return f"{rounded:.{max(0, 2 - math.floor(math.log10(abs(rounded))))}f}"


def plain(value: float) -> str:
    """A setting with three digits and without zeros at the end: 30, 96.8, 1230."""
    return f"{float(f'{value:.3g}'):g}"


def do_not_fit(balls: int, of: str) -> str:
    """That balls of a size do not fit, in words; of: the size, or the sizes."""
    return f"{counted(balls, 'ball')} {of} {'does' if balls == 1 else 'do'} not fit"


def counted(number: int, word: str) -> str:
    """A number of things: 1 ball, 24 balls, 2 tori."""
    plural = {"torus": "tori"}.get(word, f"{word}s")
    return f"{number} {word if number == 1 else plural}"


def prefix_of(value: float, unit: str) -> tuple[float, str]:
    """The factor and the unit that give a value, rounded to three digits, one to three digits before the point.

    2.2e-4 J is 220 µJ; what is not finite has no exponent, and no prefix.
    """
    exponent = f"{value:.2e}".partition("e")[2]
    if unit not in PREFIXED or value == 0 or not exponent:
        return 1.0, unit
    power = max(min(PREFIXES), min(max(PREFIXES), 3 * (int(exponent) // 3)))
    return 10.0**-power, PREFIXES[power] + unit


def duration(seconds: float) -> str:
    """A time in words: 40 s, 3 min 20 s, 40 min, 2 h 5 min."""
    minutes, rest = divmod(round(seconds), 60)
    if not minutes:
        return f"{rest} s"
    hours, left = divmod(minutes, 60)
    if hours:
        return f"{hours} h {left} min"
    return f"{minutes} min" if minutes >= 10 else f"{minutes} min {rest} s"
