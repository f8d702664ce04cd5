"""Numbers as people write them: a point or a comma for decimals, and commas, points or blanks between thousands."""

import re
from collections.abc import Iterable

PLAIN = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)(e[-+]?\d+)?", re.IGNORECASE)
BLANKS = " \u00a0\u2009\u202f'’"
SPACED = re.compile(rf"[-+]?[1-9]\d{{0,2}}([{BLANKS}]\d{{3}})+([.,]\d*)?")


def _pattern(mark: str, group: str) -> re.Pattern:
    """Numbers with a decimal mark, and thousands between which another sign stands."""
    whole = rf"(\d+|[1-9]\d{{0,2}}(\{group}\d{{3}})+)"
    return re.compile(rf"[-+]?({whole}(\{mark}\d*)?|\{mark}\d+)(e[-+]?\d+)?", re.IGNORECASE)


FORMS = {".": _pattern(".", ","), ",": _pattern(",", ".")}


def readings(text: str) -> dict[str, str]:
    """The plain number that a text is, by the decimal mark with which it is one: "1,041" is 1041 or 1.041."""
    text = text.strip().replace("−", "-")
    if SPACED.fullmatch(text):
        text = re.sub(f"[{BLANKS}]", "", text)
    return {
        mark: text.replace("," if mark == "." else ".", "").replace(mark, ".")
        for mark, form in FORMS.items()
        if form.fullmatch(text)
    }


def meanings(text: str) -> list[str]:
    """The plain numbers that a text may mean; a point that can be one is a decimal point."""
    return [text] if PLAIN.fullmatch(text) else list(dict.fromkeys(readings(text).values()))


def decimal_mark(texts: Iterable[str]) -> str:
    """The decimal mark that some of the numbers prove, as 0,5 and 1.234,5 do; empty if none or both are proved."""
    proved = {mark for found in map(readings, texts) if len(found) == 1 for mark in found}
    return proved.pop() if len(proved) == 1 else ""


def plain_number(text: str, mark: str) -> str | None:
    """The plain number that a text is in a table with this decimal mark, such as 1041 or 0.5; None if it is none.

    Where nothing proves a mark, a point is one, and 1,041 has two readings: raises ValueError, with both in words.
    """
    found = [readings(text)[mark]] if mark in readings(text) else meanings(text)
    if len(found) > 1:
        raise ValueError(f"is {' or '.join(found)}; write the one that is meant, with a point for decimals")
    return found[0] if found else None
