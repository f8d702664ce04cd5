"""What is wrong with a value and what to write instead, in words, for each kind of fault that pydantic finds."""

import difflib
import math
import operator
import re
from collections.abc import Callable, Iterable
from pathlib import PurePath
from typing import Any

from pydantic_core import ErrorDetails

from millprint.config.rows import PLAIN, meanings
from millprint.config.section import NAME_PATTERN

NUMBER = r"[-+]?\d*\.?\d+(?:e[-+]?\d+)?"
# The end of a key names the unit of its value: radius_mm, speed_rpm.
UNITS = ("mm", "cm", "rpm", "hz", "ml", "l", "g", "kg", "s", "min", "h", "deg", "J", "W", "gpa", "kg_m3")
# Units of the same kind, as people write them, and how large each is.
SAME_KIND = (
    {"mm": 1.0, "cm": 10.0, "m": 1e3, "µm": 1e-3, "um": 1e-3, "in": 25.4, "inch": 25.4},
    {"ml": 1.0, "l": 1e3, "cl": 10.0, "cm3": 1.0, "cm³": 1.0, "cc": 1.0},
    {"g": 1.0, "kg": 1e3, "mg": 1e-3},
    {"s": 1.0, "min": 60.0, "h": 3600.0, "ms": 1e-3},
    {"rpm": 1.0, "hz": 60.0},
    {"gpa": 1e9, "mpa": 1e6, "bar": 1e5, "kpa": 1e3, "hpa": 1e2, "pa": 1.0},
    {"kg_m3": 1.0, "g/cm3": 1e3},
    {"j": 1.0, "mj": 1e-3, "µj": 1e-6, "uj": 1e-6},
)
# Units in which people give a value by mistake, the likeliest first.
LIKELY_UNITS = {
    "mm": ("m", "cm", "µm"), "kg": ("g",), "g": ("kg", "mg"), "rpm": ("hz",), "hz": ("rpm",), "ml": ("l",),
    "s": ("min", "h"), "h": ("min", "s"), "kg_m3": ("g/cm3",), "gpa": ("mpa", "pa"),
    "pa": ("hPa", "kPa", "bar"), "k": ("°C",), "j": ("uJ", "mJ"),
}  # fmt: skip
ZERO_C_IN_K = 273.15
LETTERS = {"ä": "ae", "ö": "oe", "ü": "ue", "ß": "ss", "-": "_", " ": "_"}


def unit_of(key: str) -> str:
    """The unit that a key names; empty if it names none."""
    return next((unit for unit in sorted(UNITS, key=len, reverse=True) if key.lower().endswith(f"_{unit.lower()}")), "")


def number_meant(text: str) -> str:
    """How to write a number that people write in another way; empty if that is not plain."""
    plain = re.sub(r"[\s'\"“”„‘’]", "", text).replace("−", "-").replace("–", "-")
    plain = re.sub(r"^(~|≈|ca\.?|about)", "", plain, flags=re.IGNORECASE)
    if re.fullmatch(r"[-+]?\d+(_\d+)+", plain):
        return plain.replace("_", "")
    if "," in plain:
        return " or ".join(meanings(plain))
    if re.fullmatch(NUMBER, plain, re.IGNORECASE):
        return re.sub(r"^([-+]?)0+(?=\d)", r"\1", plain)  # 070 is 56 in YAML 1.1
    if found := re.fullmatch(rf"({NUMBER})%", plain):
        return f"{float(found[1]) / 100:g}"
    if (found := re.fullmatch(rf"({NUMBER})([:/])({NUMBER})", plain)) and float(found[3]):
        # A ratio 1:-2 of a planetary mill is -2 turns of the jar for one of the wheel; 30:1 of balls to powder is 30.
        first, second = float(found[1]), float(found[3])
        return f"{second if found[2] == ':' and abs(first) == 1 else first / second:.4g}"
    return ""


def converted(value: float, given: str, wanted: str) -> str:
    """A value in another unit of the same kind; empty if there is none."""
    given, wanted = given.lower(), wanted.lower()
    if (given, wanted) == ("°c", "k"):
        return f"{value + ZERO_C_IN_K:g}"
    kinds = (kind for kind in SAME_KIND if given in kind and wanted in kind)
    return next((f"{value * kind[given] / kind[wanted]:.10g}" for kind in kinds), "")


def other_unit(value: float, unit: str, fits: Callable[[float], bool]) -> str:
    """A question on the unit of a value that does not fit, with what to write, if it does in another; else empty."""
    for other in LIKELY_UNITS.get(unit.lower(), ()):
        if fits(float(meant := converted(value, other, unit))):
            return f"is it in {other}? Write {meant}"
    return ""


def number_words(text: Any, key: str) -> str:
    """What to write in place of a value that must be a number."""
    unit, shown = unit_of(key), ""
    if isinstance(text, str):
        found = re.fullmatch(r"\s*([-+\d.,]+(?:e[-+]?\d+)?)\s*([a-zµ°]+[²³0-9]*)\s*", text, re.IGNORECASE)
        values = meanings(found[1]) if found else []
        if found and values and found[2].lower() == (unit or found[2]).lower():
            return f"must be a number without a unit; write {' or '.join(values)}"
        if found and values:
            written = " or ".join(converted(float(value), found[2].lower(), unit) for value in values)
            return f"must be a number without a unit, in {unit}, as the key says" + (written and f"; write {written}")
        shown = number_meant(text)
        if ";" in text:
            return "must be one number; in a list, numbers are separated by commas, such as [0.1, 0.2, 0.3]"
    if shown:
        return f"must be a plain number; write {shown}"
    return f"must be a number{f' in {unit}' if unit else ''}, such as 30 or 0.5, with a point and without a unit"


