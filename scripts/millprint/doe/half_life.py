"""Half-life of NaBH4 in water, and so the hydrogen lost before the yield is measured."""


def half_life(ph: float, temperature: float) -> float:
    """Half-life of dissolved NaBH4 by Kreevoy and Jacobson (thesis Eq. 2.7) [s].

    log10(t / min) = pH - (0.034 T - 1.92), T = `temperature` [K].
    """
    return 60.0 * 10.0 ** (ph - (0.034 * temperature - 1.92))
