"""Colours of figures and pages can be told apart with any colour vision; scales of colour rise in brightness."""

import re
from itertools import combinations

import numpy as np
import pytest

from millprint.figures.style import COLOURS
from millprint.thesis.report.claims_page import SHOWN_VERDICTS
from tests.colour_vision import LOST, distance, seen_lab
from tests.conftest import ROOT

# Eight times the smallest difference that an eye can see.
SMALLEST = 18.0
VERDICTS = tuple(colour for colour, _ in SHOWN_VERDICTS.values())
# Of the explorer: two series each, or balls, powder and jar.
EXPLORER = ("#0072b2", "#c2500a", "#333333")
LIBRARY = ROOT / "src/millprint"


@pytest.mark.parametrize("vision", LOST)
@pytest.mark.parametrize("palette", [COLOURS, VERDICTS, EXPLORER], ids=["figures", "verdicts", "explorer"])
def test_colours_of_a_palette_are_far_apart(palette, vision):
    near = {pair: distance(*pair, vision) for pair in combinations(palette, 2)}
    assert min(near.values()) > SMALLEST, min(near, key=near.get)


def test_the_simulation_confuses_what_people_confuse():
    """Otherwise the test above would pass with any palette."""
    for vision in ("protanopia", "deuteranopia"):
        assert distance("#ffffff", "#000000", vision) == pytest.approx(100, abs=1)
        assert np.allclose(seen_lab("#808080", vision), seen_lab("#808080", "normal"), atol=1.5)
    assert distance("#d7191c", "#1a9641", "normal") > 100
    red_green = {vision: distance("#a0522d", "#6b7a10", vision) for vision in LOST}
    assert red_green["normal"] > 2 * red_green["deuteranopia"]
    assert red_green["deuteranopia"] < SMALLEST


def test_figures_and_pages_have_no_other_colours():
    """A colour that is written down anywhere is of a palette above, or a shade of grey."""
    allowed = {colour.lower() for colour in (*COLOURS, *VERDICTS, *EXPLORER)}
    files = [*LIBRARY.glob("**/figures/*.py"), *LIBRARY.glob("view/*.py"), LIBRARY / "thesis/report/claims_page.py"]
    files += LIBRARY.glob("explorer/*.js")
    for file in files:
        for colour in re.findall(r"#(?:[0-9a-fA-F]{6}|[0-9a-fA-F]{3})\b", file.read_text()):
            full = colour.lower() if len(colour) == 7 else "#" + "".join(2 * letter for letter in colour[1:].lower())
            grey = full[1:3] == full[3:5] == full[5:7]
            assert grey or full in allowed, f"{file.name}: {colour}"
