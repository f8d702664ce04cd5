"""Fixes predictions for the included mills before anybody measures: python tools/fix_mill_predictions.py RELEASE.

Adds those of each included fingerprint that is not in config/data/waiting_predictions.tsv, with date and digest, as the
generation of a release, such as 0.4.0; with `--swing results/validation/leaf_spring/predictions.tsv` also those of the
box on a leaf spring. Rows that this release had before are replaced, those of earlier releases stay. Writes the table
of docs/why/predictions.md: of the newest rows of each mill, the largest balls, the lowest speed and the middle fill
ratio.
"""

import argparse
import datetime
import hashlib
import re
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
import pandas as pd
import trimesh

from millprint.config.charge import ONE_SIZE
from millprint.config.checks import stop_on_bad_input
from millprint.config.dose import HeatConfig
from millprint.config.included import load_mill
from millprint.config.setup_models import SETTINGS, SWING, LeafSpringConfig
from millprint.dose.heat_balance import BODIES, ROOM, HeatSource, balance_of, band, programme_phases, sample, solve
from millprint.fingerprint.model import Fingerprint
from millprint.fingerprint.predicted_values import Prediction
from millprint.fingerprint.readers import find_ready_made, ready_made
from millprint.mill.vessel import build_vessel
from millprint.observables.definitions import POWER_PARTS
from millprint.run.files import read_table, write_table
from millprint.validation.measured import DEM
from millprint.validation.waiting import BY_CONTACT, COLUMNS, IMPACTS, POWER, TABLE, read_waiting

PAGE = Path("docs/why/predictions.md")
BLOCK = re.compile(r"(<!-- table: python tools/fix_mill_predictions.py -->\n).*?(<!-- end -->)", re.S)
CONDITION = ["mill", "ball_diameter_mm", "fill_ratio", "speed_rpm"]
WARMING, WARMING_S = "warming of the jar in two minutes", 120.0
QUANTITIES = {POWER: "Power [W]", IMPACTS: "Impacts [1/s]", WARMING: "Warming in 2 min [K]"}
BY_MEAN, BY_HEAT = "the mean of very many simulations", "what is not known of the jar and its cooling"
# A set-up of the validation whose measured curve we could not read.
LEAF_SPRING = "leaf_spring"


def digest_of_file(path: Path) -> str:
    """The digest of a fingerprint's file."""
    return hashlib.sha256(path.read_bytes()).hexdigest()[:16]


def warming_K(mill: str, prediction: Prediction, diameter_m: float, density_kg_m3: float) -> tuple[float, float, float]:
    """Median and band (value, lower, upper) of the warming of a jar in WARMING_S of milling [K].

    Half of the power is taken to be dissipated at the wall; what is not known of jar, powder and cooling is sampled
    from the default ranges of `dose.heat`.
    """
    vessel = build_vessel(load_mill(mill))
    area = float(trimesh.Trimesh(*vessel.triangles(), process=False).area)
    powers = [getattr(prediction, name).value for name in POWER_PARTS]
    source = HeatSource(
        condition=mill, about={}, power_W=np.array([powers, powers]) / 2,
        balls_kg=prediction.balls * density_kg_m3 * np.pi / 6 * diameter_m**3,
        balls_m2=prediction.balls * np.pi * diameter_m**2, inside_m2=area, inside_m3=vessel.volume_m3,
    )  # fmt: skip
    settings = HeatConfig()
    balance = balance_of(settings, mill, source, sample(settings, mill).assign(**{ROOM: 0.0}))
    times = np.array([0.0, WARMING_S])
    course = solve(balance, programme_phases(WARMING_S, WARMING_S, 0.0), times)
    lower, median, upper = band(course.temperature_degC[-1, :, BODIES.index("jar")], settings.probability)
    return float(median), float(lower), float(upper)


def predictions_of(mill: str, fingerprint: Fingerprint) -> pd.DataFrame:
    """The predictions of a mill, without date: at each simulated speed and ball size, three fill ratios."""
    low, high = fingerprint.fill_range
    rows = []
    for speed_hz, diameter, charge in fingerprint.settings:
        if charge != ONE_SIZE:
            continue
        for fill in (low, float(np.sqrt(low * high)), high):
            fill = float(f"{fill:.3g}")
            condition = fingerprint.condition(ball_diameter_m=diameter, fill_ratio=fill, speed_hz=speed_hz)
            known = fingerprint.predict(condition)
            place = (mill, float(f"{1e3 * diameter:.6g}"), fill, float(f"{60 * speed_hz:.6g}"))
            hits = known.specific_frequency_hz * known.balls
            for quantity, unit, own in ((POWER, "W", known.wall_power_W), (IMPACTS, "1/s", hits)):
                for interval, kind in ((own.mean, BY_MEAN), (own.contact, BY_CONTACT)):
                    if interval:
                        rows.append((*place, quantity, own.value, interval.lower, interval.upper, unit, kind))
            warmed = warming_K(mill, known, diameter, fingerprint.about["density_kg_m3"])
            rows.append((*place, WARMING, *warmed, "K", BY_HEAT))
    return pd.DataFrame(rows, columns=list(COLUMNS[: COLUMNS.index("release")]))


