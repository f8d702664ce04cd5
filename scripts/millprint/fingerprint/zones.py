"""The operational zones of a mill, found from its curves (thesis Secs 3.3.2, 3.3.3)."""

import numpy as np
import pandas as pd


def elbow(fill_ratio: np.ndarray, ratio: np.ndarray) -> float:
    """Fill ratio at which a curve's fall turns: farthest below the line from its top to the lowest point after it.

    A rise before the top is left out. Both arrays are flat, of one length; NaN if the curve does not fall.
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


def find_zones(smooth: pd.DataFrame) -> dict[str, float]:
    """Elbow, fill ratios of the largest powers, choking, and the ends of the ratio [-], from smooth curves."""
    fill, normal = smooth["fill_ratio"].to_numpy(), smooth["Pn"].to_numpy()
    tangential, ratio = smooth["Pt"].to_numpy(), smooth["ratio"].to_numpy()
    return {
        "elbow_fill_ratio": elbow(fill, ratio),
        "normal_max_fill_ratio": float(fill[np.argmax(normal)]),
        "tangential_max_fill_ratio": float(fill[np.argmax(tangential)]),
        "choking_fill_ratio": choking(fill, normal, tangential),
        "ratio_max": float(ratio.max()),
        "ratio_min": float(ratio.min()),
    }
