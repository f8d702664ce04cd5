"""The rounding of a file, from coordinates that were written and read again."""

import numpy as np
import pytest
import trimesh

from millprint.mill.mesh_file import coordinate_rounding

SECTIONS = [(40, 60, 24), (8, 20, 24), (75, 60, 48), (20, 63, 32)]


def corners(radius: float, height: float, sections: int) -> np.ndarray:
    """Vertices (v, 3) [mm] of a round jar, upright: half of the coordinates are sizes of the drawing."""
    outline = [[0, 0], [radius - 2, 0], [radius - 0.6, 0.6], [radius, 2], [radius, height], [0, height]]
    return trimesh.creation.revolve(outline, sections=sections).vertices


def written(points: np.ndarray, number: str) -> np.ndarray:
    return np.array([[float(number % value) for value in point] for point in points])


@pytest.mark.parametrize("sizes", SECTIONS)
@pytest.mark.parametrize("decimals", [2, 3, 4, 5, 6])
def test_decimals(sizes, decimals):
    points = written(corners(*sizes), f"%.{decimals}f")
    assert coordinate_rounding(points) == pytest.approx(0.5 * 10.0**-decimals)
    # The same numbers in a binary file, or in metres.
    assert coordinate_rounding(points / 1e3) == pytest.approx(0.5e-3 * 10.0**-decimals)
    if decimals < 5:
        assert coordinate_rounding(points.astype(np.float32)) == pytest.approx(0.5 * 10.0**-decimals)


@pytest.mark.parametrize("sizes", SECTIONS)
@pytest.mark.parametrize(("number", "digits"), [("%.6g", 6), ("%e", 7)])
def test_digits(sizes, number, digits):
    """Of the coordinates around the jar: its height, which is a whole number, may be of another decade."""
    points = corners(*sizes)
    decade = np.floor(np.log10(sizes[0]))
    assert coordinate_rounding(written(points, number)) == pytest.approx(0.5 * 10.0 ** (decade - digits + 1))


@pytest.mark.parametrize("sizes", SECTIONS)
def test_binary_numbers(sizes):
    points = corners(*sizes)
    single = np.float32(points)
    half_spacing = np.spacing(np.abs(single).max()) / 2
    assert coordinate_rounding(single.astype(float)) == half_spacing
    # As text, with all digits of a 32-bit number.
    assert coordinate_rounding(written(single, "%.9g")) == pytest.approx(half_spacing, rel=1e-6)
    assert coordinate_rounding(points) == np.spacing(np.abs(points).max()) / 2


@pytest.mark.parametrize("after", ["%.17g", "%.5f", "%.4f"])
def test_inches_that_were_rounded_before_they_became_millimetres(after):
    points = written(written(corners(40, 60, 24) / 25.4, "%.4f") * 25.4, after)
    assert coordinate_rounding(points) == pytest.approx(0.5e-4 * 25.4, rel=1e-6)


def test_sizes_of_a_drawing_are_no_rounding():
    """A box, and plates at whole and half millimetres."""
    assert coordinate_rounding(trimesh.creation.box((20, 30, 41)).vertices) < 1e-5
    plates = np.random.default_rng(0).integers(0, 600, size=(40, 3)) / 2
    assert coordinate_rounding(plates) < 1e-4
