"""Checks the input that needs geometry or physics, before the first job and in a process that imports the libraries.

The Snakefile starts this process when a run starts, or a dry run has its jobs, so that reading the Snakefile stays
fast. A check that has passed leaves a file with its warnings, named after the digest of its input, and is not repeated.
"""

import hashlib
import json
import logging
import subprocess
import sys
from collections.abc import Callable, Mapping, Sequence
from importlib.util import find_spec
from pathlib import Path

from snakemake_interface_logger_plugins.common import LogEvent

from millprint.config.contact_set import ContactConfig
from millprint.config.load import named_files
from millprint.config.mill import MillConfig
from millprint.config.workflow import WorkflowConfig
from millprint.run.digest import PACKAGE, program_digest

# In the working folder of Snakemake.
PASSED = Path(".snakemake/millprint/checked")
CHECK = "millprint.checks.before_running"


def check_once(
    config: WorkflowConfig,
    mills: Mapping[str, MillConfig],
    contacts: Mapping[str, ContactConfig],
    source: str,
    python: str,
    further: Sequence[str],
) -> None:
    """Check a configuration in a process of `python`, unless the same has passed before.

    source: the file that messages name if no other file is wrong; further: modules of further checks. If the check
    fails, its lines are printed and the program ends with status 1. Without numpy, as when only the jobs have conda
    environments, a line says that the jobs check their input.
    """
    if find_spec("numpy") is None:
        print("note: the jobs check the geometry, because Snakemake's environment has no numpy", file=sys.stderr)
        return
    content = json.dumps(
        {
            "config": config.model_dump(mode="json"),
            # Simulations do not record the tolerance, so the plain values of a mill do not contain it.
            "mills": {
                name: {**mill.model_dump(mode="json"), "volume_tolerance": mill.volume_tolerance}
                for name, mill in mills.items()
            },
            "contacts": {name: contact.model_dump(mode="json") for name, contact in contacts.items()},
            "source": source,
        },
        sort_keys=True,
    )
    shapes = [file for mill in mills.values() for file in mill.source_files]
    passed = PASSED / _digest(content, [*(path for _, path in named_files(config)), *shapes], [CHECK, *further])
    if passed.exists():
        print(passed.read_text(), end="", file=sys.stderr, flush=True)
        return
    print("checking geometry, balls, time steps and tables", file=sys.stderr, flush=True)
    done = subprocess.run([python, "-m", CHECK, *further], input=content, text=True, stderr=subprocess.PIPE)
    print(done.stderr, end="", file=sys.stderr, flush=True)
    if done.returncode:
        raise SystemExit(1)
    passed.parent.mkdir(parents=True, exist_ok=True)
    passed.write_text(done.stderr)


class DryRunCheck(logging.Filter):
    """Calls a check before the jobs of a dry run are told, since Snakemake's `onstart` is for runs only."""

    def __init__(self, is_dry_run: Callable[[], bool], check: Callable[[], None]) -> None:
        super().__init__()
        self.is_dry_run, self.check = is_dry_run, check

    def filter(self, record: logging.LogRecord) -> bool:
        """True: every record is printed."""
        if getattr(record, "event", None) == LogEvent.RUN_INFO and self.is_dry_run():
            self.check()
        return True


def _digest(content: str, files: list[str], modules: list[str]) -> str:
    """A digest of a configuration, of the files that it names, and of the library that checks it."""
    total = hashlib.sha256(content.encode())
    for name in modules:
        total.update(program_digest(PACKAGE.joinpath(*name.split(".")[1:]).with_suffix(".py")).encode())
    for file in sorted(set(files)):
        total.update(Path(file).read_bytes() if Path(file).is_file() else b"not there")
    return total.hexdigest()[:16]
