"""Removes the locks of killed runs, if no other run can hold a lock."""

import shlex
from collections.abc import Sequence

from millprint.liveness import DEAD, LIVING, UNKNOWN, Run
from millprint.verify.runner import Snakemake, say


def mend_locks(runs: Sequence[Run], snakemake: Snakemake) -> bool:
    """Print the runs that were found, and remove the locks of the dead ones, unless another is LIVING or UNKNOWN.

    Snakemake itself removes them, in whatever form it stores its locks. Returns False if it fails.
    """
    for run in runs:
        say(f"found: {described(run)}")
    dead = [run for run in runs if run.state == DEAD]
    if not dead:
        return True
    if len(dead) < len(runs):
        say("       its locks stay, for another run may be alive; if none is: snakemake --unlock")
        return True
    if not snakemake.run("--unlock", quiet=True):
        say("error: its locks could not be removed, see above")
        return False
    for run in dead:
        run.path.unlink(missing_ok=True)
    say(f"       its locks are removed: {snakemake.words('--unlock')}")
    return True


def described(run: Run) -> str:
    """A line about a run, with what the user can do."""
    where = "this machine" if run.is_here else f"machine {run.host}"
    if run.state == LIVING:
        return f"a run that is alive: process {run.pid} on {where}; its locks stay"
    if run.state == DEAD:
        return f"a run that was killed: process {run.pid} on {where}"
    if run.state == UNKNOWN:
        return (
            f"a run of which nothing is known here: process {run.pid} on {where}; its locks stay; "
            f"if it has ended: snakemake --unlock; rm {shlex.quote(str(run.path))}"
        )
    raise ValueError(f"{run.path}: a run is {LIVING}, {DEAD} or {UNKNOWN}, not {run.state}")
