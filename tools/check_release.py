"""Checks that a tag is the version of pyproject.toml, CITATION.cff and CHANGELOG.md: `check_release.py v1.2.3`."""

import re
import sys
import tomllib
from pathlib import Path

import yaml

ROOT = Path(__file__).parent.parent


def faults(tag: str) -> list[str]:
    """A line for each place with another version than the tag, or nothing."""
    version = tag.removeprefix("v")
    headings = re.findall(r"^## (\S+)", (ROOT / "CHANGELOG.md").read_text(encoding="utf-8"), re.MULTILINE)
    places = {
        "pyproject.toml": tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["version"],
        "CITATION.cff": str(yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))["version"]),
        "first heading of CHANGELOG.md": headings[0],
    }
    return [f"error: the {place} is {found}, the tag {tag}" for place, found in places.items() if found != version]


if __name__ == "__main__":
    found = faults(sys.argv[1])
    print("\n".join(found) or f"{sys.argv[1]}: the same in all places")
    sys.exit(bool(found))
