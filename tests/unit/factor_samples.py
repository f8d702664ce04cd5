"""Synthetic files of factors: what an analysis of contact parameters, or of a jar's shape, writes of a mill."""

from millprint.fingerprint.bands import FILES
from millprint.observables.definitions import CURVES

FACTOR_FILLS = (0.06, 0.12, 0.30)


def factors_of(origin: str = "contact", **changes) -> dict:
    """The content of a file of factors; each quantity has its own, which widen with the fill ratio."""
    steps = {name: 0.02 * (place + 1) for place, name in enumerate(CURVES)}
    return {
        "format": FILES[origin].model_fields["format"].annotation.__args__[0],
        "mill": "emax",
        "contact": "calibrated",
        "counting_rule": "gap_0_03",
        "probability": 0.95,
        "samples": 128,
        "parameters": {"restitution": {"low": 0.2, "high": 0.5, "source": "a handbook"}},
        "fill_ratios": list(FACTOR_FILLS),
        "factors": {
            name: {
                "lower": [1 / (1 + step * (1 + k)) for k in range(len(FACTOR_FILLS))],
                "upper": [1 + 2 * step * (1 + k) for k in range(len(FACTOR_FILLS))],
            }
            for name, step in steps.items()
        },
    } | changes
