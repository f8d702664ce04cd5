"""What the walls of a mill do, in words, what its walls are, and their largest acceleration."""

import math

import pytest

from millprint.config.load import load_named
from millprint.config.mill import MillConfig
from millprint.config.motion_kinds import MOTIONS, MotionSection
from millprint.mill.bodies import build_bodies
from millprint.mill.speed_limits import mill_in_words, wall_acceleration
from millprint.mill.wall_words import walls_in_words
from tests.conftest import ROOT


def mill(name: str) -> MillConfig:
    return load_named(ROOT / "config/mills", name, MillConfig, "mill")


def test_every_motion_has_words():
    assert all(record.section.in_words is not MotionSection.in_words for record in MOTIONS.values())


def test_a_motion_without_words_is_refused():
    with pytest.raises(NotImplementedError, match="a motion of kind 'hop' has no words"):
        MotionSection(kind="hop").in_words()


def test_words_hold_the_numbers_of_the_mill():
    assert mill_in_words(mill("emax")) == "the jar moves on a horizontal circle of 17 mm radius without turning"
    assert "70.5 mm" in mill_in_words(mill("planetary")) and "-2 times" in mill_in_words(mill("planetary"))
    said = mill_in_words(mill("attritor"))
    assert said.startswith("the jar stands still; inside it, each of 5 bodies (") and said.endswith(
        "turns about a fixed axis"
    )


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("planetary", "1 cylinder, 1 torus, 2 discs"),
        ("drum_90cm", "1 cylinder; 26 flat walls"),
        ("emax", "1 flat wall, 385 flat facets of round walls"),
        ("attritor", "1 cylinder, 2 discs; inserts: 5 cylinders, 4 discs; 42 flat walls"),
    ],
)
def test_the_walls_are_told_in_words(name, words):
    assert walls_in_words(build_bodies(mill(name))) == words


def test_the_acceleration_of_a_wall_is_that_of_the_closed_form():
    w = 2 * math.pi
    assert wall_acceleration(mill("emax")) == pytest.approx(0.017 * w**2, rel=1e-3)
    # The jar's axis on the sun wheel, and its wall about this axis, which turns back once.
    assert wall_acceleration(mill("planetary")) == pytest.approx((0.0705 + 0.0375) * w**2, rel=5e-3)
    # A drum turns about its own axis.
    drum = mill("drum")
    assert wall_acceleration(drum) == pytest.approx(drum.geometry.radius_mm * 1e-3 * w**2, rel=5e-3)
