"""Columns of the arrays that kernels work on, numbered from lists of names.

A list is a NamedTuple class. A field of type `int` is one column and a field of type `Vector` three; a field of another
list is a group with the columns of that list:

    class SampleColumns(NamedTuple):
        time_s: int
        velocity: Vector

    SAMPLE = number_columns(SampleColumns)    # SAMPLE.time_s is 0, SAMPLE.velocity is Vector(1, 2, 3)
    sample = np.zeros(width_of(SAMPLE))
    sample[span_of(SAMPLE.velocity)] = 0.0

Numba takes such a global as a constant, so that a name costs no time. To add a column, add its name to the list.
"""

from typing import Any, NamedTuple, TypeVar, get_type_hints

Columns = TypeVar("Columns", bound=tuple)


class Vector(NamedTuple):
    """The three columns of a vector."""

    x: int
    y: int
    z: int


def number_columns(kind: type[Columns], first: int = 0) -> Columns:
    """The numbers of all columns of a list, from `first` on."""
    numbers: list[Any] = []
    for field in get_type_hints(kind).values():
        numbers.append(first if field is int else number_columns(field, first))
        first = last_column(numbers[-1]) + 1
    return kind(*numbers)


def first_column(columns: int | tuple) -> int:
    """The first column of a group, or the column itself."""
    return columns if isinstance(columns, int) else first_column(columns[0])


def last_column(columns: int | tuple) -> int:
    """The last column of a group, or the column itself."""
    return columns if isinstance(columns, int) else last_column(columns[-1])


def width_of(columns: tuple) -> int:
    """The number of columns in a group."""
    return last_column(columns) + 1 - first_column(columns)


def span_of(columns: tuple) -> slice:
    """A group of columns as an index."""
    return slice(first_column(columns), last_column(columns) + 1)


def names_of(columns: tuple) -> list[str]:
    """The names of all columns in a group in their order, those of the groups within it too."""
    named = zip(columns._fields, columns, strict=True)  # type: ignore[attr-defined]
    return [name for field, at in named for name in ([field] if isinstance(at, int) else names_of(at))]
