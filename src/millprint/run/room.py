"""Room for the results of a run, checked before its first job. The Snakefile imports this, so no heavy imports here."""

import tempfile
from collections.abc import Sequence
from pathlib import Path

from millprint.config.errors import ConfigError
from millprint.run.plan import Job, free_mb, in_megabytes


def check_disk(jobs: Sequence[Job], results: str) -> None:
    """Raise ConfigError, in one line, if `results` cannot be written, or the files of the jobs have no room there."""
    place = Path(results).absolute()
    while not place.exists():
        place = place.parent
    try:
        with tempfile.TemporaryFile(dir=place):
            pass
    except OSError as error:
        raise ConfigError(
            f"{results}: nothing can be written there ({error.strerror}); run in a folder of yours, or name another "
            "one with the key `results`"
        ) from None
    needed, free = sum(job.disk_mb for job in jobs), free_mb([results])
    if needed > free:
        raise ConfigError(
            f"{results}: the run needs about {in_megabytes(needed)} and {in_megabytes(free)} are free on that disk; "
            "make room and run the same command again"
        )
