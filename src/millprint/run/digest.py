"""Digests: of what a script computes, so that a comment reruns nothing, and of the files that every job wrote.

The digest covers the source of the script and of every millprint module that it imports, directly or indirectly,
without comments, docstrings, the layout of statements, and texts of errors, of the log and of progress bars. It is a
digest of text, so that every version of Python has the same. Other files in the folders of these modules, such as parts
of pages, count with their content.

Snakemake records digests of what a job reads, not of what it writes: it sees that a file is newer, not that it is
damaged. A job's record is a JSON file next to its log with size, SHA-256 digest and date of each file.
"""

import hashlib
import json
import os
import re
import sys
import time
from collections.abc import Container, Iterable
from functools import cache
from pathlib import Path

from millprint.run.files import whole_file

PACKAGE = Path(__file__).parents[1]
TEMPLATES = (".html", ".css", ".js", ".txt", ".yaml")

# A simulation begins in SIMULATION. OUTSIDE are modules that it imports and that do not affect its numbers: files and
# messages, and settings that it gets by value. If a change there does affect numbers, raise millprint.dem.PHYSICS.
SIMULATION = "dem/run.py"
OUTSIDE = {
    *(f"run/{name}.py" for name in ("digest", "files", "hdf5", "job", "machine")),
    *("config/errors.py", "config/fingerprint.py", "config/mill_sweep.py", "config/section.py"),
}

# An import anywhere in a file, or of the file itself. A docstring that looks like an import only adds a dependency.
STATEMENT = r"(?:from[ \t]+(millprint[\w.]*)[ \t]+import[ \t]+(\([^)]*\)|.+)|import[ \t]+(millprint[\w.]*))"
ANYWHERE, AT_ONCE = (re.compile(f"^{before}{STATEMENT}", re.M) for before in (r"[ \t]*", ""))

# An import of a file of a folder below the package by its name.
OF_A_FOLDER = re.compile(r'import_module\(f"(millprint\.[\w.]+)\.\{')


@cache
def program_digest(script: str | Path) -> str:
    """The digest of a script of scripts/ and of what it imports from millprint."""
    return _digest_of([Path(script)], imports(Path(script)), set())


@cache
def simulation_digest() -> str:
    """The digest of the code that decides the numbers of a simulation; its configuration is not included."""
    return _digest_of([], {SIMULATION}, OUTSIDE)


def _digest_of(files: list[Path], modules: set[str] | frozenset[str], outside: set[str]) -> str:
    """The digest of files, and of modules with all their imports except `outside`; both by paths in the package."""
    seen: set[str] = set()
    waiting = set(modules)
    while waiting := waiting - seen - outside:
        seen |= waiting
        waiting = {name for module in waiting for name in imports(PACKAGE / module)}
    for folder in {os.path.dirname(module) for module in seen}:
        seen.update(os.path.join(folder, name) for name in os.listdir(PACKAGE / folder) if name.endswith(TEMPLATES))
    contents = [content_digest(file) for file in [*files, *(PACKAGE / name for name in seen)]]
    return hashlib.sha256(b"".join(sorted(contents))).hexdigest()[:16]


def _of_a_folder(source: str) -> set[str]:
    """The modules of the folders of which a Python source imports files by their names."""
    folders = {package: PACKAGE.joinpath(*package.split(".")[1:]) for package in OF_A_FOLDER.findall(source)}
    return {f"{package}.{own.stem}" for package, folder in folders.items() for own in folder.glob("*.py")}


@cache
def imports(file: Path, pattern: re.Pattern[str] = ANYWHERE) -> frozenset[str]:
    """The millprint files that a Python file imports, with the packages that contain them; also inside functions."""
    source = file.read_text()
    modules = _of_a_folder(source)
    for package, names, module in pattern.findall(source):
        modules |= {module} if module else {package, *(f"{package}.{name}" for name in re.findall(r"\w+", names))}
    parts = {tuple(name.split(".")[1:]) for name in modules}
    folders = {part[:depth] for part in parts for depth in range(len(part) + 1)}
    found = {"/".join([*part, "__init__.py"]) for part in folders} | {"/".join(part) + ".py" for part in parts if part}
    return frozenset(name for name in found if (PACKAGE / name).is_file())


# A string, a comment, a bracket, the end of a line, blanks, a word, or an operator, in Python 3.11.
STRING = r"""[rRbBuUfF]{0,2}(?P<quote>"{3}|'{3}|["'])(?:\\.|[^\\])*?(?P=quote)"""
PIECE = re.compile(rf"""{STRING}|\#[^\n]*|[()\[\]{{}}]|\n|[^\S\n]+|\w+|[^\w\s"'\#()\[\]{{}}]+""", re.DOTALL)
# Statements whose strings are for people.
SAYING = ("raise ", "logger .", "with progress (")


