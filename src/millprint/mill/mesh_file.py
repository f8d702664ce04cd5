"""Files of triangles: STL, PLY and OBJ as programs write them, read whole or refused in one line.

The kind follows from the content, as names of files may be wrong. trimesh reads it. What it cannot read, or not as a
whole, is explained afterwards.
"""

import codecs
import re
import warnings
from io import BytesIO

import numpy as np
import trimesh

from millprint.config.errors import ConfigError

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
    return re.sub(r"(?im)^(solid|endsolid)\b.*$", r"\1", text).rstrip() + "\n"


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
        # Its normals are not read: the order of the corners counts.
        return "stl_ascii", text.lower().replace("normal", "").encode()
    if re.search(r"(?m)^v ", text):
        return "obj", text.encode()
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
    if len(triangles) < stated or (kind == "stl_ascii" and 3 * stated != content.count(b"vertex")):
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
    used, triangles = np.unique(triangles, return_inverse=True)
    return points[used], triangles.reshape(-1, 3)
