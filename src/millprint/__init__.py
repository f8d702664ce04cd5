"""millprint: the mechanical fingerprint of a ball mill, from its geometry and motion to chemistry."""

import gc
import os
from importlib import import_module
from typing import Any

from millprint.run.extras import explain_extras

# Set in the environment of the jobs of a run (millprint.run.machine).
JOB_VARIABLE = "MILLPRINT_JOB"

if JOB_VARIABLE in os.environ:
    # The garbage collector would examine imported modules again and again, which takes up to a quarter of the import
    # time, although they live as long as the job. It is off during imports; millprint.run.job turns it on.
    gc.disable()

explain_extras()

# What `import millprint` offers to a script or a notebook, by module. A name is imported when it is used: a job of the
# workflow needs few modules, and should not wait for the others.
OFFERED = {
    "ConfigError": "config.errors",
    "SimulationError": "config.errors",
    "load_mill": "config.included",
    "load_contact": "config.included",
    "included_mills": "config.included",
    "included_contacts": "config.included",
    "MillConfig": "config.mill",
    "ContactConfig": "config.contact_set",
    "take_fingerprint": "api",
    "simulate": "api",
    "read_fingerprint": "api",
    "predict": "api",
    "plot": "api",
    "Fingerprint": "fingerprint.model",
    "Prediction": "fingerprint.model",
    "Condition": "observables.condition",
    "compare": "fingerprint.match_words",
    "match": "fingerprint.match_words",
}
__all__ = [*OFFERED]


def __getattr__(name: str) -> Any:
    if name == "__version__":
        # Reading the versions of packages takes a while.
        return import_module("importlib.metadata").version("millprint")
    if name not in OFFERED:
        raise AttributeError(f"module 'millprint' has no attribute {name!r}")
    return getattr(import_module(f"millprint.{OFFERED[name]}"), name)


def __dir__() -> list[str]:
    return sorted([*globals(), *OFFERED])
