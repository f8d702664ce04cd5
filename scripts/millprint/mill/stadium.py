"""The stadium jar as flat facets: outlines of the lid, the walls, the fillet, the floor and the post."""

import itertools

import numpy as np

from millprint.config.mill import StadiumGeometry


def stadium_outline(end_radius: float, straight: float, facets: int) -> np.ndarray:
    """Vertices (2 facets + 2, 2) of a stadium, counter-clockwise; the long side runs along x, all in one unit."""
    angle = np.linspace(-np.pi / 2, np.pi / 2, facets + 1)
    end = end_radius * np.column_stack([np.cos(angle), np.sin(angle)])
    shift = np.array([straight / 2, 0.0])
    return np.concatenate([end + shift, -end - shift])


def _rings(geometry: StadiumGeometry) -> list[np.ndarray]:
    """Horizontal outlines (k, 3) [m] of the jar's side from the lid down to the floor."""
    radius, straight = geometry.end_radius_mm / 1e3, geometry.straight_mm / 1e3
    fillet, height = geometry.fillet_radius_mm / 1e3, geometry.height_mm / 1e3
    levels = [(0.0, height)]
    if fillet:
        angle = np.linspace(0, np.pi / 2, geometry.fillet_facets + 1)
        levels += [(fillet * (1 - np.cos(a)), fillet * (1 - np.sin(a))) for a in angle]
    else:
        levels += [(0.0, 0.0)]
    rings = []
    for inset, z in levels:
        outline = stadium_outline(radius - inset, straight, geometry.facets_per_half_circle)
        rings.append(np.column_stack([outline, np.full(len(outline), z)]))
    return rings


def stadium_facets(geometry: StadiumGeometry) -> list[list[np.ndarray]]:
    """Outlines [m] of every facet, a list of loops each, counter-clockwise seen from inside the jar.

    The round ends and the fillet have their vertices on the smooth surface. Floor at z = 0, centred on the origin.
    """
    rings = _rings(geometry)
    facets = []
    for upper, lower in itertools.pairwise(rings):
        for k in range(len(upper)):
            following = (k + 1) % len(upper)
            facets.append([np.array([upper[k], upper[following], lower[following], lower[k]])])
    floor, lid = [rings[-1]], [rings[0][::-1]]
    if geometry.post:
        angle = 2 * np.pi * np.arange(geometry.post.facets) / geometry.post.facets
        ring = geometry.post.radius_mm / 1e3 * np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])
        top = ring + np.array([0.0, 0.0, geometry.height_mm / 1e3])
        floor.append(ring[::-1])
        lid.append(top)
        for k in range(len(ring)):
            following = (k + 1) % len(ring)
            facets.append([np.array([ring[k], ring[following], top[following], top[k]])])
    return [*facets, floor, lid]
