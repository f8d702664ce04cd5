"""The command `millprint`: finds the command that is asked for, and runs its module. Nothing else is imported."""

import argparse
import gc
import os
import sys
from collections.abc import Sequence
from importlib import import_module
from typing import Any, NamedTuple, NoReturn

from millprint.config.errors import MillprintError, readable

# Exit statuses: wrong arguments, and those of a shell for an ended reader and for Ctrl-C.
USAGE, PIPE, INTERRUPTED = 2, 141, 130


class Command(NamedTuple):
    """A command: the module whose `main` runs it, and what it does in a few words."""

    module: str
    does: str


COMMANDS = {
    "new": Command("millprint.cli.new_mill", "describe a mill of your own: asks, and writes its YAML and its picture"),
    "estimate": Command("millprint.cli.estimate_condition", "what a mill does, at once, from its dimensions"),
    "fingerprint": Command("millprint.cli.run_targets", "simulate a mill and write its fingerprint"),
    "explore": Command("millprint.cli.run_targets", "make a page with sliders for a mill"),
    "run": Command("millprint.cli.run_targets", "make any target or file of the workflow"),
    "plan": Command("millprint.cli.plan_run", "say what a run would do: jobs, time, memory and disk"),
    "match": Command("millprint.cli.match_conditions", "find settings that do to a powder what another mill does"),
    "card": Command("millprint.cli.simulate_card", "simulate one experiment and write its milling card"),
    "dose": Command(
        "millprint.cli.compute_dose", "energy and hits that a gram of powder has seen, for a table of runs"
    ),
    "wear": Command("millprint.cli.predict_wear", "wear of the balls and iron in the powder"),
    "warm": Command("millprint.cli.warm", "power of your own mill, from the warming of its jar"),
    "watt": Command("millprint.cli.watt", "power of your own mill, from a wattmeter with loose and fixed balls"),
    "quantities": Command("millprint.cli.list_quantities", "list what own measurements can be compared with"),
    "animate": Command("millprint.cli.view_run", "animate the snapshots of a simulation"),
    "export": Command("millprint.cli.view_run", "write the snapshots of a simulation for ParaView"),
    "design": Command("millprint.thesis.commands.make_design", "make a design of experiments"),
    "analyse": Command("millprint.thesis.commands.analyse_design", "analyse the runs of a design"),
    "wet-lab": Command(
        "millprint.thesis.commands.calculate_wet_lab", "yields, half-lives, charges and wear from readings"
    ),
    "yields": Command("millprint.thesis.commands.ask_yields", "predict yields by a stored model"),
    "verify": Command("millprint.cli.records", "list the files that have changed since their jobs wrote them"),
    "crate": Command("millprint.cli.records", "describe a finished run as an RO-Crate"),
    "check-crate": Command("millprint.cli.records", "check a copy of results against its crate"),
    "completion": Command("millprint.cli.completion", "print the completion of this command for bash"),
}


def overview() -> str:
    """What `millprint --help` prints."""
    lines = [f"  {name:<12} {command.does}" for name, command in COMMANDS.items()]
    return "\n".join(
        [
            "millprint: the mechanical fingerprint of a ball mill.",
            "",
            "usage: millprint COMMAND ...; millprint COMMAND --help has an example of each",
            "",
            *lines,
            "",
            "example:",
            "  millprint new planetary --name mine",
            "  millprint fingerprint mine.yaml",
        ]
    )


def main(words: Sequence[str] | None = None) -> int:
    """Run a command; returns the exit status."""
    # Imports make many objects that live to the end; looking for garbage among them takes a sixth of a short command.
    gc.set_threshold(3_000_000)
    try:
        status = _run(sys.argv[1:] if words is None else words)
        sys.stdout.flush()
    except BrokenPipeError:
        # Who read the output, such as `head`, has ended; what is left of it goes nowhere, without a traceback.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return PIPE
    except KeyboardInterrupt:
        return INTERRUPTED
    return status


def _run(words: Sequence[str]) -> int:
    if not words or words[0] in ("-h", "--help", "help"):
        print(overview())
        return 0
    if words[0] == "--version":
        # Reading the versions of packages takes a while.
        from importlib.metadata import version

        print(f"millprint {version('millprint')}")
        return 0
    name = words[0]
    if name not in COMMANDS:
        from millprint.config.wording import close_to

        print(f"error: millprint {name}: unknown command{close_to(name, COMMANDS)}", file=sys.stderr)
        return USAGE
    try:
        return import_module(COMMANDS[name].module).main(list(words[1:]), name) or 0
    except MillprintError as error:
        print("\n".join(f"error: {line}" for line in str(error).splitlines()), file=sys.stderr)
        return 1
    except OSError as error:
        if isinstance(error, BrokenPipeError) or error.filename is None:
            raise
        print(f"error: {error.filename}: {error.strerror}", file=sys.stderr)
        return 1
    except EOFError:
        print("error: no answer came; with --set NAME=VALUE or --yes nothing is asked", file=sys.stderr)
        return 1


class Once(argparse.Action):
    """Stores what follows an option, and refuses the option a second time: argparse keeps the last without a word."""

    is_given = False

    def __call__(
        self, parser: argparse.ArgumentParser, namespace: argparse.Namespace, values: Any, option: str | None = None
    ) -> None:
        """Store the values."""
        if option and self.is_given:
            words = f"write all values after one {option}" if self.nargs in ("+", "*") else "give it once"
            parser.error(f"{option}: is given twice; {words}")
        self.is_given = True
        setattr(namespace, self.dest, values)


class OneLineParser(argparse.ArgumentParser):
    """A parser that says what is wrong in one line, and takes each option once."""

    def __init__(self, *words: Any, **settings: Any) -> None:
        super().__init__(*words, **settings)
        for name in (None, "store"):
            self.register("action", name, Once)

    def error(self, message: str) -> NoReturn:
        """Print the fault and where help is, and end."""
        text = readable(f"{self.prog}: {message}; {self.prog} --help shows what it takes".replace("\n", " "))
        print(f"error: {text}", file=sys.stderr)
        sys.exit(USAGE)


def parser_of(name: str, text: str | None) -> argparse.ArgumentParser:
    """The parser of a command, whose help is the docstring of its module."""
    return OneLineParser(
        prog=f"millprint {name}", description=text, formatter_class=argparse.RawDescriptionHelpFormatter
    )
