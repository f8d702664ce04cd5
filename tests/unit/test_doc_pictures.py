"""Each picture of a page is of the run that its text describes."""

import json
import re
from pathlib import Path

import pytest
from PIL import Image
from tools.draw_pictures import ANIMATION, DRAWINGS, PICTURES, RUNS, TABLE, mill_of
from tools.made_by import digest_of

from millprint.config.included import load_mill, read_run
from millprint.config.mill_sweep import MillSweepConfig
from millprint.dem import PHYSICS
from millprint.run.files import read_table
from tests.conftest import ROOT

SHOWN = re.compile(r"!\[(?P<words>[^\]]*)\]\((?P<path>[^)]*pictures/[^)]*)\)")
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
FIRST_HOUR = (ROOT / "docs/first_hour.md").read_text()


def shown() -> list[tuple[Path, str, Path]]:
    """The pictures of all pages: page, what is said of the picture, and its file."""
    return [
        (page, found["words"], (page.parent / found["path"]).resolve())
        for page in PAGES
        for found in SHOWN.finditer(page.read_text())
    ]


def test_every_picture_is_there_and_shown():
    files = {path for _, _, path in shown()}
    assert files == set(PICTURES.iterdir())


def test_every_picture_is_what_the_table_says_and_what_the_present_code_would_draw():
    """A picture that was put in by hand, or is of a mill or a physics of before, is found out."""
    made = read_table(TABLE).set_index("picture")
    assert {path.name for path in PICTURES.iterdir()} == set(made.index) == {*RUNS, *DRAWINGS, ANIMATION}
    for name, row in made.iterrows():
        assert row["sha256"] == digest_of((PICTURES / name).read_bytes()), f"python -m tools.draw_pictures {name}"
        if name not in RUNS:
            assert row["made_of"] == mill_of(name), f"python -m tools.draw_pictures {name}"
            continue
        # A page carries what it was made of; the condition that it shows is one that its command simulates.
        with Image.open(PICTURES / name) as picture:
            told = picture.text
        numbers, command = json.loads(told["numbers"]), RUNS[name][0]
        assert told["run"] == command and told["made of"] == row["made_of"]
        assert row["made_of"].startswith(f"physics {PHYSICS}, "), f"python -m tools.draw_pictures {name}"
        sweep = read_run(given)["sweep"] if (given := command.split()[-1]).endswith(".yaml") else load_mill(given).sweep
        sweep = MillSweepConfig.model_validate(sweep)
        assert numbers["speed"] in sweep.speeds and numbers["ball diameter"] in sweep.balls
        assert numbers["fill ratio"] in sweep.fills


# What the text says of the page that it shows: the row of the page, the words around the number, and its unit.
SAID = {
    "speed": (r"\(left\): (\d+) rpm", 1),
    "ball diameter": (r"balls of (\d+) mm, \d+ % of the jar", 1),
    "fill ratio": (r"(\d+) % of the jar filled with balls", 0.01),
    "weighted normal energy E*n": (r"dissipates ([\d.]+) µJ by compression", 1e-6),
    "weighted tangential energy E*t": (r"one ([\d.]+) mJ by shear", 1e-3),
    "weighted normal frequency f*n": (r"about ([\d.]+) collisions a second", 1),
    "weighted tangential frequency f*t": (r"about ([\d.]+) of the second", 1),
    "normal power": (r"dissipate ([\d.]+) W by compression", 1),
    "tangential power": (r"and ([\d.]+) W by shear", 1),
    "power": (r"rolling ([\d.]+) W in all", 1),
    "dose of an hour at a ball-to-powder ratio of 10": (r"in all: ([\d.]+) kJ for a gram", 1),
    "wall power per ball: of speed": (r"speed to the power of (\d+\.\d+)", 1),
}


@pytest.mark.parametrize("row", SAID)
def test_the_first_hour_says_what_its_picture_shows(row):
    with Image.open(PICTURES / "first_hour_fingerprint.png") as picture:
        numbers = json.loads(picture.text["numbers"])
    pattern, unit = SAID[row]
    (said,) = re.findall(pattern, " ".join(FIRST_HOUR.split()))
    # To the digits that the text has.
    decimals = len(said.partition(".")[2])
    assert abs(float(said) - numbers[row] / unit) <= 0.5001 * 10**-decimals
