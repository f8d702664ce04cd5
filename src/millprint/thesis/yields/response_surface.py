"""The response surface that chapter 2 suggests, as a baseline: six parameters on the logit of the yield.

    logit y = b0 + b1 R + b2 m + b3 m^2 + b4 ln t + b5 R m + e,
ball-to-powder ratio R, molar ratio m, time t: what Fig. 2.3 and Fig. 2.4 show, and nothing of the mill. It is fitted by
least squares (Box and Draper, Response Surfaces, Mixtures, and Ridge Analyses, 2nd ed. (2007), ch. 3), so that nothing
is searched and no choice is made from yields.
"""

from dataclasses import dataclass

import numpy as np
import pandas as pd

from millprint.estimate.quantiles import student_quantile
from millprint.thesis.yields.averaging import LINKS, expected_conversion, to_conversion
from millprint.thesis.yields.features import CHEMICAL

LINK = "logit"


def design(rows: pd.DataFrame) -> np.ndarray:
    """The terms of the surface (n, 6) for rows with bpr, molar_ratio [-] and time_h [h]."""
    ratio, molar, time = (rows[name].to_numpy(float) for name in CHEMICAL)
    return np.column_stack([np.ones(len(rows)), ratio, molar, molar**2, np.log(time), ratio * molar])


@dataclass(frozen=True)
class ResponseSurface:
    """A fitted surface: coefficients (6,), (X'X)^-1 (6, 6), residual standard deviation, and degrees of freedom."""

    coefficients: np.ndarray
    inverse: np.ndarray
    residual: float
    freedom: int

    def latent(self, rows: pd.DataFrame) -> tuple[np.ndarray, np.ndarray]:
        """Mean and standard deviation of the logit of a new measurement, (n,) each: s^2 (1 + x' (X'X)^-1 x)."""
        terms = design(rows)
        spread = np.sqrt(1 + np.einsum("ij,jk,ik->i", terms, self.inverse, terms))
        return terms @ self.coefficients, self.residual * spread

    def predict(self, rows: pd.DataFrame) -> np.ndarray:
        """Mean yields (n,) [%], as of the averaged process: over the distribution of the logit."""
        return 100 * expected_conversion(LINK, *self.latent(rows))

    def intervals(self, rows: pd.DataFrame, levels: list[float]) -> np.ndarray:
        """Ends (n, levels, 2) [%] of the prediction intervals by Student's t."""
        mean, deviation = self.latent(rows)
        half = student_quantile(0.5 + np.asarray(levels) / 2, self.freedom) * deviation[:, None]
        return 100 * LINKS[LINK].inverse(np.stack([mean[:, None] - half, mean[:, None] + half], axis=2))


def fit_surface(rows: pd.DataFrame, yields: np.ndarray, margin: float) -> ResponseSurface:
    """The surface of rows with the conditions and yields (n,) [%], n > 6; margin: as of `to_conversion`."""
    terms, target = design(rows), LINKS[LINK].forward(to_conversion(yields, margin))
    coefficients = np.linalg.lstsq(terms, target, rcond=None)[0]
    freedom, errors = len(target) - terms.shape[1], target - terms @ coefficients
    return ResponseSurface(
        coefficients, np.linalg.pinv(terms.T @ terms), float(np.sqrt(errors @ errors / freedom)), freedom
    )
