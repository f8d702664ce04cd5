"""The formulas of a kind as JavaScript, written down by letting `Kind` compute with names in place of numbers."""

import math
from typing import Any

from millprint.atlas.atlas_model import FITTED, combined
from millprint.atlas.kind_groups import SETTINGS, Kind

# Functions of numpy that a formula may use, by their names in JavaScript.
FUNCTIONS = {
    "log": "Math.log",
    "exp": "Math.exp",
    "sqrt": "Math.sqrt",
    "maximum": "Math.max",
    "minimum": "Math.min",
}


class Name:
    """A number that is not known yet: what is computed with it becomes the text of a formula."""

    def __init__(self, text: str) -> None:
        self.text = text

    def __add__(self, other: Any) -> "Name":
        return _joined(self, "+", other)

    def __radd__(self, other: Any) -> "Name":
        return _joined(other, "+", self)

    def __sub__(self, other: Any) -> "Name":
        return _joined(self, "-", other)

    def __rsub__(self, other: Any) -> "Name":
        return _joined(other, "-", self)

    def __mul__(self, other: Any) -> "Name":
        return _joined(self, "*", other)

    def __rmul__(self, other: Any) -> "Name":
        return _joined(other, "*", self)

    def __truediv__(self, other: Any) -> "Name":
        return _joined(self, "/", other)

    def __rtruediv__(self, other: Any) -> "Name":
        return _joined(other, "/", self)

    def __neg__(self) -> "Name":
        return Name(f"(-{self.text})")

    def __pow__(self, power: Any) -> "Name":
        return Name(f"Math.pow({self.text}, {_text(power)})")

    def __array_ufunc__(self, function: Any, method: str, *values: Any, **_: Any) -> "Name":
        if method != "__call__" or function.__name__ not in FUNCTIONS:
            raise TypeError(f"numpy.{function.__name__}: add its name in JavaScript to FUNCTIONS of {__name__}")
        return Name(f"{FUNCTIONS[function.__name__]}({', '.join(map(_text, values))})")


def _text(value: Any) -> str:
    if isinstance(value, Name):
        return value.text
    number = float(value)
    if not math.isfinite(number):
        raise ValueError(f"{number} has no number in JavaScript")
    return f"({number!r})" if number < 0 else repr(number)


def _joined(one: Any, sign: str, other: Any) -> Name:
    return Name(f"({_text(one)} {sign} {_text(other)})")


def _object(values: dict[str, Any]) -> str:
    return "{ " + ", ".join(f"{name}: {_text(value)}" for name, value in values.items()) + " }"


def formulas_of(kind: Kind) -> str:
    """Functions of a condition c or of groups g, as an object: volume_m3, stroke_m, groups, scales, derived,
    bounded."""
    condition: dict[str, Any] = {own.name: Name(f"c.{own.name}") for own in (*kind.dimensions, *SETTINGS)}
    groups: dict[str, Any] = {name: Name(f"g.{name}") for name in kind.names}
    derived = ", ".join(_text(of(groups)) for of in kind.derived)
    bounded = ", ".join(_text(limit.of(groups)) for limit in kind.limits)
    return (
        "{\n"
        f"    volume_m3: (c) => {_text(kind.volume_m3(condition))},\n"
        f"    stroke_m: (c) => {_text(kind.stroke_m(condition))},\n"
        f"    groups: (c) => ({_object(kind.groups_of(condition))}),\n"
        f"    scales: (c) => ({_object(kind.scales(condition))}),\n"
        f"    derived: (g) => [{derived}],\n"
        f"    bounded: (g) => [{bounded}],\n"
        "  }"
    )


def formulas(kinds: list[Kind]) -> str:
    """FORMULAS and COMBINED of the page.

    Those of each kind by its name; and the logarithms of what is predicted, each a function of those of what is fitted.
    """
    parts = "\n".join(f"  {kind.name}: {formulas_of(kind)}," for kind in kinds)
    fitted: dict[str, Any] = {name: Name(f"f.{name}") for name in FITTED}
    predicted = "\n".join(f"  {name}: (f) => {_text(value)}," for name, value in combined(fitted).items())
    head = "/* Written by millprint.atlas.page.written_formulas. */"
    return f"{head}\nconst FORMULAS = {{\n{parts}\n}};\nconst COMBINED = {{\n{predicted}\n}};"
