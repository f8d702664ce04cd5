"""What decides the numbers of a stored picture or notebook, so that a test finds out one that is of former settings."""

import hashlib
import json

from millprint.cases.table import CaseTable, Why
from millprint.config.checks import load_workflow
from millprint.config.identity import shared_identity
from millprint.config.included import SOURCES, read_run
from millprint.config.load import YAML


def digest_of(content: bytes) -> str:
    """A short digest."""
    return hashlib.sha256(content).hexdigest()[:16]


def settings_of(given: str) -> str:
    """A digest of all simulations of a fingerprint and of how it is read off them.

    given: the name of an included mill, or the file of a run.
    """
    content = read_run(given) if given.endswith(YAML) else {"mill": given}
    config, mills, contacts, _ = load_workflow(content, [given], SOURCES)
    cases = CaseTable(config, mills, contacts).cases(Why.MILL, config.mill)
    what = {
        "cases": {path: case.model_dump(mode="json") for path, case in cases.items()},
        "shared": shared_identity(mills[config.mill], contacts[config.mills.contact_set], config.dem),
        "read": [config.mills.rule, config.fingerprint.interval, config.fingerprint.smooth_points],
    }
    return digest_of(json.dumps(what, sort_keys=True).encode())
