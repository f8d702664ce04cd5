"""When the settings behind each prediction were fixed, and whether they are still the same.

The table of fixed predictions has a row for each set-up: the date, and a digest of every setting that makes the
prediction (section, mill, contact sets, steps of the DEM). The code is no part of it. A digest that no longer agrees
shows that a number was changed after the date, perhaps with the measured values in sight. A prediction that was fixed
again says why.
"""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from millprint.config.contact import ContactConfig
from millprint.config.mill import MillConfig
from millprint.config.setups.base import SetupConfig
from millprint.config.sweep import DemConfig
from millprint.errors import ConfigError
from millprint.files import write_table
from millprint.tables import Text, read_measured

COLUMNS = [Text("setup", unique=True), Text("date"), Text("digest"), Text("why")]
FIRST = "fixed for the first time"
# Settings of `dem` that can change a prediction; its times and its step are those of the section.
DEM_KEYS = {"rayleigh_fraction_max", "overlap_max"}
# Texts for people.
TEXTS = {"title", "source"}


@dataclass(frozen=True)
class Fixed:
    """The record of a set-up: the date, the digest of its settings then, and why it was fixed then."""

    date: str
    digest: str
    why: str = FIRST

    def status(self, digest: str) -> str:
        """Whether the settings of today are those of the date, in words."""
        if digest == self.digest:
            return f"settings fixed on {self.date}" + ("" if self.why == FIRST else f", again: {self.why}")
        return f"settings changed since they were fixed on {self.date}"


def settings_digest(
    settings: SetupConfig, mill: MillConfig | None, contacts: Mapping[str, ContactConfig], dem: DemConfig
) -> str:
    """A digest of every setting that makes the prediction of a set-up; where is predicted is none of them."""
    content = {
        "settings": settings.model_dump(mode="json", exclude=set(settings.places), exclude_none=True),
        "mill": mill and mill.model_dump(mode="json", exclude={*TEXTS, "sweep"}, exclude_none=True),
        "contacts": {
            name: contact.model_dump(mode="json", exclude=TEXTS, exclude_none=True)
            for name, contact in contacts.items()
        },
        "dem": dem.model_dump(mode="json", include=DEM_KEYS) if settings.sweeps else {},
    }
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()[:16]


def read_fixed(path: str | Path) -> dict[str, Fixed]:
    """The records by set-up. Raises ConfigError as `millprint.tables.read_measured`."""
    rows = read_measured(path, COLUMNS, fewest_rows=0).to_dict("records")
    return {row["setup"]: Fixed(row["date"], row["digest"], row["why"]) for row in rows}


def status_of(name: str, digest: str, fixed: Mapping[str, Fixed]) -> str:
    """Whether the settings of a set-up are those that were fixed, in words."""
    return fixed[name].status(digest) if name in fixed else "settings not fixed"


def fix(path: str | Path, digests: Mapping[str, str], today: str, why: str = "") -> list[str]:
    """Record the digests of some set-ups with the date, and return the names of those that have changed.

    A set-up whose digest is unchanged keeps its date. why: the reason for fixing again. Raises ConfigError where a
    set-up that had been fixed has changed, and no reason is given.
    """
    fixed = read_fixed(path) if Path(path).exists() else {}
    changed = [name for name, digest in digests.items() if name not in fixed or fixed[name].digest != digest]
    again = [name for name in changed if name in fixed]
    if again and not why:
        names = ", ".join(again)
        raise ConfigError(f"{path}: {names} had been fixed with other settings: say why they changed, by --why")
    fixed |= {name: Fixed(today, digests[name], why if name in again else FIRST) for name in changed}
    rows = [{"setup": name, **vars(each)} for name, each in sorted(fixed.items())]
    write_table(pd.DataFrame(rows, columns=[column.name for column in COLUMNS]), path)
    return changed
