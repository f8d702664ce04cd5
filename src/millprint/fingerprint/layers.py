"""Where nothing is known of hits: around conditions in which balls go round with the wall, or rest, as one layer."""

import numpy as np

from millprint.fingerprint.processes import SAME


def around(values: np.ndarray, asked: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The places (m,) of the neighbours of asked (m,) among rising values (n,): below and above, or the end."""
    last = len(values) - 1
    below = np.searchsorted(values, asked + SAME, side="right") - 1
    return np.clip(below, 0, last), np.clip(np.searchsorted(values, asked - SAME), 0, last)


def are_near_layers(asked: np.ndarray, hits: np.ndarray, layers: np.ndarray) -> np.ndarray:
    """Whether a condition without impacts is among the simulated conditions around each of those asked (m,).

    asked (m, k), hits (n, k), layers (j, k): inputs of a process, of conditions with and without impacts. Around a
    condition are the settings between its neighbouring values of each variable but the fill ratio, and in each of them
    the fill ratios next to its own: between a layer and the next fill ratio with impacts, hits begin anywhere.
    """
    found = np.zeros(len(asked), dtype=bool)
    if not len(layers):
        return found
    rows, is_layer = np.vstack([hits, layers]), np.repeat([False, True], [len(hits), len(layers)])
    settings, own = np.unique(rows[:, 1:].round(6), axis=0, return_inverse=True)
    is_around = np.ones((len(asked), len(settings)), dtype=bool)
    for column, values in zip(asked[:, 1:].T, settings.T, strict=True):
        known = np.unique(values)
        below, above = around(known, column)
        is_around &= (known[below][:, None] <= values) & (values <= known[above][:, None])
    for setting in range(len(settings)):
        rising = np.flatnonzero(own.ravel() == setting)
        rising = rising[np.argsort(rows[rising, 0])]
        below, above = around(rows[rising, 0], asked[:, 0])
        found |= is_around[:, setting] & (is_layer[rising[below]] | is_layer[rising[above]])
    return found
