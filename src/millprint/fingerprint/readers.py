"""Readers of the fingerprint stage: summaries and collisions of simulations, and finished fingerprints.

Each reader refuses, in one line, a file that lacks what is needed.
"""

import hashlib
import json
from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import reduce
from operator import getitem
from pathlib import Path

import numpy as np
import pandas as pd

from millprint.config.charge import BallMixture
from millprint.config.contact_set import ContactConfig
from millprint.config.counting import CountingRule
from millprint.config.errors import ConfigError
from millprint.config.identity import WORDS
from millprint.config.included import load_contact, load_mill, read_run, shipped
from millprint.config.load import MILL_FOLDER, WORKING_FOLDER, YAML, Sources
from millprint.config.mill import MillConfig
from millprint.config.wording import close_to
from millprint.dem.collisions import (
    CONTACTS_BY,
    COUNTING,
    VALUE_NAMES,
    by_surface,
    collision_statistics,
    energies_of,
    kept_by,
    merge_contacts,
    read_rows,
    sort_by_pair,
)
from millprint.observables.counted_collisions import CHANNELS, Collisions
from millprint.observables.definitions import MEASURED
from millprint.run.files import read_format, read_json, read_table
from millprint.run.hdf5 import open_hdf5

# Coefficients of walls, stored where they differ from those of ball on ball.
WALL = {"wall_restitution": "restitution", "wall_static_friction": "static_friction"}
# The format of a fingerprint file, and the usual name of such files.
FORMAT = "millprint fingerprint 2"
WHERE = "one is written as fingerprint_CONTACT.json"
# Numbers that a summary must have: group.key, or a key without a group.
ERRORS = ("power_standard_error_W.normal", "power_standard_error_W.tangential")
SUMMARY_NUMBERS = (
    *(column.key for column in MEASURED if column.key and not column.key.startswith("rule.")),
    *("density_kg_m3", "amplitude_m", "case.ball_diameter_m", "case.fill_ratio", "case.speed_hz", "case.seed"),
    *ERRORS,
)
# A run without a finished contact has no median duration, a window of less than two revolutions no standard error.
OPTIONAL_NUMBERS = {*(column.key for column in MEASURED if column.optional), *ERRORS}


def check_summary(summary: dict, source: str) -> dict:
    """Return `summary` unchanged; raises ConfigError that names the file, the key and the value."""
    for key in [*(key.split(".")[0] for key in SUMMARY_NUMBERS), "mill", "contact", "collisions", "per_revolution"]:
        if key not in summary:
            raise ConfigError(f"{source}: {key}: this key is missing; rerun the simulation that wrote the summary")
    for key in SUMMARY_NUMBERS:
        *groups, name = key.split(".")
        value = reduce(getitem, groups, summary).get(name)
        if value is None and key in OPTIONAL_NUMBERS:
            continue
        if isinstance(value, bool) or not isinstance(value, int | float) or not np.isfinite(value):
            raise ConfigError(f"{source}: {key} = {value!r}: must be a finite number")
    if summary["frequency_hz"] <= 0:
        raise ConfigError(f"{source}: frequency_hz = {summary['frequency_hz']}: a mill at rest has no descriptors")
    return summary


def with_counts(summary: dict, run_path: str | Path, rules: Iterable[CountingRule]) -> dict:
    """A summary whose collisions are counted by these rules: from its run.h5 where the run did not count by them.

    Raises ConfigError for a run that has no table of its collisions.
    """
    recorded = [(CountingRule.of_count(count), count) for count in summary["collisions"]]
    rules = list(rules)
    further = [rule for rule in rules if not any(own == rule for own, _ in recorded)]
    if further:
        with open_hdf5(run_path) as file:
            group = file["collisions"]
            rows = read_rows(group)
            begin_s, window_s = float(group.attrs["begin_s"]), float(group.attrs["window_s"])
        if rows is None:
            raise ConfigError(
                f"{run_path}: has no table of its many collisions, for {further[0].name} to count; delete it, and it "
                "is simulated again"
            )
        balls, frequency_hz = summary["balls"], summary["frequency_hz"]
        counts = collision_statistics(rows, further, begin_s, window_s, balls, frequency_hz)
        recorded += zip(further, counts, strict=True)
    return summary | {"collisions": [next(count for own, count in recorded if own == rule) for rule in rules]}


def read_counted(path: str | Path, rules: Iterable[dict]) -> dict:
    """A summary with its collisions by counting rules, which are plain values of the configuration."""
    run_path = Path(path).with_name("run.h5")
    return with_counts(read_json(path), run_path, [CountingRule(**rule) for rule in rules])


