"""The page "from a paper to your mill": one HTML file with the atlas, which computes in the browser."""

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pandas as pd
from markupsafe import Markup

from millprint.atlas.atlas_model import FITTED, HITS, MARKS, PREDICTED, KindModel, combined, read_model
from millprint.atlas.estimate_mill import STIFFNESS
from millprint.atlas.kind_groups import BEYOND, MOST_BALLS, PACKED, SETTINGS, Kind
from millprint.atlas.kinds import KINDS
from millprint.atlas.search_mills import fastest_of_kinds, listed_mills, makers_mills
from millprint.config.fingerprint import SearchConfig
from millprint.config.included import load_contact
from millprint.fingerprint.condition_search import SOLD_MM
from millprint.run.files import read_json, read_table
from millprint.run.html_pages import embed_files, embed_json, render_page

# Functions of numpy that a formula may use, by their names in JavaScript.
FUNCTIONS = {"log": "Math.log", "exp": "Math.exp", "sqrt": "Math.sqrt", "maximum": "Math.max", "minimum": "Math.min"}


class Name:
    """A number that is not known yet: what is computed with it becomes the text of a formula."""

    def __init__(self, text: str) -> None:
        self.text = text

    def __add__(self, other: Any) -> "Name":
        return _joined(self, "+", other)

    def __radd__(self, other: Any) -> "Name":
        return _joined(other, "+", self)

    def __sub__(self, other: Any) -> "Name":
        return _joined(self, "-", other)

    def __rsub__(self, other: Any) -> "Name":
        return _joined(other, "-", self)

    def __mul__(self, other: Any) -> "Name":
        return _joined(self, "*", other)

    def __rmul__(self, other: Any) -> "Name":
        return _joined(other, "*", self)

    def __truediv__(self, other: Any) -> "Name":
        return _joined(self, "/", other)

    def __rtruediv__(self, other: Any) -> "Name":
        return _joined(other, "/", self)

    def __neg__(self) -> "Name":
        return Name(f"(-{self.text})")

    def __pow__(self, power: Any) -> "Name":
        return Name(f"Math.pow({self.text}, {_text(power)})")

    def __array_ufunc__(self, function: Any, method: str, *values: Any, **_: Any) -> "Name":
        if method != "__call__" or function.__name__ not in FUNCTIONS:
            raise TypeError(f"numpy.{function.__name__}: add its name in JavaScript to FUNCTIONS of {__name__}")
        return Name(f"{FUNCTIONS[function.__name__]}({', '.join(map(_text, values))})")


def _text(value: Any) -> str:
    if isinstance(value, Name):
        return value.text
    number = float(value)
    if not math.isfinite(number):
        raise ValueError(f"{number} has no number in JavaScript")
    return f"({number!r})" if number < 0 else repr(number)


def _joined(one: Any, sign: str, other: Any) -> Name:
    return Name(f"({_text(one)} {sign} {_text(other)})")


def _object(values: dict[str, Any]) -> str:
    return "{ " + ", ".join(f"{name}: {_text(value)}" for name, value in values.items()) + " }"


def formulas_of(kind: Kind) -> str:
    """Functions of a condition c or of groups g, as an object: volume_m3, stroke_m, groups, scales, derived,
    bounded."""
    condition: dict[str, Any] = {own.name: Name(f"c.{own.name}") for own in (*kind.dimensions, *SETTINGS)}
    groups: dict[str, Any] = {name: Name(f"g.{name}") for name in kind.names}
    derived = ", ".join(_text(of(groups)) for of in kind.derived)
    bounded = ", ".join(_text(limit.of(groups)) for limit in kind.limits)
    return (
        "{\n"
        f"    volume_m3: (c) => {_text(kind.volume_m3(condition))},\n"
        f"    stroke_m: (c) => {_text(kind.stroke_m(condition))},\n"
        f"    groups: (c) => ({_object(kind.groups_of(condition))}),\n"
        f"    scales: (c) => ({_object(kind.scales(condition))}),\n"
        f"    derived: (g) => [{derived}],\n"
        f"    bounded: (g) => [{bounded}],\n"
        "  }"
    )


def formulas(kinds: list[Kind]) -> str:
    """FORMULAS and COMBINED of the page.

    Those of each kind by its name; and the logarithms of what is predicted, each a function of those of what is fitted.
    """
    parts = "\n".join(f"  {kind.name}: {formulas_of(kind)}," for kind in kinds)
    fitted: dict[str, Any] = {name: Name(f"f.{name}") for name in FITTED}
    predicted = "\n".join(f"  {name}: (f) => {_text(value)}," for name, value in combined(fitted).items())
    head = "/* Written by millprint.atlas.page.atlas_page. */"
    return f"{head}\nconst FORMULAS = {{\n{parts}\n}};\nconst COMBINED = {{\n{predicted}\n}};"


