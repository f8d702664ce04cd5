"""Reads a card back: which settings of another mill come nearest to it, what is lost, and how long they take."""

from dataclasses import replace

import numpy as np
import pandas as pd

from millprint.card.card_model import MillingCard
from millprint.config.fingerprint import SearchConfig
from millprint.fingerprint.condition_search import check_same_count, rank_conditions
from millprint.fingerprint.match_target import Target
from millprint.fingerprint.match_words import match_in_words
from millprint.fingerprint.model import Fingerprint
from millprint.observables.definitions import ASKED_SETS, POWER

# A search of everything that was simulated.
ANYTHING = SearchConfig()


def target_of_card(card: MillingCard, request: SearchConfig) -> Target:
    """What a request asks for, to be like a card."""
    own = card.fingerprint.descriptors
    wanted = {name: getattr(own, name) for name in ASKED_SETS[request.descriptors]}
    power = own.wall_power_W * (1e3 / card.balls.mass_g)
    return Target(wanted, request.asked, replace(power, unit="W/kg"), card.fingerprint.probability)


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
