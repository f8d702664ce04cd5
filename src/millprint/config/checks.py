"""Loads the configuration and checks names and cases before a job starts."""

import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from millprint.config.arguments import NAMES, values_of
from millprint.config.calibration import ExperimentConfig
from millprint.config.card import Experiment, read_experiments
from millprint.config.charge import chosen_balls
from millprint.config.contact_set import ContactConfig
from millprint.config.errors import ConfigError
from millprint.config.load import (
    CONTACT_FOLDER,
    MILL_FOLDER,
    WORKING_FOLDER,
    Sources,
    check_model,
    check_names_differ,
    check_paths,
    load_named,
    read_yaml,
)
from millprint.config.mill import MillConfig
from millprint.config.mill_sweep import with_fill_ratios
from millprint.config.rows import read_rows
from millprint.config.setup_models import SETTINGS
from millprint.config.sweep import Case, expand_sweep
from millprint.config.wording import close_to
from millprint.config.workflow import ChapterSections, WorkflowConfig

CONFIG_FILE = "config/config.yaml"
# The name in messages about a configuration that has no file, such as a module's.
CONFIGURATION = "configuration"


@contextmanager
def stop_on_bad_input() -> Iterator[None]:
    """Print a line for each fault of the input and end the program, without a traceback."""
    try:
        yield
    except ConfigError as error:
        for line in str(error).splitlines():
            print(f"error: {line}", file=sys.stderr)
        raise SystemExit(1) from None


def load_workflow(
    content: dict, files: Sequence[str], sources: Sources = WORKING_FOLDER
) -> tuple[WorkflowConfig, dict[str, MillConfig], dict[str, ContactConfig], dict[str, Case]]:
    """Validate the configuration merged from `files` and every file that it names, which `sources` finds.

    Returns the configuration, the mills and contact sets by name, and the cases by path. The run's mill has the `sweep`
    of the configuration, where that gives one.
    Raises ConfigError, a line for each fault.
    """
    source = files[-1] if files else CONFIGURATION
    config = check_model(content, WorkflowConfig, files)
    check_paths(config, source)
    config = with_measured_setups(sources.resolve(config))
    mills = {name: load_named(MILL_FOLDER, name, MillConfig, "mill", sources) for name in _mill_names(config)}
    if config.sweep:
        mills[config.mill] = mills[config.mill].model_copy(update={"sweep": config.sweep})
    contacts = {
        name: load_named(CONTACT_FOLDER, name, ContactConfig, "contact set", sources) for name in _contact_names(config)
    }
    density = contacts[config.mills.contact_set].density_kg_m3
    for name, mill in mills.items():
        own = source if config.sweep and name == config.mill else f"{MILL_FOLDER}/{name}.yaml"
        mills[name] = with_own_fills(mill, density, f"{own}: sweep", sources)
    check_chosen_charges(config, mills, source)
    check_heated_mills(config, sources, source)
    check_names_differ(MILL_FOLDER, list(mills), "mill")
    check_names_differ(CONTACT_FOLDER, list(contacts), "contact set")
    return config, mills, contacts, collect_cases(config, source)


def with_measured_setups(config: WorkflowConfig) -> WorkflowConfig:
    """The configuration with the set-ups of a user's own measurements, where it names none."""
    validation = config.validation
    if validation.setups or not validation.is_own:
        return config
    named = {row.get("setup") for row in read_rows(validation.measured)}
    update = {"setups": [name for name in SETTINGS if name in named]}
    return config.model_copy(update={"validation": validation.model_copy(update=update)})


def with_own_fills(mill: MillConfig, density_kg_m3: float, place: str, sources: Sources = WORKING_FOLDER) -> MillConfig:
    """A mill whose sweep, if it has one, has fill ratios only. Raises ConfigError as `with_fill_ratios`."""
    if mill.sweep is None:
        return mill
    sweep = with_fill_ratios(sources.resolve(mill.sweep), mill.volume_ml, density_kg_m3, place)
    return mill.model_copy(update={"sweep": sweep})


