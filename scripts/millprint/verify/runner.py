"""Calls the user's Snakemake from the command that checks and repairs results, and removes locks of killed runs."""

import argparse
import shlex
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

from millprint.liveness import DEAD, LIVING, UNKNOWN, Run


class Snakemake:
    """A Snakemake command without targets: its arguments, and the folder in which it is called."""

    def __init__(self, arguments: Sequence[str]) -> None:
        # Without a number of cores Snakemake makes nothing.
        self.arguments = list(arguments) or ["--cores", "1"]
        self.called_from = Path.cwd()

    @property
    def folder(self) -> Path:
        """Its working folder."""
        parser = argparse.ArgumentParser(add_help=False, allow_abbrev=False)
        parser.add_argument("--directory", "-d", default=".")
        return self.called_from / parser.parse_known_args(self.arguments)[0].directory

    def words(self, *more: str) -> str:
        """The command with `more` arguments, as typed in a shell."""
        return shlex.join(["snakemake", *self.arguments, *more])

    def run(self, *more: str, quiet: bool = False) -> bool:
        """Run it with `more` arguments; True if it succeeds. If `quiet`, its output is shown only after a failure."""
        said = ""
        with subprocess.Popen(
            [sys.executable, "-m", "snakemake", *self.arguments, *more],
            cwd=self.called_from,
            stdout=subprocess.PIPE if quiet else None,
            stderr=subprocess.STDOUT if quiet else None,
            text=True,
        ) as process:
            while process.returncode is None:
                try:
                    said = process.communicate()[0] or ""
                except KeyboardInterrupt:
                    # The interrupt has reached Snakemake too, which ends its jobs first.
                    continue
        if process.returncode:
            print(said, end="", file=sys.stderr, flush=True)
        return process.returncode == 0


# Snakemake's locks of the current folder.
LOCKS = Path(".snakemake/locks")


def say(text: str) -> None:
    """Print a line before the next output of Snakemake."""
    print(text, flush=True)


def mend_locks(runs: Sequence[Run], snakemake: Snakemake) -> bool:
    """Print the runs that were found, and remove the locks of the dead ones, unless another is LIVING or UNKNOWN.

    Snakemake itself removes them, in whatever form it stores its locks. Locks without a run are of one that was killed
    at its very end, when it had said that it was over. Returns False if Snakemake fails.
    """
    for run in runs:
        say(f"found: {described(run)}")
    dead = [run for run in runs if run.state == DEAD]
    if not runs and LOCKS.is_dir() and any(LOCKS.iterdir()):
        say("found: a run that was killed as it ended")
    elif not dead:
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
