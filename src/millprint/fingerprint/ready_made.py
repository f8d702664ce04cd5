"""The fingerprints that come with millprint: its own mills at precision `standard`, so that they need no simulation.

`tools/ship_fingerprints.py` makes them. A mill or contact set that was changed since has none.
"""

import hashlib
import json
from pathlib import Path

from millprint.config.contact_set import ContactConfig
from millprint.config.included import load_contact, load_mill, shipped
from millprint.config.mill import MillConfig
from millprint.run.files import read_table

FOLDER = "config/fingerprints"
# A row for each: mill, contact, digest (of `digest_of`), sha256 of its file, and what it was made with.
TABLE = f"{FOLDER}/made.tsv"
# What changes no simulation of a mill.
WORDS = {"title", "source", "speed_unit", "sweep"}


def digest_of(mill: MillConfig, contact: ContactConfig) -> str:
    """A short digest of what a mill and its contact set are, without their words and the mill's sweep."""
    parts = [mill.model_dump(mode="json", exclude=WORDS), contact.model_dump(mode="json", exclude=WORDS)]
    return hashlib.sha256(json.dumps(parts, sort_keys=True).encode()).hexdigest()[:16]


def ready_made() -> list[str]:
    """Names of the mills that have a fingerprint without a simulation, in the order of the table."""
    table = shipped(TABLE)
    return list(read_table(table)["mill"]) if table else []


def find_ready_made(mill: str) -> Path | None:
    """The file of a mill's fingerprint; None if it has none, or if the mill of that name is another one here."""
    if mill not in ready_made():
        return None
    row = read_table(str(shipped(TABLE))).set_index("mill").loc[mill]
    if digest_of(load_mill(mill), load_contact(row["contact"])) != row["digest"]:
        return None
    path = shipped(f"{FOLDER}/{mill}.json")
    return Path(path) if path else None
