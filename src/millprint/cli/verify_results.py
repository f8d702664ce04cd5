"""Lists the files of RESULTS that have changed since their jobs wrote them, and changes none.

    millprint verify results

The exit status is 0 if there are none, else 1.
"""

from pathlib import Path

from millprint.cli.commands import parser_of
from millprint.config.errors import ConfigError
from millprint.run.output_digests import report_damaged


def main(arguments: list[str], name: str = "verify") -> int:
    """Check one folder."""
    parser = parser_of(name, __doc__)
    parser.add_argument("results", nargs="?", default="results", help="folder of results (default: %(default)s)")
    results = parser.parse_args(arguments).results
    if not Path(results).is_dir():
        raise ConfigError(f"{results}: no such folder; give the folder of the results of a run")
    if report_damaged(Path(results) / "logs"):
        return 1
    print(f"checked: every file in {results} is as its job wrote it")
    return 0
