"""Bodies from files of triangles (STL, PLY, OBJ): read, checked, and merged into flat facets.

A binary STL has 32-bit numbers: a coordinate of 35 mm is rounded by up to 2 nm, and flat facets are flat only to that
rounding. PLY and OBJ written as text, and an ASCII STL, have as many digits as their writer gave them.
"""

from io import BytesIO
from pathlib import Path

import numpy as np
import trimesh
from scipy.spatial import cKDTree

from millprint.config.errors import ConfigError
from millprint.config.geometry import StlGeometry
from millprint.mill.intersect import self_intersection
from millprint.mill.merge import FLAT, half_edges, merge_coplanar

METRES = {"mm": 1e-3, "cm": 1e-2, "m": 1.0, "inch": 0.0254}
# A binary STL: a header with the number of triangles, then the triangles [bytes].
HEADER, TRIANGLE = 84, 50
SMALLEST_M, LARGEST_M = 3e-3, 3.0
# Files of more triangles take minutes to check, and their curves have more facets than a simulation can take.
MOST_TRIANGLES = 500_000


def _mm(point: np.ndarray) -> str:
    return "(" + ", ".join(f"{value * 1e3:.4g}" for value in point) + ") mm"


def _read_file(geometry: StlGeometry) -> trimesh.Trimesh:
    """The surface as the file has it, in metres, nothing merged."""
    root = Path.cwd().resolve()
    path = (root / geometry.path).resolve()
    if not path.is_relative_to(root):
        raise ConfigError(f"leads out of the project, to {path}; copy the file into it")
    if not path.is_file():
        raise ConfigError("no such file")
    content, kind = whole_content(path.read_bytes(), path.suffix.lower()), path.suffix.lower().lstrip(".")
    try:
        mesh = trimesh.load_mesh(BytesIO(content), file_type=kind, process=False, skip_materials=True)
        points = np.array(mesh.vertices, dtype=float) * METRES[geometry.unit] * geometry.scale
        triangles = np.array(mesh.faces, dtype=np.int64)
    except Exception as error:  # whatever a reader of broken files may raise
        what = " ".join(str(error).split()) or type(error).__name__
        raise ConfigError(f"cannot be read as {path.suffix.lower()} ({what})") from None
    if triangles.ndim != 2 or len(triangles) < 4:
        raise ConfigError(f"{len(triangles)} triangles; a closed surface has at least 4")
    if len(triangles) > MOST_TRIANGLES:
        raise ConfigError(f"{len(triangles)} triangles, at most {MOST_TRIANGLES}: export it less finely")
    if not np.isfinite(points).all():
        raise ConfigError("has coordinates that are not finite numbers")
    return trimesh.Trimesh(points, triangles, process=False)


# How files begin that are sent or saved in place of a surface.
OTHER_FILES = {
    b"version https://git-lfs": "is a pointer of Git LFS and not the file itself; `git lfs pull` gets it",
    b"<": "is a page of the web (HTML) and not the file that it offers; download that",
    b"PK\x03\x04": "is a ZIP archive; unpack it",
    b"ISO-10303": "is a STEP file; export it as STL",
}


def whole_content(content: bytes, suffix: str) -> bytes:
    """The bytes of a surface without padding. Raises ConfigError for a file that is cut, or another one."""
    if not content.strip(b"\0 \r\n"):
        raise ConfigError("is empty")
    begin = content.lstrip()[:40]
    for start, what in OTHER_FILES.items():
        if begin.startswith(start):
            raise ConfigError(what)
    if suffix != ".stl":
        return content
    if b"facet" in content[:1000]:
        if begin.startswith(b"solid") and b"endsolid" not in content:
            raise ConfigError("is cut: it has no `endsolid`; copy or export it again")
        return content
    triangles = int.from_bytes(content[HEADER - 4 : HEADER], "little")
    size = HEADER + TRIANGLE * triangles
    if len(content) < size:
        raise ConfigError(
            f"is cut, or not an STL: it has {len(content)} bytes of the {size} for {triangles} triangles; copy or "
            "export it again"
        )
    if content[size:].strip(b"\0 \r\n"):
        raise ConfigError(f"has {len(content) - size} bytes after its {triangles} triangles; export it again")
    return content[:size]


def _check_size(mesh: trimesh.Trimesh, unit: str) -> None:
    smallest, *_, largest = sorted(mesh.extents)
    if smallest <= 0:
        raise ConfigError("all points lie in one plane; a closed surface encloses a volume")
    if not SMALLEST_M <= largest <= LARGEST_M:
        raise ConfigError(
            f"is {largest:.3g} m large if its unit is {unit}; a mill has {SMALLEST_M * 1e3:g} mm to {LARGEST_M:g} m: "
            "correct `unit`"
        )


def weld(points: np.ndarray, triangles: np.ndarray, tolerance: float) -> tuple[np.ndarray, np.ndarray]:
    """Merge points closer than a tolerance [m], also chains of such points.

    points (v, 3) [m]; triangles (t, 3), rows of points. Returns the merged points that a triangle uses, and the
    triangles as rows of them. A triangle whose corners are merged stays, without an area.
    """
    points, number = np.unique(points, axis=0, return_inverse=True)
    pairs = cKDTree(points).query_pairs(tolerance, output_type="ndarray")
    group = trimesh.graph.connected_component_labels(pairs, node_count=len(points))
    _, first = np.unique(group, return_index=True)
    used, triangles = np.unique(group[number.reshape(-1)[triangles]], return_inverse=True)
    return points[first[used]], triangles.reshape(-1, 3)