def computed(source: str) -> str:
    """A Python source, a statement a line, without what its digest does not cover."""
    statements: list[list[str]] = []
    pieces: list[str] = []
    depth = 0
    for piece in (match[0] for match in PIECE.finditer(source + "\n")):
        depth += (piece in "([{") - (piece in ")]}")
        if piece == "\n" and not depth:
            statements.append(pieces)
            pieces = []
        elif piece[0] != "#":
            pieces.append(piece)
    kept = []
    for pieces in statements:
        indent = pieces.pop(0) if pieces and pieces[0].isspace() else ""
        pieces = [piece for piece in pieces if not piece.isspace()]
        text = " ".join(pieces)
        if text.startswith(SAYING):
            text = " ".join(piece for piece in pieces if piece[-1] not in "\"'")
        if pieces and not (len(pieces) == 1 and text[-1] in "\"'"):
            kept.append(indent + text)
    return "\n".join(kept)


@cache
def content_digest(file: Path) -> bytes:
    """The digest of a file; for a Python file, of what it computes."""
    content = file.read_bytes()
    return hashlib.sha256(computed(content.decode()).encode() if file.suffix == ".py" else content).digest()


def digest(path: str | Path) -> str:
    """SHA-256 of the content of a file."""
    with open(path, "rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def record_path(log_path: str | Path) -> Path:
    """The path of the record of the job with this log."""
    return Path(log_path).with_suffix(".json")


def read_record(path: Path) -> dict[str, dict]:
    """Bytes, digest and date of each file; empty if there is no readable record."""
    try:
        content = json.loads(path.read_text())
        files = {name: dict(entry) for name, entry in content["files"].items()}
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return {}
    return files if all({"bytes", "sha256", "date_ns"} <= set(entry) for entry in files.values()) else {}


def entry_of(file: str | Path) -> dict:
    """The entry of a file: bytes, digest and date [ns since 1970]."""
    found = os.stat(file)
    return {"sha256": digest(file), "bytes": found.st_size, "date_ns": found.st_mtime_ns}


def write_record(path: Path, files: Iterable[str | Path]) -> None:
    """Record the `files` that exist."""
    _write(path, {name: entry_of(name) for name in map(str, files) if Path(name).is_file()})


def _write(path: Path, entries: dict[str, dict]) -> None:
    with whole_file(path) as partial:
        partial.write_text(json.dumps({"files": entries}, indent=1, sort_keys=True) + "\n")


def report_damaged(logs: str | Path) -> int:
    """Print a line on stderr for each recorded file whose content has changed since its job; returns how many.

    Only files with another size or date than in the record are read. Snakemake changes the date of every output after
    its job, so each is read once; if it is unchanged, the new date is written to the record.
    """
    found = 0
    for record in sorted(Path(logs).rglob("*.json")):
        entries = read_record(record)
        damages = {name: damage for name, entry in entries.items() if (damage := _damage_of(name, entry))}
        for name, damage in damages.items():
            print(
                f"changed: {name}: {damage}; delete it, and a run makes it again; to keep it, delete {record}",
                file=sys.stderr,
                flush=True,
            )
        _renew_dates(record, entries, damages)
        found += len(damages)
    return found


def _damage_of(name: str, entry: dict) -> str:
    """What happened to a file since it was recorded; empty if it is unchanged, or missing, which Snakemake detects."""
    try:
        found = os.stat(name)
    except OSError:
        return ""
    if (found.st_size, found.st_mtime_ns) == (entry["bytes"], entry["date_ns"]):
        return ""
    dated = time.strftime("dated %Y-%m-%d %H:%M", time.localtime(found.st_mtime))
    if found.st_size < entry["bytes"]:
        return f"truncated, {found.st_size} bytes of {entry['bytes']} ({dated})"
    try:
        same = found.st_size == entry["bytes"] and digest(name) == entry["sha256"]
    except OSError as error:
        return f"cannot be read: {error.strerror} ({dated})"
    return "" if same else f"not as its job wrote it ({dated})"


def _renew_dates(record: Path, entries: dict[str, dict], damaged: Container[str]) -> None:
    """Update the dates of all undamaged files in a record, unless a job has changed the record in the meantime."""
    renewed = {}
    for name, entry in entries.items():
        there = name not in damaged and Path(name).is_file()
        renewed[name] = {**entry, "date_ns": os.stat(name).st_mtime_ns} if there else entry
    if renewed != entries and read_record(record) == entries:
        _write(record, renewed)
