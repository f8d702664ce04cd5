"""The digest of a script covers exactly the files that it imports, directly or indirectly."""

from millprint import digest


def write(folder, name, text):
    path = folder / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)
    return path


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
    digest._imports.cache_clear()
    digest._module_files.cache_clear()
    digest.library_digest.cache_clear()
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
