"""The stadium jar as flat facets: outlines of the lid, the walls, the fillet, the floor and the post."""

import numpy as np

from millprint.config.geometry import StadiumGeometry
from millprint.mill.loft import fillet_profile, loft


def stadium_outline(end_radius: float, straight: float, facets: int, unevenness: float = 0.0) -> np.ndarray:
    """Vertices (2 facets + 2, 2) of a stadium, counter-clockwise; the long side runs along x, all in one unit.

    Facets of a round end are by turns 1 + unevenness and 1 - unevenness times as wide as the mean. Each end begins
    with a wide one, so that half a turn brings the outline onto itself.
    """
    widths = 1.0 + unevenness * (-1.0) ** np.arange(facets)
    angle = np.pi * (np.concatenate([[0.0], np.cumsum(widths)]) / widths.sum() - 0.5)
    end = end_radius * np.column_stack([np.cos(angle), np.sin(angle)])
    shift = np.array([straight / 2, 0.0])
    return np.concatenate([end + shift, -end - shift])


def stadium_facets(geometry: StadiumGeometry) -> list[list[np.ndarray]]:
    """Outlines [m] of every facet, a list of loops each, counter-clockwise seen from inside the jar.

    The round ends and the fillet have their vertices on the smooth surface. Floor at z = 0, centred on the origin.
    """
    radius, straight, height = geometry.end_radius_mm / 1e3, geometry.straight_mm / 1e3, geometry.height_mm / 1e3
    rings = []
    for inset, z in fillet_profile(height, geometry.fillet_radius_mm / 1e3, geometry.fillet_facets, "bottom"):
        outline = stadium_outline(radius - inset, straight, geometry.facets_per_half_circle, geometry.facet_unevenness)
        rings.append(np.column_stack([outline, np.full(len(outline), z)]))
    *facets, floor, lid = loft(rings)
    if geometry.post:
        angle = 2 * np.pi * np.arange(geometry.post.facets) / geometry.post.facets
        ring = geometry.post.radius_mm / 1e3 * np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])
        top = ring + np.array([0.0, 0.0, height])
        floor.append(ring[::-1])
        lid.append(top)
        for k in range(len(ring)):
            following = (k + 1) % len(ring)
            facets.append([np.array([ring[k], ring[following], top[following], top[k]])])
    return [*facets, floor, lid]
