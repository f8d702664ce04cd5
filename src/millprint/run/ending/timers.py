"""What Snakemake would wait for when a run has ended. The Snakefile imports this, so no heavy imports here."""

import threading


def stop_timers() -> None:
    """Stop the timers of this process.

    After each look at the waiting jobs, Snakemake sets a timer to look again once `max-jobs-per-timespan` is over, and
    it ends only after the last of them. None is of use to a run that has ended.
    """
    for thread in threading.enumerate():
        if isinstance(thread, threading.Timer):
            thread.cancel()
