"""When the settings behind each prediction were fixed, and whether they are still the same.

The table of fixed predictions has a row for each time that a set-up was fixed: date and time, a digest of every setting
that makes the prediction (section, mill, contact sets, steps of the DEM), and why. The code is not in the digest. A
digest that no longer agrees shows that a setting was changed after the date, perhaps with the measured values in sight.
Rows are only added, so that the table shows every change.
"""

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from millprint.config.contact_set import ContactConfig
from millprint.config.errors import ConfigError
from millprint.config.mill import MillConfig
from millprint.config.setup_models import SetupConfig
from millprint.config.sweep import DemConfig
from millprint.run.files import write_table
from millprint.run.tables import Text, read_measured

COLUMNS = [Text("setup"), Text("date"), Text("digest"), Text("why")]
FIRST = "fixed for the first time"
# Settings of `dem` that can change a prediction; times and step are set by the section.
DEM_KEYS = {"rayleigh_fraction_max", "overlap_max"}
# Texts for people.
TEXTS = {"title", "source"}


@dataclass(frozen=True)
class Fixed:
    """One fixing of a set-up: date and time (UTC), the digest of its settings at that time, and the reason."""

    date: str
    digest: str
    why: str = FIRST


def settings_digest(
    settings: SetupConfig, mill: MillConfig | None, contacts: Mapping[str, ContactConfig], dem: DemConfig
) -> str:
    """A digest of every setting that makes the prediction of a set-up, except the places of the predictions."""
    content = {
        "settings": settings.model_dump(mode="json", exclude=set(settings.places), exclude_none=True),
        "mill": mill and mill.model_dump(mode="json", exclude={*TEXTS, "sweep"}, exclude_none=True),
        "contacts": {
            name: contact.model_dump(mode="json", exclude=TEXTS, exclude_defaults=True)
            for name, contact in contacts.items()
        },
        "dem": dem.model_dump(mode="json", include=DEM_KEYS) if settings.sweeps else {},
    }
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()[:16]


def read_fixed(path: str | Path) -> dict[str, list[Fixed]]:
    """Every time that each set-up was fixed, in order. Raises ConfigError as `read_measured`."""
    fixed: dict[str, list[Fixed]] = {}
    for row in read_measured(path, COLUMNS, fewest_rows=0).to_dict("records"):
        fixed.setdefault(row["setup"], []).append(Fixed(row["date"], row["digest"], row["why"]))
    return fixed


def status_of(name: str, digest: str, fixed: Mapping[str, Sequence[Fixed]]) -> str:
    """Whether the settings of a set-up are as fixed last, in words, with the dates and the last reason."""
    if name not in fixed:
        return "settings not fixed"
    first, last = fixed[name][0], fixed[name][-1]
    if digest != last.digest:
        return f"settings changed since they were fixed on {last.date}"
    again = len(fixed[name]) - 1
    if not again:
        return f"settings fixed on {first.date}"
    times = f"{again} times, the last time" if again > 1 else "once,"
    return f"settings fixed on {first.date}; fixed again {times} on {last.date}: {last.why}"


def fixed_table(fixed: Mapping[str, Sequence[Fixed]], digests: Mapping[str, str]) -> pd.DataFrame:
    """Every time that the set-ups of `digests` were fixed; `today`: whether the settings are still the same."""
    rows = [
        {"setup": name, **vars(each), "today": "yes" if each.digest == digest else "no"}
        for name, digest in digests.items()
        for each in fixed.get(name, ())
    ]
    return pd.DataFrame(rows, columns=[*(column.name for column in COLUMNS), "today"])


def fix(path: str | Path, digests: Mapping[str, str], now: str, why: str = "") -> list[str]:
    """Add the digests of some set-ups with date and time, and return the names of the changed ones.

    A set-up with an unchanged digest gets no row. why: the reason for fixing again. Raises ConfigError if a fixed
    set-up has changed and no reason is given.
    """
    fixed = read_fixed(path) if Path(path).exists() else {}
    changed = [name for name, digest in digests.items() if name not in fixed or fixed[name][-1].digest != digest]
    again = [name for name in changed if name in fixed]
    if again and not why:
        names = ", ".join(again)
        raise ConfigError(f"{path}: {names} had been fixed with other settings: say why they changed, by --why")
    for name in changed:
        fixed.setdefault(name, []).append(Fixed(now, digests[name], why if name in again else FIRST))
    rows = [{"setup": name, **vars(each)} for name, times in sorted(fixed.items()) for each in times]
    write_table(pd.DataFrame(rows, columns=[column.name for column in COLUMNS]), path)
    return changed
