"""Lists what the measured set-ups predict: the quantities that a row of own measurements may name, with their units.

    millprint quantities
    millprint quantities slice_mill

A table of own measurements has the columns id, setup, quantity, value and unit, and x where the quantity depends on
something; docs/how_to/measurements.md explains it.
"""

from millprint.cli.commands import parser_of
from millprint.config.errors import ConfigError
from millprint.config.setup_models import SETTINGS, quantities_of
from millprint.config.wording import close_to


def main(arguments: list[str], name: str = "quantities") -> None:
    """Print a line for each quantity of each set-up, or of one."""
    parser = parser_of(name, __doc__)
    parser.add_argument("setup", nargs="?", help=f"one of {', '.join(SETTINGS)}; all if left out")
    chosen = parser.parse_args(arguments).setup
    if chosen and chosen not in SETTINGS:
        raise ConfigError(f"millprint quantities {chosen}: unknown set-up{close_to(chosen, SETTINGS)}")
    print(f"{'setup':<16}{'quantity':<62}{'unit':<8}x")
    for setup in [chosen] if chosen else SETTINGS:
        for quantity, asked in quantities_of(SETTINGS[setup]).items():
            print(f"{setup:<16}{quantity:<62}{asked.unit:<8}{asked.x or '-'}")
