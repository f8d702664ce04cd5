"""The jars that both codes can express: an upright cylinder and a box, for millprint as flat facets."""

from collections.abc import Iterator
from contextlib import contextmanager
from unittest import mock

import numpy as np

from millprint.mill.vessel import Facet, Vessel


def prism(outline: np.ndarray, height: float, name: str) -> Vessel:
    """The upright prism over a counter-clockwise outline (k, 2) [m], floor at z = 0, `height` [m]."""
    low = np.column_stack([outline, np.zeros(len(outline))])
    high = low + np.array([0.0, 0.0, height])
    sides = [[np.array([low[k], low[k - 1], high[k - 1], high[k]])] for k in range(len(outline))]
    return Vessel([Facet.from_loops(loops) for loops in [*sides, [low], [high[::-1]]]], name)


def cylinder(radius: float, height: float, facets: int) -> Vessel:
    """An upright cylinder of flat facets with their edges on the smooth surface [m]: it lies within the smooth one."""
    angle = 2 * np.pi * np.arange(facets) / facets
    return prism(radius * np.column_stack([np.cos(angle), np.sin(angle)]), height, "cylinder")


def box(length: float, width: float, height: float) -> Vessel:
    """A box centred on the origin in plan [m]."""
    x, y = length / 2, width / 2
    return prism(np.array([[-x, -y], [x, -y], [x, y], [-x, y]]), height, "box")


@contextmanager
def in_vessel(vessel: Vessel | None) -> Iterator[None]:
    """Simulations that are made within the block have this vessel in place of their mill's own; None changes nothing.

    Mills cannot be described as a cylinder or a box; once they can, a mill of that geometry takes this one's place.
    """
    if vessel is None:
        yield
    else:
        with mock.patch("millprint.dem.simulation.build_vessel", lambda mill: vessel):
            yield
