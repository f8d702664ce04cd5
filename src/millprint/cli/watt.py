"""Power of your own mill from a wattmeter, with loose and with fixed balls, and the predicted power. Example:

    millprint watt my_card loose.tsv fixed.tsv --efficiency 0.5 0.85 --jars 2 --table mine.tsv

my_card is the folder of `millprint card` for the same speed and balls. Each table has the columns time_s and power_W,
twenty readings or more at a steady speed. Fixed balls are the same balls, tied in a bag or held by wool. The efficiency
is the range of the share of additional electric power that motor and belt pass on.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from millprint.cli.commands import parser_of
from millprint.config.arguments import card_folder, value_of_key
from millprint.config.errors import ConfigError
from millprint.config.load import check_model
from millprint.own_machine.settings import WattSettings, add_options, given
from millprint.run.numbers import counted

if TYPE_CHECKING:
    import numpy as np


# No mill takes as much more power with loose balls than with fixed ones.
FARTHEST = 100.0


def blocks_of(path: Path) -> np.ndarray:
    """Means of the blocks of a table of powers [W]."""
    from millprint.own_machine.prediction import BLOCKS, block_means
    from millprint.own_machine.readings import POWER, read_series

    table = read_series(path, POWER, 2 * BLOCKS)
    try:
        return block_means(table["time_s"].to_numpy(), table["value"].to_numpy())
    except ValueError as error:
        raise ConfigError(f"{path}: {error}") from None


def main(arguments: list[str], name: str = "watt") -> None:
    """Print the difference, the power in the balls, the prediction and the verdict."""
    parser = parser_of(name, __doc__)
    parser.add_argument("card", type=card_folder, help="folder of `millprint card`")
    parser.add_argument("loose", type=Path, help="table of the power with loose balls")
    parser.add_argument("fixed", type=Path, help="table of the power with fixed balls")
    share, ends = value_of_key(WattSettings, "efficiency_low"), ("LOW", "HIGH")
    parser.add_argument("--efficiency", type=share, nargs=2, required=True, metavar=ends, help="of motor and belt [-]")
    parser.add_argument("--jars", type=value_of_key(WattSettings, "jars"), help="jars with balls (default: 1)")
    add_options(parser)
    options = parser.parse_args(arguments)
    from millprint.own_machine.prediction import keep, power_of_charge, predicted_power, read_condition, say_power

    low, high = options.efficiency
    asked = {"efficiency_low": low, "efficiency_high": high, **given(options, "jars")}
    settings = check_model(asked, WattSettings, "options")
    condition = read_condition(options.card)
    loose, fixed = blocks_of(options.loose), blocks_of(options.fixed)
    lower, higher = sorted([float(loose.mean()), float(fixed.mean())])
    if 0 < FARTHEST * lower < higher:
        raise ConfigError(
            f"{options.loose}, {options.fixed}: {loose.mean():.3g} and {fixed.mean():.3g} W on average, more than "
            f"{FARTHEST:g} times apart; is one of them in kW? Its column is power_kW"
        )
    electric, charge = power_of_charge(loose, fixed, settings)
    print(f"{condition.card.name}: {condition.words}")
    print(f"electric power, loose less fixed balls: {electric}, of {counted(settings.jars, 'jar')}")
    doubt = "less than zero: are the tables swapped?" if charge.hull().upper < 0 else ""
    note = say_power(condition, charge, options.date, doubt)
    figure = None
    if options.figure:
        from millprint.figures.card_figures import plot_powers

        figure = plot_powers(
            {"loose less fixed": electric, "in the balls of a jar": charge, "predicted": predicted_power(condition)}
        )
    keep(options, condition.row("power by wattmeter", "W", charge, note), figure)
