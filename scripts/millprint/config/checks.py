"""Everything that must hold before a job starts: names, tables, balls that fit, a time step that is stable."""

import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from millprint.config.contact import ContactConfig
from millprint.config.load import check_model, check_names_differ, load_named
from millprint.config.mill import MillConfig
from millprint.config.sweep import Case, expand_sweep
from millprint.config.workflow import WorkflowConfig
from millprint.errors import ConfigError

MILL_FOLDER = Path("config/mills")
CONTACT_FOLDER = Path("config/contacts")


@contextmanager
def stop_on_bad_input() -> Iterator[None]:
    """Print each fault of the configuration on a line of its own and end the program, with no traceback."""
    try:
        yield
    except ConfigError as error:
        for line in str(error).splitlines():
            print(f"error: {line}", file=sys.stderr)
        raise SystemExit(1) from None


def load_workflow(
    content: dict, files: Sequence[str]
) -> tuple[WorkflowConfig, dict[str, MillConfig], dict[str, ContactConfig], dict[str, Case]]:
    """Validate the configuration merged from `files` and every file that it names.

    Returns the configuration, the mills and contact sets by name, and the cases by path.
    Raises ConfigError, a line for each fault.
    """
    config = check_model(content, WorkflowConfig, files)
    mills = {name: load_named(MILL_FOLDER, name, MillConfig, "mill") for name in _mill_names(config)}
    contacts = {name: load_named(CONTACT_FOLDER, name, ContactConfig, "contact set") for name in _contact_names(config)}
    check_names_differ(MILL_FOLDER, list(mills), "mill")
    check_names_differ(CONTACT_FOLDER, list(contacts), "contact set")
    return config, mills, contacts, _collect_cases(config, files[-1])


def _mill_names(config: WorkflowConfig) -> list[str]:
    named = [name for sweep in config.sweeps for name in sweep.mills or []]
    tracked = [name for test in config.calibration.oscillation.experiments for name in (test.mill, test.track_mill)]
    return list(dict.fromkeys([config.mill, *named, *filter(None, tracked), *config.mills.named]))


def _contact_names(config: WorkflowConfig) -> list[str]:
    named = [name for sweep in config.sweeps for name in sweep.contacts]
    tracked = [test.contact for test in config.calibration.oscillation.experiments]
    return list(dict.fromkeys([*config.contacts, *named, *tracked, config.mills.contact]))


def _collect_cases(config: WorkflowConfig, source: str) -> dict[str, Case]:
    cases: dict[str, Case] = {}
    origin: dict[str, str] = {}
    for sweep in config.sweeps:
        for case in expand_sweep(sweep, config.dem, config.mill):
            if cases.setdefault(case.path, case) != case:
                raise ConfigError(
                    f"{source}: sweeps.{sweep.name}: case {case.path} is also in sweep {origin[case.path]} with other "
                    "durations, step, bounds or snapshots; a case can be simulated in one way only"
                )
            origin.setdefault(case.path, sweep.name)
    return cases
