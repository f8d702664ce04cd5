"""Timers that Snakemake would wait for at the end of a run. The Snakefile imports this, so no heavy imports here."""

import threading


def stop_timers() -> None:
    """Stop the timers of this process.

    Whenever Snakemake checks the waiting jobs, it sets a timer to check again after `max-jobs-per-timespan`, and it
    exits only after the last timer. A run that has ended does not need them.
    """
    for thread in threading.enumerate():
        if isinstance(thread, threading.Timer):
            thread.cancel()
