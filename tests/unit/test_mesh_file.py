"""Files of triangles as programs write them: the same surface, or one line that says what is wrong."""

import gzip
import random
import re
import zipfile
from io import BytesIO

import numpy as np
import pytest
import trimesh

from millprint.config.errors import ConfigError
from millprint.mill.mesh_file import read_triangles, weld
from tests.refusals import refusal

BOX = trimesh.creation.box((50, 40, 30))
BINARY, TEXT = BOX.export(file_type="stl"), BOX.export(file_type="stl_ascii").encode()
OBJ, PLY = BOX.export(file_type="obj").encode(), BOX.export(file_type="ply")
PLY_TEXT = BOX.export(file_type="ply", encoding="ascii")
HALVES = b"".join(
    BOX.submesh([range(*span)], append=True).export(file_type="stl_ascii").encode() for span in ((0, 6), (6, 12))
)
CORNERS = [(x, y, z) for z in (-15, 15) for x, y in ((-25, -20), (25, -20), (25, 20), (-25, 20))]
QUADS = ((3, 2, 1, 0), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7))


def obj_of_quads(relative: bool) -> bytes:
    """A box with two materials; each face next to its own corners, which it names by counting back, or not."""
    lines = ["mtllib box.mtl", "o box"]
    for number, quad in enumerate(QUADS):
        lines += [f"usemtl {'ab'[number % 2]}", *("v {} {} {}".format(*CORNERS[corner]) for corner in quad)]
        first = 4 * number + 1
        lines.append("f -4/-4 -3/-3 -2/-2 -1/-1" if relative else f"f {first} {first + 1} {first + 2} {first + 3}")
    return "\n".join(lines).encode()


def ply_of_quads() -> bytes:
    """A box in 64-bit numbers of the other order of bytes."""
    properties = "".join(f"property double {axis}\n" for axis in "xyz")
    head = f"ply\nformat binary_big_endian 1.0\nelement vertex 8\n{properties}element face 6\n"
    rows = b"".join(b"\4" + np.array(quad, ">i4").tobytes() for quad in QUADS)
    head += "property list uchar int vertex_indices\nend_header\n"
    return head.encode() + np.array(CORNERS, ">f8").tobytes() + rows


def is_closed(points: np.ndarray, triangles: np.ndarray) -> bool:
    """Whether each side of a triangle is one of another in the opposite sense."""
    corners = [[tuple(points[corner]) for corner in triangle] for triangle in triangles]
    sides = {(triangle[k - 1], triangle[k]) for triangle in corners for k in range(3)}
    return 0 < len(sides) == 3 * len(triangles) and sides == {side[::-1] for side in sides}


def with_normals(normal: str) -> bytes:
    return re.sub(rb"facet normal .*", f"facet normal {normal}".encode(), TEXT)


@pytest.mark.parametrize(
    "content",
    [
        pytest.param(BINARY, id="binary STL"),
        pytest.param(BINARY + bytes(512), id="padding"),
        pytest.param(b"solid".ljust(80) + BINARY[80:], id="binary STL, solid"),
        pytest.param(b"solid facet normal vertex endsolid".ljust(80) + BINARY[80:], id="binary STL, solid and facet"),
        pytest.param(TEXT, id="STL as text"),
        pytest.param(TEXT.upper(), id="capitals"),
        pytest.param(TEXT.title(), id="mixed case"),
        pytest.param(TEXT.replace(b"\n", b"\r\n"), id="CRLF"),
        pytest.param(TEXT.replace(b"\n", b"\r"), id="CR"),
        pytest.param(b"\xef\xbb\xbf \n" + TEXT.replace(b"\n", b" \n\t "), id="BOM and indents"),
        pytest.param(TEXT.decode().encode("utf-16"), id="UTF-16"),
        pytest.param(TEXT.replace(b"solid", b"solid a vertex, a facet and endsolid \xe4", 1), id="words in the name"),
        pytest.param(b" ".join(TEXT.split()), id="one line"),
        pytest.param(re.sub(rb"\n *(outer|vertex|end(loop|facet))", rb" \1", TEXT), id="a line for each triangle"),
        pytest.param(re.sub(rb"end(?=loop|facet|solid)", b"end ", TEXT) + b" the end loop", id="keywords of two words"),
        pytest.param(b" ".join(re.sub(rb"end(?=loop|facet)", b"End ", TEXT).split()), id="the same in one line"),
        pytest.param(re.sub(rb"(end|outer )(?=loop|facet|solid)", rb"\1\n", TEXT), id="keywords of two lines"),
        pytest.param(TEXT.replace(b"solid", b"solid the back end", 1), id="a name that ends like a keyword"),
        pytest.param(re.sub(rb"(\d\.\d*)(?:E(\S+))?", rb"\1D+00", TEXT.upper()), id="exponents of Fortran"),
        pytest.param(HALVES, id="two solids of one surface"),
        pytest.param(with_normals("0 0 0"), id="normals of zero"),
        pytest.param(with_normals("nan nan nan"), id="normals that are no numbers"),
        pytest.param(with_normals("0 0 -1"), id="wrong normals"),
        pytest.param(with_normals("0,5 a -"), id="normals in words"),
        pytest.param(OBJ, id="OBJ"),
        pytest.param(OBJ.replace(b"v ", b" v\t").replace(b"f ", b"  f\t"), id="OBJ with tabs"),
        pytest.param(re.sub(rb"(\d) (-?\d)", rb"\1 \\\n  \2", OBJ), id="OBJ with continued lines"),
        pytest.param(obj_of_quads(relative=False), id="OBJ of quads with materials"),
        pytest.param(obj_of_quads(relative=True), id="OBJ that counts back"),
        pytest.param(PLY, id="PLY"),
        pytest.param(PLY_TEXT, id="PLY as text"),
        pytest.param(PLY_TEXT.replace(b"\n", b"\r\n"), id="PLY as text, CRLF"),
        pytest.param(ply_of_quads(), id="PLY of quads, big-endian"),
    ],
)
def test_a_dialect_is_read(content):
    points, triangles = read_triangles(content)
    assert len(triangles) == 12
    assert is_closed(points, triangles)
    assert np.linalg.det(points[triangles]).sum() / 6 == pytest.approx(50 * 40 * 30)


