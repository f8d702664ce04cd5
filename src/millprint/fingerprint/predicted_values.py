"""What a fingerprint predicts for a condition, or for the rows of a table: quantities with their bands."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from millprint.config.charge import MEASURES, fill_from, too_much_words
from millprint.config.errors import ConfigError
from millprint.estimate.estimates import Estimate, Interval, columns_of, known_ends, parts_of
from millprint.fingerprint.plausible import check_near
from millprint.fingerprint.processes import Told
from millprint.observables.condition import Condition
from millprint.observables.definitions import CURVES, OWN_CURVES, WEIGHTED_BASIC, scaled_quantities

# Columns of a table: the variable that each is, and the factor to its unit.
SETTINGS = {
    "ball_diameter_mm": ("ball_diameter_m", 1e-3),
    "ball_diameter_m": ("ball_diameter_m", 1.0),
    "speed_rpm": ("speed_hz", 1 / 60),
    "speed_hz": ("speed_hz", 1.0),
}
# What a mill has as built.
BUILT = ("density_kg_m3", "amplitude_m")
COLUMNS = (*SETTINGS, *MEASURES, *BUILT)


def conditions_of(table: pd.DataFrame, about: Mapping[str, Any], one: bool = False) -> Condition[np.ndarray]:
    """The conditions (m,) of a table of a mill that a fingerprint is `about`, in SI units.

    one: the table is one condition, whose faults have no row. Raises ConfigError, in one line, for a column that is
    missing or says the same as another, and for a value that is impossible or far from what was simulated.
    """
    place = "condition" if one else "conditions"
    for name in COLUMNS:
        if list(table.columns).count(name) > 1:
            raise ConfigError(f"{place}: {name} appears twice")
    values = {name: pd.to_numeric(table[name], errors="coerce").to_numpy(float) for name in COLUMNS if name in table}
    for names in (("ball_diameter_mm", "ball_diameter_m"), ("speed_rpm", "speed_hz"), MEASURES):
        given = [name for name in names if name in values]
        if len(given) != 1:
            fault = f"{' and '.join(given)} say the same" if given else f"{names[0]} is missing"
            raise ConfigError(f"{place}: {fault}; give one of {', '.join(names)}")

    def fault_of(row: int, name: str, why: str) -> ConfigError:
        return ConfigError(f"{place}:{'' if one else f' row {row + 1}:'} {name} = {table[name].iloc[row]}: {why}")

    for name, own in values.items():
        share, whole = name in ("fill_ratio", "bulk_filling"), name == "number"
        bad = np.flatnonzero(~((own > 0) & (own < (1 if share else np.inf)) & ((own % 1 == 0) | (not whole))))
        if len(bad):
            raise fault_of(bad[0], name, f"must be a {'whole ' * whole}number over 0{' and under 1' * share}")
    built = {name: values.get(name, np.full(len(table), float(about[name]))) for name in BUILT}
    found = {variable: factor * values[name] for name, (variable, factor) in SETTINGS.items() if name in values}
    for end in (np.min, np.max) if len(table) else ():
        check_near(about, speed_rpm=60 * end(found["speed_hz"]), ball_diameter_mm=1e3 * end(found["ball_diameter_m"]))
    measure = next(name for name in MEASURES if name in values)
    volume_ml, diameter_mm = 1e6 * about["volume_m3"], 1e3 * found["ball_diameter_m"]
    fill = fill_from(measure, values[measure], volume_ml, diameter_mm, built["density_kg_m3"])
    for row in np.flatnonzero(fill >= 1)[:1]:
        raise fault_of(row, measure, too_much_words(measure, values[measure][row], fill[row]))
    return Condition(fill_ratio=fill, **found, **built)


# The quantities that are read from curves, from which all others are calculated. The power of the thesis and its parts
# are that power and the ratio of these parts, so that the parts add up to the whole, and their bands do not exceed it;
# rolling and the power of the walls are that power and the ratio of rolling to it.
OF_COLLISIONS = ("P", "ratio", "f", *WEIGHTED_BASIC, *OWN_CURVES)
KNOWN = (*OF_COLLISIONS, "rolling_ratio", "Pw")


@dataclass(frozen=True)
class Prediction:
    """The observables of one condition, each of PREDICTED by its name, as `prediction.wall_power_W`, with its bands.

    `outside` names the variables outside the simulated range, and `no_impacts` where nothing is known of hits, whose
    values are then NaN. missing: why an interval of a further origin (contact parameters, shape of the jar) is None, by
    origin.
    """

    balls: int
    known: Mapping[str, Estimate]
    outside: tuple[str, ...]
    missing: Mapping[str, str]

    def __getattr__(self, name: str) -> Estimate:
        """An observable by its name. Raises AttributeError for one that is not predicted."""
        if name == "known" or name not in self.known:
            raise AttributeError(name)
        return self.known[name]


def bands(table: pd.DataFrame) -> dict[str, Estimate]:
    """The quantities of the first row of a table of `banded`, each with its two bands."""
    row = {name: float(value) for name, value in table.iloc[0].items()}
    found = {}
    for name in CURVES:
        ends = {own: Interval(*(row[column] for column in columns_of(name, own))) for own in ("scatter", "mean")}
        known = {own: each for own, each in ends.items() if not np.isnan(each.lower + each.upper)}
        found[name] = Estimate(row[name], "-").having(known)
    return found


def from_curves(read: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Every scaled quantity [-] from those of KNOWN that have a curve; NaN for what needs one that is missing.

    Pn = P / (1 + ratio), Pt = P - Pn, Pr = rolling_ratio P, Pw = P + Pr. Without a ratio, Pn is read from a curve of
    its own; without a rolling_ratio, as where nothing rolls in some conditions, Pr is what is left of the curve of Pw.
    """
    missing, power = np.full_like(read["P"], np.nan), read["P"]
    normal = power / (1 + read["ratio"]) if "ratio" in read else read.get("Pn", missing)
    basic = {name: read.get(name, missing) for name in ("f", *WEIGHTED_BASIC)}
    found = scaled_quantities({**basic, "Pn": normal, "Pt": power - normal if "ratio" in read else missing})
    if "rolling_ratio" in read:
        rolling = read["rolling_ratio"] * power
    else:
        rolling = np.maximum(read.get("Pw", missing) - power, 0.0)
    own = {name: read.get(name, missing) for name in OWN_CURVES}
    return {**found, **own, "P": power, "Pr": rolling, "Pw": power + rolling, "rolling_ratio": rolling / power}


