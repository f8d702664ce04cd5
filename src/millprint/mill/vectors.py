"""Three-vectors as tuples, for kernels: they live in registers."""

import math

from millprint.run.kernel import inlined


@inlined()
def row(array, index):
    """The first three columns of row `index` of an array."""
    return array[index, 0], array[index, 1], array[index, 2]


@inlined()
def vector(array, index, columns):
    """The vector in three columns (millprint.mill.kernel_columns.Vector) of row `index` of an array."""
    return array[index, columns.x], array[index, columns.y], array[index, columns.z]


@inlined()
def put_vector(array, index, columns, vector):
    """Write a vector into three columns of row `index` of an array."""
    array[index, columns.x], array[index, columns.y], array[index, columns.z] = vector


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


@inlined()
def rotate(rotation, a):
    """R a, with R a tuple of three rows."""
    return dot(rotation[0], a), dot(rotation[1], a), dot(rotation[2], a)


@inlined()
def rotate_back(rotation, a):
    """R^T a, with R a tuple of three rows."""
    first, second, third = rotation
    return (
        first[0] * a[0] + second[0] * a[1] + third[0] * a[2],
        first[1] * a[0] + second[1] * a[1] + third[1] * a[2],
        first[2] * a[0] + second[2] * a[1] + third[2] * a[2],
    )


@inlined()
def any_across(axis):
    """A unit vector across another one."""
    x, y, z = axis
    if abs(z) < 0.9:
        size = math.sqrt(x * x + y * y)
        return y / size, -x / size, 0.0
    size = math.sqrt(y * y + z * z)
    return 0.0, z / size, -y / size
