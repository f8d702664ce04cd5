"""Cylinders, boxes and stirrers by parameters: closed, of the right volume and place, hollow or solid."""

from typing import Literal

import numpy as np
import pytest
import trimesh
from pydantic import TypeAdapter

from millprint.config.errors import ConfigError
from millprint.config.mill import GeometrySection, SolidGeometry, VesselGeometry
from millprint.mill import shapes
from millprint.mill.borders import borders_of
from millprint.mill.distance import SignedDistance
from millprint.mill.outlines import Facet, facets_of
from millprint.mill.vessel import LATTICE, Vessel, drawn_shape, shape_curves
from millprint.mill.wall_features import features_of

CAPSULE = {"kind": "cylinder", "radius_mm": 10, "height_mm": 45, "fillet_radius_mm": 10, "fillet_ends": "both"}
STIRRER = {
    "kind": "paddles", "hub_radius_mm": 10, "blades": 4, "blade_length_mm": 30, "blade_thickness_mm": 5,
    "height_mm": 60, "bottom_mm": 15,
}  # fmt: skip
SHAPES = {
    "jar": {"kind": "cylinder", "radius_mm": 20, "height_mm": 50},
    "cup": {"kind": "cylinder", "radius_mm": 20, "height_mm": 50, "fillet_radius_mm": 6, "fillet_facets": 3},
    "round cup": {"kind": "cylinder", "radius_mm": 20, "height_mm": 50, "fillet_radius_mm": 20},
    "drum": {"kind": "cylinder", "radius_mm": 80, "height_mm": 30, "axis": "y", "facets": 60},
    "mixer": {**CAPSULE, "axis": "x"},
    "ball": {**CAPSULE, "height_mm": 20, "axis": "y"},
    "lens": {**CAPSULE, "height_mm": 10, "fillet_radius_mm": 5},
    "moved": {**CAPSULE, "axis": "x", "centre_mm": [5, -7, 30]},
    "box": {"kind": "box", "x_mm": 10, "y_mm": 20, "z_mm": 30},
}


def vessel(shape: dict, **changes) -> Vessel:
    geometry = TypeAdapter(VesselGeometry).validate_python({**shape, **changes})
    return Vessel(facets_of(drawn_shape(geometry, "mill.yaml: geometry", solid=False)[0]))


def solid(shape: dict, **changes) -> Vessel:
    geometry = TypeAdapter(SolidGeometry).validate_python({**shape, **changes})
    return Vessel(facets_of(drawn_shape(geometry, "mill.yaml: geometry", solid=True)[0]), solid=True)


@pytest.mark.slow
@pytest.mark.parametrize("name", SHAPES)
def test_a_hollow_is_watertight_and_smooth_ones_are_convex(name):
    made = vessel(SHAPES[name])
    mesh = trimesh.Trimesh(*made.triangles(), process=False)
    assert mesh.is_watertight
    assert mesh.is_winding_consistent
    assert -mesh.volume == pytest.approx(made.volume_m3, rel=1e-9)
    assert not features_of(made).lines
    flat = [np.ptp(loop @ facet.normal) for facet in made.facets for loop in facet.loops]
    assert max(flat) < 3 * LATTICE * made.size


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "volume_mm3"),
    [
        ("jar", np.pi * 20**2 * 50),
        ("round cup", np.pi * 20**2 * 30 + np.pi * 2 / 3 * 20**3),
        ("drum", np.pi * 80**2 * 30),
        ("mixer", np.pi * 10**2 * 25 + np.pi * 4 / 3 * 10**3),
        ("ball", np.pi * 4 / 3 * 10**3),
        ("moved", np.pi * 10**2 * 25 + np.pi * 4 / 3 * 10**3),
        ("box", 6000),
    ],
)
def test_volume_tends_to_that_of_the_smooth_shape(name, volume_mm3):
    """The facets lie inside the smooth shape, and what they leave out falls with their number squared."""
    if name == "box":
        assert vessel(SHAPES[name]).volume_m3 * 1e9 == pytest.approx(volume_mm3)
        return
    coarse, fine = (
        1 - vessel(SHAPES[name], facets=4 * k, fillet_facets=k).volume_m3 * 1e9 / volume_mm3 for k in (10, 20)
    )
    assert 0 < fine < 0.01
    assert coarse / fine == pytest.approx(4, rel=0.02)


