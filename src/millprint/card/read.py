"""What a card is made from in addition to the experiment; and reading a card, also one of another program.

Reads a card back: which settings of another mill come nearest to it, what is lost, and how long they take.
"""

import json
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
import pandas as pd

from millprint.card.card_model import FORMAT, SCHEMA_VERSION, MillingCard
from millprint.config.card import Experiment
from millprint.config.counting import DEFAULT_RULE, RuleName
from millprint.config.dose import DoseConfig
from millprint.config.errors import ConfigError
from millprint.config.fingerprint import SearchConfig
from millprint.config.load import check_model
from millprint.config.section import Fraction, Section
from millprint.dose.wear import read_coefficient, read_materials
from millprint.fingerprint.condition_search import Target, check_same_count, rank_conditions
from millprint.fingerprint.match_words import match_in_words
from millprint.fingerprint.model import Fingerprint
from millprint.observables.definitions import ASKED_SETS, POWER

# Steels differ in density by less than this fraction; other materials by more.
DENSITY_TOLERANCE = 0.03


class CardSettings(Section):
    """What a card takes from the configuration of a run, with the same defaults."""

    counting_rule: RuleName = DEFAULT_RULE
    """name of the rule that defines one collision"""
    interval: Fraction = 0.95
    """probability of the bands of a new simulation and of the mean [-]"""
    dose: DoseConfig = DoseConfig()
    """settings of spectra, heat and wear"""


@dataclass(frozen=True)
class Runs:
    """The finished simulations of a condition: summary and path of run.h5 for each seed."""

    summaries: list[dict]
    paths: list[str]


@dataclass(frozen=True)
class Known:
    """Other results that apply to the experiment, None where there are none.

    fingerprint: of the mill, with factors by contact parameters and shape; wear: result of `dose.wear.fit_wear`;
    materials: table of materials; why: reasons for what is missing, by name.
    """

    fingerprint: "Fingerprint | None" = None
    wear: Mapping | None = None
    materials: pd.DataFrame | None = None
    why: Mapping[str, str] = field(default_factory=dict)


def check_material(
    experiment: Experiment, density_kg_m3: float, materials: pd.DataFrame, place: str, path: str
) -> None:
    """Refuse, with a ConfigError in one line, a material that is not in the table, or of another density.

    density_kg_m3: of the simulated balls; place: file of the experiment; path: file of the materials.
    """
    name = experiment.balls.material
    if name is None:
        return
    if name not in materials.index:
        raise ConfigError(f"{place}: balls.material = {name!r}: not in {path}; it has {', '.join(materials.index)}")
    density = float(materials.loc[name, "density_kg_m3"])
    if abs(density / density_kg_m3 - 1) > DENSITY_TOLERANCE:
        raise ConfigError(
            f"{place}: balls.material = {name!r}: has {density:g} kg/m3, the simulated balls {density_kg_m3:g}; "
            f"give balls.density_kg_m3: {density:g}"
        )


def read_card(path: str | Path) -> MillingCard:
    """The card in a file.

    Raises ConfigError for a missing file, a file that is not a card, another version of the schema, and, with a line
    each, for fields that do not match the schema.
    """
    try:
        content = json.loads(Path(path).read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise ConfigError(f"{path}: no such card; `millprint card` and the target `cards` write card.json") from None
    except (OSError, ValueError) as error:
        raise ConfigError(f"{path}: not a milling card: cannot be read as JSON ({error})") from None
    if not isinstance(content, dict) or content.get("format") != FORMAT:
        raise ConfigError(f"{path}: format: must be {FORMAT!r}")
    version = content.get("schema_version")
    if version != SCHEMA_VERSION or isinstance(version, bool):
        raise ConfigError(
            f"{path}: schema_version = {version!r}: must be {SCHEMA_VERSION}; write the card again, or read it with "
            "the version of millprint that wrote it"
        )
    return check_model(content, MillingCard, str(path))


def known_of(uncertainty: str | Path | None, wear: str | Path | None, materials: str | Path, contact: str) -> Known:
    """What other results tell, from files that may not be there; contact: the set that the intervals must be of."""
    why = {}
    fingerprint = coefficient = None
    if uncertainty and Path(uncertainty).is_file():
        fingerprint = Fingerprint.read(uncertainty)
        fingerprint = fingerprint if fingerprint.about["contact"] == contact else None
    if wear and Path(wear).is_file():
        coefficient = read_coefficient(wear)
    else:
        why["wear"] = "no fitted wear coefficient; the target `dose` of config/config.yaml fits one"
    return Known(fingerprint, coefficient, read_materials(materials), why)


# A search of everything that was simulated.
ANYTHING = SearchConfig()


def target_of_card(card: MillingCard, request: SearchConfig) -> Target:
    """What a request asks for, to be like a card."""
    own = card.fingerprint.descriptors
    wanted = {name: getattr(own, name) for name in ASKED_SETS[request.descriptors]}
    power = own.wall_power_W * (1e3 / card.balls.mass_g)
    mass_power = replace(power, unit="W/kg")
    return Target(wanted, request.asked, mass_power, card.fingerprint.probability, said=card.fingerprint.against)


def match_card(
    card: MillingCard, fingerprint: Fingerprint, request: SearchConfig = ANYTHING, hours: float | None = None
) -> tuple[Target, pd.DataFrame, list[str]]:
    """What a card asks of a mill, the settings nearest to it as `rank_conditions`, and sentences on them.

    Of a card with powder the table has powder_mass_g, at the card's ball-to-powder ratio, and rate_W_g, power over it;
    milling_h, with the ends of its interval, is the time for the card's dose, if it has a programme. hours: in place of
    its milling time. Raises ConfigError, in one line, as `check_same_count` and `rank_conditions`.
    """
    check_same_count(f"card {card.name}", vars(card.fingerprint), fingerprint, request.descriptors)
    target = target_of_card(card, request)
    table = rank_conditions(target, [fingerprint], request)
    table.insert(0, "target", card.name)
    hours = hours or (card.programme.milling_h if card.programme else None)
    if card.powder is not None:
        volume_m3 = np.pi / 6 * (1e-3 * table["ball_diameter_mm"]) ** 3
        balls_g = 1e3 * table["balls"] * table["density_kg_m3"] * volume_m3
        powder_g = balls_g / card.powder.ball_to_powder_ratio
        table = table.assign(powder_mass_g=powder_g, rate_W_g=table[POWER] / powder_g)
    if hours is not None:
        ends = ("", "_mean_lower", "_mean_upper")
        table = table.assign(**{f"milling_h{end}": hours * table[f"time_ratio{end}"] for end in ends})
    lines = match_in_words(table, target, request, [fingerprint], hours or 1.0)
    return target, table, [f"{card.name}: {lines[0]}", *lines[1:]]
