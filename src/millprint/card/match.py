"""Reads a card back: which settings of another mill come nearest to it, what is lost, and how long they take."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd

from millprint.card.card_model import MillingCard
from millprint.config.checks import MILL_FOLDER
from millprint.config.errors import ConfigError
from millprint.config.sources import WORKING_FOLDER, Sources
from millprint.config.wording import close_to
from millprint.estimate.estimates import Estimate, Interval
from millprint.fingerprint.comparison import (
    ALL_SIMULATED,
    Wanted,
    limits_in_words,
    lost_in_words,
    nearest,
    setting_in_words,
)
from millprint.fingerprint.condition_search import SHARED_CONTACT, check_same_count, simulated_ranges
from millprint.fingerprint.model import Fingerprint
from millprint.fingerprint.readers import find_ready_made
from millprint.observables.definitions import DESCRIPTOR_SETS, POWER

# Settings are near a card if its descriptors are met to this on average (root mean square of logarithms).
NEAR = 0.25
# Columns that are added to a ranking: powder and dose at the card's ball-to-powder ratio.
DOSE_COLUMNS = ("powder_mass_g", "rate_W_g", "rate_ratio", "milling_h")


def find_fingerprint(mill: str, results: str | Path = "results", sources: Sources = WORKING_FOLDER) -> Path:
    """The fingerprint of a mill, given by its file or its name: of a run, or the one that comes with millprint.

    Of a mill that was run, the one with all intervals first.

    Raises ConfigError, in one line, for an unknown mill, and for a mill that was not run, with the command to run it.
    """
    if mill.endswith(".json"):
        return Path(mill)
    places = [Path(results) / folder / mill / "fingerprint.json" for folder in ("uncertainty", "mills")]
    places += sorted((Path(results) / "fingerprint").glob("fingerprint_*.json"))
    for path in places:
        if path.is_file() and (path.parent.name == mill or Fingerprint.read(path).about["mill"] == mill):
            return path
    if (included := find_ready_made(mill)) is not None:
        return included
    if not Path(sources.find(f"{MILL_FOLDER}/{mill}.yaml")).is_file():
        raise ConfigError(f"{mill}: unknown mill{close_to(mill, sources.names(MILL_FOLDER))}")
    raise ConfigError(
        f"{mill}: this mill was not run: {places[1]} is missing; `millprint fingerprint {mill}` writes it"
    )


def with_band(quantity: Estimate) -> Estimate:
    """A quantity of a card, with a band of no width if the band of a new simulation is missing."""
    return replace(quantity, scatter=quantity.scatter or Interval(quantity.value, quantity.value))


def match_card(card: MillingCard, fingerprint: Fingerprint, wanted: Wanted = ALL_SIMULATED) -> pd.DataFrame:
    """The settings of a mill nearest to a card, as `rank_conditions`, with ratios to it and DOSE_COLUMNS.

    powder_mass_g: at the card's ball-to-powder ratio; rate_W_g: power over it; rate_ratio: over the card's rate;
    milling_h: time for the card's dose. Empty if the card has no powder or programme.
    Raises ConfigError, in one line, as `check_same_count` and `rank_conditions`.
    """
    check_same_count(f"card {card.name}", vars(card.fingerprint), fingerprint, wanted.descriptors)
    names = DESCRIPTOR_SETS[wanted.descriptors]
    bands = {name: with_band(getattr(card.fingerprint.descriptors, name)) for name in names}
    table = nearest(bands, card.fingerprint.probability, fingerprint, wanted)
    table.insert(0, "target", card.name)
    return _with_dose(table, card)


def _with_dose(table: pd.DataFrame, card: MillingCard) -> pd.DataFrame:
    volume_m3 = np.pi / 6 * (1e-3 * table["ball_diameter_mm"]) ** 3
    balls_g = 1e3 * table["balls"] * table["density_kg_m3"] * volume_m3
    found = dict.fromkeys(DOSE_COLUMNS, np.full(len(table), np.nan))
    if card.powder is not None:
        powder = balls_g / card.powder.ball_to_powder_ratio
        own = card.fingerprint.descriptors.wall_power_W.value / card.powder.mass_g
        rate = table[POWER] / powder
        found |= {"powder_mass_g": powder, "rate_W_g": rate, "rate_ratio": rate / own}
        if card.programme is not None:
            found["milling_h"] = card.programme.milling_h * own / rate
    return table.assign(**found)


def is_near(row: pd.Series, near: float = NEAR) -> bool:
    """Whether a row of a ranking is near the card and within the simulated range."""
    return bool(np.expm1(row["distance"]) <= near and row["inside"] == "yes")


def verdict(
    card: MillingCard, fingerprint: Fingerprint, table: pd.DataFrame, near: float = NEAR, wanted: Wanted = ALL_SIMULATED
) -> list[str]:
    """Sentences on a ranking: the nearest setting, if there is one, what is lost, and how long it takes.

    wanted: what was searched, whose limits are named where nothing comes near.
    """
    mill = fingerprint.about["mill"]
    if table.empty:
        return [f"{card.name}: no setting of {mill}: none of the requested fill ratios was simulated"]
    best = table.iloc[0]
    near_rows = [row for _, row in table.iterrows() if is_near(row, near)]
    if not near_rows:
        outside = f", outside the simulations: {best['outside']}" if best["inside"] == "no" else ""
        if np.expm1(best["distance"]) <= near:
            return [
                f"{card.name}: no simulated setting of {mill} comes within {100 * near:g} % of the card; by the "
                f"scaling of its curves {setting_in_words(best)}{outside} would: {lost_in_words(best)}"
            ]
        return [
            f"{card.name}: no setting of {mill} comes within {100 * near:g} % of the card; the nearest "
            f"({setting_in_words(best)}{outside}) is off by a factor of {np.exp(best['distance']):.2g}: "
            f"{lost_in_words(best)}; {_limits(best, fingerprint, wanted)}"
        ]
    best = near_rows[0]
    lines = [f"{card.name}: on {mill}, {setting_in_words(best)}; against the card: {lost_in_words(best)}"]
    if np.isfinite(best["milling_h"]) and card.programme:
        lines.append(
            f"with {best['powder_mass_g']:.3g} g of powder (ball-to-powder ratio as in the card) it gives "
            f"{best['rate_ratio']:.2g} of the card's power per gram: {best['milling_h']:.3g} h of milling for the dose "
            f"of {card.programme.milling_h:.3g} h"
        )
    if "contact" in fingerprint.further and fingerprint.about["contact"] == card.contact_set.name:
        lines.append(SHARED_CONTACT.format(contact=card.contact_set.name))
    return lines


def _limits(best: pd.Series, fingerprint: Fingerprint, wanted: Wanted) -> str:
    ranges = simulated_ranges([fingerprint])
    balls = [1e3 * fingerprint.balls(choice)[0] for choice in wanted.balls or ranges["ball_diameters_mm"]]
    speeds, fills = wanted.speeds_rpm or ranges["speeds_rpm"], wanted.fill_ratios or ranges["fill_ratios"]
    return limits_in_words(best, speeds, fills, balls)
