"""What the pages say of matches is what the present code finds: the count over all pairs, and the example."""

import re

import numpy as np
import pytest
from tools import count_matches

from millprint.fingerprint.model import Fingerprint
from millprint.fingerprint.readers import find_ready_made, ready_made
from millprint.run.files import read_table
from tests.conftest import ROOT

NUMBER = re.compile(r"\d+\.?\d*")


@pytest.fixture
def pairs():
    return read_table(ROOT / count_matches.TABLE)


def test_the_table_of_the_page_counts_every_pair_in_every_sense(pairs):
    mills = ready_made()
    assert pairs.groupby("sense").size().to_dict() == dict.fromkeys(count_matches.SENSES, len(mills) * (len(mills) - 1))
    assert count_matches.block(pairs) in (ROOT / count_matches.PAGE).read_text()


@pytest.mark.slow
@pytest.mark.parametrize("sense", count_matches.SENSES)
def test_a_stored_pair_is_found_again(pairs, sense):
    one, other = (Fingerprint.read(find_ready_made(name)) for name in ("spex", "planetary"))
    stored = pairs[(pairs["like"] == "spex") & (pairs["mill"] == "planetary") & (pairs["sense"] == sense)].iloc[0]
    found = count_matches.match_pair(one, other, sense)
    assert found["verdict"] == stored["verdict"]
    for name, value in found.items():
        if isinstance(value, float):
            assert value == pytest.approx(stored[name], rel=1e-2, nan_ok=True), name


@pytest.mark.slow
@pytest.mark.parametrize("page", ["README.md", count_matches.PAGE])
def test_the_example_prints_what_the_page_shows(page):
    text, printed = (ROOT / page).read_text(), count_matches.example()
    assert f"millprint {count_matches.EXAMPLE}" in text
    (shown,) = re.findall(r"<!-- example: .*? -->\n(.*?)<!-- end -->", text, re.S)
    assert NUMBER.sub("", shown).split() == NUMBER.sub("", printed).split()
    numbers = [np.array(NUMBER.findall(each), dtype=float) for each in (shown, printed)]
    np.testing.assert_allclose(*numbers, rtol=2e-2, atol=1e-2)
