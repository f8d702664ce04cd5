"""Ranks the conditions that do the same to a powder as a given one, and shows what is lost in each.

    millprint match mixer --like planetary 400 10 0.2 --speeds 900 1620 --balls 10
    millprint match spex --like mixer 25Hz 10 0.3 --hours 5
    millprint match results/fingerprint/fingerprint_calibrated.json \\
        --energies 2.21e-4 5.00e-4 --frequency 400 --speeds 300 1200 --balls 5 8 10
    millprint match --from card.json --to planetary
    millprint match --any --like mixer 25Hz 10 number=6

Name each mill that you could use, by its name if it was run (--results says where), by the YAML file of its run, or by
its fingerprint.json. The target is a condition of another mill (--like MILL SPEED BALLS FILL) or a milling card
(--from, --to). Its collisions are asked for, by their energy-weighted energies E*n and E*t, which need no counting
rule, or by the mean energies of the thesis (--descriptors per_collision); how often they come is made up by milling
time, unless --equal-frequency asks for that too. --descriptors shear_share asks for E*n and the share of shear in the
power, compared by tangential over normal power. Or the target is numbers: energies per collision [J] and all collisions
over the balls [1/s].

SPEED is in rpm, or in Hz as 25Hz. Balls are a diameter [mm] or the name of a charge of several sizes that was
simulated; between two charges nothing is calculated. FILL is the fill ratio, or `number=50`, `mass_g=200`, or
`bulk_filling=0.33` of the jar with a packing fraction of 0.6, which is an assumption. Ranges that are left out are
those of the simulations.

A YAML file can hold all of this (--request), as fingerprint.inverse of config/config.yaml does; options take
precedence over it.

--any asks the atlas (docs/why/atlas.md) instead of fingerprints: of the mills that are named, or of all makers' mills
and those that come with millprint, which jar, balls, number and speed come nearest; balls are calibrated ones. Of the
options, --balls, --speeds, --hours, --near, --ranked and --out hold there.

The first line has the verdict, from the bands of both mills, of the mean of very many simulations: met, if they are
surely within --near of each other; not met, if they are surely not; not known, where a band is too wide to say, or
something was not simulated. Further lines say how long the same dose takes, and what to choose where not all is met.
The table has what was found over what was wanted, with the interval; --out writes every column.
"""

from __future__ import annotations

import argparse
import textwrap
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import Field

from millprint.cli.commands import parser_of
from millprint.config.arguments import check_written, value_of, value_of_key
from millprint.config.charge import BallChoice, charge_words, speed_words
from millprint.config.errors import ConfigError
from millprint.config.fingerprint import AskedSet, Energy, Frequency, MatchConfig, SearchConfig
from millprint.config.load import check_model, read_yaml
from millprint.config.section import Count, Density, Fraction, PositiveSpeed
from millprint.observables.definitions import ASKED_DESCRIPTORS, ASKED_SETS
from millprint.run.files import write_table
from millprint.run.numbers import three

if TYPE_CHECKING:
    import pandas as pd

Hours = Annotated[float, Field(gt=0, le=1e4)]
# Columns of a ranking as they are printed; the last two of a ranking against a card.
SHOWN = {"rank": "#", "mill": "mill", "contact": "contact", "charge": "charge", "ball_diameter_mm": "ball/mm"}
DOSES = {"powder_mass_g": "powder/g", "milling_h": "h"}
NOTHING, WIDTH, WIDEST = "nothing", 118, 120


def _slug(name: str) -> str:
    """A descriptor in a command line: normal-energy, in any set."""
    return "-".join(word for word in name.removesuffix("_J").removesuffix("_hz").split("_") if word != "weighted")


FIRST = list(dict.fromkeys(_slug(name) for names in ASKED_SETS.values() for name in names))


def shown(rows: pd.DataFrame, asked: Sequence[str], hours: float = 1.0, intervals: bool = True) -> pd.DataFrame:
    """What is printed of a ranking, as text: settings, what was found over what was wanted, time, and verdict.

    Columns that are the same in every row are left out. intervals: whether the ratios have theirs.
    """
    import pandas as pd

    from millprint.fingerprint.condition_search import variables_in_words
    from millprint.fingerprint.match_words import compared_sign, interval_in_words, speed_in_words

    table = {}
    for name, title in SHOWN.items():
        if name in rows and (name in ("rank", "ball_diameter_mm") or rows[name].nunique() > 1):
            table[title] = [f"{value:g}" if isinstance(value, float) else str(value) for value in rows[name]]
    table["fill"] = [f"{fill:.3f}" for fill in rows["fill_ratio"]]
    table["balls"] = [str(count) for count in rows["balls"]]
    table["speed"] = [speed_in_words(*setting) for setting in zip(rows["mill"], rows["speed_rpm"], strict=True)]
    records = rows.to_dict("records")
    for name in ASKED_DESCRIPTORS:
        ratio = f"{name}_ratio"
        if name in asked:
            table[compared_sign(name)] = [
                three(row[ratio]) + (f" ({interval_in_words(row, ratio)})" if intervals else "") for row in records
            ]
    for name, title in DOSES.items():
        if name in rows and rows[name].notna().all():
            table[title] = [three(value) for value in rows[name]]
    if DOSES["milling_h"] not in table and "time_ratio" in rows and rows["time_ratio"].notna().all():
        table[f"h for {hours:g}"] = [three(hours * ratio) for ratio in rows["time_ratio"]]
    table["verdict"] = list(rows["verdict"])
    if (rows["outside"] != NOTHING).any():
        table["not simulated"] = [variables_in_words(tuple(names.split(", "))) for names in rows["outside"]]
    return pd.DataFrame(table)