def read_summaries(paths: Iterable[str | Path], rules: Iterable[dict] | None = None) -> list[dict]:
    """Read and check every summary; raises ConfigError for a file that is absent, is not JSON or lacks a key.

    rules: by which collisions are counted, as for `read_counted`; those of the run if left out. run_path: the run.h5
    next to it.
    """
    found = []
    for path in paths:
        try:
            summary = read_json(path) if rules is None else read_counted(path, rules)
        except FileNotFoundError:
            raise ConfigError(f"{path}: no such summary") from None
        except json.JSONDecodeError as error:
            raise ConfigError(f"{path}: not valid JSON ({error})") from None
        found.append(check_summary(summary, str(path)) | {"run_path": str(Path(path).with_name("run.h5"))})
    if not found:
        raise ConfigError("fingerprint: no simulation to describe; sweeps must hold a case without snapshots")
    return found


def charges_of(summaries: Iterable[dict]) -> dict[str, BallMixture]:
    """The charges of several ball sizes that were simulated, by their names."""
    mixtures = [summary["case"].get("mixture") for summary in summaries]
    return {mixture["name"]: BallMixture(**mixture) for mixture in mixtures if mixture}


def read_content(path: str | Path) -> dict:
    """The content of a fingerprint file. Raises ConfigError, in one line, for a missing or an invalid file."""
    return read_format(path, [FORMAT], "fingerprint", WHERE)


FOLDER = "config/fingerprints"
# A row for each: mill, contact, digest (of `digest_of`), sha256 of its file, and what it was made with.
TABLE = f"{FOLDER}/made.tsv"


def digest_of(mill: MillConfig, contact: ContactConfig) -> str:
    """A short digest of what a mill and its contact set are, without their words and the mill's sweep."""
    # A key that came later changes no digest where it is left out.
    later = set() if contact.cohesion else {"cohesion"}
    parts = [mill.model_dump(mode="json", exclude=WORDS), contact.model_dump(mode="json", exclude=WORDS | later)]
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


def find_fingerprint(mill: str, results: str | Path = "results", sources: Sources = WORKING_FOLDER) -> Path:
    """The fingerprint of a mill, given by its file or its name: of a run, or the one that comes with millprint.

    mill: fingerprint.json, a name, or the YAML file of a run, which says where its results are, or of a mill. Of a mill
    that was run, the one with all intervals first. A run that `millprint new` has written has a folder of its own in
    `results`.

    Raises ConfigError, in one line, for an unknown mill, and for a mill that was not run, with the command to run it.
    """
    if mill.endswith(".json"):
        return Path(mill)
    given = mill
    if Path(mill).suffix in YAML:
        run = read_run(mill)
        mill, results = str(run.get("mill", run.get("name"))), str(run.get("results", results))
    homes = [Path(results), Path(results) / mill]
    places = [home / folder / mill / "fingerprint.json" for home in homes for folder in ("uncertainty", "mills")]
    places += sorted((Path(results) / "fingerprint").glob("fingerprint_*.json"))
    for path in places:
        if path.is_file() and (path.parent.name == mill or read_content(path)["about"]["mill"] == mill):
            return path
    if (included := find_ready_made(mill)) is not None:
        return included
    if not Path(sources.find(f"{MILL_FOLDER}/{mill}.yaml")).is_file():
        raise ConfigError(f"{mill}: unknown mill{close_to(mill, sources.names(MILL_FOLDER))}")
    raise ConfigError(
        f"{given}: this mill was not run: {places[1]} is missing; `millprint fingerprint {given}` writes it"
    )


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


def read_contacts(path: str | Path, everything: bool = False) -> Contacts | None:
    """The contacts of a run.h5; None if it has no table of them. Raises ConfigError for a damaged file.

    everything: with all values of a contact that were recorded, not only those for counting.
    """
    with open_hdf5(path) as file:
        group = file["collisions"]
        rows = read_rows(group, [name for name in VALUE_NAMES if name in group] if everything else COUNTING)
        if rows is None:
            return None
        begin_s, window_s = float(group.attrs["begin_s"]), float(group.attrs["window_s"])
        spring = file["ledger/elastic_tangential_J"]
        stored = float(spring[-1] - spring[0])
    contacts = by_surface(rows)
    is_open = (contacts["complete"].to_numpy() == 0) | (contacts["start_s"].to_numpy() < begin_s)
    open_J = {channel: float(energy[is_open].sum()) for channel, energy in energies_of(contacts).items()}
    return Contacts(rows, begin_s, window_s, open_J, stored)


def collisions_by(contacts: Contacts, rule: CountingRule, frequency_hz: float) -> Collisions:
    """The collisions of a run by a counting rule, the same that `dem.collisions.count_collisions` counts."""
    merged = contacts.merged(rule, frequency_hz)
    kept = kept_by(rule, merged)
    dropped = {name: float(merged[f"{name}_J"].to_numpy()[~kept].sum()) / contacts.window_s for name in CHANNELS}
    return Collisions(merged[kept], contacts.begin_s, contacts.window_s, dropped)