def fix_waiting(path: str | Path, release: str, now: str) -> list[str]:
    """Add the predictions of each included mill whose fingerprint is not that of the newest generation; its names.

    release: the version that is to be released; rows of the same mill and release are replaced.
    """
    fixed = []
    for mill in ready_made():
        place = find_ready_made(mill)
        if place and fix_rows(path, release, now, partial(_included, mill, place), mill, digest_of_file(place)):
            fixed.append(mill)
    return fixed


def _included(mill: str, place: Path) -> pd.DataFrame:
    return predictions_of(mill, Fingerprint.read(place))


def fix_rows(
    path: str | Path, release: str, now: str, rows: Callable[[], pd.DataFrame], mill: str, digest: str
) -> bool:
    """Add rows of a mill to its generation of a release, unless its newest ones have this digest; whether it did."""
    known = read_waiting(path) if Path(path).exists() else pd.DataFrame(columns=list(COLUMNS))
    own = known[known["mill"] == mill]
    if len(own) and own.sort_values("date")["digest"].iloc[-1] == digest:
        return False
    kept = known.drop(own.index[own["release"] == release])
    tables = [table for table in (kept, rows().assign(release=release, date=now, digest=digest)) if len(table)]
    write_table(pd.concat(tables, ignore_index=True)[list(COLUMNS)], path, digits=4)
    return True


def swing_rows(predictions: pd.DataFrame, settings: LeafSpringConfig) -> pd.DataFrame:
    """The amplitudes of the box on a leaf spring after each second, without date; predictions: of its set-up."""
    own = predictions[(predictions["quantity"] == SWING) & (predictions["model"] == DEM)]
    volume = settings.side_diameters**2 * settings.length_diameters
    fill = float(f"{settings.balls * np.pi / 6 / volume:.3g}")
    place = (LEAF_SPRING, settings.ball_diameter_mm, fill, 60 * settings.frequency_hz)
    rows = [
        (*place, f"{SWING} after {row.x:g} s", row.predicted, row.lower, row.upper, "-", row.interval)
        for row in own.itertuples()
    ]
    return pd.DataFrame(rows, columns=list(COLUMNS[: COLUMNS.index("release")]))


def digits(value: float) -> str:
    """A number with three digits, never with an exponent."""
    return f"{float(f'{value:.3g}'):g}"


def table_of(waiting: pd.DataFrame) -> str:
    """A line for each mill: value and intervals of each of QUANTITIES, at one condition of the newest release."""
    head = ["Mill", "Balls [mm]", "Fill ratio [-]", "Speed [rpm]", *QUANTITIES.values()]
    lines = [head, ["---"] * len(head)]
    for _, rows in waiting[waiting["mill"] != LEAF_SPRING].groupby("mill", sort=False):
        own = rows[rows["date"] == rows["date"].max()]
        own = own[own["ball_diameter_mm"] == own["ball_diameter_mm"].max()]
        own = own[own["speed_rpm"] == own["speed_rpm"].min()]
        fills = sorted(own["fill_ratio"].unique())
        own = own[own["fill_ratio"] == fills[len(fills) // 2]]
        cells = []
        for quantity in QUANTITIES:
            found = own[own["quantity"] == quantity]
            ends = "; ".join(f"{digits(row.lower)} to {digits(row.upper)}" for row in found.itertuples())
            cells.append(f"{digits(found['value'].iloc[0])} ({ends})")
        lines.append(
            [*(f"{own[name].iloc[0]:g}" if name != "mill" else own[name].iloc[0] for name in CONDITION), *cells]
        )
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("release", help="version that is to be released")
    parser.add_argument("--swing", type=Path, help="predictions.tsv of the set-up leaf_spring")
    given = parser.parse_args()
    with stop_on_bad_input():
        now = datetime.datetime.now(datetime.UTC).strftime("%Y-%m-%d %H:%M")
        fixed = fix_waiting(TABLE, given.release, now)
        if given.swing:
            settings = SETTINGS[LEAF_SPRING]
            assert isinstance(settings, LeafSpringConfig)
            rows = swing_rows(read_table(given.swing, may_be_blank=["x", "lower", "upper", "id"]), settings)
            if fix_rows(TABLE, given.release, now, lambda: rows, LEAF_SPRING, digest_of_file(given.swing)):
                fixed.append(LEAF_SPRING)
        table = table_of(read_waiting())
        PAGE.write_text(BLOCK.sub(lambda found: f"{found[1]}{table}\n{found[2]}", PAGE.read_text()))
        print(f"fixed now: {', '.join(fixed) or 'nothing'}")
