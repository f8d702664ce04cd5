"""The page "from a paper to your mill": one HTML file with the atlas, which computes in the browser."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pandas as pd
from markupsafe import Markup

from millprint.atlas.atlas_model import FITTED, HITS, PREDICTED, KindModel, read_model
from millprint.atlas.compare_models import MARKS
from millprint.atlas.estimate_mill import BEYOND, STIFFNESS
from millprint.atlas.kind_groups import MOST_BALLS, PACKED, SETTINGS, Kind
from millprint.atlas.kinds import KINDS
from millprint.atlas.owned_mills import included_mills, makers_mills
from millprint.atlas.page.written_formulas import formulas
from millprint.config.fingerprint import SearchConfig
from millprint.config.included import load_contact
from millprint.fingerprint.condition_search import SOLD_MM
from millprint.run.files import read_json, read_table
from millprint.run.html_pages import embed_files, embed_json, render_page

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
    return {
        "kinds": {kind.name: _words(kind) for kind in kinds},
        "not_yet": [kind.title for kind in KINDS.values() if kind not in kinds],
        "settings": [vars(own) for own in SETTINGS],
        "models": {kind.name: _model(models[kind.name]) for kind in kinds},
        "errors": {kind.name: _errors(errors[errors["kind"] == kind.name]) for kind in kinds},
        "least_held": LEAST_HELD,
        "fitted": FITTED,
        "predicted": PREDICTED,
        "limits": {"hits": HITS, "beyond": BEYOND, "stiffness": STIFFNESS, "most_balls": MOST_BALLS, "packed": PACKED},
        "turns": {"per_radius": turns["per_radius"], "kinds": {kind.name: turns["kinds"][kind.name] for kind in kinds}},
        "mills": [*included_mills(included, kinds), *makers_mills(makers, kinds)],
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
    )


def read_content(folder: Path, turns: Path, included: list[str]) -> dict[str, Any]:
    """The data of the page from a folder such as config/atlas, and the recorded turns of `tools/record_turns.py`."""
    models, errors = read_model(folder / "model.json"), read_table(folder / "errors.tsv")
    return atlas_content(models, errors, read_json(turns), folder / "makers.tsv", included)
