"""Says what a run would do, before anything runs: Snakemake's table of its jobs, time, memory, disk, and the walls.

    millprint plan fingerprint planetary
    millprint plan fingerprint mine.yaml --cores 4

Targets and a mill or a configuration stand before or after arguments of Snakemake, such as --cores 4; without a target,
the whole run. Nothing is changed.
"""

import argparse
import io
import logging
import re
import sys
from collections.abc import Sequence
from contextlib import redirect_stderr, redirect_stdout
from itertools import chain, takewhile

from snakemake_interface_logger_plugins.common import LogEvent

from millprint.cli.commands import USAGE, parser_of
from millprint.cli.engine import settings_of, snakefile_words
from millprint.config.arguments import check_configfiles
from millprint.config.errors import ConfigError
from millprint.config.load import YAML
from millprint.run import machine
from millprint.run.plan import Job, OneLineAJob, plan_text


class Plan(logging.Filter):
    """Takes the jobs of a run where Snakemake has planned it; lets through its table of them, and what went wrong.

    filters: those of Snakemake's logger, to which the Snakefile adds one that knows what each job takes.
    """

    def __init__(self, filters: Sequence[object]) -> None:
        super().__init__()
        self.filters = filters
        self.jobs: list[Job] = []
        self.mills: set[str] = set()
        self.shown = False

    def filter(self, record: logging.LogRecord) -> bool:
        """Whether a record is printed."""
        event, first = getattr(record, "event", None), not self.shown
        if event == LogEvent.JOB_INFO:
            self.mills |= {vars(record)["wildcards"].get("mill", "")}
        if event == LogEvent.RUN_INFO and first:
            self.jobs = [job for own in self.filters if isinstance(own, OneLineAJob) for job in own.waiting()]
            self.shown = True
        return record.levelno >= logging.WARNING or (event == LogEvent.RUN_INFO and first)


def cores_of(words: list[str]) -> int:
    """The number of cores among the arguments of Snakemake; that of the machine without one.

    Raises ConfigError for fewer than one, which Snakemake takes.
    """
    parser = argparse.ArgumentParser(add_help=False, allow_abbrev=False)
    parser.add_argument("--cores", "-c", "--jobs", "-j", dest="cores")
    found = parser.parse_known_args(words)[0].cores or ""
    if re.fullmatch(r"-\d+|0+", found):
        raise ConfigError(f"--cores: {found}: must be 1 or more")
    return int(found) if found.isdigit() else machine.cores()


def with_targets_first(arguments: list[str]) -> list[str]:
    """The arguments with targets and mills in front, as Snakemake's own parser tells them from values of options."""
    bare = list(takewhile(lambda word: not word.startswith("-"), arguments))
    if all(word.startswith("-") for word in arguments[len(bare) :]):
        return arguments
    # Imported here: it takes a second, which most refusals do not need.
    from snakemake.cli import get_argument_parser
    from snakemake.exceptions import CliException

    try:
        found = get_argument_parser().parse_known_intermixed_args(arguments)[0].targets
    except CliException:
        # Snakemake will refuse them in its own words.
        return arguments
    # The same words may also be values of options.
    return [*found, *(word for word in arguments if word != "--" and not any(word is each for each in found))]


def main(arguments: list[str], name: str = "plan") -> int:
    """Print the plan; returns the exit status, that of Snakemake where it refuses."""
    if "--help" in arguments or "-h" in arguments:
        parser_of(name, __doc__).parse_args(["--help"])
    from millprint.config.included import included_mills, load_mill

    # Reading the Snakefile as a run does: a configuration among the targets is its settings.
    mills = included_mills()
    cores = cores_of(arguments)
    arguments = with_targets_first(arguments)
    own = list(takewhile(lambda word: not word.startswith("-"), arguments))
    named = [settings_of(word) if word.endswith(YAML) or word in ("", *mills) else [word] for word in own]
    words = [*chain.from_iterable(named), *arguments[len(own) :]]
    check_configfiles(words)
    # Imported here: it takes a second, which most refusals do not need.
    from snakemake.cli import main as snakemake_command
    from snakemake.logging import logger

    plan, said, table = Plan(logger.filters), io.StringIO(), io.StringIO()
    logger.addFilter(plan)
    try:
        with redirect_stderr(said), redirect_stdout(table):
            snakemake_command(["--dry-run", *snakefile_words(), *words])
    except SystemExit as ended:
        # The last line of Snakemake's usage message says which argument is wrong.
        lines = said.getvalue().splitlines()
        print("\n".join(lines[-1:] if ended.code == USAGE else lines), file=sys.stderr)
        print(table.getvalue(), end="")
        if ended.code:
            return int(ended.code)
    print(plan_text(plan.jobs, cores))
    # Imported here: they take a second, which the other ways out of this command do not need.
    from millprint.mill.bodies import build_bodies
    from millprint.mill.wall_words import walls_in_words

    for mill in sorted(plan.mills & {*mills}):
        print(f"wall         {mill}: {walls_in_words(build_bodies(load_mill(mill)))}")
    return 0