@pytest.mark.parametrize(
    ("name", "low", "high"),
    [
        ("jar", [-20, -20, 0], [20, 20, 50]),
        ("drum", [-80, -15, -80], [80, 15, 80]),
        ("mixer", [-22.5, -10, -10], [22.5, 10, 10]),
        ("moved", [-17.5, -17, 20], [27.5, 3, 40]),
        ("box", [-5, -10, 0], [5, 10, 30]),
    ],
)
def test_where_a_shape_lies(name, low, high):
    assert vessel(SHAPES[name]).bounds * 1e3 == pytest.approx(np.array([low, high]))


def test_the_bottom_of_a_lying_cup_is_towards_the_negative_side():
    points = vessel(SHAPES["round cup"], axis="x").vertices
    assert np.hypot(points[:, 1], points[:, 2])[points[:, 0] < -0.0249].max() < 1e-9
    assert np.hypot(points[:, 1], points[:, 2])[points[:, 0] > 0.0249].min() > 0.0199


@pytest.mark.parametrize("name", ["drum", "moved", "box"])
def test_a_solid_is_the_hollow_turned_over(name):
    hollow, body = vessel(SHAPES[name]), solid(SHAPES[name])
    assert body.volume_m3 == pytest.approx(-hollow.volume_m3)
    borders = borders_of(hollow)
    assert len(features_of(body).lines) == (~borders.is_drawn).sum()
    assert len(features_of(body).rims) == len(borders.rims)


def test_facets_that_are_open_or_the_wrong_side_out_are_refused():
    facets = [Facet(f.normal, f.offset, f.loops) for f in vessel(SHAPES["box"]).facets]
    with pytest.raises(ConfigError, match="inside out"):
        Vessel(facets, solid=True)
    with pytest.raises(ConfigError, match="open"):
        Vessel(facets[:-1])


def beyond(*ways: np.ndarray) -> np.ndarray:
    """Distance from a product of bodies, such as a disc and a line, of which a point is these ways outside of each."""
    out = np.array(ways)
    return np.linalg.norm(np.maximum(out, 0), axis=0) + np.minimum(out.max(axis=0), 0)


def cup(at: np.ndarray) -> np.ndarray:
    """Distance from SHAPES["cup"], whose lower edge is rounded."""
    out, up = np.hypot(*at[:2]) - 20, np.abs(at[2] - 25) - 25
    return np.where(at[2] < 25, beyond(out + 6, up + 6) - 6, beyond(out, up))


# With more faces than a block of them.
STAR = {**STIRRER, "blades": 16, "blade_thickness_mm": 2}


def star(at: np.ndarray) -> np.ndarray:
    """Distance from STAR of a point outside of it: from its hub or a blade, here with its part inside the hub."""
    angle, height = np.pi / 8 * np.arange(16)[:, None], np.broadcast_to(np.abs(at[2] - 45) - 30, (16, at.shape[1]))
    along, across = at[0] * np.cos(angle) + at[1] * np.sin(angle), at[1] * np.cos(angle) - at[0] * np.sin(angle)
    blades = beyond(np.abs(along - 20) - 20, np.abs(across) - 1, height)
    return np.minimum(beyond(np.hypot(*at[:2]) - 10, height[0]), blades.min(axis=0))


# Of points (3, n) [mm].
CLOSED_FORMS = {
    "box": lambda at: beyond(np.abs(at[0]) - 5, np.abs(at[1]) - 10, np.abs(at[2] - 15) - 15),
    "drum": lambda at: beyond(np.hypot(at[0], at[2]) - 80, np.abs(at[1]) - 15),
    "cup": cup,
    "moved": lambda at: np.hypot(np.hypot(at[1] + 7, at[2] - 30), np.maximum(np.abs(at[0] - 5) - 12.5, 0)) - 10,
    "star": star,
}


