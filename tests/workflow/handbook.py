"""The commands that the pages for users show."""

import re
import shlex
import textwrap
from dataclasses import dataclass
from itertools import dropwhile
from pathlib import Path

from tests.conftest import ROOT

BLOCK = re.compile(r"^(?P<indent> *)```(?:ba)?sh\n(?P<text>.*?)^(?P=indent)```$", re.MULTILINE | re.DOTALL)
# A command within a sentence.
INLINE = re.compile(r"`((?:make|snakemake|python|millprint) [^`]+)`")
# Names that stand for those of the reader, and what a test takes for them.
PLACES = {
    "MILL/CONTACT/CASE": "emax/calibrated/d10_f0.10_n300_s0",
    "mill=NAME": "mill=mine",
    "fingerprint NAME": "fingerprint spex",
}
# They read what a run of minutes leaves: test_cards.py and test_smoke.py run them on one.
READ_A_CARD, READ_A_RUN = "my_card", ("results/dem/", "results/fingerprint/", "results/yield/")


def pages() -> list[Path]:
    """Every page for users, relative to the project."""
    own = (path.relative_to(ROOT) for path in sorted((ROOT / "docs").rglob("*.md")) if "_build" not in path.parts)
    return [Path("README.md"), Path("CONTRIBUTING.md"), Path("config/README.md"), *own]


@dataclass(frozen=True)
class Command:
    """A command of a page, as a list of words without its comment."""

    page: str
    words: tuple[str, ...]

    def __str__(self) -> str:
        return f"{self.page}: {shlex.join(self.words)}"


def block_lines(text: str) -> list[str]:
    """The lines of the blocks of a page for a shell, with continued lines joined."""
    blocks = [textwrap.dedent(found["text"]) for found in BLOCK.finditer(text)]
    return [line for line in "".join(blocks).replace("\\\n", " ").splitlines() if line.strip()]


def commands(page: Path) -> list[Command]:
    """The commands of a page, in its blocks and in its sentences."""
    text = (ROOT / page).read_text()
    lines = [*block_lines(text), *(" ".join(found.split()) for found in INLINE.findall(BLOCK.sub("", text)))]
    for name, value in PLACES.items():
        lines = [line.replace(name, value) for line in lines]
    # `make install && source ...` is two commands.
    split = (shlex.split(part, comments=True) for line in lines for part in line.split(" && "))
    # A variable stands before the program that it is for.
    own = (tuple(dropwhile(lambda word: re.match(r"[A-Z_]+=", word), words)) for words in split)
    return [Command(str(page), words) for words in own if words]


def shown_file(page: str, language: str, number: int) -> str:
    """The text of a block of a page, such as its second `yaml`."""
    return re.findall(rf"^```{language}\n(.*?)^```$", (ROOT / page).read_text(), re.MULTILINE | re.DOTALL)[number]
