"""The jar as facets: closed, of the right volume, with edges of the right kind."""

import math
from pathlib import Path

import numpy as np
import pytest
import trimesh

from millprint.config.included import load_mill
from millprint.mill.bodies import build_bodies
from millprint.mill.distance import SignedDistance
from millprint.mill.exact_walls import _without_collapsed
from millprint.mill.outlines import Outlines, enclosed_volume
from millprint.mill.vessel import Vessel, build_vessel
from millprint.mill.wall_arrays import build_walls, fill_cells
from millprint.mill.wall_features import features_of
from millprint.mill.walls import beyond_side
from tests.closed_distances import distance_to_triangles, solid_angle

MILLS = Path(__file__).parents[2] / "config/mills"
NAMES = sorted(path.stem for path in MILLS.glob("*.yaml"))


@pytest.fixture(scope="module")
def vessels() -> dict[str, Vessel]:
    return {name: build_vessel(load_mill(name)) for name in NAMES}


def test_the_plane_of_a_narrow_facet_does_not_lean_by_the_rounding_of_its_outline():
    """Half a ring, 0.1 mm wide and 37 mm long, with heights of 0 or 5 um: by its area its ends are 0.16 mm off."""
    rng, angles = np.random.default_rng(0), np.linspace(0, np.pi, 100)
    radii = np.append(18.6e-3 + rng.uniform(0, 5e-5, 100), np.full(100, 18.5e-3))
    angles = np.append(angles, angles[::-1])
    heights = rng.choice([-5e-6, 0, 5e-6], 200)
    outline = np.column_stack([radii * np.cos(angles), radii * np.sin(angles), heights])
    (normal,), (offset,) = Outlines.of([[outline]]).planes()
    assert normal[2] > 0 and np.abs(outline @ normal - offset).max() < 1e-5


def test_facets_that_cross_a_border_by_a_diagonal_end_at_it():
    """A dome of a flat cone and one step below it, which one facet of the cone crosses with a triangle of the next."""
    count, angles = 8, np.arange(8) * math.pi / 4
    around = np.column_stack([np.cos(angles), np.sin(angles)])
    rings = [np.column_stack([r * around, np.full(count, z)]) for r, z in [(0.9, 1.1), (1.0, 1.0), (1.0, 0.0)]]
    points = np.vstack([[[0, 0, 1.2]], *rings]) * 0.01
    tip, a, b, c = 0, 1 + np.arange(count), 9 + np.arange(count), 17 + np.arange(count)
    ahead = (np.arange(count) + 1) % count
    loops = [[tip, a[2], b[2], b[1], b[0], a[1]], [b[0], a[0], a[1]], c.tolist()]
    loops += [[tip, a[ahead[k]], a[k]] for k in range(count) if k != 1]
    loops += [[a[k], a[ahead[k]], b[ahead[k]], b[k]] for k in range(count) if k > 1]
    loops += [[b[k], b[ahead[k]], c[ahead[k]], c[k]] for k in range(count)]
    vessel = Vessel(Outlines.of([[points[loop]] for loop in loops]))
    # What is left of the step is put on the border, by rounding not in the same places.
    moved, rng = vessel.vertices.copy(), np.random.default_rng(0)
    for k in range(3):
        at = np.linalg.norm(vessel.vertices - points[b[k]], axis=1).argmin()
        moved[at] = points[a[k]] + rng.uniform(-4e-7, 4e-7, 3)
    facets, kept = _without_collapsed(vessel, moved, 2e-6)
    exact = Vessel(facets)
    assert len(kept) == len(loops) - 1 and len(exact.vertices) == len(vessel.vertices) - 3
    # Facets that are bent by now are cut into triangles from another vertex.
    points[b[:3]] = points[a[:3]]
    assert exact.volume_m3 == pytest.approx(enclosed_volume([[points[loop]] for loop in loops]), rel=1e-2)


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_walls_are_watertight_and_enclose_the_volume(vessels, name):
    vessel = vessels[name]
    vertices, triangles = vessel.triangles()
    mesh = trimesh.Trimesh(vertices, triangles, process=False)
    assert mesh.is_watertight
    assert mesh.is_winding_consistent
    # Normals point into the vessel, so that the mesh's own volume is negative.
    assert -mesh.volume == pytest.approx(enclosed_volume(facet.loops for facet in vessel.facets), rel=1e-9)


def test_the_jar_holds_its_nominal_volume(vessels):
    assert vessels["emax"].volume_m3 == pytest.approx(125e-6, rel=0.02)


