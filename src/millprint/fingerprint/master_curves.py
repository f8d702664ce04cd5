"""Master curves: scaled quantities against fill ratio, averaged over speeds and ball sizes."""

import numpy as np
import pandas as pd

from millprint.config.errors import ConfigError
from millprint.fingerprint.condition import COUNTED, SCALED_BY, universal_factor

# Scaled quantities with a master curve: the four panels of thesis Fig. 3.12, then those for predictions.
PANELS = ("Pn", "Pt", "f", "ratio")
# The panels of a mill's sheet.
SHEET_PANELS = ("Pn", "Pt", "En_star", "Et_star")
# The panels of the energy-weighted descriptors.
WEIGHTED = tuple(name for name in SCALED_BY.values() if name not in COUNTED)
CURVES = (*PANELS, "P", "En", "Et", *WEIGHTED)
CURVE_COLUMNS = [
    "fill_ratio",
    *(f"{name}{end}" for name in dict.fromkeys((*PANELS, *SHEET_PANELS)) for end in ("", "_lower", "_upper")),
]


def conditions_of(descriptors: pd.DataFrame, mill: str, contact: str) -> pd.DataFrame:
    """The conditions of one mill and contact set; raises ConfigError if there are none."""
    chosen = descriptors[(descriptors["mill"] == mill) & (descriptors["contact"] == contact)]
    if chosen.empty:
        raise ConfigError(f"sweeps: no simulation of mill {mill} with contact set {contact}; add one to a sweep")
    return chosen


def _pooled_spread(groups: list[np.ndarray]) -> float:
    """Relative spread of a quantity between conditions, over all fill ratios that have several; NaN if none has."""
    squares, freedom = 0.0, 0
    for values in groups:
        squares += float(((values / values.mean() - 1.0) ** 2).sum())
        freedom += len(values) - 1
    return float(np.sqrt(squares / freedom)) if freedom else float("nan")


def average_curves(descriptors: pd.DataFrame) -> pd.DataFrame:
    """Mean and spread of every quantity at each simulated fill ratio (thesis Figs 3.11, 3.12).

    `Q_lower` and `Q_upper` are the mean minus and plus one standard deviation between speeds and ball sizes. A fill
    ratio with one condition takes the relative deviation pooled over the other fill ratios or, if no fill ratio has
    two conditions, the run's own standard error.
    """
    by_fill = sorted(descriptors.groupby("fill_ratio").indices.items())
    rows = [{"fill_ratio": fill} for fill, _ in by_fill]
    for quantity in CURVES:
        values = descriptors[quantity].to_numpy()
        groups = [values[at] for _, at in by_fill]
        for row, group, (_, at) in zip(rows, groups, by_fill, strict=True):
            mean = group.mean()
            spread = group.std(ddof=1) if len(group) > 1 else mean * _pooled_spread(groups)
            if np.isnan(spread):
                spread = descriptors[f"{quantity}_se"].iloc[at[0]]
            row |= {quantity: mean, f"{quantity}_lower": mean - spread, f"{quantity}_upper": mean + spread}
    return pd.DataFrame([row | {"conditions": len(at)} for row, (_, at) in zip(rows, by_fill, strict=True)])


def at_shared_fills(descriptors: pd.DataFrame) -> pd.DataFrame:
    """The conditions at the fill ratios that every contact set has, where sets can be compared or averaged."""
    sets = descriptors.groupby("fill_ratio")["contact"].nunique()
    return descriptors[descriptors["fill_ratio"].isin(sets[sets == descriptors["contact"].nunique()].index)]


def universal_descriptors(descriptors: pd.DataFrame) -> pd.DataFrame:
    """Descriptors with powers and frequency times (1 - eps)^(1/2) (Eqs 3.31, 3.32); energies and ratio stay."""
    scaled = descriptors.copy()
    factor = universal_factor(scaled["effective_restitution"])
    rates = [quantity for name, quantity in SCALED_BY.items() if name.endswith("_hz")]
    for quantity in ("Pn", "Pt", "P", *rates):
        scaled[quantity] *= factor
        scaled[f"{quantity}_se"] *= factor
    return scaled


def fill_grid(fill_ratios: np.ndarray, points: int) -> np.ndarray:
    """Points from the smallest to the largest fill ratio, with the simulated ones among them."""
    between = np.geomspace(fill_ratios.min(), fill_ratios.max(), points)
    apart = np.abs(between[:, None] / fill_ratios - 1.0).min(axis=1) > 1e-6
    return np.union1d(between[apart], fill_ratios)
