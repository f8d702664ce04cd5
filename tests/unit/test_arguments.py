"""Arguments have the ranges of the keys that they stand for, and the likely mistake is named in one line."""

import os
import subprocess
import sys

import pytest

from millprint.cli.commands import main
from tests.refusals import refusals


@pytest.mark.parametrize(("words", "parts"), refusals("the_likely_mistake_is_named"))
def test_the_likely_mistake_is_named(tmp_path, monkeypatch, capsys, words, parts):
    monkeypatch.chdir(tmp_path)
    try:
        assert main(words.split()) == 1
    except SystemExit as ended:
        assert ended.code == 2
    *_, line = capsys.readouterr().err.splitlines()
    assert line.startswith("error: ") and all(part in line for part in parts), line


@pytest.mark.parametrize(
    "words",
    [(), *(pytest.param(("fingerprint", "planetary", way), marks=pytest.mark.slow) for way in ("-n", "--list-rules"))],
)
def test_a_reader_that_ends_gets_no_traceback(tmp_path, words):
    read, write = os.pipe()
    os.close(read)
    command = [sys.executable, "-m", "millprint.cli", *words]
    done = subprocess.run(command, stdout=write, stderr=subprocess.PIPE, text=True, check=False, cwd=tmp_path)
    os.close(write)
    assert done.returncode == 141 and "Traceback" not in done.stderr and "BrokenPipe" not in done.stderr


@pytest.mark.parametrize(("words", "said"), refusals("a_new_mill_says_what_is_unlikely"))
def test_a_new_mill_says_what_is_unlikely(tmp_path, monkeypatch, capsys, words, said):
    monkeypatch.chdir(tmp_path)
    main(["new", "planetary", "--name", "a", "--no-picture", "--set", words])
    assert said in capsys.readouterr().err
