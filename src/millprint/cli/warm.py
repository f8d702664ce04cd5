"""Power of your own mill from the warming of its jar, and the power predicted for its condition. Example:

    millprint warm my_card thermometer.tsv --jar-kg 0.72 --start-s 30 --stop-s 150 --table mine.tsv

my_card is the folder of `millprint card` for the same speed, balls and powder. The table has the columns time_s (or
time_min) and temperature_degC, from before the start until some minutes after the stop if possible, while the balls
pass their heat on to the jar. All must have the temperature of the room at the start. What is not known of the jar is
sampled from the ranges of `dose.heat` (config/keys.md).
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, get_args

from millprint.cli.commands import parser_of
from millprint.config.arguments import card_folder, value_of_key
from millprint.config.dose import BodyName, HeatConfig, JarSection
from millprint.config.errors import ConfigError
from millprint.config.load import check_model
from millprint.own_machine.settings import WarmSettings, add_options, given

if TYPE_CHECKING:
    from millprint.dose.heat_balance import Balance
    from millprint.own_machine.prediction import Condition

SAMPLES, FEWEST_READINGS, SHORTEST_S = 4000, 10, 30.0
# Rooms in which people mill, also cold ones; 68 degrees Fahrenheit are 20 degC.
COLDEST_DEGC, WARMEST_DEGC = -30.0, 50.0
FLOAT_OPTIONS = {
    "jar_kg": "mass of jar and lid [kg]",
    "powder_g": "powder in the jar [g]",
    "start_s": "time at which the mill starts [s]",
    "stop_s": "time at which it stops [s]",
    "resolution_K": "resolution of the thermometer [K]",
}


def balance_of_1_W(condition: Condition, settings: WarmSettings) -> Balance:
    """Balances of the condition for 1 W of dissipation in all, with everything that is not known sampled."""
    from millprint.dose.heat_balance import ROOM, balance_of, mean_of, read_source, sample

    card = condition.card
    powder = settings.powder_g or (card.powder.mass_g if card.powder else None)
    jar = JarSection(cooling=settings.cooling or card.jar.cooling or "moving_air", mass_kg=settings.jar_kg)
    heat = HeatConfig(samples=SAMPLES, powder_mass_g=powder, jars={card.machine.name: jar})
    source = mean_of([read_source(run / "summary.json", run / "run.h5") for run in condition.runs])
    drawn = sample(heat, card.machine.name).assign(**{ROOM: 0.0})
    unit = type(source)(**{**vars(source), "power_W": source.power_W / source.power_W.sum()})
    return balance_of(heat, card.machine.name, unit, drawn)


def main(arguments: list[str], name: str = "warm") -> None:
    """Print the power, the prediction and the verdict."""
    parser = parser_of(name, __doc__)
    parser.add_argument("card", type=card_folder, help="folder of `millprint card`")
    parser.add_argument("readings", type=Path, help="table with time and temperature")
    for option, text in FLOAT_OPTIONS.items():
        parser.add_argument(
            f"--{option.replace('_', '-')}", dest=option, type=value_of_key(WarmSettings, option), help=text,
            required=WarmSettings.model_fields[option].is_required(),
        )  # fmt: skip
    parser.add_argument("--cooling", choices=["still_air", "moving_air", "water"], help="what cools the jar")
    parser.add_argument("--body", choices=get_args(BodyName), help="what the thermometer touches (default: jar)")
    add_options(parser)
    options = parser.parse_args(arguments)
    from millprint.dose.heat_balance import BODIES
    from millprint.own_machine.prediction import fit_power, keep, read_condition, say_power, unit_response
    from millprint.own_machine.readings import TEMPERATURE, read_series

    settings = check_model(given(options, *FLOAT_OPTIONS, "cooling", "body"), WarmSettings, "options")
    condition = read_condition(options.card)
    table = read_series(options.readings, TEMPERATURE, FEWEST_READINGS)
    time_s, read = table["time_s"].to_numpy(), table["value"].to_numpy()
    start = time_s[0] if settings.start_s is None else settings.start_s
    stop = time_s[-1] if settings.stop_s is None else settings.stop_s
    if start < time_s[0] or time_s[-1] - start < SHORTEST_S:
        raise ConfigError(
            f"{options.readings}: readings from {time_s[0]:g} to {time_s[-1]:g} s and milling from {start:g} s: needs "
            f"a reading before the start, and {SHORTEST_S:g} s of readings after it"
        )
    if not COLDEST_DEGC <= read[0] <= WARMEST_DEGC:
        raise ConfigError(
            f"{options.readings}: {read[0]:.3g} degC at the beginning: must be the temperature of a room, "
            f"{COLDEST_DEGC:g} to {WARMEST_DEGC:g} degC; is it in degrees Fahrenheit?"
        )
    response = unit_response(balance_of_1_W(condition, settings), time_s, start, stop, BODIES.index(settings.body))
    found = fit_power(response, time_s, read, settings.resolution_K)
    print(f"{condition.card.name}: {condition.words}")
    print(
        f"warming at the start: {found.begin_K_min:.3g} K/min; readings within {found.residual_K:.2g} K of the balance"
    )
    doubt = ""
    if found.power_W.hull().upper < 0:
        doubt = "less than zero: does the jar cool?"
    elif not found.described:
        doubt = (
            f"the balance does not describe these readings of {time_s[-1] - time_s[0]:g} s with "
            f"{min(stop, time_s[-1]) - start:g} s of milling: is it in minutes? Was all at the temperature of the room?"
        )
    note = say_power(condition, found.power_W, options.date, doubt)
    figure = None
    if options.figure:
        from millprint.figures.card_figures import plot_warming

        figure = plot_warming(time_s, read, found.model_degC, (start, min(stop, time_s[-1])), settings.body)
    row = condition.row("power by warming", "W", found.power_W, note)
    keep(options, row, figure)
