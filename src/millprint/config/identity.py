"""What decides the numbers of a simulation, so that nothing else simulates it again.

Not of it: words, facets that only draw round walls, the time between restart files, the rules that count collisions
(they are counted again from run.h5), and tolerances that a finished run kept. A rule that simulates has `identity` in
its parameters, and gets everything else in parameters that Snakemake does not compare, functions of the output.
"""

import json
from pathlib import Path
from typing import Any

from millprint.config.contact_set import ContactConfig
from millprint.config.mill import MillConfig
from millprint.config.sweep import Case, DemConfig

# Keys of mills and contact sets that change no simulation.
WORDS = {"title", "source", "speed_unit", "sweep"}
DURATIONS = {"settle_s", "discard_turns", "window_s"}
# A file next to run.h5, in which `keeps` looks: the tolerances that a run had, and what it reached.
TOLERANCES = "tolerances.json"


def _without_pictures(values: Any, by_facet: bool) -> Any:
    """Plain values without the facets of round walls; by_facet: contacts are counted by facet, which needs them."""
    if isinstance(values, list):
        return [_without_pictures(each, by_facet) for each in values]
    if not isinstance(values, dict):
        return values
    drawn = values.get("faceted", False) is False and not by_facet
    return {
        key: value if key == "post" and not drawn else _without_pictures(value, by_facet)
        for key, value in values.items()
        if not (drawn and "facet" in key and key != "faceted")
    }


def mill_identity(mill: MillConfig, by_facet: bool = False) -> dict:
    """A mill as plain values, without what changes no simulation of it."""
    return _without_pictures(mill.model_dump(mode="json", exclude=WORDS), by_facet)


def contact_identity(contact: ContactConfig) -> dict:
    """A contact set as plain values, without its words."""
    return contact.model_dump(mode="json", exclude=WORDS)


def dem_identity(dem: DemConfig) -> dict:
    """The settings of a simulation as plain values, without tolerances, counting rules and restart files."""
    left_out = {"counting_rules", "restart_interval_s", "overlap_max", "closure_max", "lammps"}
    return dem.model_dump(mode="json", exclude=left_out) | {"by_facet": dem.counts_by_facet}


def shared_identity(mill: MillConfig, contact: ContactConfig, dem: DemConfig) -> dict:
    """What decides the numbers of every case of a mill with a contact set."""
    return {
        "mill": mill_identity(mill, dem.counts_by_facet),
        "contact": contact_identity(contact),
        # A case has durations of its own.
        "dem": {key: value for key, value in dem_identity(dem).items() if key not in DURATIONS},
    }


def identity(case: Case, shared: dict, dem: DemConfig, folder: str | Path) -> dict:
    """What decides the numbers of a case; shared: as `shared_identity`; folder: of its run.h5."""
    own = case.model_dump(mode="json", exclude={"closure_max"})
    return {"case": own, **shared, "tolerances": revision(case, dem, folder)}


def revision(case: Case, dem: DemConfig, folder: str | Path) -> int:
    """How often a case was simulated again since a run did not keep its tolerances; one more if this one does not.

    A closure within the tolerance is kept. A run whose step was shortened depends on the closure that was asked for.
    The overlap is checked all the time and recorded only in the window, so that a smaller overlap_max is not kept.
    """
    try:
        made = json.loads((Path(folder) / TOLERANCES).read_text())
    except (FileNotFoundError, ValueError):
        return 0
    closure_max = case.closure_max or dem.closure_max
    closes = made["closure"] <= closure_max and (not made["shortened"] or closure_max == made["closure_max"])
    return int(made["revision"]) + (0 if closes and dem.overlap_max >= made["overlap_max"] else 1)


def tolerances_of(case: Case, dem: DemConfig, summary: dict, revision: int) -> dict:
    """The content of TOLERANCES for a finished run."""
    return {
        "closure_max": case.closure_max or dem.closure_max,
        "overlap_max": dem.overlap_max,
        "closure": summary["closure"],
        "shortened": summary["case"]["rayleigh_fraction"] != case.rayleigh_fraction,
        "revision": revision,
    }
