"""The digest of a script covers exactly the files that it imports, directly or indirectly."""

from pathlib import Path

import pytest

from millprint import digest

SCRIPTS = sorted((Path(__file__).parents[2] / "scripts").glob("*.py"))


def write(folder, name, text):
    path = folder / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)
    return path


def forget():
    """What a process keeps in memory: here the files change while it lives."""
    for kept in (digest._folders, digest._module_files, digest._content, digest._imports_of, digest.library_digest):
        kept.cache_clear()


@pytest.fixture(autouse=True)
def nothing_kept():
    forget()
    yield
    forget()


def package(folder, monkeypatch):
    root = folder / "millprint"
    for name in ("__init__.py", "near/__init__.py", "far/__init__.py"):
        write(root, name, "")
    write(root, "near/first.py", "from millprint.near import second\n")
    write(root, "near/second.py", "VALUE = 1\n")
    write(root, "far/other.py", "VALUE = 2\n")
    monkeypatch.setattr(digest, "PACKAGE", root)
    return root, write(folder, "script.py", "def main():\n    from millprint.near.first import second\n")


def fresh(script):
    forget()
    return digest.library_digest(script)


def test_files_are_followed_through_imports(tmp_path, monkeypatch):
    root, script = package(tmp_path, monkeypatch)
    names = [path.relative_to(root).as_posix() for path in digest.library_files(script)]
    assert names == ["__init__.py", "near/__init__.py", "near/first.py", "near/second.py"]


def test_digest_changes_with_what_is_used_only(tmp_path, monkeypatch):
    root, script = package(tmp_path, monkeypatch)
    before = fresh(script)
    write(root, "far/other.py", "VALUE = 3\n")
    assert fresh(script) == before
    write(root, "near/second.py", "VALUE = 3\n")
    assert fresh(script) != before


def test_digest_changes_with_the_templates_of_the_used_modules(tmp_path, monkeypatch):
    root, script = package(tmp_path, monkeypatch)
    write(root, "near/page.html", "<p>")
    write(root, "far/page.html", "<p>")
    before = fresh(script)
    write(root, "far/page.html", "<h1>")
    assert fresh(script) == before
    write(root, "near/page.html", "<h1>")
    assert fresh(script) != before


def test_every_file_is_read_once_for_all_scripts(monkeypatch):
    """The Snakefile asks for the digest of every script, in a dry run too."""
    opened = []
    read = Path.read_bytes
    monkeypatch.setattr(Path, "read_bytes", lambda path: opened.append(path) or read(path))
    assert len(set(map(digest.library_digest, SCRIPTS))) > 50
    assert len(opened) == len(set(opened)) > 200
