"""Mills and contact sets of the repository, for the physics tests."""

from pathlib import Path

import pytest

from millprint.config.contact_set import ContactConfig
from millprint.config.load import load_named
from millprint.config.mill import MillConfig

CONFIG = Path(__file__).parents[2] / "config"


@pytest.fixture(scope="session")
def mills() -> dict[str, MillConfig]:
    names = [path.stem for path in (CONFIG / "mills").glob("*.yaml")]
    return {name: load_named(CONFIG / "mills", name, MillConfig, "mill") for name in names}


@pytest.fixture(scope="session")
def contacts() -> dict[str, ContactConfig]:
    names = [path.stem for path in (CONFIG / "contacts").glob("*.yaml")]
    return {name: load_named(CONFIG / "contacts", name, ContactConfig, "contact set") for name in names}