FOLDER = Path(__file__).parent
EXPLORER = FOLDER.parents[1] / "explorer"
# In the order of their dependencies.
SHARED = ("elements.js", "units.js", "match.js")
SCRIPTS = ("model.js", "judge.js", "nearest.js", "turns.js", "side.js", "page.js")
# Contact sets to choose from, the first is chosen.
CONTACTS = ("calibrated", "steel")
# Rows of the table of errors, and the share of held-out mills below which an interval decides nothing.
OF_ERRORS = {"median": "atlas", "held": "share held by the 90 % interval"}
LEAST_HELD = 0.8


def _words(kind: Kind) -> dict[str, Any]:
    return {
        "title": kind.title,
        "speed_unit": kind.speed_unit,
        "dimensions": [vars(own) for own in kind.dimensions],
        "ranges": [vars(group) for group in kind.groups],
        "ends": kind.ends,
        "bounds": [{"formula": own.formula, "reason": own.reason, "most": own.most} for own in kind.limits],
    }


def atlas_content(
    models: Mapping[str, KindModel], errors: pd.DataFrame, turns: dict, makers: str | Path, included: list[str]
) -> dict[str, Any]:
    """All data of the page.

    models: of each kind by name; errors: on the held-out mills, as config/atlas/errors.tsv; turns: content of the file
    of recorded turns; makers: path of the table of makers' mills; included: names of mills that come with the library.
    """
    kinds = [kind for name, kind in KINDS.items() if name in models]
    made = makers_mills(makers, kinds)
    return {
        "kinds": {kind.name: _words(kind) for kind in kinds},
        "not_yet": [kind.title for kind in KINDS.values() if kind not in kinds],
        "settings": [vars(own) for own in SETTINGS],
        "models": {kind.name: _model(models[kind.name]) for kind in kinds},
        "errors": {kind.name: _errors(errors[errors["kind"] == kind.name]) for kind in kinds},
        "least_held": LEAST_HELD,
        "marks": MARKS,
        "fitted": FITTED,
        "predicted": PREDICTED,
        "limits": {"hits": HITS, "beyond": BEYOND, "stiffness": STIFFNESS, "most_balls": MOST_BALLS, "packed": PACKED},
        "turns": {"per_radius": turns["per_radius"], "kinds": {kind.name: turns["kinds"][kind.name] for kind in kinds}},
        "mills": listed_mills(made, included, kinds),
        "fastest_hz": fastest_of_kinds(made),
        "contacts": [_contact(name) for name in CONTACTS],
        "sold_mm": SOLD_MM,
        "near_percent": SearchConfig().near_percent,
    }


def _model(own: KindModel) -> dict[str, Any]:
    """A model as its file has it, without what only errors of slopes need."""
    content = own.plain()
    for surface in (*content["surfaces"].values(), content["hits"]):
        del surface["noise"], surface["amplitude"], surface["factor"]
    return {**content, "about": own.about}


def _errors(rows: pd.DataFrame) -> dict[str, Any]:
    """Number of held-out mills of a kind, and median error and share held by the intervals of each number [-]."""
    own = rows.set_index("model")
    shares = {name: own.loc[row, list(MARKS)].astype(float).to_dict() for name, row in OF_ERRORS.items()}
    return {"mills": int(own.loc[OF_ERRORS["median"], "mills"]), **shares}


def _contact(name: str) -> dict[str, Any]:
    contact = load_contact(name)
    return {
        "name": name,
        "source": contact.source,
        "restitution": contact.value_of("restitution"),
        "static_friction": contact.value_of("static_friction"),
        "wall_static_friction": contact.at_wall.value_of("static_friction"),
        "rolling_friction": contact.value_of("rolling_friction"),
        "young_modulus_gpa": contact.value_of("young_modulus_gpa"),
    }


def atlas_page(content: dict[str, Any]) -> str:
    """The page with `content` from `atlas_content`."""
    kinds = [KINDS[name] for name in content["kinds"]]
    return render_page(
        FOLDER / "page.html",
        style=Markup("\n").join(embed_files(folder, "page.css") for folder in (EXPLORER, FOLDER)),
        scripts=Markup("\n").join(
            [embed_files(EXPLORER, *SHARED), Markup(formulas(kinds)), embed_files(FOLDER, *SCRIPTS)]
        ),
        content=embed_json(content),
        near_percent=f"{content['near_percent']:g}",
        least_held=f"{content['least_held']:.0%}".replace("%", " %"),
    )


def read_content(folder: Path, turns: Path, included: list[str]) -> dict[str, Any]:
    """The data of the page from a folder such as config/atlas, and the recorded turns of `tools/record_turns.py`."""
    models, errors = read_model(folder / "model.json"), read_table(folder / "errors.tsv")
    return atlas_content(models, errors, read_json(turns), folder / "makers.tsv", included)
