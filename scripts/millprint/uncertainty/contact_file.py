"""The file contact.json: by what factor the contact parameters may change a mill's predictions.

    {"format": "millprint contact uncertainty 1", "mill": "emax", "contact": "calibrated", "probability": 0.95,
     "samples": 128, "parameters": {"restitution": {"kind": "uniform", "low": 0.1, "high": 0.9, "source": "..."}, ...},
     "fill_ratios": [0.06, ...], "factors": {"Pn": {"lower": [0.7, ...], "upper": [1.4, ...]}, ...}}

The factors multiply what the fingerprint of the contact set predicts; one entry for each fill ratio.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from millprint.errors import ConfigError
from millprint.files import read_json, write_json
from millprint.fingerprint.curves import CURVES

FORMAT = "millprint contact uncertainty 1"


@dataclass(frozen=True)
class ContactUncertainty:
    """Intervals of the scaled quantities by contact parameters alone, relative to a fingerprint's own prediction.

    samples: simulations behind it; parameters: by name, the distribution of each as plain values, with its `source`;
    fill_ratios: (m,) rising [-]; lower, upper: by quantity of CURVES, factors (m,) on the prediction [-].
    """

    mill: str
    contact: str
    probability: float
    samples: int
    parameters: dict[str, dict[str, Any]]
    fill_ratios: np.ndarray
    lower: dict[str, np.ndarray]
    upper: dict[str, np.ndarray]

    def write(self, path: str | Path) -> None:
        """Write the file."""
        factors = {name: {"lower": self.lower[name].tolist(), "upper": self.upper[name].tolist()} for name in CURVES}
        plain = {name: getattr(self, name) for name in ("mill", "contact", "probability", "samples", "parameters")}
        write_json({"format": FORMAT, **plain, "fill_ratios": self.fill_ratios.tolist(), "factors": factors}, path)

    @classmethod
    def read(cls, path: str | Path) -> "ContactUncertainty":
        """Read what `write` wrote; raises ConfigError, in one line, for a missing file or one with other content."""
        try:
            content = read_json(path)
        except FileNotFoundError:
            raise ConfigError(
                f"{path}: no such file; `snakemake --cores 2 uncertainty --config mill=NAME` writes it"
            ) from None
        if not isinstance(content, dict) or content.get("format") != FORMAT:
            raise ConfigError(f"{path}: not a file of contact uncertainties: its format must be {FORMAT!r}")
        try:
            fills = _rising(content["fill_ratios"])
            ends = {end: {name: np.array(content["factors"][name][end], float) for name in CURVES} for end in ENDS}
            found = cls(
                str(content["mill"]), str(content["contact"]), float(content["probability"]), int(content["samples"]),
                dict(content["parameters"]), fills, **ends,
            )  # fmt: skip
        except (KeyError, TypeError, ValueError) as error:
            raise ConfigError(f"{path}: not whole: {type(error).__name__} {error}") from None
        for name in CURVES:
            low, high = found.lower[name], found.upper[name]
            if low.shape != fills.shape or high.shape != fills.shape or not np.all((low > 0) & (low <= high)):
                raise ConfigError(
                    f"{path}: factors.{name}: must have a lower and an upper factor above 0 for each of the "
                    f"{len(fills)} fill ratios, the lower no larger than the upper"
                )
        return found

    def at(self, fill_ratio: float | np.ndarray) -> dict[str, tuple[np.ndarray, np.ndarray]]:
        """Lower and upper factor of each quantity at fill ratios, of their shape.

        In between, logarithms of factors are interpolated over the logarithm of the fill ratio. Beyond the fill ratios
        of the file the factors of the nearest one are returned; `covers` tells.
        """
        place, known = np.log(np.asarray(fill_ratio, dtype=float)), np.log(self.fill_ratios)

        def between(factors: np.ndarray) -> np.ndarray:
            return np.exp(np.interp(place, known, np.log(factors)))

        return {name: (between(self.lower[name]), between(self.upper[name])) for name in CURVES}

    def covers(self, fill_ratio: float) -> bool:
        """Whether a fill ratio lies within those of the file."""
        return bool(self.fill_ratios[0] * (1 - 1e-9) <= fill_ratio <= self.fill_ratios[-1] * (1 + 1e-9))


ENDS = ("lower", "upper")


def _rising(values: list[float]) -> np.ndarray:
    found = np.array(values, dtype=float)
    if found.ndim != 1 or not found.size or not np.all(np.diff(found, prepend=0.0) > 0):
        raise ValueError(f"fill_ratios = {values}: must rise, above 0")
    return found
