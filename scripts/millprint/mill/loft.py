"""Shapes made of rings: outlines stacked from the top down, with flat facets between them and a cap at each end."""

import itertools

import numpy as np


def fillet_profile(height: float, fillet: float, facets: int, ends: str) -> list[tuple[float, float]]:
    """Insets from the side and levels of the rings, from the top at `height` down to 0, all in one unit.

    ends: "none", "bottom" or "both", the ends whose edge is rounded with the radius `fillet` in `facets` steps. The
    rings lie on the smooth fillet.
    """
    angle = np.linspace(0, np.pi / 2, facets + 1)
    rounded = [(fillet * (1 - np.cos(a)), fillet * (1 - np.sin(a))) for a in angle]
    lower = rounded if fillet and ends in ("bottom", "both") else [(0.0, 0.0)]
    upper = [(inset, height - level) for inset, level in rounded[::-1]] if fillet and ends == "both" else []
    levels = [*upper, *lower] if upper else [(0.0, height), *lower]
    # A sphere, or a cup as deep as its fillet, has no straight part between the rounded ones.
    return [levels[0], *(low for high, low in itertools.pairwise(levels) if high[1] - low[1] > 1e-12 * height)]


def loft(rings: list[np.ndarray]) -> list[list[np.ndarray]]:
    """Facets between rings (k, 3), from the top down, each counter-clockwise seen from above; then floor and lid.

    A facet is a list of loops, counter-clockwise seen from inside. A ring of a single point closes an end with
    triangles, and that end has no cap.
    """
    facets = []
    for upper, lower in itertools.pairwise(rings):
        for k in range(max(len(upper), len(lower))):
            following = (k + 1) % max(len(upper), len(lower))
            if len(lower) == 1:
                corners = [upper[k], upper[following], lower[0]]
            elif len(upper) == 1:
                corners = [upper[0], lower[following], lower[k]]
            else:
                corners = [upper[k], upper[following], lower[following], lower[k]]
            facets.append([np.array(corners)])
    if len(rings[-1]) > 1:
        facets.append([rings[-1]])
    if len(rings[0]) > 1:
        facets.append([rings[0][::-1]])
    return facets