def _check_areas(mesh: trimesh.Trimesh, tolerance: float) -> None:
    corners = mesh.vertices[mesh.faces]
    longest = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2).max(axis=1)
    flat = np.flatnonzero(2 * mesh.area_faces <= tolerance * longest)
    if len(flat):
        raise ConfigError(
            f"{len(flat)} degenerate triangles without area, the first at {_mm(corners[flat[0], 0])}; remove them with "
            "the export's or a mesh program's repair"
        )


def _check_closed(mesh: trimesh.Trimesh) -> None:
    start, end = mesh.edges.T
    sides, of_side, uses = np.unique(mesh.edges_sorted, axis=0, return_inverse=True, return_counts=True)

    def edge(is_wrong: np.ndarray) -> str:
        first, second = mesh.vertices[sides[np.argmax(is_wrong)]]
        return f"the edge from {_mm(first)} to {_mm(second)}"

    for wrong, what, count in ((uses == 1, "open", "one triangle"), (uses > 2, "not manifold", "more than two")):
        if wrong.any():
            raise ConfigError(f"{what}: {edge(wrong)} belongs to {count} ({wrong.sum()} such edges)")
    sense = np.bincount(of_side.reshape(-1), np.where(start < end, 1, -1))
    if sense.any():
        raise ConfigError(f"the triangles at {edge(sense != 0)} are not oriented alike")
    twin = half_edges(mesh.faces).twin
    # Corners of triangles that are side by side around a vertex; a vertex with two such fans is where two parts touch.
    fans = np.column_stack([np.arange(len(twin)), twin - twin % 3 + (twin + 1) % 3])
    fan = trimesh.graph.connected_component_labels(fans, node_count=len(twin))
    fans_of_vertex = np.bincount(start[np.unique(fan, return_index=True)[1]])
    if fans_of_vertex.max() > 1:
        place = _mm(mesh.vertices[np.argmax(fans_of_vertex)])
        raise ConfigError(f"not manifold: two parts of the surface touch in the point {place}")


def _check_pieces(mesh: trimesh.Trimesh) -> None:
    pieces = trimesh.graph.connected_components(mesh.face_adjacency, nodes=np.arange(len(mesh.faces)))
    if len(pieces) == 1:
        return
    corners = [mesh.triangles[piece].reshape(-1, 3) for piece in pieces]
    low, high = np.array([part.min(axis=0) for part in corners]), np.array([part.max(axis=0) for part in corners])
    nested = len(pieces) == 2 and any((low[a] < low[1 - a]).all() and (high[a] > high[1 - a]).all() for a in (0, 1))
    volumes = [trimesh.triangles.mass_properties(mesh.triangles[piece])["volume"] for piece in pieces]
    if nested and min(volumes) < 0 < max(volumes):
        raise ConfigError("2 separate pieces; give only the hollow, not the wall around it")
    raise ConfigError(
        f"{len(pieces)} separate pieces; give one closed surface: export only the hollow, and each lifter, baffle or "
        "other body in it to a file of its own, one of `inserts`; without a `motion` it moves with the vessel, and may "
        "stand in its wall"
    )


def _rounding(points: np.ndarray) -> float:
    """What rounding in a file grows with [m]: the size of the body and its distance from the origin."""
    return max(float(np.ptp(points, axis=0).max()), float(np.abs(points).max()))


def _checked_mesh(geometry: StlGeometry) -> trimesh.Trimesh:
    mesh = _read_file(geometry)
    _check_size(mesh, geometry.unit)
    tolerance = FLAT * _rounding(mesh.vertices)
    mesh = trimesh.Trimesh(*weld(mesh.vertices, mesh.faces, tolerance), process=False)
    _check_areas(mesh, tolerance)
    _check_closed(mesh)
    _check_pieces(mesh)
    if mesh.volume <= 0:
        raise ConfigError(
            "inside out: the normals point into the body that the surface encloses; they must point out of it (for a "
            "vessel: from the hollow into the wall); flip all normals"
        )
    meeting = self_intersection(mesh.vertices, mesh.faces, tolerance)
    if meeting:
        first, second = mesh.triangles_center[list(meeting)]
        raise ConfigError(f"cuts through itself: the triangles at {_mm(first)} and {_mm(second)} intersect")
    return mesh


def mesh_facets(geometry: StlGeometry) -> list[list[np.ndarray]]:
    """Outlines (k, 3) [m] of the flat facets of a file's surface, counter-clockwise seen from outside the body.

    Raises ConfigError, beginning with the key `path`, for a surface that is open, not manifold, degenerate, inside out,
    in several pieces, cuts through itself or is of a size that no mill has.
    """
    try:
        mesh = _checked_mesh(geometry)
    except ConfigError as error:
        raise ConfigError(f"path = {geometry.path!r}: {error}") from None
    points = np.asarray(mesh.vertices)
    return merge_coplanar(points, np.asarray(mesh.faces), _rounding(points))
