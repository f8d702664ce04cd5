"""Calls the user's Snakemake from the command that checks and repairs results."""

import argparse
import shlex
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path


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


def say(text: str) -> None:
    """Print a line before the next output of Snakemake."""
    print(text, flush=True)
