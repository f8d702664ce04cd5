"""The operational zones of a mill, found from its curves with their uncertainty (thesis Secs 3.3.2, 3.3.3)."""

import numpy as np
import pandas as pd

from millprint.fingerprint.model import Fingerprint

ZONE_CURVES = ("Pn", "Pt", "ratio")
POINTS, SAMPLES = 120, 500
COLUMNS = ["contact", "zone", "value", "lower", "upper", "found", "smallest", "largest"]


def elbow(fill_ratio: np.ndarray, ratio: np.ndarray) -> float:
    """Fill ratio at the elbow of a falling curve: farthest below the line from its top to the lowest point after it.

    A rise before the top is left out. Both arrays have one dimension and the same length; NaN if the curve does not
    fall.
    """
    top = int(np.argmax(ratio))
    bottom = top + int(np.argmin(ratio[top:]))
    if bottom - top < 2:
        return float("nan")
    fill_ratio, ratio = fill_ratio[top : bottom + 1], ratio[top : bottom + 1]
    across = (fill_ratio - fill_ratio[0]) / (fill_ratio[-1] - fill_ratio[0])
    chord = ratio[0] + across * (ratio[-1] - ratio[0])
    return float(fill_ratio[np.argmax(chord - ratio)])


def choking(fill_ratio: np.ndarray, normal: np.ndarray, tangential: np.ndarray) -> float:
    """Fill ratio beyond which neither power per ball exceeds 90 % of its largest value; NaN if one still does."""
    low = (normal < 0.9 * normal.max()) & (tangential < 0.9 * tangential.max())
    still = np.flatnonzero(~low)
    return float(fill_ratio[still[-1] + 1]) if still[-1] + 1 < fill_ratio.size else float("nan")


def zones_of(fill: np.ndarray, normal: np.ndarray, tangential: np.ndarray, ratio: np.ndarray) -> dict[str, float]:
    """Elbow, fill ratios of the largest powers, choking [-], and the ratio at the elbow and its ends [-]."""
    bend = elbow(fill, ratio)
    return {
        "elbow": bend,
        "normal_maximum": float(fill[np.argmax(normal)]),
        "tangential_maximum": float(fill[np.argmax(tangential)]),
        "choking": choking(fill, normal, tangential),
        "ratio_at_elbow": float(np.interp(bend, fill, ratio)) if np.isfinite(bend) else float("nan"),
        "ratio_largest": float(ratio.max()),
        "ratio_smallest": float(ratio.min()),
    }


def _curves(fingerprint: Fingerprint, quantity: str, fills: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Log curves over the fills: of each setting (j, m), and the mean over the settings with SAMPLES draws of it."""
    inputs = fingerprint.at_settings(fills)
    mean, covariance = fingerprint.predictors[quantity].joint(inputs)
    settings = len(inputs) // fills.size
    average = np.kron(np.eye(fills.size), np.full(settings, 1.0 / settings))
    centre = average @ mean
    generator = np.random.default_rng(0)
    drawn = generator.multivariate_normal(centre, average @ covariance @ average.T, size=SAMPLES, method="eigh")
    return mean.reshape(fills.size, settings).T, np.vstack([centre, drawn])


def _zones_of_all(fills: np.ndarray, curves: dict[str, np.ndarray]) -> pd.DataFrame:
    lines = zip(*(np.exp(curves[name]) for name in ZONE_CURVES), strict=True)
    return pd.DataFrame([zones_of(fills, *line) for line in lines])


def find_zones(fingerprint: Fingerprint) -> pd.DataFrame:
    """The zones with intervals: columns contact, zone, value, lower, upper, found, smallest, largest.

    `value` is from the curves averaged over the simulated speeds and ball sizes. `lower` and `upper` hold the
    fingerprint's probability of such curves drawn from the processes; `found` is the share of the drawn curves that
    have the zone at all. `smallest` and `largest` are over single speeds and ball sizes. The fill ratios of a zone are
    on a grid within the simulated ones, so the true maximum may be beyond an end of the grid. Powers and ratio each
    come from a separate process. There is no row where one of the three has no curve.
    """
    if not set(ZONE_CURVES) <= fingerprint.predictors.keys():
        return pd.DataFrame(columns=COLUMNS)
    fills = np.geomspace(*fingerprint.fill_range, POINTS)
    pairs = {name: _curves(fingerprint, name, fills) for name in ZONE_CURVES}
    single = _zones_of_all(fills, {name: pair[0] for name, pair in pairs.items()})
    average = _zones_of_all(fills, {name: pair[1] for name, pair in pairs.items()})
    tail = 0.5 - 0.5 * fingerprint.about["probability"]
    drawn = average.iloc[1:]
    found = drawn.notna().mean()
    is_common = found >= 0.5
    return pd.DataFrame(
        {
            "contact": fingerprint.about["contact"],
            "zone": average.columns,
            "value": average.iloc[0].to_numpy(),
            "lower": drawn.quantile(tail).where(is_common).to_numpy(),
            "upper": drawn.quantile(1.0 - tail).where(is_common).to_numpy(),
            "found": found.to_numpy(),
            "smallest": single.min().to_numpy(),
            "largest": single.max().to_numpy(),
        }
    )
