"""What the rules share: the validated configuration, the results folder, and digests of the library."""

from millprint.config.checks import CONFIGURATION
from millprint.config.sweep import expand_sweep
from millprint.digest import library_digest
from millprint.fingerprint.cases import has_chapters

# In the order in which they lie over each other: those of --configfile are on top, and Snakemake names them first as well.
CONFIG_FILES = [str(file) for file in (*workflow.configfiles, *workflow.overwrite_configfiles)]

with stop_on_bad_input():
    # Snakemake's own reader takes the last of two equal keys, and any number of aliases.
    for file in CONFIG_FILES:
        read_yaml(file)
    CONFIG, MILLS, CONTACTS, CASES = load_workflow(config, CONFIG_FILES, Sources(shipped))
    CHAPTERS = has_chapters(CONFIG, CASES)

# What is checked as a run starts: the mills as they are in files, and the file that a refusal names.
CHECKED_MILLS = dict(MILLS)
SOURCE = CONFIG_FILES[-1] if CONFIG_FILES else CONFIGURATION

# Captions of the report, and the record of the run, have the configuration with all of its defaults.
config = CONFIG.model_dump(mode="json")

RESULTS = CONFIG.results.rstrip("/")
LOGS = f"{RESULTS}/logs"
BENCHMARKS = f"{RESULTS}/benchmarks"


def settings(section: str) -> dict:
    """A section of the validated configuration as plain values, for `params`."""
    return getattr(CONFIG, section).model_dump(mode="json")


def library(script: str) -> str:
    """The digest of the library files that a script imports, for `params`: an edit of one of them reruns the rule.

    Snakemake's own trigger, the code of a rule, sees the script alone.
    """
    return library_digest(shipped(f"scripts/{script}"))


def summaries_over(key: str) -> list[str]:
    """Summaries of every case of the sweeps that give this list of values; none where no sweep does."""
    return summaries_of([block for block in CONFIG.sweeps if getattr(block, key)])


def summaries_of(sweeps) -> list[str]:
    """Summaries of every case of some sweeps."""
    cases = [case for sweep in sweeps for case in expand_sweep(sweep, CONFIG.dem, CONFIG.mill)]
    return [f"{RESULTS}/dem/{case.path}/summary.json" for case in cases]


def cases_of_sweep(name: str) -> list[str]:
    """Paths of every case of a sweep; none for a sweep that the configuration lacks."""
    blocks = [block for block in CONFIG.sweeps if block.name == name]
    return [case.path for block in blocks for case in expand_sweep(block, CONFIG.dem, CONFIG.mill)]


def yield_settings(section: str) -> dict:
    """One part of the section `yields`, so that a change of another part reruns nothing."""
    return getattr(CONFIG.yields, section).model_dump(mode="json")


def every_model(pattern: str, models) -> list[str]:
    """The files of `models`, from a pattern of {model} and {strategy}."""
    return [pattern.format(model=model, strategy=strategy) for model, strategy in models]
