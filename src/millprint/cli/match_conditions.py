"""Ranks the conditions whose descriptors come nearest to given ones, and shows what is lost in each.

    millprint match mixer --like planetary 400 10 0.2 --speeds 900 1620 --balls 10
    millprint match results/fingerprint/fingerprint_calibrated.json \\
        --energies 2.21e-4 5.00e-4 --frequency 400 --speeds 300 1200 --balls 5 8 10
    millprint match --from card.json --to planetary

Name each mill that you could use, by its name if it was run (--results says where) or by its fingerprint.json. The
target is a condition of another mill (--like MILL SPEED_RPM BALLS FILL), by energy-weighted descriptors, which need no
counting rule, or by those of the thesis (--descriptors), or energies per collision [J] and all collisions over the
balls [1/s]. Balls are a diameter [mm] or the name of a charge of several sizes that was simulated; between two charges
nothing is calculated. FILL is the fill ratio, or `number=50`, `mass_g=200`, or `bulk_filling=0.33` of the jar with a
packing fraction of 0.6, which is an assumption. Ranges that are left out are those of the simulations. A milling card
can be the target too (--from, --to), with the time for the same dose.

A YAML file can hold all of this (--request), as fingerprint.inverse of config/config.yaml does; options take
precedence over it.

The first line says whether the target is met, or which limit of a range stands in the way. The table shows the
residuals in per cent, the descriptors that lie within the band of a new simulation of the condition (met), and the
values outside the simulated ranges; --out writes the whole table. With the target `uncertainty` it also shows by how
much, in per cent, contact parameters and the shape of the jar may change each descriptor, and next to another mill
(--like) the intervals of the ratio to it.
"""

import argparse
from pathlib import Path
from typing import Annotated, Any

import pandas as pd
from pydantic import Field

from millprint.card.match import NEAR, find_fingerprint, match_card, verdict
from millprint.card.read import read_card
from millprint.cli.commands import parser_of
from millprint.config.arguments import check_written, value_of
from millprint.config.charge import charge_words
from millprint.config.errors import ConfigError
from millprint.config.fingerprint import DescriptorSet, Energy, Frequency, MatchConfig
from millprint.config.included import SOURCES
from millprint.config.load import check_model, read_yaml
from millprint.config.mixture import BallChoice
from millprint.config.section import Count, Density, Fraction, PositiveSpeed
from millprint.estimate.estimates import columns_of
from millprint.fingerprint.bands import FURTHER, NOT_KNOWN
from millprint.fingerprint.comparison import Wanted, match_in_words
from millprint.fingerprint.condition_search import (
    extrapolated_targets,
    match_targets,
    shared_contact,
    simulated_ranges,
)
from millprint.fingerprint.descriptors import CHARGE, FEWEST_TURNS
from millprint.fingerprint.model import Fingerprint
from millprint.fingerprint.readers import find_ready_made
from millprint.observables.definitions import DESCRIPTOR_SETS
from millprint.run.files import write_table

SHORT = {
    "weighted_normal_energy_J": "E*n",
    "weighted_tangential_energy_J": "E*t",
    "weighted_normal_frequency_hz": "f*n",
    "weighted_tangential_frequency_hz": "f*t",
    "normal_energy_J": "En",
    "tangential_energy_J": "Et",
    "specific_frequency_hz": "f",
}
SHOWN = {
    "rank": "rank",
    "mill": "mill",
    "contact": "contact",
    CHARGE: "charge",
    "ball_diameter_mm": "ball/mm",
    "fill_ratio": "fill",
    "balls": "balls",
    "speed_rpm": "rpm",
    **{f"{name}_residual_percent": f"{short} %" for name, short in SHORT.items()},
    "within_interval": "met",
    "outside": "outside",
}
# Further columns of a ranking against a card.
DOSES = {"powder_mass_g": "powder/g", "rate_W_g": "W/g", "milling_h": "h for the dose"}
FORMATS = {"fill": "{:.3f}".format, "rpm": "{:.0f}".format}
FORMATS |= dict.fromkeys((f"{short} %" for short in SHORT.values()), "{:+.1f}".format)
FORMATS |= dict.fromkeys(DOSES.values(), "{:.3g}".format)


