"""The digest of a script is that of what it and its imports compute, and of nothing else."""

import io
import re
import shutil
import tokenize
from pathlib import Path

import pytest

from millprint.run import digest

PACKAGE = digest.PACKAGE

SCRIPTS = sorted((Path(__file__).parents[2] / "scripts").glob("*.py"))
KEPT = (digest.content_digest, digest.imports, digest.program_digest, digest.simulation_digest)

FIRST = '''"""A module."""
import logging
from millprint.near import second
from millprint.run.job import progress

logger = logging.getLogger("millprint")


def halve(value):
    """Half of a value."""
    # A comment.
    if value < 0:
        raise ValueError(f"{value}: is negative")
    with progress(value, "halving", "halves") as bar:
        logger.info("half of %d", value)
        bar.update()
    return value / 2
'''
# What changes no result, and what does.
TEXTS = [
    ("A module.", "The module."),
    ("Half of a value.", "A half."),
    ("# A comment.", "# Another comment, in two\n    # lines."),
    ("is negative", "must be 0 or more"),
    ('"halving", "halves"', '"at work", "steps"'),
    ('logger.info("half of %d", value)', 'logger.info("a half", value)'),
    ("    return", "\n    return"),
]
RESULTS = [("/ 2", "/ 3"), ("< 0", "<= 0"), ("raise ValueError", "raise KeyError"), ("(value)", "(value, more=0)")]


def write(folder, name, text):
    path = folder / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)
    return path


def forget():
    """What a process keeps in memory: here the files change while it lives."""
    for kept in KEPT:
        kept.cache_clear()


@pytest.fixture(autouse=True)
def nothing_kept():
    forget()
    yield
    forget()


@pytest.fixture
def package(tmp_path, monkeypatch):
    """A small package and a script of it."""
    root = tmp_path / "millprint"
    for name in ("__init__.py", "progress.py", "near/__init__.py", "far/__init__.py"):
        write(root, name, "")
    write(root, "near/first.py", FIRST)
    write(root, "near/second.py", "VALUE = 1\n")
    write(root, "far/other.py", "VALUE = 2\n")
    monkeypatch.setattr(digest, "PACKAGE", root)
    return root, write(tmp_path, "script.py", "def main():\n    from millprint.near.first import second\n")


def fresh(script):
    forget()
    return digest.program_digest(script)


@pytest.mark.parametrize(("before", "after"), TEXTS)
def test_texts_change_nothing(package, before, after):
    root, script = package
    first = fresh(script)
    assert before in FIRST
    write(root, "near/first.py", FIRST.replace(before, after))
    assert fresh(script) == first


@pytest.mark.parametrize(("before", "after"), RESULTS)
def test_what_is_computed_changes_the_digest(package, before, after):
    root, script = package
    first = fresh(script)
    write(root, "near/first.py", FIRST.replace(before, after))
    assert fresh(script) != first


def test_only_what_is_imported_counts_also_through_other_files(package):
    root, script = package
    before = fresh(script)
    write(root, "far/other.py", "VALUE = 3\n")
    assert fresh(script) == before
    write(root, "near/second.py", "VALUE = 3\n")
    assert fresh(script) != before
    forget()
    changed = digest.program_digest(script)
    write(script.parent, script.name, script.read_text() + "    return 1\n")
    assert fresh(script) != changed


@pytest.fixture
def library(tmp_path, monkeypatch):
    """A copy of the library, of which the digest of a simulation is taken."""
    shutil.copytree(digest.PACKAGE, tmp_path / "millprint", ignore=shutil.ignore_patterns("__pycache__"))
    monkeypatch.setattr(digest, "PACKAGE", tmp_path / "millprint")
    return tmp_path / "millprint"


def edited(library, file, before, after) -> str:
    """The digest of a simulation after an edit of a file of the library."""
    text = (library / file).read_text()
    assert text.count(before) >= 1, file
    (library / file).write_text(text.replace(before, after))
    forget()
    return digest.simulation_digest()


def test_a_name_from_another_module_changes_the_digest(package):
    root, script = package
    write(root, "near/third.py", "VALUE, OTHER = 1, 2\n")
    both = "from millprint.near.second import {}\nfrom millprint.near.third import {}\n"
    write(script.parent, script.name, both.format("VALUE", "OTHER"))
    first = fresh(script)
    write(script.parent, script.name, both.format("OTHER", "VALUE"))
    assert fresh(script) != first


NUMBERS = [
    ("dem/__init__.py", "PHYSICS = 1", "PHYSICS = 2"),
    ("dem/run.py", "SHORTENED, SHORTEST = 2, 0.4", "SHORTENED, SHORTEST = 2, 0.3"),
    ("dem/law.py", " * ", " / "),
    ("dem/packing.py", " + ", " - "),
    ("dem/ledger.py", " / ", " * "),
    ("mill/motion.py", " * ", " / "),
    ("config/contact_set.py", '"static_friction": 0.0', '"static_friction": 0.1'),
    ("config/charge.py", " / ", " * "),
]


@pytest.mark.slow
def test_a_simulation_runs_again_where_its_numbers_may_change(library):
    forget()
    seen = {digest.simulation_digest()}
    # The settings of a chapter are none of its own.
    assert edited(library, "config/yields.py", "Count = 2000", "Count = 2001") in seen
    for edit in NUMBERS:
        now = edited(library, *edit)
        assert now not in seen, edit
        seen.add(now)


def test_what_counts_of_a_file_is_what_python_reads_in_it():
    """By the tokenizer of Python, of every file of the project: all but comments, layout, and lone strings."""
    for file in [*SCRIPTS, *PACKAGE.rglob("*.py")]:
        source = file.read_text()
        assert "".join("".join(tokens(source)).split()) == "".join(digest.computed(source).split()), file


def tokens(source: str) -> list[str]:
    """The tokens of a source without layout, lone strings, and strings of errors, of the log and of progress bars."""
    found, statement = [], []
    for token in tokenize.generate_tokens(io.StringIO(source + "\n").readline):
        if token.type == tokenize.NEWLINE:
            saying = re.match(r"raise |logger \. |with progress \( ", " ".join(each.string for each in statement))
            kept = [each.string for each in statement if not (saying and each.type == tokenize.STRING)]
            found += [] if len(statement) == 1 and statement[0].type == tokenize.STRING else kept
            statement = []
        elif token.type not in (tokenize.COMMENT, tokenize.NL, tokenize.INDENT, tokenize.DEDENT, tokenize.ENDMARKER):
            statement.append(token)
    return found
