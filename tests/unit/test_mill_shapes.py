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
from millprint.mill.vessel import LATTICE, Vessel, drawn_shape
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
    points = np.random.default_rng(0).uniform(*(hollow.bounds * 1.3), (200, 3))
    assert SignedDistance(body)(points)[0] == pytest.approx(-SignedDistance(hollow)(points)[0], abs=1e-13)


def test_facets_that_are_open_or_the_wrong_side_out_are_refused():
    facets = [Facet(f.normal, f.offset, f.loops) for f in vessel(SHAPES["box"]).facets]
    with pytest.raises(ConfigError, match="inside out"):
        Vessel(facets, solid=True)
    with pytest.raises(ConfigError, match="open"):
        Vessel(facets[:-1])


def test_distance_from_a_box_is_that_of_the_closed_form():
    """Outside a box: the length of what sticks out beyond its half sizes. Corners and edges decide the sign."""
    body, half = solid(SHAPES["box"], centre_mm=[0, 0, 0]), np.array([5, 10, 15]) / 1e3
    rng = np.random.default_rng(2)
    signs = rng.choice([-1, 1], (400, 3))
    points = np.concatenate([rng.uniform(-0.03, 0.03, (400, 3)), signs * half * rng.choice([1, 1.5, 2], (400, 3))])
    beyond = np.abs(points) - half
    expected = np.linalg.norm(np.maximum(beyond, 0), axis=1) + np.minimum(beyond.max(axis=1), 0)
    assert SignedDistance(body)(points)[0] == pytest.approx(-expected, abs=1e-13)


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
    with pytest.raises(ValueError, match="kind = 'torus': no such shape is in the registry; known: stadium, "):
        facets_of(drawn_shape(TorusGeometry(), "mill.yaml: geometry", solid=False)[0])


def test_a_stadium_of_an_odd_number_of_facets_is_its_own_mirror_image():
    """Seen in a mirror, the mill of the thesis turns the other way round: its powers must not tell."""
    outline = {tuple(point) for point in np.round(shapes.stadium_outline(26.0, 29.0, 31, 0.65), 9).tolist()}
    for mirror in ((1, -1), (-1, 1), (-1, -1)):
        assert {tuple(np.round(np.array(point) * mirror, 9) + 0.0) for point in outline} == outline