def print_table(rows: pd.DataFrame, asked: Sequence[str], hours: float) -> None:
    """Print a ranking; without the intervals of its ratios where it would be too wide, as of several mills."""
    text = shown(rows, asked, hours).to_string(index=False)
    if max(map(len, text.splitlines())) > WIDEST:
        text = shown(rows, asked, hours, intervals=False).to_string(index=False)
        print("the intervals of all rows are in the table of --out")
    print(text)


def print_lines(*lines: str) -> None:
    """Print sentences, as wide as the table."""
    for line in lines:
        print(textwrap.fill(line, WIDTH, subsequent_indent="  "))


def _speed(word: str) -> float:
    """A speed in rpm, or in Hz as 25Hz [rpm]."""
    ((key, number),) = speed_words(word).items()
    return value_of(key, PositiveSpeed)(number) * (60 if key == "speed_hz" else 1)


def parse(arguments: list[str], name: str) -> argparse.Namespace:
    """Parse the command line."""
    parser = parser_of(name, __doc__)
    add = parser.add_argument
    add("fingerprints", nargs="*", metavar="MILL", help="mills that you could use: name, YAML or fingerprint.json")
    add("--request", type=Path, help="YAML file with targets, speeds_rpm and so on")
    add(
        "--energies",
        nargs=2,
        type=value_of("energy_J", Energy),
        metavar=("NORMAL", "TANGENTIAL"),
        help="target energies [J]",
    )
    add(
        "--frequency",
        type=value_of("frequency_hz", Frequency),
        metavar="HZ",
        help="target: all collisions over the balls [1/s]",
    )
    add("--like", nargs=4, metavar=("MILL", "SPEED", "BALLS", "FILL"), help="target: a condition of another mill")
    add("--any", action="store_true", help="with --like: of the mills named, or of all makers', by the atlas")
    hours = value_of("time_h", Hours)
    add("--hours", type=hours, metavar="H", help="milling time of the target (default 1, or the card's) [h]")
    add("--speeds", nargs=2, type=_speed, metavar=("FROM", "TO"), help="range of the mill [rpm, or as 25Hz]")
    add(
        "--fills",
        nargs=2,
        type=value_of("fill_ratio", Fraction),
        metavar=("FROM", "TO"),
        help="fill ratios (default: all) [-]",
    )
    balls = value_of("ball_diameter_mm", BallChoice)
    add("--balls", nargs="+", type=balls, metavar="BALLS", help="available balls: diameters [mm], names of charges")
    add(
        "--densities",
        nargs="+",
        type=value_of("density_kg_m3", Density),
        metavar="KG_M3",
        help="densities of the balls [kg/m3]",
    )
    known = "what is met of another mill or a card (default weighted)"
    add("--descriptors", choices=list(ASKED_SETS), help=known)
    add("--equal-frequency", action="store_true", default=None, help="ask for the frequencies too")
    near = value_of_key(SearchConfig, "near_percent")
    add("--near", dest="near_percent", type=near, metavar="PERCENT", help="what counts as met (default 30)")
    add("--first", choices=FIRST, help="what counts most")
    add("--ranked", type=value_of("ranked", Count), metavar="N", help="conditions to list (default 10)")
    add("--from", dest="card", type=Path, metavar="CARD", help="target: a milling card, card.json")
    add("--to", metavar="MILL", help="with --from: name of a mill that was run, or its fingerprint")
    add("--results", default="results", metavar="FOLDER", help="where mills were run (default: %(default)s)")
    add("--out", type=Path, help="TSV file for the whole table")
    options = parser.parse_args(arguments)
    if (options.card is None) != (options.to is None):
        parser.error("--from CARD and --to MILL belong together")
    if options.any and not options.like:
        parser.error("--any: say what is to be met: --like MILL SPEED BALLS FILL")
    if options.card is None and not options.fingerprints and not options.any:
        parser.error("name a mill, or give --from CARD --to MILL, or --any --like MILL SPEED BALLS FILL")
    if not (options.card or options.like or options.energies or options.frequency or options.request):
        parser.error(
            "say what is to be met: --like MILL SPEED BALLS FILL, --energies NORMAL TANGENTIAL, or --request FILE"
        )
    others = ("fingerprints", "request", "energies", "frequency", "like")
    if options.card and (given := [name for name in others if getattr(options, name)]):
        parser.error(f"--from CARD: is a target of its own; leave out {', '.join(given)}")
    check_written(options.out, *filter(None, (options.request, options.card)), *options.fingerprints)
    return options


