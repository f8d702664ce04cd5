"""What a surrogate makes of balls that lie still in a jar that stands still: nothing, if it is right."""

import numpy as np

from millprint.surrogate import measures
from millprint.surrogate.series import Series


def rest_measures(series: Series, driven_W: float) -> dict[str, float]:
    """Energy from nothing, as a share of what the driven jar dissipates in that time [%], and the highest lift [m].

    Energy shows as dissipation, of either sign, and as motion: the largest mean square speed in any frame is given too.
    """
    with np.errstate(over="ignore", invalid="ignore"):
        span = np.abs(np.diff(series.cumulative_J, axis=0)).sum(axis=0).mean()
        fastest = (series.speed() ** 2).mean(axis=(1, 2)).max()
        share = 100 * span / (driven_W * series.time_s[-1])
    return {
        "rest_dissipation_share_percent": float(share) if np.isfinite(share) else np.inf,
        "rest_highest_lift_m": measures.highest_lift(series.position_m),
        "rest_rms_speed_max_m_s": float(np.sqrt(fastest)) if np.isfinite(fastest) else np.inf,
    }