def exact_shape(shape: dict, is_solid: bool) -> Vessel:
    """A shape as mills have it, its round walls exact."""
    geometry = TypeAdapter(SolidGeometry if is_solid else VesselGeometry).validate_python(shape)
    outlines, _ = drawn_shape(geometry, "mill.yaml: geometry", solid=is_solid)
    return Vessel(outlines, solid=is_solid, curves=shape_curves(geometry, is_solid))


@pytest.mark.parametrize("name", CLOSED_FORMS)
def test_distances_of_shapes_are_those_of_closed_forms(name):
    """Inside and outside, near edges and corners, on faces; also of the hollow, which is the solid turned over."""
    body = exact_shape(STAR if name == "star" else SHAPES[name], True)
    rng, (low, high) = np.random.default_rng(2), body.bounds
    vertices, triangles = body.triangles()
    places = vertices[triangles].mean(axis=1)
    places = np.concatenate([rng.choice(places, 20), rng.choice(places, 50), rng.choice(vertices, 50)])
    places[20:] += rng.uniform(-0.004, 0.004, (100, 3))
    points = np.concatenate([rng.uniform(low - 0.01, high + 0.01, (90, 3)), places])
    exact = CLOSED_FORMS[name](points.T * 1e3) / 1e3
    if name == "star":  # inside, the nearest wall of a part may lie in another part
        points, exact = points[exact > -1e-9], exact[exact > -1e-9]
    found, gradient = SignedDistance(body)(points)
    assert found == pytest.approx(-exact, abs=1e-12)
    assert CLOSED_FORMS[name]((points - found[:, None] * gradient).T * 1e3) == pytest.approx(0, abs=1e-9)
    assert np.linalg.norm(gradient, axis=1) == pytest.approx(1)
    if name != "star":
        assert SignedDistance(exact_shape(SHAPES[name], False))(points)[0] == pytest.approx(exact, abs=1e-12)


@pytest.mark.parametrize("blades", [1, 2, 3, 4, 7])
def test_a_stirrer_is_hub_and_blades(blades):
    body = solid(STIRRER, blades=blades, hub_facets=120)
    # A blade is a rectangle less the piece of the hub's circle that it covers.
    half, hub = 2.5, 10.0
    root = np.arcsin(half / hub)
    blade = 2 * half * (40 - hub * np.cos(root)) - hub**2 * (root - np.sin(root) * np.cos(root))
    assert -body.volume_m3 * 1e9 == pytest.approx(60 * (np.pi * hub**2 + blades * blade), rel=1e-3)
    assert body.bounds[:, 2] * 1e3 == pytest.approx([15, 75])
    assert body.bounds[1, 0] * 1e3 == pytest.approx(40)
    mesh = trimesh.Trimesh(*body.triangles(), process=False)
    assert mesh.is_watertight
    assert mesh.volume == pytest.approx(-body.volume_m3)


class TorusGeometry(GeometrySection):
    """A shape that is not registered."""

    kind: Literal["torus"] = "torus"


def test_a_shape_that_is_not_in_the_registry_is_refused():
    with pytest.raises(KeyError, match="'torus'"):
        facets_of(drawn_shape(TorusGeometry(), "mill.yaml: geometry", solid=False)[0])


def test_a_stadium_of_an_odd_number_of_facets_is_its_own_mirror_image():
    """Seen in a mirror, the mill of the thesis turns the other way round: its powers must not tell."""
    outline = {tuple(point) for point in np.round(shapes.stadium_outline(26.0, 29.0, 31, 0.65), 9).tolist()}
    for mirror in ((1, -1), (-1, 1), (-1, -1)):
        assert {tuple(np.round(np.array(point) * mirror, 9) + 0.0) for point in outline} == outline
