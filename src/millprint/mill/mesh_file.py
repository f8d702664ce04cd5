"""Files of triangles: STL, PLY and OBJ as programs write them, their rounding, and how triangles join to a surface.

Programs write a fixed number of decimals, a fixed number of digits, or 32-bit numbers, and may have rounded before, in
another unit or format. So the digits in the file do not say it. But rounded coordinates all lie on a grid.

The kind follows from the content, as names of files may be wrong. trimesh reads it. What it cannot read, or not as a
whole, is explained afterwards.
"""

import codecs
import re
import warnings
from collections.abc import Iterator
from io import BytesIO

import numpy as np
import trimesh
from scipy.sparse import csr_array
from scipy.spatial import cKDTree

from millprint.config.errors import ConfigError
from millprint.mill.outlines import HalfEdges, half_edges, triangle_widths

# A coarser grid is how the body was drawn, not rounding; on a finer one nobody draws [shares of its size].
COARSEST, FINEST = 1e-3, 1e-5
# Between them a grid is believed if this many coordinates, and this share of them, are on none that is five times as
# coarse: those of a round wall need their last digit, while the sizes of a drawing end in 0 or 5.
FEWEST, SHARE = 3, 0.25
INCH_MM = 25.4


def _off(values: np.ndarray, step: np.ndarray | float) -> np.ndarray:
    """Distances of values from the multiples of a step."""
    return np.abs(values - np.rint(values / step) * step)


def _grids(values: np.ndarray) -> Iterator[np.ndarray]:
    """Steps of each value (n,): of one number of decimals, then of one number of digits, from the coarsest on."""
    decade = np.floor(np.log10(values))
    for exponent in range(int(decade.max()), -16, -1):
        yield np.full(len(values), 10.0**exponent)
    for digits in range(1, 17):
        yield 10.0 ** (decade - digits + 1)


