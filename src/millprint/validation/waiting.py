"""Predictions for the included mills that wait for a measurement: fixed, with their date and a digest.

They are those of the included fingerprints, which need no simulation, and of the box on a leaf spring. The table has
one generation of rows a release: those of earlier releases stay, and a measurement is judged by the newest generation
that is older than it.
"""

import hashlib
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
import pandas as pd

from millprint.config.charge import ONE_SIZE
from millprint.config.dose import HeatConfig
from millprint.config.included import load_mill, shipped
from millprint.config.setup_models import SWING, LeafSpringConfig
from millprint.dose.heat_balance import BODIES, ROOM, HeatSource, balance_of, band, programme_phases, sample, solve
from millprint.fingerprint.model import Fingerprint
from millprint.fingerprint.predicted_values import Prediction
from millprint.fingerprint.readers import find_ready_made, ready_made
from millprint.mill.vessel import build_vessel
from millprint.observables.definitions import POWER_PARTS
from millprint.run.files import write_table
from millprint.run.tables import Number, Text, read_measured
from millprint.validation.measured import DEM

TABLE = "config/data/waiting_predictions.tsv"
CONDITION = ("ball_diameter_mm", "fill_ratio", "speed_rpm")
COLUMNS = ("mill", *CONDITION, "quantity", "value", "lower", "upper", "unit", "interval", "release", "date", "digest")
POWER, IMPACTS, WARMING = "power of the walls", "impacts a second", "warming of the jar in two minutes"
WARMING_S = 120.0
BY_MEAN, BY_HEAT = "the mean of very many simulations", "what is not known of the jar and its cooling"
BY_CONTACT = "contact parameters that nobody has measured"
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
    # Imported here: slow to import.
    import trimesh

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


def read_waiting(path: str | Path = TABLE) -> pd.DataFrame:
    """The table of fixed predictions. Raises ConfigError as `read_measured`."""
    ends = [Number(name, optional=True, may_be_blank=True) for name in ("lower", "upper")]
    numbers = [*map(Number, (*CONDITION, "value")), *ends]
    texts = [Text(name) for name in COLUMNS if name not in {number.name for number in numbers}]
    return read_measured(path, [*numbers, *texts])


def fixed_before(
    date: str, mill: str, diameter_mm: float, fill_ratio: float, speed_rpm: float, quantity: str
) -> dict | None:
    """The newest row of a quantity at a condition that is older than a date, with the interval of its mean.

    date: of the measurement, as 2026-11-27, or with the time (UTC). None if there is none, or the mill is another one
    here.
    """
    path = shipped(TABLE)
    if path is None or find_ready_made(mill) is None:
        return None
    table = read_waiting(path)
    same = (table["mill"] == mill) & (table["quantity"] == quantity) & (table["interval"] != BY_CONTACT)
    same &= table["date"] < date
    for name, value in zip(CONDITION, (diameter_mm, fill_ratio, speed_rpm), strict=True):
        same &= np.isclose(table[name], value, rtol=1e-3)
    return table[same].sort_values("date").iloc[-1].to_dict() if same.any() else None


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
