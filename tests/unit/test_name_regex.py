"""Patterns of many names."""

import re
import time

import pytest

from millprint.run.name_regex import any_of

NAMES = ["d10_f0.06_n600", "d10_f0.06_n60", "d5_f0.1", "d5_f0.10", "a+b", "a"]


@pytest.mark.parametrize("name", NAMES)
def test_each_name_matches(name):
    assert re.fullmatch(any_of(NAMES), name)
    assert re.match(f"(?:{any_of(NAMES)})/", f"{name}/summary.json")


@pytest.mark.parametrize("name", ["", "d10_f0.06", "d10_f0.06_n6000", "d5_f0x1", "aab", "ab"])
def test_another_name_does_not(name):
    assert not re.fullmatch(any_of(NAMES), name)


def test_without_names_nothing_matches():
    assert not re.fullmatch(any_of([]), "") and not re.fullmatch(any_of([]), "a")


def test_a_match_among_thousands_of_names_is_quick():
    names = [f"grown/calibrated/d{size}_f{fill:.4f}_n{speed}" for size in range(5, 15) for fill in
             (0.06 + 0.001 * step for step in range(100)) for speed in range(100, 1000, 50)]  # fmt: skip
    found, plain = re.compile(any_of(names)), re.compile("|".join(map(re.escape, names)))

    def matching(pattern: re.Pattern) -> float:
        begin = time.process_time()
        assert all(pattern.fullmatch(name) for name in names[::90])
        return time.process_time() - begin

    assert matching(found) < 0.1 * matching(plain)
