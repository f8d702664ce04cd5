"""Runs the workflow for a mill: the fingerprint, the page with sliders, or any target.

    millprint fingerprint planetary
    millprint fingerprint mine.yaml --cores 4
    millprint explore mine.yaml
    millprint run convergence mine.yaml
    millprint run uncertainty mine.yaml --dry-run

A mill is the name of an included one, its file in config/mills, or the configuration of a run, as `millprint new`
writes it; without one, config/config.yaml of this folder. The command prints the Snakemake command that it runs.
Further arguments are those of Snakemake, such as --dry-run, or --config with keys of the configuration.
"""

from millprint.cli.commands import parser_of
from millprint.cli.engine import run_workflow, settings_of
from millprint.config.arguments import Cores, check_configfiles, value_of
from millprint.config.errors import ConfigError
from millprint.config.wording import close_to
from millprint.run.machine import cores
from millprint.run.plan import endings

TARGETS = {"fingerprint": "fingerprint", "explore": "explorer"}


def check_target(target: str) -> None:
    """Raise ConfigError, with the nearest known one, for a target that the workflow cannot have; files have a /."""
    if "/" not in target and target not in endings():
        raise ConfigError(f"millprint run {target}: unknown target{close_to(target, endings())}")


def joined_settings(words: list[str], further: list[str]) -> list[str]:
    """The settings of a mill and those given after the command: Snakemake takes one --config only."""
    if "--config" in words and "--config" in further:
        place = further.index("--config") + 1
        return [*further[:place], *words[1:], *further[place:]]
    return [*words, *further]


def without_config(arguments: list[str]) -> tuple[list[str], list[str]]:
    """The arguments without --config and what follows it, and these; a setting is not the name of a mill."""
    if "--config" not in arguments:
        return arguments, []
    place = arguments.index("--config")
    end = next((n for n in range(place + 1, len(arguments)) if arguments[n].startswith("-")), len(arguments))
    return arguments[:place] + arguments[end:], arguments[place:end]


def main(arguments: list[str], name: str) -> int:
    """Run a target of the workflow."""
    parser = parser_of(name, __doc__)
    if name not in TARGETS:
        parser.add_argument("target", help=f"what to make: {', '.join(endings())}, or a file in results/")
    parser.add_argument("mill", nargs="?", help="name, file or configuration of a mill")
    parser.add_argument(
        "--cores", type=value_of("cores", Cores), default=cores(), metavar="N", help="processors (default %(default)s)"
    )
    arguments, config = without_config(arguments)
    options, further = parser.parse_known_args(arguments)
    if further and not further[0].startswith("-"):
        parser.error(f"{further[0]}: one mill at a time, after {options.mill}; arguments of Snakemake begin with --")
    check_configfiles(further)
    target = TARGETS.get(name) or options.target
    check_target(target)
    settings = joined_settings(settings_of(options.mill) if options.mill is not None else [], [*further, *config])
    # A list of settings would take the target as one of its own.
    return run_workflow(["--cores", str(options.cores), target, *settings])