def _of_part(share: np.ndarray, ends: np.ndarray, whole: np.ndarray) -> np.ndarray:
    """Logarithms (2, m) of the ends of a part's band over its value: below and above.

    share: of the part in the whole (m,); ends: of this share (2, m); whole: half the width of the band of the whole
    (m,). The distances of two independent factors add up in squares, so that no end of a part is beyond the whole.
    """
    return np.array([-1, 1])[:, None] * np.hypot(whole, np.log(ends / share))


def banded(told: Mapping[str, Told], width: float) -> pd.DataFrame:
    """For each quantity: Q, Q_lower and Q_upper of a new simulation, and Q_mean_lower and Q_mean_upper of the mean.

    Ends that are not known are NaN.
    told: logarithms and deviations (m,) of each quantity that has a curve; width: of the bands, in deviations.
    """
    values = from_curves({name: np.exp(own.logs) for name, own in told.items()})
    table: dict[str, np.ndarray] = {}
    for name in CURVES:
        table[name] = values[name]
        for columns, part in ((columns_of(name, "scatter"), "of_new"), (columns_of(name, "mean"), "of_mean")):
            halves = {own: width * getattr(each, part) for own, each in told.items()}
            whole, ratio, share = PARTS.get(name, ("", "", None))
            if share and {whole, ratio} <= told.keys():
                away = np.outer([1, -1] if name == "Pn" else [-1, 1], halves[ratio])
                shares = share(np.vstack([values[ratio] * np.exp(away), values[ratio]]))
                logs = _of_part(shares[2], shares[:2], halves[whole])
            else:
                logs = np.outer([-1, 1], halves.get(name, np.full_like(values[name], np.nan)))
            table |= dict(zip(columns, values[name] * np.exp(known_ends(logs)), strict=True))
    return pd.DataFrame(table)


# Parts of a power -> the whole, and their share in it by a ratio: of tangential to normal, or of rolling to both.
PARTS: dict[str, tuple[str, str, Callable[[np.ndarray], np.ndarray]]] = {
    "Pn": ("P", "ratio", lambda ratio: 1 / (1 + ratio)),
    "Pt": ("P", "ratio", lambda ratio: ratio / (1 + ratio)),
    "Pr": ("Pw", "rolling_ratio", lambda ratio: ratio / (1 + ratio)),
}


def with_parts(found: Mapping[str, Estimate]) -> dict[str, Estimate]:
    """Scaled quantities whose parts of the power have intervals within what that of the power allows."""
    whole, parts = ("Pw", tuple(PARTS)) if np.isfinite(found["Pw"].value) else ("P", ("Pn", "Pt"))
    if not np.isfinite(found["Pt"].value):
        return dict(found)
    return {**found, **parts_of(found[whole], {name: found[name] for name in parts})}
