"""The mills and contact sets that come with the library: the folder `config` of a checkout, or its copy in a wheel."""

from pathlib import Path
from typing import Any

from millprint.config.contact_set import ContactConfig
from millprint.config.errors import ConfigError
from millprint.config.load import (
    CONTACT_FOLDER,
    MILL_FOLDER,
    YAML,
    Named,
    Sources,
    check_model,
    load_named,
    read_yaml,
    shipped,
)
from millprint.config.mill import MillConfig
from millprint.config.wording import close_to

# A file of the working folder takes the place of an included one of the same name.
SOURCES = Sources(shipped)


def load_mill(mill: str | Path) -> MillConfig:
    """A mill by its name, such as "planetary", or by its own YAML file.

    A name is searched in config/mills of the working folder, then among the included mills (`included_mills`).
    Raises ConfigError with a line for each fault: an unknown name, a missing file, an invalid key.
    """
    return _load(mill, MILL_FOLDER, MillConfig, "mill")


def load_contact(contact: str | Path) -> ContactConfig:
    """A contact set (restitution, frictions, density, elasticity) by its name or YAML file, as `load_mill`."""
    return _load(contact, CONTACT_FOLDER, ContactConfig, "contact set")


def read_run(path: str | Path) -> dict[str, Any]:
    """The YAML file of a run, with the key `mill`, or of a mill, with the key `geometry`.

    Raises ConfigError, in one line, for a file that is not there or is neither.
    """
    if not Path(path).is_file():
        here = [own.name for own in Path(path).parent.glob("*.[yY]*ml")]
        hint = close_to(Path(path).name, here) if here else ""
        raise ConfigError(f"{path}: no such file{hint}; `millprint new` writes one")
    content = read_yaml(path)
    names = content if isinstance(content, dict) else {}
    if not ("mill" in names or "geometry" in names):
        meant = next((f"; {name}: did you mean mill?" for name in names if str(name).lower() in ("mills", "mil")), "")
        raise ConfigError(
            f"{path}: has neither `mill` (a run) nor `geometry` (a mill); `millprint new` writes both{meant}"
        )
    return names


def included_mills() -> list[str]:
    """Names of the mills that `load_mill` knows."""
    return SOURCES.names(MILL_FOLDER)


def included_contacts() -> list[str]:
    """Names of the contact sets that `load_contact` knows."""
    return SOURCES.names(CONTACT_FOLDER)


def _load(given: str | Path, folder: str, model: type[Named], what: str) -> Named:
    if Path(given).suffix not in YAML:
        return load_named(folder, str(given), model, what, SOURCES)
    if not Path(given).is_file():
        raise ConfigError(f"{given}: no such file of a {what}")
    return check_model(read_yaml(given), model, str(given))
