"""Shared by all rules: the validated configuration, the results folder, and digests of the code."""

from operator import attrgetter

from millprint.config.checks import CONFIGURATION, check_given_once
from millprint.cases.table import has_chapters
from millprint.run.outputs import captioned

# In the order in which they are merged. Those of --configfile come last and win; Snakemake lists them among the first too.
CONFIG_FILES = [str(file) for file in (*workflow.configfiles, *workflow.overwrite_configfiles)]

with stop_on_bad_input():
    if workflow.is_main_process:
        check_given_once(sys.argv)
    # Stricter than Snakemake's own reader, which accepts a key twice and any number of aliases.
    for file in CONFIG_FILES:
        read_yaml(file)
    CONFIG, MILLS, CONTACTS, CASES = load_workflow(config, CONFIG_FILES, SOURCES)
    CHAPTERS = has_chapters(CONFIG, CASES)

# For the check at the start of a run: the mills as they are in files, and the configuration file that messages name.
CHECKED_MILLS = dict(MILLS)
SOURCE = CONFIG_FILES[-1] if CONFIG_FILES else CONFIGURATION

# Captions of the report and the record of the run use the configuration with all defaults.
config = CONFIG.model_dump(mode="json")

RESULTS = CONFIG.results.rstrip("/")
LOGS = f"{RESULTS}/logs"
BENCHMARKS = f"{RESULTS}/benchmarks"


def settings(section: str) -> dict:
    """A section of the validated configuration, such as dem or dose.heat, as plain values, for `params`.

    A rule asks for the part that it reads, so that a change of another part does not rerun it.
    """
    return attrgetter(section)(CONFIG).model_dump(mode="json")


def program(script: str):
    """The digest of what a script computes. In `params`, it reruns the rule when that changes, but not for a comment.

    Snakemake itself only notices the date of the script. It is computed once a job asks for it.
    """
    if script == "run_dem_case.py":
        return lambda wildcards: simulation_digest()
    path = shipped(f"scripts/{script}")
    return lambda wildcards: program_digest(path)


def every_model(pattern: str, models) -> list[str]:
    """The files of `models`, from a pattern with {model} and {strategy}."""
    return [pattern.format(model=model, strategy=strategy) for model, strategy in models]


def shown(path: str, **further: str):
    """A file that the report of Snakemake shows, as its record in millprint.run.outputs says; further: words of its labels."""
    about = captioned(str(Path(path).relative_to(RESULTS)), **further)
    return report(path, caption=f"../report/{about.caption}.rst", category=about.chapter, labels=dict(about.labels))


def figures(*stems: str, **further: str) -> list:
    """Figures that the report shows, each as SVG and PNG; further: words of their labels."""
    return [path for stem in stems for path in (shown(f"{stem}.svg", **further), f"{stem}.png")]
