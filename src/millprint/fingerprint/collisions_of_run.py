"""The collisions of a finished run, read from its run.h5: for spectra, and for statistics that its summary lacks."""

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pandas as pd

from millprint.config.counting import CountingRule
from millprint.dem.collisions import (
    CHANNELS,
    CONTACTS_BY,
    SLIDING,
    by_surface,
    energies_of,
    kept_by,
    merge_contacts,
    read_rows,
    sort_by_pair,
)
from millprint.run.hdf5 import open_hdf5

PAIRS = ("ball_ball", "ball_wall")
BOTH = "both"


@dataclass(frozen=True)
class Contacts:
    """The contacts of a run, and their energies in the ledger.

    rows: as of `dem.collisions.collision_table`, only the needed columns; open_J: energy of each of CHANNELS in
    contacts that were open at an end of the window [J]; stored_J: energy that tangential springs stored in it [J].
    """

    rows: pd.DataFrame
    begin_s: float
    window_s: float
    open_J: dict[str, float]
    stored_J: float
    _ordered: dict[str, pd.DataFrame] = field(default_factory=dict)

    def ordered(self, by: str) -> pd.DataFrame:
        """The contacts by a key of CONTACTS_BY, as of `sort_by_pair`; made once."""
        if by not in self._ordered:
            self._ordered[by] = sort_by_pair(CONTACTS_BY[by](self.rows))
        return self._ordered[by]

    def merged(self, rule: CountingRule, frequency_hz: float) -> pd.DataFrame:
        """The collisions by the pairs and the gap of a rule, without its thresholds, as of `merge_contacts`.

        frequency_hz: turns of the mill.
        """
        return merge_contacts(self.ordered(rule.by), rule.gap_s(frequency_hz))


def read_contacts(path: str | Path) -> Contacts | None:
    """The contacts of a run.h5; None if it only holds their histograms. Raises ConfigError for a damaged file."""
    with open_hdf5(path) as file:
        group = file["collisions"]
        rows = read_rows(group, ("start_s", "duration_s", "peak_force_N", "normal_J", "damping_J", SLIDING))
        if rows is None:
            return None
        begin_s, window_s = float(group.attrs["begin_s"]), float(group.attrs["window_s"])
        spring = file["ledger/elastic_tangential_J"]
        stored = float(spring[-1] - spring[0])
    contacts = by_surface(rows)
    is_open = (contacts["complete"].to_numpy() == 0) | (contacts["start_s"].to_numpy() < begin_s)
    open_J = {channel: float(energy[is_open].sum()) for channel, energy in energies_of(contacts).items()}
    return Contacts(rows, begin_s, window_s, open_J, stored)


@dataclass(frozen=True)
class Collisions:
    """The collisions of a run that a rule keeps.

    energy: of each of CHANNELS, within the window [J], (collisions,); rate: 1 / window for a collision that begins in
    it, else 0 [1/s]; between_balls: (collisions,); dropped_W: power of each channel below a threshold of the rule.
    """

    energy: dict[str, np.ndarray]
    rate: np.ndarray
    between_balls: np.ndarray
    window_s: float
    dropped_W: dict[str, float]

    def chosen(self, pair: str) -> np.ndarray:
        """Which collisions belong to this pair: one of PAIRS, or BOTH."""
        return np.ones_like(self.between_balls) if pair == BOTH else self.between_balls == (pair == PAIRS[0])


def collisions_by(contacts: Contacts, rule: CountingRule, frequency_hz: float) -> Collisions:
    """The collisions of a run by a counting rule, the same that `dem.collisions.count_collisions` counts."""
    merged = contacts.merged(rule, frequency_hz)
    kept = kept_by(rule, merged)
    energy = {channel: merged[f"{channel}_J"].to_numpy() for channel in CHANNELS}
    return Collisions(
        energy={channel: values[kept] for channel, values in energy.items()},
        rate=(merged["start_s"].to_numpy()[kept] >= contacts.begin_s) / contacts.window_s,
        between_balls=merged["second"].to_numpy()[kept] >= 0,
        window_s=contacts.window_s,
        dropped_W={channel: float(values[~kept].sum()) / contacts.window_s for channel, values in energy.items()},
    )
