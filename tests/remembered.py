"""The slow parts of the check before a run, remembered: most changes of a configuration do not touch its mills."""

import pickle
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

import pandas as pd

from millprint.config.contact_set import ContactConfig
from millprint.config.errors import ConfigError
from millprint.config.mill import MillConfig
from millprint.config.strict_yaml import read_yaml
from millprint.dem.case_checks import checked_bodies
from millprint.mill.bodies import Body, inserts_in_vessel
from millprint.mill.speed_limits import Pace, paces
from millprint.mill.vessel import Vessel
from millprint.run.files import read_table
from millprint.thesis.calibration.oscillation import make_swing


def remembered(compute: Callable, known: dict, key: tuple):
    """What `compute` returns or refuses, computed once for each `key`."""
    if key not in known:
        try:
            known[key] = compute()
        except ConfigError as error:
            known[key] = error
    if isinstance(known[key], ConfigError):
        raise known[key]
    return known[key]


_SEEN: dict = {}


def _content(path: str | Path) -> bytes | None:
    return Path(path).read_bytes() if Path(path).is_file() else None


def key_of(mill: MillConfig) -> tuple:
    """All that the bodies of a mill follow from. The JSON of a mill contains neither the tolerance nor its files."""
    return mill.model_dump_json(), mill.volume_tolerance, *map(_content, mill.source_files)


def remembered_bodies(mills: dict[str, MillConfig]) -> dict:
    """As checked_bodies; of several mills with faults, each gives its lines."""
    bodies, faults = {}, []
    for name, mill in mills.items():
        try:
            found = remembered(partial(checked_bodies, {name: mill}), _SEEN, ("bodies", name, *key_of(mill)))
            bodies |= found
        except ConfigError as error:
            faults.append(str(error))
    if faults:
        raise ConfigError("\n".join(faults))
    return bodies


def remembered_swing(mill: MillConfig, contact: ContactConfig, fraction: float, diameter: float, settings):
    """As make_swing."""
    key = ("swing", *key_of(mill), contact.model_dump_json(), fraction, diameter, settings.model_dump_json())
    return remembered(partial(make_swing, mill, contact, fraction, diameter, settings), _SEEN, key)


def remembered_paces(mill: MillConfig, bodies: Sequence[Body]) -> list[Pace]:
    """As paces."""
    return remembered(partial(paces, mill, bodies), _SEEN, ("paces", *key_of(mill)))


def remembered_inserts(bodies: Sequence[Body]) -> list[Vessel]:
    """As inserts_in_vessel; the bodies are kept, so that no others take their place in memory."""
    placed, _ = remembered(lambda: (inserts_in_vessel(bodies), bodies), _SEEN, ("inserts", *map(id, bodies)))
    return placed


def remembered_table(path: str | Path, **columns: Sequence[str]) -> pd.DataFrame:
    """As read_table."""
    key = ("table", str(path), _content(path), repr(columns))
    return remembered(partial(read_table, path, **columns), _SEEN, key).copy()


def remembered_yaml(path: str | Path) -> object:
    """As read_yaml."""
    key = ("yaml", str(path), _content(path))
    return pickle.loads(remembered(lambda: pickle.dumps(read_yaml(path)), _SEEN, key))


# What each of them replaces, by its place in the library.
SLOW_PARTS = {
    "millprint.thesis.chapter_checks.make_swing": remembered_swing,
    "millprint.config.load.read_yaml": remembered_yaml,
    "millprint.dem.case_checks.inserts_in_vessel": remembered_inserts,
    "millprint.checks.before_running.checked_bodies": remembered_bodies,
    "millprint.fingerprint.speeds.paces": remembered_paces,
    "millprint.run.tables.read_table": remembered_table,
}