def list_words(value: Any) -> str:
    """What to write in place of a value that must be a list."""
    # The dash of a range is not a sign: 5-10 and 5 - 10, but 0 -1.
    text = re.sub(r"(?<=\d)(-| - )(?=\d)", " ", value) if isinstance(value, str) else ""
    numbers = re.findall(NUMBER, text)
    if numbers and not re.search(r"[a-z]", text.replace("to", ""), re.IGNORECASE) and not re.search(r"\d,\d", text):
        return f"must be a list; write [{', '.join(numbers)}]"
    return "must be a list; write " + (f"[{value}]" if isinstance(value, str | int | float) else "[...]")


def name_words(value: str) -> str:
    """What to write in place of a text that must be a name."""
    stem = PurePath(value).stem if value.lower().endswith((".yaml", ".yml")) else value
    plain = "".join(LETTERS.get(letter, letter) for letter in stem.lower())
    near = re.sub(r"[^a-z0-9_]", "", plain).lstrip("0123456789_")
    words = "must be a name of small letters, digits and _ that begins with a letter"
    return f"{words}; write {near}" if near else words


def close_to(word: str, known: Iterable[str]) -> str:
    """The end of a message about an unknown word: the nearest of those known, or all of them."""
    known = list(known)
    close = difflib.get_close_matches(word.lower(), known, n=1)
    return f"; did you mean {close[0]}?" if close else f"; known: {', '.join(known)}"


def _shape(error: ErrorDetails, key: str) -> str:
    pattern = error["ctx"]["pattern"]
    if pattern == NAME_PATTERN:
        return name_words(error["input"])
    if key == "results":
        return "must be a folder in the working folder: letters, digits, _ and -, with / between; write results/mine"
    return f"must have the pattern {pattern}"


def _number_of(value: Any) -> float:
    """A number or its text; whole numbers may be larger than any other number."""
    return math.inf if len(str(value)) > 300 else float(value)


def _bound(words: str, name: str) -> Callable[[ErrorDetails, str], str]:
    def told(error: ErrorDetails, key: str) -> str:
        limit, value, unit = error["ctx"][name], _number_of(error["input"]), unit_of(key)
        if limit == 1 and 1 < value < 100 and not unit:
            return f"must be {words} {limit:g}; write {value / 100:g} for {value:g} %"
        compare = operator.gt if name[0] == "g" else operator.lt
        if value > 0 and (asked := other_unit(value, unit, lambda meant: compare(meant, limit))):
            return f"must be {words} {limit:g} {unit.replace('_', '/')}; {asked}"
        return f"must be {words} {limit:g}"

    return told


def _few(error: ErrorDetails, key: str) -> str:
    return f"has {error['ctx']['actual_length']} values; at least {error['ctx']['min_length']} are needed"


def _number(error: ErrorDetails, key: str) -> str:
    return number_words(error["input"], key)


def _section(error: ErrorDetails, key: str) -> str:
    return f"must be a section, with keys of its own in the lines below {key}"


def _one_text(value: Any) -> str:
    """A value as a text in quotes; of a list its items."""
    return f'"{", ".join(map(str, value))}"' if isinstance(value, list) else repr(str(value))


WORDS: dict[str, Callable[[ErrorDetails, str], str]] = {
    "float_parsing": _number,
    "float_type": _number,
    "int_parsing": lambda error, key: (
        "must be a whole number" if PLAIN.fullmatch(error["input"].strip()) else _number(error, key)
    ),
    "finite_number": lambda error, key: "must be a finite number",
    "int_type": _number,
    "int_from_float": lambda error, key: "must be a whole number",
    "string_type": lambda error, key: (
        "must be a text, and nothing stands there; # begins a comment, so put a text with # in quotes"
        if error["input"] is None
        else f"must be a text; write it in quotes, {_one_text(error['input'])}"
    ),
    "list_type": lambda error, key: list_words(error["input"]),
    "tuple_type": lambda error, key: list_words(error["input"]),
    "too_short": _few,
    "greater_than": _bound("greater than", "gt"),
    "greater_than_equal": _bound("greater than or equal to", "ge"),
    "less_than": _bound("less than", "lt"),
    "less_than_equal": _bound("less than or equal to", "le"),
    "string_pattern_mismatch": _shape,
    "literal_error": lambda error, key: f"must be {error['ctx']['expected']}",
    "model_type": _section,
    "model_attributes_type": _section,
    "dict_type": _section,
}


def in_words(error: ErrorDetails, key: str) -> str:
    """What is wrong with a value, and what to write; key: the last part of its path that has a name."""
    if error["type"] in WORDS:
        return WORDS[error["type"]](error, key)
    message = error["msg"].removeprefix("Value error, ")
    # An abbreviation keeps its capitals.
    begin = message[:1] if message[:2].isupper() else message[:1].lower()
    return f"{begin}{message[1:]}"