def packed(name: str) -> bytes:
    with zipfile.ZipFile(file := BytesIO(), "w") as archive:
        archive.writestr(name, TEXT)
    return file.getvalue()


@pytest.mark.parametrize(
    ("content", "part"),
    [
        (b"", "is empty"),
        (b"\0" * 100, "is empty"),
        (b"solid".ljust(84, b"\0"), "has no triangles"),
        (b"\x89PNG\r\n\x1a\n" + bytes(99), "has no triangles, or is neither STL"),
        (BINARY[:300], "is cut"),
        (BINARY + b"more", "4 bytes after its 12 triangles"),
        (TEXT[:900], "is cut: it has no `endsolid`"),
        (HALVES[: len(HALVES) - 40], "is cut: it has no `endsolid`"),
        (TEXT.replace(b"endfacet", b"", 1), "it has 36 corners, and `endfacet` 11 times"),
        (TEXT.replace(b"endfacet", b"endface"), "it has 36 corners, and `endfacet` 0 times"),
        (b"solid x\nfacet normal a b c\n", "is cut: it has no `endsolid`"),
        (OBJ[:200], "is cut: it has no faces"),
        (PLY[:-30], "is cut"),
        (PLY_TEXT[:-30], "is cut: it has 1"),
        (TEXT.replace(b".", b","), "decimal commas (facet"),
        (OBJ.replace(b".", b","), "decimal commas (v -25,0"),
        (PLY_TEXT.replace(b".", b",").replace(b"1,0", b"1.0", 1), "decimal commas"),
        (TEXT.replace(b"25.0", b"25.0mm", 1), "cannot be read as STL"),
        (OBJ.replace(b"\nf ", b"\nf 9", 1), "cannot be read as OBJ"),
        (b"<html><body>Sign in</body></html>", "a page of the web"),
        (b"version https://git-lfs.github.com/spec/v1\noid sha256:4d\nsize 12\n", "a pointer of Git LFS"),
        (packed("jar.stl"), "a ZIP archive"),
        (packed("3D/3dmodel.model"), "a 3MF file; export it as STL"),
        (gzip.compress(TEXT), "packed by gzip"),
        (b"ISO-10303-21;\nHEADER;\n", "a STEP file"),
        (b"The jar is in the other file.\n" * 9, "neither STL, PLY nor OBJ"),
        (random.Random(0).randbytes(900), "neither STL, PLY nor OBJ"),
    ],
)
def test_what_is_no_surface_names_the_cause_in_one_line(content, part):
    assert part in refusal(read_triangles, content)


@pytest.mark.parametrize("content", [BINARY, TEXT, HALVES, OBJ, PLY, PLY_TEXT, *map(obj_of_quads, (False, True))])
def test_a_file_that_is_cut_anywhere_is_never_a_smaller_closed_surface(content):
    """One that is cut in its last line, or between two solids, may be read: as the whole surface, or an open one."""
    read = 0
    for length in random.Random(0).sample(range(len(content)), 300 if len(content) > 300 else len(content)):
        try:
            points, triangles = read_triangles(content[:length])
        except ConfigError as error:
            assert "\n" not in str(error)
            continue
        read += 1
        assert len(triangles) == 12 or not is_closed(points, triangles)
    assert read < 150


def test_what_is_folded_on_itself_where_points_are_merged_is_dropped():
    """A point between three others, two of which are one by rounding; two bodies that touch stay two."""
    points = np.array([[0, 0, 0], [9, 0, 0], [0, 9, 0], [0, 0, 9], [0.1, 0.1, 0], [4, 0.2, 0.0]])
    # The floor (0, 2, 1) with 4 next to 0, and 5 in the triangle (0, 4, 1).
    floor = [(0, 2, 4), (4, 2, 1), (0, 4, 5), (4, 1, 5), (1, 0, 5)]
    sides = [(0, 1, 3), (1, 2, 3), (2, 0, 3)]
    assert is_closed(points, np.array(floor + sides))
    merged = weld(points, np.array(floor + sides), 0.2)
    assert is_closed(*merged) and len(merged[1]) == 4
    below = points[:4] * [1, 1, -1]
    both = np.concatenate([points[:4], below])
    two = np.array([(0, 2, 1), *sides, (4, 5, 6), (4, 7, 5), (5, 7, 6), (6, 7, 4)])
    assert len(weld(both, two, 0.2)[1]) == 8