def test_the_plain_jar_is_convex_and_the_post_is_not(vessels):
    assert not features_of(vessels["emax"]).lines
    assert not features_of(vessels["emax"]).corners
    post = vessels["emax_post"]
    assert len(features_of(post).lines) == 24
    assert len(features_of(post).corners) == 48
    assert all(np.isclose(edge.turn, 2 * np.pi / 24) for edge in features_of(post).lines)


@pytest.mark.parametrize("name", ["emax", "emax_post"])
@pytest.mark.slow
def test_signed_distance_agrees_with_the_mesh(vessels, name):
    vessel = vessels[name]
    rng = np.random.default_rng(1)
    points = rng.uniform(*(vessel.bounds * 1.2), (150, 3))
    distance, gradient = SignedDistance(vessel)(points)
    vertices, triangles = vessel.triangles()
    assert np.abs(distance) == pytest.approx(distance_to_triangles(vertices[triangles], points), abs=1e-12)
    # A step against the gradient by the distance ends on the wall.
    landed = SignedDistance(vessel)(points - distance[:, None] * gradient)[0]
    assert np.abs(landed).max() < 1e-12


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.slow
def test_every_body_of_every_mill_is_hollow_or_solid_where_its_mesh_is(name):
    """The sign of the exact distance by another rule, but near round walls, which the mesh cuts short."""
    for body in build_bodies(load_mill(name)):
        vessel = body.vessel
        vertices, triangles = vessel.triangles()
        low, high = vessel.bounds
        points = np.random.default_rng(2).uniform(low - 0.02 * (high - low), high + 0.02 * (high - low), (400, 3))
        distance = SignedDistance(vessel)(points)[0]
        enclosed = np.abs(solid_angle(vertices[triangles], points)) > 0.5
        certain = np.abs(distance) > max(2e-3 * vessel.size, vessel.sagitta)
        assert ((distance < 0) == (enclosed != vessel.solid))[certain].all()
        assert certain.mean() > 0.5


@pytest.mark.slow
@pytest.mark.parametrize("name", ["emax", "emax_post"])
def test_points_in_line_with_a_corner_are_inside_or_outside_without_doubt(vessels, name):
    """Rounding must not let a ray through a corner count it twice or not at all."""
    vessel = vessels[name]
    walls = build_walls([vessel], 5e-3, 3e-4, 0.01)
    facet = max(range(len(vessel.facets)), key=lambda k: len(vessel.facets[k].loops[0]))
    axes = np.array(vessel.facets[facet].axes)
    flat = np.concatenate(vessel.facets[facet].loops) @ axes.T
    rng = np.random.default_rng(0)
    expected = Path2D(vessel, facet)
    for u in rng.uniform(*np.percentile(flat[:, 0], [2, 98]), 40):
        for v in np.concatenate([flat[:, 1], np.nextafter(flat[:, 1], 1), np.nextafter(flat[:, 1], -1)]):
            point = tuple((np.array([u, v]) @ axes).tolist())
            beyond = beyond_side(walls.axes, walls.first_side, walls.side, walls.bow, facet, point)
            # A point slightly off the lines through the corners gives the same answer, except on the outline itself.
            if abs(beyond) > 1e-9:
                assert (beyond < 0) == expected.holds(u, v + 1e-10), (u, v)


class Path2D:
    """Winding of a facet's outlines about a point, by angles: another way to tell inside from outside."""

    def __init__(self, vessel: Vessel, facet: int) -> None:
        self.loops = [loop @ np.array(vessel.facets[facet].axes).T for loop in vessel.facets[facet].loops]

    def holds(self, u: float, v: float) -> bool:
        total = 0.0
        for loop in self.loops:
            angle = np.arctan2(loop[:, 1] - v, loop[:, 0] - u)
            turn = np.diff(angle, append=angle[0])
            total += ((turn + np.pi) % (2 * np.pi) - np.pi).sum()
        return abs(total) > np.pi


@pytest.mark.parametrize("name", ["emax", "emax_post"])
def test_the_cells_list_what_they_would_if_no_feature_were_passed_over(vessels, name):
    radius, margin, pitch = 2.5e-3, 3e-4, 4e-3
    walls = build_walls([vessels[name]], radius, margin, pitch)
    first, features = walls.cell_first.copy(), len(walls.body)
    reach = margin + pitch * math.sqrt(3) / 2
    found, sure = fill_cells(walls, radius, reach, np.full((features, 3), -1.0), np.full((features, 3), 1.0))
    assert np.array_equal(first, walls.cell_first)
    assert np.array_equal(walls.cell_feature, found) and np.array_equal(walls.cell_sure, sure)
    assert len(found) > features
