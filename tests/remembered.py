"""The slow parts of the check before a run, remembered: most changes of a configuration do not touch its mills."""

from collections.abc import Callable
from functools import partial
from pathlib import Path

from millprint.calibration.oscillation import make_swing
from millprint.config.contact import ContactConfig
from millprint.config.mill import MillConfig
from millprint.dem.preflight import checked_bodies
from millprint.errors import ConfigError


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


def key_of(mill: MillConfig) -> tuple:
    """All that the bodies of a mill follow from. The JSON of a mill contains neither the tolerance nor its files."""
    files = [Path(file) for file in mill.source_files]
    contents = (file.read_bytes() if file.is_file() else None for file in files)
    return mill.model_dump_json(), mill.volume_tolerance, *contents


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