def _step(values: np.ndarray, noise: np.ndarray, size: float) -> float:
    """The largest step of a grid that all values (n,) lie on, to within a noise (n,); 0 where there is none."""
    largest, some = 0.0, slice(None, None, max(1, len(values) // 100))
    for step in _grids(values):
        is_sure, error = 16 * noise <= step, noise + 1e-9 * step
        if not is_sure.any() or step.max() > COARSEST * size:
            continue
        if any((_off(values[rows], step[rows]) > error[rows]).any() for rows in (some, slice(None))):
            continue
        needs_it = is_sure & (_off(values, 5 * step) > error)
        # In the decade of the largest step that enough values need.
        for top in np.unique(step[is_sure])[::-1]:
            here = step == top
            enough = max(FEWEST, SHARE * here.sum()) if top > FINEST * size else 1
            if top > largest and needs_it[here].sum() >= enough:
                largest = float(top)
    return largest


def coordinate_rounding(points: np.ndarray) -> float:
    """The largest error that rounding gives a coordinate of points (v, 3), in their unit.

    Half a step of the grid of decimals or digits, in the points' unit or 25.4 times as large, on which all coordinates
    are; half the spacing of 32-bit or 64-bit numbers where there is none that is certain.
    """
    values = np.unique(np.abs(points))
    values = values[values > 0]
    single = values.astype(np.float32)
    # A 32-bit number that is written with nine digits.
    is_single = bool((np.abs(single - values) <= 5e-9 * values).all())
    spacing = np.spacing(single).astype(float) if is_single else np.spacing(values)
    size = float(np.ptp(points, axis=0).max())
    step = _step(values, spacing, size)
    in_inches = _step(values / INCH_MM, np.maximum(spacing, step / 2) / INCH_MM, size / INCH_MM) * INCH_MM
    return max(float(spacing.max()), step, in_inches) / 2


# Slivers are taken out again and again, as one may leave another; more rounds than this do not help.
ROUNDS = 20


def _unfolded(triangles: np.ndarray) -> np.ndarray:
    """Triangles (t, 3) without pairs that lie on each other in opposite senses, and have a side of their own.

    What was between the two is gone. Where two bodies touch, all sides of such a pair are also those of others.
    """
    while True:
        count = np.int64(triangles.max(initial=0) + 1)
        low, middle, high = np.sort(triangles, axis=1).T
        _, pair, copies = np.unique((low * count + middle) * count + high, return_inverse=True, return_counts=True)
        if copies.max(initial=1) == 1:
            return triangles
        follows = np.roll(triangles, -1, axis=1)
        sense = np.bincount(pair, np.where((triangles < follows).sum(axis=1) == 2, 1, -1))
        _, side, uses = np.unique(
            np.minimum(triangles, follows) * count + np.maximum(triangles, follows),
            return_inverse=True,
            return_counts=True,
        )
        has_own = (uses[side.reshape(-1, 3)] == 2).any(axis=1)
        is_folded = (copies[pair] == 2) & (sense[pair] == 0) & has_own
        if not is_folded.any():
            return triangles
        triangles = triangles[~is_folded]


def _joined(points: np.ndarray, triangles: np.ndarray, pairs: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Points and triangles with pairs of points (n, 2) made one, also chains; what has no third corner is dropped."""
    group = trimesh.graph.connected_component_labels(pairs, node_count=len(points))
    _, first = np.unique(group, return_index=True)
    triangles = group[triangles]
    a, b, c = triangles.T
    used, triangles = np.unique(_unfolded(triangles[(a != b) & (b != c) & (c != a)]), return_inverse=True)
    return points[first[used]], triangles.reshape(-1, 3)


def weld(points: np.ndarray, triangles: np.ndarray, tolerance: float) -> tuple[np.ndarray, np.ndarray]:
    """Merge points closer than a tolerance [m], also chains of such points.

    points (v, 3) [m]; triangles (t, 3), rows of points. Returns the merged points that a triangle uses, in ascending
    order, and the triangles as rows of them, without those that are left with fewer than three corners.
    """
    order = np.lexsort(points.T[::-1])
    is_new = np.append(True, (np.diff(points[order], axis=0) != 0).any(axis=1))
    number = np.empty(len(order), dtype=np.int64)
    number[order] = np.cumsum(is_new) - 1
    points, triangles = points[order[is_new]], number[triangles]
    return _joined(points, triangles, cKDTree(points).query_pairs(tolerance, output_type="ndarray"))


def close_gaps(points: np.ndarray, triangles: np.ndarray, tolerance: float) -> tuple[np.ndarray, np.ndarray]:
    """Merge points on open edges that are closer than a tolerance [m]: one point that was rounded in two ways."""
    edges = half_edges(triangles)
    is_open = edges.twin < 0
    rim = np.unique(np.concatenate([edges.start[is_open], edges.end[is_open]]))
    if not len(rim):
        return points, triangles
    return _joined(points, triangles, rim[cKDTree(points[rim]).query_pairs(tolerance, output_type="ndarray")])


def _apart(pairs: np.ndarray) -> np.ndarray:
    """Which pairs (n, 2) have no number in common with an earlier one: all that can be changed at a time."""
    _, first = np.unique(pairs, return_index=True)
    is_first = np.isin(np.arange(pairs.size), first)
    return np.logical_and(is_first[::2], is_first[1::2])


def _contractible(edges: HalfEdges, ends: np.ndarray) -> np.ndarray:
    """Those of some sides (n, 2) whose ends may be one point: only two points are neighbours of both."""
    count = int(edges.start.max()) + 1
    beside = csr_array((np.ones(len(edges.start), dtype=np.int64), (edges.start, edges.end)), (count, count))
    return ends[(beside[ends[:, 0]] * beside[ends[:, 1]]).sum(axis=1) == 2]


def without_slivers(points: np.ndarray, triangles: np.ndarray, tolerance: float) -> tuple[np.ndarray, np.ndarray]:
    """A closed surface without triangles that are narrower than a tolerance [m], as far as it stays closed.

    A triangle with a side shorter than the tolerance loses that side. One with a corner in the middle of its longest
    side gives it to the triangle across that side, which is cut in two there.
    """
    for _ in range(ROUNDS):
        corners = points[triangles]
        narrow = np.flatnonzero(triangle_widths(corners) <= tolerance)
        if not len(narrow):
            break
        lengths = np.linalg.norm(np.roll(corners[narrow], -1, axis=1) - corners[narrow], axis=2)
        # Sides between points of a file's grid are often exactly as long as the tolerance, but for the last bit.
        is_needle, rows = lengths.min(axis=1) <= (1 + 1e-6) * tolerance, np.arange(len(narrow))
        edges = half_edges(triangles)
        short = (3 * narrow + lengths.argmin(axis=1))[is_needle]
        ends = _contractible(edges, np.column_stack([edges.start[short], edges.end[short]]))
        if len(ends):
            # No chains, as an outline whose sides are all short would be one point; in any order, or one at a time.
            ends = np.random.default_rng(0).permutation(ends)
            points, triangles = _joined(points, triangles, ends[_apart(ends)])
            continue
        longest = lengths.argmax(axis=1)
        twin = edges.twin[3 * narrow + longest]
        pairs = np.column_stack([narrow, twin // 3])[twin >= 0]
        # Each triangle in one exchange at a time.
        chosen = rows[twin >= 0][_apart(pairs)]
        across, side = twin[chosen] // 3, twin[chosen] % 3
        start, end, middle = (triangles[narrow[chosen], (longest[chosen] + k) % 3] for k in range(3))
        far = triangles[across, (side + 2) % 3]
        triangles = triangles.copy()
        triangles[narrow[chosen]] = np.column_stack([middle, start, far])
        triangles[across] = np.column_stack([end, middle, far])
        points, triangles = _joined(points, triangles, np.empty((0, 2), dtype=int))
    return points, triangles


# A binary STL: a header with the number of triangles, then the triangles [bytes].
HEADER, TRIANGLE = 84, 50
# A larger number of triangles is not one, and the file is of another kind.
MOST_STATED = 10_000_000
UTF_16 = codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE
PADDING = b"\0 \t\r\n"
# How files begin that are sent or saved in place of a surface.
OTHER_FILES = {
    b"version https://git-lfs": "is a pointer of Git LFS and not the file itself; `git lfs pull` gets it",
    b"<": "is a page of the web (HTML), or other XML, and not the file itself; download that, or export it as STL",
    b"PK\x03\x04": "is a ZIP archive; unpack it",
    b"\x1f\x8b": "is packed by gzip; unpack it",
    b"ISO-10303": "is a STEP file; export it as STL",
}
WORDS_OF_STL = r"(?:facet|outer|vertex|endloop|endfacet|endsolid)\b"
# The name of a solid, which ends with its line or, where all is in one line, with the first triangle.
NAMED = re.compile(r"(?im)^(solid|endsolid)\b(?:(?! facet +normal +[-+.\d]).)*")
# A word of the format that is written as two.
PARTED = re.compile(r"(?i)\bend[ \n]+(?=(?:facet|loop|solid)\b)")
NOT_A_SURFACE = "is neither STL, PLY nor OBJ; export it as STL"


def _binary_stl(content: bytes) -> bytes:
    """A binary STL without padding."""
    triangles = int.from_bytes(content[HEADER - 4 : HEADER], "little")
    size = HEADER + TRIANGLE * triangles
    if len(content) < size and triangles > MOST_STATED:
        raise ConfigError(NOT_A_SURFACE)
    if len(content) < size:
        raise ConfigError(
            f"is cut, or not an STL: it has {len(content)} bytes of the {size} for {triangles} triangles; copy or "
            "export it again"
        )
    if content[size:].strip(PADDING):
        raise ConfigError(f"has {len(content) - size} bytes after its {triangles} triangles; export it again")
    return content[:size]


def _plain_text(content: bytes) -> str:
    """Text of a file with one kind of space and line end, without names, which may hold any word."""
    text = content.decode("utf-16" if content.startswith(UTF_16) else "utf-8-sig", errors="replace")
    text = text.rstrip("\0").replace("\r\n", "\n").replace("\r", "\n")
    text = re.sub(r" *\n[ \n]*", "\n", text.replace("\t", " ")).lstrip()
    return NAMED.sub(r"\1", text).rstrip() + "\n"


def _stl_lines(text: str) -> str:
    """An STL in small letters, each word of the format at the beginning of a line, without normals.

    The order of the corners counts, and not the normals. Exponents are of e, where Fortran writes d.
    """
    text = NAMED.sub(r"\1", PARTED.sub("end", text))
    if text.count("\n") < 2 * text.lower().count("vertex"):
        text = NAMED.sub(r"\1", re.sub(rf"(?i) (?={WORDS_OF_STL})", "\n", text))
    return text.lower().replace("normal", "").replace("d+", "e+").replace("d-", "e-")


def _counted_from_the_start(content: bytes) -> bytes:
    """An OBJ whose faces name their corners by numbers from the first vertex, as not all count back from the last."""
    lines, vertices = content.decode().split("\n"), 0
    for row, line in enumerate(lines):
        vertices += line.startswith("v ")
        if line.startswith("f ") and "-" in line:
            corners = [each.split("/")[0] for each in line.split()[1:]]
            lines[row] = "f " + " ".join(str(vertices + 1 + int(each)) if int(each) < 0 else each for each in corners)
    return "\n".join(lines).encode()


def _kind_and_content(content: bytes) -> tuple[str, bytes]:
    """The kind of a file (stl, stl_ascii, ply, obj), and what its reader is given."""
    if not content.strip(PADDING):
        raise ConfigError("is empty")
    begin = content.removeprefix(codecs.BOM_UTF8).lstrip()[:40]
    if begin.startswith(b"PK") and b"3d/3dmodel.model" in content.lower():
        raise ConfigError("is a 3MF file; export it as STL")
    for start, what in OTHER_FILES.items():
        if begin.startswith(start):
            raise ConfigError(what)
    if re.match(rb"ply\s", begin):
        is_text = re.search(rb"\nformat +ascii", content[:1000])
        return "ply", _plain_text(content).encode() if is_text else content.lstrip()
    # The top byte of a number of triangles is zero, and a text has no such byte.
    if b"\0" in content[HEADER - 4 : HEADER] and not content.startswith(UTF_16):
        return "stl", _binary_stl(content)
    text = _plain_text(content)
    if re.search(r"(?im)^(solid|facet)\b", text):
        return "stl_ascii", _stl_lines(text).encode()
    if re.search(r"(?m)^v ", text):
        return "obj", text.replace("\\\n", " ").encode()
    raise ConfigError(NOT_A_SURFACE)


def _stated_numbers(content: bytes) -> dict[bytes, int]:
    """Numbers of elements in the header of a PLY."""
    head = content.partition(b"\nend_header")[0]
    return {name: int(number) for name, number in re.findall(rb"\nelement +(\w+) +(\d+)", head)}


def _unfinished(kind: str, content: bytes) -> str | None:
    """What shows that a file was cut, or None."""
    if kind == "stl_ascii":
        last = max(content.rfind(word) for word in (b"\nsolid", b"facet", b"vertex"))
        return "it has no `endsolid` after its last triangle" if content.rfind(b"\nendsolid") < last else None
    if kind == "obj":
        return None if b"\nf " in content else "it has no faces"
    if kind == "ply" and b"\nformat ascii" in content:
        rows, expected = content.partition(b"\nend_header\n")[2].count(b"\n"), sum(_stated_numbers(content).values())
        return None if rows == expected else f"it has {rows} rows of numbers, not the {expected} of its header"
    return None


def _unread(kind: str, content: bytes, points: np.ndarray, triangles: np.ndarray) -> str | None:
    """What of a file is not in the points and triangles that were read, or None."""
    stated = {"stl_ascii": content.count(b"endfacet"), "ply": _stated_numbers(content).get(b"face", 0)}.get(kind, 0)
    if kind == "stl_ascii" and 3 * stated != (corners := content.count(b"vertex")):
        return f"it has {corners} corners, and `endfacet` {stated} times, not once for each three"
    if len(triangles) < stated:
        return f"of its {stated} faces {len(triangles)} can be read"
    if kind == "obj":
        last = np.array(content[content.rfind(b"\nv ") :].split()[1:4], dtype=float)
        if not (points[triangles.ravel()] == last).all(axis=1).any():
            return "its last vertex is in no face; if it is whole, export it without loose points"
    return None


def _why(kind: str, content: bytes, error: Exception) -> str:
    """Why a file could not be read."""
    if kind == "ply" and b"\nformat ascii" not in content:
        return "is cut, has bytes after its end, or faces of different numbers of corners; export it as triangles"
    if kind != "stl" and (comma := re.search(rb"[^\n]*\d,\d[^\n]*", content)):
        return f"has decimal commas ({comma[0].decode()[:60]}); export it with points"
    if cut := _unfinished(kind, content):
        return f"is cut: {cut}; copy or export it again"
    what = " ".join(str(error).split()) or type(error).__name__
    return f"cannot be read as {kind.split('_')[0].upper()} ({what})"


def read_triangles(content: bytes) -> tuple[np.ndarray, np.ndarray]:
    """The surface in the bytes of a file: points (v, 3) in the file's unit, and triangles (t, 3) as rows of them.

    Nothing is merged. Raises ConfigError for what is cut, or is not a surface.
    """
    kind, content = _kind_and_content(content)
    try:
        if kind == "obj":
            content = _counted_from_the_start(content)
        with warnings.catch_warnings():
            # Older numpy warns of a word among the numbers, and leaves out what follows.
            warnings.filterwarnings("error", "string or file could not be read", DeprecationWarning)
            mesh = trimesh.load_mesh(BytesIO(content), file_type=kind, process=False, skip_materials=True)
        points, triangles = np.array(mesh.vertices, dtype=float), np.array(mesh.faces, dtype=np.int64)
        if points.shape != (len(points), 3):
            raise ValueError("a point has fewer than three coordinates")
        if triangles.size == 0:
            triangles = triangles.reshape(0, 3)
        elif triangles.shape[1] != 3 or not -1 < triangles.min() <= triangles.max() < len(points):
            raise ValueError("its faces are not of points that it has")
        cut = _unfinished(kind, content) or _unread(kind, content, points, triangles)
    except Exception as error:  # whatever a reader of broken files may raise
        raise ConfigError(_why(kind, content, error)) from None
    if cut:
        raise ConfigError(f"is cut: {cut}; copy or export it again")
    if not len(triangles):
        raise ConfigError(f"has no triangles, or {NOT_A_SURFACE}")
    used, triangles = np.unique(triangles, return_inverse=True)
    return points[used], triangles.reshape(-1, 3)
