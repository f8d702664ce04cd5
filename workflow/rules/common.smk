"""What the rules share: the results folder, the validated configuration, and digests of the library."""

RESULTS = CONFIG.results.rstrip("/")
LOGS = f"{RESULTS}/logs"
BENCHMARKS = f"{RESULTS}/benchmarks"


def settings(section: str) -> dict:
    """A section of the validated configuration as plain values, for `params`."""
    return getattr(CONFIG, section).model_dump(mode="json")


def library(script: str) -> str:
    """The digest of the library files that a script imports: an edit of one of them reruns the rule."""
    return library_digest(Path(workflow.basedir) / "scripts" / script)