def _target_name(like: list[str] | None) -> str:
    """The name of a target of the command line."""
    return f"as_{Path(like[0]).stem}" if like and not like[0].endswith(".json") else "target"


def _first(slug: str | None, descriptors: AskedSet) -> str | None:
    """The descriptor of a set that --first means. Raises ConfigError for one of another set."""
    if slug is None:
        return None
    for name in ASKED_SETS[descriptors]:
        if _slug(name) == slug:
            return name
    raise ConfigError(f"--first {slug}: must be one of {', '.join(map(_slug, ASKED_SETS[descriptors]))}")


def request_of(options: argparse.Namespace) -> MatchConfig:
    """The request from the YAML file and the options, which take precedence."""
    from millprint.config.included import SOURCES
    from millprint.fingerprint.readers import find_fingerprint

    content: dict[str, Any] = {}
    if options.request:
        read = read_yaml(options.request)
        if isinstance(read, dict) and "fingerprint" in read:  # a configuration of the workflow
            inverse = (read["fingerprint"] or {}).get("inverse", {})
            read = {key: value for key, value in inverse.items() if key in MatchConfig.model_fields}
        if not isinstance(read, dict):
            raise ConfigError(f"{options.request}: must be a mapping of keys to values")
        content = read
    target: dict[str, Any] = {"name": _target_name(options.like)}
    if options.energies:
        target |= dict(zip(("normal_energy_J", "tangential_energy_J"), options.energies, strict=True))
    if options.frequency is not None:
        target["specific_frequency_hz"] = options.frequency
    if options.like:
        mill, speed, balls, charge = options.like
        found = str(find_fingerprint(mill, options.results, SOURCES))
        settings = {**speed_words(speed), "ball_diameter_mm": balls, **charge_words(charge)}
        target["like"] = {"fingerprint": found, **settings}
    if len(target) > 1:
        content["targets"] = [target]
    content |= searched(options, content.get("descriptors", "weighted"))
    return check_model(content, MatchConfig, str(options.request or "command line"))


def searched(options: argparse.Namespace, descriptors: AskedSet = "weighted") -> dict[str, Any]:
    """The keys of a search that are given as options; descriptors: the set that is asked for without an option."""
    keys = {"speeds": "speeds_rpm", "fills": "fill_ratios", "balls": "ball_diameters_mm"}
    keys |= {"densities": "densities_kg_m3"} | {
        name: name for name in ("ranked", "descriptors", "equal_frequency", "near_percent")
    }
    given = {key: value for option, key in keys.items() if (value := getattr(options, option)) is not None}
    first = _first(options.first, given.get("descriptors", descriptors))
    return given | ({"first": first} if first else {})


def located(mills: list[str], results: str) -> list[Path]:
    """The fingerprints of mills; says which of them come with millprint."""
    from millprint.config.included import SOURCES
    from millprint.fingerprint.readers import find_fingerprint, find_ready_made

    paths = [find_fingerprint(mill, results, SOURCES) for mill in mills]
    for mill, path in zip(mills, paths, strict=True):
        if path == find_ready_made(mill):
            print(f"{mill}: the fingerprint that comes with millprint; `millprint fingerprint {mill}` makes one here")
    return paths


def match_from_card(options: argparse.Namespace) -> None:
    """Rank the settings of a mill by how near they come to a card; print them with what is lost."""
    from millprint.card.read import match_card, read_card
    from millprint.fingerprint.model import Fingerprint

    card = read_card(options.card)
    fingerprint = Fingerprint.read(*located([options.to], options.results))
    request = check_model(searched(options), SearchConfig, "command line")
    target, table, lines = match_card(card, fingerprint, request, options.hours)
    if options.out:
        write_table(table, options.out)
    print_lines(*lines)
    if len(table):
        print_table(table, target.asked, options.hours or 1.0)


def main(arguments: list[str], name: str = "match") -> None:
    """Rank the conditions, print them and, with --out, write them."""
    options = parse(arguments, name)
    import pandas as pd

    from millprint.fingerprint.condition_search import rank_conditions, target_of
    from millprint.fingerprint.match_words import match_in_words
    from millprint.fingerprint.model import Fingerprint

    if options.card:
        match_from_card(options)
        return
    if options.any:
        from millprint.cli.match_any import match_any

        match_any(options)
        return
    fingerprints = [Fingerprint.read(path) for path in located(options.fingerprints, options.results)]
    request = request_of(options)
    tables = []
    for asked in request.targets:
        target = target_of(asked, fingerprints, request)
        rows = rank_conditions(target, fingerprints, request)
        first, *further = match_in_words(rows, target, request, fingerprints, options.hours or 1.0)
        print_lines(f"{asked.name}: {first}", *further)
        if len(rows):
            print_table(rows, target.asked, options.hours or 1.0)
        tables.append(rows.assign(target=asked.name))
    if options.out:
        write_table(pd.concat(tables, ignore_index=True), options.out)
