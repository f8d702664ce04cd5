"""The mills that somebody may own: those of makers, of a table with sources, and those that come with the library."""

from pathlib import Path
from typing import Any

from millprint.atlas.kind_groups import Kind
from millprint.atlas.kinds import recognise
from millprint.config.included import load_mill
from millprint.run.files import read_table

# What a table of makers calls a jar that fits several mills.
JAR, ASSUMED = "jar of", "assumed"
SPEEDS = {"speed_max_rpm": 1 / 60, "speed_max_hz": 1.0}


def makers_mills(path: str | Path, kinds: list[Kind]) -> list[dict[str, Any]]:
    """The mills of makers: dimensions of the table of makers, the others as the included mill of the kind has them.

    known: how each of the dimensions is known that the table does not assume.
    """
    table = read_table(path)
    found: list[dict[str, Any]] = []
    for (name, kind_name), rows in table.groupby(["mill", "kind"], sort=False):
        kind = next((kind for kind in kinds if kind.name == kind_name), None)
        values = dict(zip(rows["quantity"], rows["value"], strict=True))
        known = recognise(load_mill(kind.name)) if kind else None
        own = {each.name for each in kind.dimensions} & set(values) if kind else set()
        if kind is None or known is None or JAR in name or not own - {"ratio"}:
            continue
        fastest = [values[key] * factor for key, factor in SPEEDS.items() if key in values]
        found.append({
            "title": name, "kind": kind.name, "dimensions": known[1] | {each: values[each] for each in own},
            "fastest_hz": fastest[0] if fastest else None,
            "known": {row["quantity"]: row["how_known"] for row in rows.to_dict("records")
                      if row["quantity"] in own and not row["how_known"].startswith(ASSUMED)},
        })  # fmt: skip
    return found


def included_mills(names: list[str], kinds: list[Kind]) -> list[dict[str, Any]]:
    """Those of the included mills that are of a kind of the atlas."""
    found: list[dict[str, Any]] = []
    for name in names:
        mill = load_mill(name)
        built = recognise(mill)
        if built and built[0] in kinds:
            own = {"title": mill.title, "kind": built[0].name, "dimensions": built[1]}
            found.append({**own, "fastest_hz": None, "known": None})
    return found