def _words(lower: pd.Series, upper: pd.Series, number: str) -> list[str]:
    """Intervals in words, or that one is not known; number: the format of an end."""
    ends = zip(lower, upper, strict=True)
    return [f"{low:{number}} to {high:{number}}" if low == low else NOT_KNOWN for low, high in ends]


def shown(rows: pd.DataFrame) -> pd.DataFrame:
    """The columns of a ranking that are printed, with short names; a descriptor's interval in per cent of the value."""
    found = rows[[name for name in SHOWN if name in rows]].rename(columns=SHOWN)
    met = found["met"].str.split(", ")
    found["met"] = met.map(lambda names: ", ".join(SHORT.get(name, name) for name in names))

    def add(title: str, lower: pd.Series, upper: pd.Series, number: str) -> None:
        found.insert(len(found.columns) - 1, title, _words(lower, upper, number))

    for name, short in SHORT.items():
        if f"{name}_ratio" in rows:
            add(f"{short} ratio", rows[f"{name}_ratio_lower"], rows[f"{name}_ratio_upper"], ".2f")
    for origin in FURTHER:
        for name, short in SHORT.items():
            lower, upper = columns_of(name, origin)
            if lower in rows:
                low, high = (100 * (rows[end] / rows[name] - 1) for end in (lower, upper))
                add(f"{short} by {origin} %", low, high, "+.0f")
            lower, upper = columns_of(f"{name}_ratio", origin)
            if lower in rows:
                add(f"{short} ratio by {origin}", rows[lower], rows[upper], ".2f")
    return found


def parse(arguments: list[str], name: str) -> argparse.Namespace:
    """Parse the command line."""
    parser = parser_of(name, __doc__)
    add = parser.add_argument
    add("fingerprints", nargs="*", metavar="MILL", help="mills that you could use, or their fingerprint.json")
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
    add("--like", nargs=4, metavar=("MILL", "RPM", "BALLS", "FILL"), help="target: a condition of another mill")
    add(
        "--speeds",
        nargs=2,
        type=value_of("speed_rpm", PositiveSpeed),
        metavar=("FROM", "TO"),
        help="range of the mill [rpm]",
    )
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
    add("--descriptors", choices=list(DESCRIPTOR_SETS), help=known)
    add("--ranked", type=value_of("ranked", Count), metavar="N", help="conditions to list (default 10)")
    add("--from", dest="card", type=Path, metavar="CARD", help="target: a milling card, card.json")
    add("--to", metavar="MILL", help="with --from: name of a mill that was run, or its fingerprint")
    add("--results", default="results", metavar="FOLDER", help="where mills were run (default: %(default)s)")
    near = value_of("near", Annotated[float, Field(gt=0, le=1000)])
    add("--near", type=near, default=100 * NEAR, metavar="PERCENT", help="with --from: what comes near")
    add("--out", type=Path, help="TSV file for the whole table")
    options = parser.parse_args(arguments)
    if (options.card is None) != (options.to is None):
        parser.error("--from CARD and --to MILL belong together")
    if options.card is None and not options.fingerprints:
        parser.error("name a mill, or give --from CARD --to MILL")
    others = ("fingerprints", "request", "energies", "frequency", "like")
    if options.card and (given := [name for name in others if getattr(options, name)]):
        parser.error(f"--from CARD: is a target of its own; leave out {', '.join(given)}")
    check_written(options.out, *filter(None, (options.request, options.card)), *options.fingerprints)
    return options


def _target_name(like: list[str] | None) -> str:
    """The name of a target of the command line."""
    return f"as_{Path(like[0]).stem}" if like and not like[0].endswith(".json") else "target"


