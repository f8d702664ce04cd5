"""Half-life of NaBH4 in water, and so the hydrogen lost before the yield is measured."""

import numpy as np


def half_life(ph: np.ndarray | float, temperature: np.ndarray | float) -> np.ndarray | float:
    """Half-life of dissolved NaBH4 by Kreevoy and Jacobson (thesis Eq. 2.7) [s].

    log10(t / min) = pH - (0.034 T - 1.92), T = `temperature` [K].
    """
    return 60.0 * 10.0 ** (ph - (0.034 * temperature - 1.92))


def share_lost(time: np.ndarray | float, half_life_s: np.ndarray | float) -> np.ndarray | float:
    """Share of the NaBH4 that has decomposed after `time` [s], by first order: 1 - 2^(-t / t_half) [-]."""
    return -np.expm1(-np.log(2.0) * time / half_life_s)