def base_of(given: Mapping[str, Any], sources: Sources = WORKING_FOLDER) -> str | None:
    """The configuration that a run begins from, and that its settings `given` by --configfile and --config change.

    That is config/config.yaml of the working folder or, without one, the workflow's: the thesis. Who names a mill does
    not ask for the thesis, and begins from the defaults, or from a config/config.yaml without chapters.
    Returns None for the defaults. Raises ConfigError for a base that cannot be read.
    """
    base = sources.find(CONFIG_FILE)
    if not Path(base).is_file():
        return None
    content = read_yaml(base) if "mill" in given else None
    return None if isinstance(content, dict) and set(ChapterSections.model_fields) & set(content) else base


def check_chosen_charges(config: WorkflowConfig, mills: dict[str, MillConfig], source: str) -> None:
    """Refuse a charge that the sections of `mills` name and the sweep of its mill does not have."""
    for key, name, choices in config.mills.named_balls:
        sweep = mills[name].sweep
        for choice in choices:
            chosen_balls(choice, sweep.balls if sweep else [], f"{source}: {key}")


def check_heated_mills(config: WorkflowConfig, sources: Sources, source: str) -> None:
    """Refuse a mill of `dose.heat.jars` that has no file: its numbers would be used nowhere."""
    for name in config.dose.heat.jars:
        if not Path(sources.find(f"{MILL_FOLDER}/{name}.yaml")).is_file():
            known = sources.names(MILL_FOLDER)
            raise ConfigError(f"{source}: dose.heat.jars.{name}: unknown mill{close_to(name, known)}")


def _mill_names(config: WorkflowConfig) -> list[str]:
    named = [name for sweep in config.sweeps for name in sweep.mills or []]
    tracked = [name for test in _experiments(config) for name in (test.mill, test.track_mill)]
    read = [*config.uncertainty.mills, *config.dose.heat.mills]
    carded = [*(each.mill for each in card_experiments(config)), *config.cards.match]
    further = [*config.mills.named, *config.validation.mills, *read, *carded]
    return list(dict.fromkeys([config.mill, *named, *filter(None, tracked), *further]))


def _contact_names(config: WorkflowConfig) -> list[str]:
    named = [name for sweep in config.sweeps for name in sweep.contacts]
    tracked = [test.contact for test in _experiments(config)]
    carded = [each.contact for each in card_experiments(config) if each.contact]
    own = [config.mills.contact_set, *config.validation.contacts, *carded]
    return list(dict.fromkeys([*config.contacts, *named, *tracked, *own]))


def card_experiments(config: WorkflowConfig) -> list[Experiment]:
    """The experiments of the run's milling cards. Raises ConfigError as `read_experiments`."""
    return read_experiments(config.cards.experiments) if config.cards.experiments else []


def _experiments(config: WorkflowConfig) -> list[ExperimentConfig]:
    return config.calibration.oscillation.experiments if config.calibration else []


def collect_cases(config: WorkflowConfig, source: str) -> dict[str, Case]:
    """The cases of every sweep by their path; raises ConfigError for one that two sweeps want in different ways."""
    cases: dict[str, Case] = {}
    origin: dict[str, str] = {}
    for sweep in config.sweeps:
        for case in expand_sweep(sweep, config.dem, config.mill):
            if cases.setdefault(case.path, case) != case:
                raise ConfigError(
                    f"{source}: sweeps.{sweep.name}: case {case.path} is also in sweep {origin[case.path]} with other "
                    "balls, durations, step, bounds or snapshots; a case can be simulated in one way only"
                )
            origin.setdefault(case.path, sweep.name)
    return cases


def check_given_once(words: Sequence[str]) -> None:
    """Raise ConfigError where a command line gives --configfile or --config twice: Snakemake reads the last only."""
    for option in NAMES:
        groups = values_of(words, option)
        lost = [word for group in groups[:-1] for word in group]
        if lost:
            raise ConfigError(
                f"{option} is given {len(groups)} times, and Snakemake takes only the last, {' '.join(groups[-1])}: "
                f"{' '.join(lost)} would be left out; write {option} {' '.join([*lost, *groups[-1]])}"
            )
