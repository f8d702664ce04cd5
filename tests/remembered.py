"""The slow parts of the check before a run, remembered: most changes of a configuration do not touch its mills."""

import pickle
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

from millprint.config.contact_set import ContactConfig
from millprint.config.errors import ConfigError, SimulationError
from millprint.config.load import read_yaml
from millprint.config.mill import MillConfig
from millprint.dem.case_checks import checked_bodies
from millprint.dem.packing import capacity, pack_mixture
from millprint.mill.bodies import Body, inserts_in_vessel
from millprint.mill.speed_limits import Pace, paces
from millprint.mill.vessel import Vessel
from millprint.thesis import chapter_checks
from millprint.thesis.drop import make_swing


def remembered(compute: Callable, known: dict, key: tuple):
    """What `compute` returns or refuses, computed once for each `key`."""
    if key not in known:
        try:
            known[key] = compute()
        except (ConfigError, SimulationError) as error:
            known[key] = error
    if isinstance(known[key], ConfigError | SimulationError):
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


def remembered_capacity(vessel: Vessel, diameter_m: float, inserts: Sequence[Vessel], enough: int) -> int:
    """As capacity; the vessel is kept, as above."""
    key = ("capacity", id(vessel), diameter_m, *map(id, inserts), enough)
    most, _ = remembered(lambda: (capacity(vessel, diameter_m, inserts=inserts, enough=enough), vessel), _SEEN, key)
    return most


def remembered_mixture(vessel: Vessel, diameters_m, counts, seed: int, inserts: Sequence[Vessel]) -> None:
    """As pack_mixture, of which the check uses only that it raises nothing."""
    key = ("mixture", id(vessel), tuple(diameters_m), tuple(counts), seed, *map(id, inserts))
    remembered(lambda: (pack_mixture(vessel, diameters_m, counts, seed, inserts), vessel), _SEEN, key)


_check_tables = chapter_checks.check_tables


def remembered_check_tables(config, source: str) -> None:
    """As check_tables."""
    tables = (file.read_bytes() for file in sorted(Path("config/data").iterdir()) if file.is_file())
    remembered(partial(_check_tables, config, source), _SEEN, ("tables", source, config.model_dump_json(), *tables))


def remembered_yaml(path: str | Path) -> object:
    """As read_yaml."""
    key = ("yaml", str(path), _content(path))
    return pickle.loads(remembered(lambda: pickle.dumps(read_yaml(path)), _SEEN, key))


# What each of them replaces, by its place in the library.
SLOW_PARTS = {
    "millprint.thesis.chapter_checks.make_swing": remembered_swing,
    "millprint.config.load.read_yaml": remembered_yaml,
    "millprint.thesis.chapter_checks.check_tables": remembered_check_tables,
    "millprint.dem.case_checks.inserts_in_vessel": remembered_inserts,
    "millprint.dem.case_checks.capacity": remembered_capacity,
    "millprint.dem.case_checks.pack_mixture": remembered_mixture,
    "millprint.checks.before_running.checked_bodies": remembered_bodies,
    "millprint.fingerprint.sweep_checks.paces": remembered_paces,
}
