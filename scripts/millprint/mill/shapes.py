"""Cylinders, boxes and stirrers as flat facets, seen from inside: the walls of a hollow, or a solid turned over."""

import numpy as np

from millprint.config.geometry import BoxGeometry, CylinderGeometry, PaddlesGeometry
from millprint.mill.loft import fillet_profile, loft

# Columns that bring a shape built along z to lie along an axis: cyclic, so that no shape is mirrored.
_ALONG = {"x": [2, 0, 1], "y": [1, 2, 0], "z": [0, 1, 2]}

Loops = list[np.ndarray]


def _level(outline: np.ndarray, z: float) -> np.ndarray:
    return np.column_stack([outline, np.full(len(outline), z)])


def _circle(radius: float, facets: int) -> np.ndarray:
    angle = 2 * np.pi * np.arange(facets) / facets
    return radius * np.column_stack([np.cos(angle), np.sin(angle)])


def cylinder_facets(geometry: CylinderGeometry) -> list[Loops]:
    """Outlines [m] of every facet, a list of loops each, counter-clockwise seen from inside."""
    radius, height, fillet = geometry.radius_mm / 1e3, geometry.height_mm / 1e3, geometry.fillet_radius_mm / 1e3
    rings = []
    for inset, z in fillet_profile(height, fillet, geometry.fillet_facets, geometry.fillet_ends):
        # The last ring of a half sphere is its pole.
        is_pole = radius - inset < 1e-9 * radius
        rings.append(np.array([[0.0, 0.0, z]]) if is_pole else _level(_circle(radius - inset, geometry.facets), z))
    centre = [0.0, 0.0, height / 2] if geometry.axis == "z" else [0.0, 0.0, 0.0]
    if geometry.centre_mm is not None:
        centre = [value / 1e3 for value in geometry.centre_mm]
    order, half = _ALONG[geometry.axis], np.array([0.0, 0.0, height / 2])
    return [[(loop - half)[:, order] + centre for loop in facet] for facet in loft(rings)]


def box_facets(geometry: BoxGeometry) -> list[Loops]:
    """Outlines [m] of the six facets, counter-clockwise seen from inside."""
    half = np.array([geometry.x_mm, geometry.y_mm, geometry.z_mm]) / 2e3
    centre = np.array([0.0, 0.0, half[2]]) if geometry.centre_mm is None else np.array(geometry.centre_mm) / 1e3
    outline = half[:2] * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    return [[loop + centre for loop in facet] for facet in loft([_level(outline, half[2]), _level(outline, -half[2])])]


def paddles_outline(geometry: PaddlesGeometry) -> np.ndarray:
    """Vertices (k, 2) [m] of hub and blades, counter-clockwise; the first blade points along x."""
    hub, half = geometry.hub_radius_mm / 1e3, geometry.blade_thickness_mm / 2e3
    tip = hub + geometry.blade_length_mm / 1e3
    pitch, root = 2 * np.pi / geometry.blades, np.arcsin(half / hub)
    arcs = max(1, round(geometry.hub_facets * (pitch - 2 * root) / (2 * np.pi)))
    # One blade's tip and the hub from there to just before the next blade.
    arc = np.linspace(root, pitch - root, arcs + 1)
    piece = np.concatenate([[[tip, -half], [tip, half]], hub * np.column_stack([np.cos(arc), np.sin(arc)])])
    turned = []
    for blade in range(geometry.blades):
        cosine, sine = np.cos(blade * pitch), np.sin(blade * pitch)
        turned.append(piece @ np.array([[cosine, sine], [-sine, cosine]]))
    return np.concatenate(turned)


def paddles_facets(geometry: PaddlesGeometry) -> list[Loops]:
    """Outlines [m] of every facet, counter-clockwise seen from inside the solid."""
    outline, bottom = paddles_outline(geometry), geometry.bottom_mm / 1e3
    return loft([_level(outline, bottom + geometry.height_mm / 1e3), _level(outline, bottom)])