def request_of(options: argparse.Namespace, content: dict) -> MatchConfig:
    """The request from the YAML file and the options, which take precedence, over the keys of `content`."""
    if options.request:
        read = read_yaml(options.request)
        if isinstance(read, dict) and "fingerprint" in read:  # a configuration of the workflow
            inverse = (read["fingerprint"] or {}).get("inverse", {})
            read = {key: value for key, value in inverse.items() if key in MatchConfig.model_fields}
        if not isinstance(read, dict):
            raise ConfigError(f"{options.request}: must be a mapping of keys to values")
        content = content | read
    target: dict[str, Any] = {"name": _target_name(options.like)}
    if options.energies:
        target |= dict(zip(("normal_energy_J", "tangential_energy_J"), options.energies, strict=True))
    if options.frequency is not None:
        target["specific_frequency_hz"] = options.frequency
    if options.like:
        mill, speed, balls, charge = options.like
        found = str(find_fingerprint(mill, options.results, SOURCES))
        condition = {"speed_rpm": speed, "ball_diameter_mm": balls, **charge_words(charge)}
        target["like"] = {"fingerprint": found, **condition}
    if len(target) > 1:
        content["targets"] = [target]
    keys = {"speeds": "speeds_rpm", "fills": "fill_ratios", "balls": "ball_diameters_mm"}
    keys |= {"densities": "densities_kg_m3", "ranked": "ranked", "descriptors": "descriptors"}
    content |= {key: given for option, key in keys.items() if (given := getattr(options, option)) is not None}
    return check_model(content, MatchConfig, str(options.request or "command line"))


def located(mills: list[str], results: str) -> list[Path]:
    """The fingerprints of mills; says which of them come with millprint."""
    paths = [find_fingerprint(mill, results, SOURCES) for mill in mills]
    for mill, path in zip(mills, paths, strict=True):
        if path == find_ready_made(mill):
            print(f"{mill}: the fingerprint that comes with millprint; `millprint fingerprint {mill}` makes one here")
    return paths


def match_from_card(options: argparse.Namespace) -> None:
    """Rank the settings of a mill by how near they come to a card; print them with what is lost."""
    card = read_card(options.card)
    fingerprint = Fingerprint.read(*located([options.to], options.results))
    chosen: DescriptorSet = options.descriptors or "weighted"
    wanted = Wanted(options.speeds, options.fills, options.balls, options.densities, options.ranked or 10, chosen)
    table = match_card(card, fingerprint, wanted)
    if options.out:
        write_table(table, options.out)
    for line in verdict(card, fingerprint, table, options.near / 100, wanted):
        print(line)
    if len(table):
        doses = {name: table[column] for column, name in DOSES.items() if table[column].notna().all()}
        own = shown(table).assign(**doses)
        print(own.to_string(index=False, formatters=FORMATS))


def main(arguments: list[str], name: str = "match") -> None:
    """Rank the conditions, print them and, with --out, write them."""
    options = parse(arguments, name)
    if options.card:
        match_from_card(options)
        return
    fingerprints = [Fingerprint.read(path) for path in located(options.fingerprints, options.results)]
    request = request_of(options, simulated_ranges(fingerprints))
    table = match_targets(request, fingerprints)
    notes = [*extrapolated_targets(request), *shared_contact(request, fingerprints)]
    notes += [
        f"{own.about['mill']}: few turns: {own.about['few_turns']} of its conditions were recorded for fewer than "
        f"{FEWEST_TURNS} independent turns"
        for own in fingerprints
        if own.about.get("few_turns")
    ]
    if options.out:
        write_table(table, options.out)
    for target, rows in table.groupby("target", sort=False):
        print(f"{target}: {match_in_words(rows, request, fingerprints)}")
        print(shown(rows).to_string(index=False, formatters=FORMATS))
    for note in notes:
        print(note)
    if table.empty:
        print("no condition: none of the requested fill ratios was simulated")
