"""`millprint match --any`: the nearest settings of any mill, by the atlas."""

from __future__ import annotations

import argparse
import math

import pandas as pd

from millprint.atlas.estimate_mill import estimate, included_models, model_of
from millprint.atlas.kind_groups import Kind
from millprint.atlas.kinds import KINDS, balls_of, recognise
from millprint.atlas.search_mills import (
    ALIKE,
    Found,
    fastest_of_kinds,
    listed_mills,
    makers_mills,
    nearest_settings,
    own_mill,
    ranked,
)
from millprint.cli.estimate_condition import condition_of, mill_and_contact
from millprint.cli.match_conditions import print_lines
from millprint.config.charge import charge_words, speed_words
from millprint.config.errors import ConfigError
from millprint.config.fingerprint import SearchConfig
from millprint.config.included import included_mills as included_names
from millprint.config.load import check_model, shipped
from millprint.config.mill_sweep import ConditionSection
from millprint.estimate.judge import AGREES
from millprint.fingerprint.condition_search import SOLD_MM
from millprint.run.files import write_table
from millprint.run.numbers import plain, three

MAKERS = "config/atlas/makers.tsv"
# Options of `match` that fingerprints answer only.
NOT_OF_ATLAS = ("request", "energies", "frequency", "fills", "densities", "descriptors", "equal_frequency", "first")
# Settings that are printed for each mill; columns of what is compared.
PER_MILL = 2
COMPARED = dict(zip(ALIKE, ("E*n", "E*t"), strict=True))


def _wanted(like: list[str]) -> tuple:
    """Kind and condition of a target. Raises ConfigError, in one line, for a mill of no kind."""
    name, speed, balls, charge = like
    mill, contact = mill_and_contact(name, None)
    known = recognise(mill)
    if known is None:
        raise ConfigError(f"--like {name}: no kind of the atlas; leave out --any, and name mills to compare")
    words = {**speed_words(speed), "ball_diameter_mm": balls, **charge_words(charge)}
    asked = check_model(words, ConditionSection, "--like")
    return known[0], condition_of(*known, asked, contact), contact


def _mills(names: list[str], made: list[dict], kinds: list[Kind]) -> list[dict]:
    """The mills that are named, or the makers' (made) and those that come with the library, of `kinds` of the atlas.

    Raises ConfigError for one of no kind."""
    if not names:
        return listed_mills(made, list(included_names()), kinds)
    found = []
    for name in names:
        known = recognise(mill_and_contact(name, None)[0])
        if known is None:
            raise ConfigError(f"{name}: no kind of the atlas; leave out --any to match its fingerprint")
        found.append(own_mill(name, *known, made))
    return found


def match_any(options: argparse.Namespace) -> None:
    """Search all mills, print the nearest settings of each, and write the table where --out says."""
    if unknown := [name for name in NOT_OF_ATLAS if getattr(options, name) is not None]:
        words = ", ".join(f"--{name.replace('_', '-')}" for name in unknown)
        raise ConfigError(f"--any: is by E*n and E*t of the atlas, between all fill ratios; leave out {words}")
    given = {key: value for key in ("near_percent", "ranked") if (value := getattr(options, key)) is not None}
    request = check_model(given, SearchConfig, "command line")
    kind, condition, contact = _wanted(options.like)
    models = included_models()
    wanted = estimate(kind, condition, model_of(kind))
    kinds = [model.kind for model in models.values()]
    table = shipped(MAKERS)
    made = makers_mills(table, kinds) if table else []
    mills, of_kinds = _mills(options.fingerprints, made, kinds), fastest_of_kinds(made)
    sizes = [float(size) for size in options.balls or SOLD_MM]

    def search(low_hz: float, high_hz: float) -> list[Found]:
        found: list[Found] = []
        for mill in mills:
            # Without a limit of the machine or of the user, what makers' mills of the kind reach.
            reached = math.inf if options.speeds else of_kinds.get(mill["kind"], math.inf)
            speeds_hz = max(low_hz, mill["slowest_hz"]), min(high_hz, mill["fastest_hz"] or reached)
            own = nearest_settings(
                mill["title"], models[mill["kind"]], mill["dimensions"], balls_of(contact), sizes, wanted, speeds_hz
            )
            found += ranked(own, request.near_percent)[:PER_MILL]
        return found

    low, high = options.speeds or (0.0, math.inf)
    found = search(low / 60, high / 60)
    if not found:
        left_out = [f"--{name}" for name in ("balls", "speeds") if getattr(options, name)]
        hint = f"; leave out {', '.join(left_out)}" if left_out else ""
        if options.speeds and search(low, high):
            hint = f"; are the speeds in Hz? Write --speeds {low:g}Hz {high:g}Hz"
        raise ConfigError(f"--any: no mill has settings that the atlas knows for these balls and speeds{hint}")
    found = ranked(found, request.near_percent)[: request.ranked]
    table = pd.DataFrame([_row(own, request.near_percent, options.hours or 1.0) for own in found])
    met = (table["verdict"] == AGREES).sum()
    print_lines(
        f"met for sure within {plain(request.near_percent)} % by {met} of {len(table)} settings; in brackets the 90 % "
        "intervals of both mills; hours are for the same energy per mass of balls"
    )
    print(table.to_string(index=False))
    titles = {own.title for own in found}
    print_lines(*_assumed([mill for mill in mills if mill["title"] in titles], of_kinds, bool(options.speeds)))
    if options.out:
        write_table(table, options.out)


def _speed_words(kind: str, speed_hz: float) -> str:
    return f"{speed_hz:.1f} Hz" if KINDS[kind].speed_unit == "hz" else f"{60 * speed_hz:.0f} rpm"


def _assumed(mills: list[dict], of_kinds: dict[str, float], is_given: bool) -> list[str]:
    """Lines on what is not known of the mills that were found: dimensions, and speeds where none are given."""
    lines = []
    for mill in mills:
        guessed = [name for name in mill["dimensions"] if mill["known"] is not None and name not in mill["known"]]
        if guessed:
            lines.append(f"{mill['title']}: assumed {', '.join(guessed)}; measure yours and name your mill's file")
    for mill in [] if is_given else mills:
        if not mill["fastest_hz"]:
            kind, most = mill["kind"], of_kinds.get(mill["kind"])
            reached = f"the {_speed_words(kind, most)} of makers' mills" if most else "what the atlas knows"
            lines.append(f"{mill['title']}: fastest speed not known, here up to {reached}; give --speeds FROM TO")
    return lines


def _row(own: Found, near_percent: float, hours: float) -> dict[str, str]:
    """A setting as it is printed."""
    condition, kind = own.estimate.condition, own.estimate.kind
    row = {
        "mill": own.title, "jar mm": f"{plain(2 * condition['radius_mm'])} x {plain(condition['height_mm'])}",
        "ball mm": plain(condition["ball_diameter_mm"]), "balls": plain(condition["number"]),
        "speed": _speed_words(kind.name, condition["speed_hz"]),
    }  # fmt: skip
    for name, sign in COMPARED.items():
        low, high = own.ratios[name].ends("scatter")
        row[sign] = f"{three(own.ratios[name].value)} ({three(low)} to {three(high)})"
    return row | {f"h for {hours:g}": three(hours / own.strength.value), "verdict": own.verdict(near_percent).word}
