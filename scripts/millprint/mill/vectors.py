"""Three-vectors as tuples, for kernels: they live in registers."""

from millprint.kernel import inlined


@inlined()
def row(array, index):
    """Row `index` of an (n, 3) array."""
    return array[index, 0], array[index, 1], array[index, 2]


@inlined()
def dot(a, b):
    """a . b"""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@inlined()
def add(a, b):
    """a + b"""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


@inlined()
def subtract(a, b):
    """a - b"""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


@inlined()
def scale(factor, a):
    """factor a"""
    return factor * a[0], factor * a[1], factor * a[2]


@inlined()
def add_scaled(a, factor, b):
    """a + factor b."""
    return a[0] + factor * b[0], a[1] + factor * b[1], a[2] + factor * b[2]


@inlined()
def cross(a, b):
    """a x b"""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]
