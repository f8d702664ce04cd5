"""What the rules share: the results folder, the validated configuration, and digests of the library."""

from millprint.config.sweep import expand_sweep
from millprint.dem.budget import minutes_on_cluster

RESULTS = CONFIG.results.rstrip("/")
LOGS = f"{RESULTS}/logs"
BENCHMARKS = f"{RESULTS}/benchmarks"

# Cases by path that no sweep of the configuration holds: those of the mills' own sweeps.
OTHER_CASES = {}

# Jobs that go on from where they were, if a cluster ended them for their time or their node, are worth another attempt,
# with more time. On one's own machine a job that fails fails again.
RETRIES = 0 if workflow.local_exec else 2


def settings(section: str) -> dict:
    """A section of the validated configuration as plain values, for `params`."""
    return getattr(CONFIG, section).model_dump(mode="json")


def library(script: str) -> str:
    """The digest of the library files that a script imports: an edit of one of them reruns the rule."""
    return library_digest(Path(workflow.basedir) / "scripts" / script)


def summaries_over(key: str) -> list[str]:
    """Summaries of every case of the sweeps that give this list of values; none where no sweep does."""
    blocks = [block for block in CONFIG.sweeps if getattr(block, key)]
    cases = [case for block in blocks for case in expand_sweep(block, CONFIG.dem, CONFIG.mill)]
    return [f"{RESULTS}/dem/{case.path}/summary.json" for case in cases]


def case_of(wildcards):
    """The case whose run.h5 is asked for."""
    path = f"{wildcards.mill}/{wildcards.contact}/{wildcards.case}"
    return CASES[path] if path in CASES else OTHER_CASES[path]


def minutes_of(wildcards, attempt):
    """Time that a cluster is asked for: the case's estimate, more with each attempt, since it goes on [min]."""
    return attempt * minutes_on_cluster(case_of(wildcards), CONFIG.dem, MILLS[wildcards.mill])


def cases_of_sweep(name: str) -> list[str]:
    """Paths of every case of a sweep; none for a sweep that the configuration lacks."""
    blocks = [block for block in CONFIG.sweeps if block.name == name]
    return [case.path for block in blocks for case in expand_sweep(block, CONFIG.dem, CONFIG.mill)]


def summaries_of_sweep(name: str) -> list[str]:
    """Summaries of every case of a sweep."""
    return [f"{RESULTS}/dem/{path}/summary.json" for path in cases_of_sweep(name)]


def yield_settings(section: str) -> dict:
    """One part of the section `yields`, so that a change of another part reruns nothing."""
    return getattr(CONFIG.yields, section).model_dump(mode="json")


def every_model(pattern: str, models) -> list[str]:
    """The files of `models`, from a pattern of {model} and {strategy}."""
    return [pattern.format(model=model, strategy=strategy) for model, strategy in models]
