"""Checks a configuration, given as JSON on standard input: geometry, balls that fit, time steps, speeds, tables.

The Snakefile calls it at the start of a run (millprint.checks.check_once). The exit status is 1 if anything is refused.
"""

import json
import sys

from millprint.checks.before_running import check_before_running
from millprint.config.checks import collect_cases, stop_on_bad_input
from millprint.config.contact_set import ContactConfig
from millprint.config.mill import MillConfig
from millprint.config.workflow import WorkflowConfig


def main(content: dict) -> None:
    """Print a line for each warning; raise ConfigError with a line for each fault."""
    config = WorkflowConfig(**content["config"])
    chapter_faults = None
    if config.chapters:
        # Its packages are not installed where only mills are described.
        from millprint.thesis.chapter_checks import chapter_faults
    mills = {name: MillConfig(**mill) for name, mill in content["mills"].items()}
    contacts = {name: ContactConfig(**contact) for name, contact in content["contacts"].items()}
    if config.validation.chosen:
        from millprint.thesis.validation.measured import check_validation

        check_validation(config)
    cases = collect_cases(config, content["source"])
    for line in check_before_running(config, mills, contacts, cases, content["source"], chapter_faults):
        print(f"warning: {line}", file=sys.stderr)


if __name__ == "__main__":
    with stop_on_bad_input():
        main(json.load(sys.stdin))
