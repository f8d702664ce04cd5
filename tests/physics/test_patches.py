"""A wall is a surface: how it is cut into facets changes neither what a ball touches nor what a contact is.

Random floors of triangles with shallow seams, steps and convex edges, every mill of config/, and hits on walls that are
drawn in different ways. `test_closed_surfaces.py` has surfaces that have a closed form.
"""

from functools import cache

import numpy as np
import pytest

from millprint.config.mill import MillConfig
from millprint.config.sweep import OVERLAP_LIMIT
from millprint.dem.collisions import by_surface, collision_table
from millprint.dem.layout import COUNTER, ENDED
from millprint.dem.simulation import walls_for
from millprint.mill.borders import SMOOTH_TURN
from millprint.mill.outlines import facets_of
from millprint.mill.vessel import Vessel, build_vessel
from millprint.mill.wall_features import features_of
from tests.closed_distances import distance_to_triangles, solid_angle
from tests.physics.setups import CALIBRATED, FewBalls, box, prism
from tests.surfaces import MM, put

RADIUS = 5e-3
FRICTIONLESS = CALIBRATED.model_copy(update={"static_friction": 0.0, "rolling_friction": 0.0})


def open_features(vessel, walls, point, radius=RADIUS) -> list[int]:
    """Features with which a ball that is put at `point` is in contact."""
    world = FewBalls(point, None, vessel=vessel, radius=radius, walls=walls, step=1e-10)
    world.run(1e-10)
    contacts = world.open_contacts
    return (-1 - contacts.partner[contacts.slot >= 0]).tolist()


def tray(floor: np.ndarray, height: float, rng: np.random.Generator) -> Vessel:
    """A box whose floor runs through a grid of points (n, n, 3) [m], each cell of it cut along a random diagonal."""
    loops, n = [], len(floor) - 1
    for i, j in np.ndindex(n, n):
        a, b, c, d = floor[i, j], floor[i + 1, j], floor[i + 1, j + 1], floor[i, j + 1]
        loops += [[a, b, c], [a, c, d]] if rng.random() < 0.5 else [[a, b, d], [b, c, d]]
    lid = {(i, j): np.array([*floor[i, j, :2], height]) for i in (0, n) for j in (0, n)}
    loops.append([lid[0, 0], lid[0, n], lid[n, n], lid[n, 0]])
    loops.append([*floor[::-1, 0], lid[0, 0], lid[n, 0]])
    loops.append([*floor[:, n], lid[n, n], lid[0, n]])
    loops.append([*floor[0], lid[0, n], lid[0, 0]])
    loops.append([*floor[n, ::-1], lid[n, 0], lid[n, n]])
    return Vessel(facets_of([[np.array(loop)] for loop in loops]))


def floor_grid(pitch: float, roughness: float, step: float, rng: np.random.Generator, cells: int = 8) -> np.ndarray:
    """Points (n, n, 3) [m] of a floor in an uneven grid: heights random within +-roughness, and half of it lowered."""
    at = np.arange(cells + 1) * pitch
    x, y = np.meshgrid(at, at, indexing="ij")
    shift = 0.25 * pitch * rng.uniform(-1, 1, (2, *x.shape))
    shift[0, [0, -1]], shift[1][:, [0, -1]] = 0, 0
    z = roughness * rng.uniform(-1, 1, x.shape) - step * (x > x.max() / 2)
    return np.stack([x + shift[0], y + shift[1], z], axis=-1)


def corners(vessel: Vessel) -> np.ndarray:
    """The corners (t, 3, 3) of a vessel's triangles [m]."""
    points, triangles = vessel.triangles()
    return points[triangles]


def lowered(triangles: np.ndarray, place, gap: float) -> np.ndarray:
    """The point above `place` (2,) at which a ball has a gap to the surface [m], negative for an overlap."""
    low, high = triangles[..., 2].min(), 0.05
    for _ in range(45):
        middle = (low + high) / 2
        point = np.array([[*place, middle]])
        low, high = (middle, high) if distance_to_triangles(triangles, point)[0] < RADIUS + gap else (low, middle)
    return np.array([*place, high])


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(12))
def test_contacts_of_a_random_surface_are_as_the_distance_to_its_triangles(seed):
    rng = np.random.default_rng(seed)
    pitch, step = rng.choice([1.5e-3, 3e-3, 6e-3]), rng.choice([0.0, 0.0, 4e-3])
    roughness = pitch * rng.choice([1e-5, 1e-3, 0.02, 0.1, 0.3])
    vessel = tray(floor_grid(pitch, roughness, step, rng), 0.06, rng)
    triangles, gaps = corners(vessel), RADIUS * rng.uniform(-0.03, 0.01, 40)
    points = np.array([lowered(triangles, rng.uniform(1.6, 6.4, 2) * pitch, gap) for gap in gaps])
    exact, contacts = distance_to_triangles(triangles, points), put(vessel, points / MM, RADIUS / MM)
    for k, distance in enumerate(exact):
        overlaps = contacts.overlap[contacts.ball == k] * MM
        if distance >= RADIUS:
            assert not len(overlaps)
        else:
            assert overlaps.max() == pytest.approx(RADIUS - distance, abs=1e-9 * RADIUS)


def drawn_finely(mill: MillConfig) -> MillConfig:
    """The mill with so many facets that its chords are off its round walls by less than 4e-4 of their radius."""

    def fine(shape):
        number = {"facets_per_half_circle": 60, "facets": 120, "fillet_facets": 30}
        keys = {key: number[key] for key in number if isinstance(getattr(shape, key, None), int)}
        post = {"post": fine(shape.post)} if getattr(shape, "post", None) else {}
        return shape.model_copy(update={**keys, **post})

    return mill if mill.geometry.faceted else mill.model_copy(update={"geometry": fine(mill.geometry)})


@pytest.mark.slow
def test_the_vessel_of_every_mill_is_touched_as_the_distance_to_fine_triangles_says(mills):
    """By its smallest ball, near vertices, where facets end."""
    for mill in {mill.geometry.model_dump_json(): mill for mill in mills.values()}.values():
        sizes = mill.sweep.ball_diameters_mm if mill.sweep else [10]
        radius = min(min(getattr(size, "sizes_mm", [size])) for size in sizes) / 2e3
        vessel, triangles = build_vessel(mill), corners(build_vessel(drawn_finely(mill)))
        rng, off = np.random.default_rng(0), 4e-4 * vessel.size
        points = rng.choice(vessel.vertices, 80) + radius * rng.normal(size=(80, 3))
        # The triangles' normals point inwards.
        points = points[np.rint(solid_angle(triangles, points)) == -1]
        gap = distance_to_triangles(triangles, points)
        points, gap = points[gap > 0.8 * radius], gap[gap > 0.8 * radius]
        contacts = put(vessel, points / MM, radius / MM)
        for k, distance in enumerate(gap):
            overlap = max([0.0, *contacts.overlap[contacts.ball == k] * MM])
            assert abs(overlap - max(0.0, radius - distance)) < off, (mill.name, points[k])


def flat_tray(seed: int, noise_m: float) -> Vessel:
    """A flat floor in 128 triangles, its points off the plane by up to a noise [m]."""
    rng = np.random.default_rng(seed)
    return tray(floor_grid(4e-3, noise_m, 0.0, rng), 0.06, rng)


@pytest.mark.slow
@pytest.mark.parametrize("noise_m", [0.0, 1e-9, 1e-7, 1e-6])
@pytest.mark.parametrize("restitution", [0.3, 0.8])
def test_a_hit_on_a_remeshed_floor_is_one_contact_of_its_restitution(noise_m, restitution):
    contact = FRICTIONLESS.model_copy(update={"restitution": restitution})
    vessel, rng = flat_tray(1, noise_m), np.random.default_rng(2)
    walls = walls_for(vessel, RADIUS)
    corners = vessel.vertices[vessel.vertices[:, 2] < 1e-5]
    inner = corners[np.abs(corners[:, :2] - 0.016).max(axis=1) < 0.01]
    for place in [*rng.choice(inner[:, :2], 6), *rng.uniform(0.008, 0.024, (6, 2))]:
        world = FewBalls([*place, 1.02 * RADIUS], [0, 0, -1.0], vessel=vessel, contact=contact, walls=walls, step=5e-7)
        world.run(2e-3)
        assert len(world.contacts) == 1
        assert world.balls.velocity[0, 2] == pytest.approx(restitution, abs=2e-3)


@pytest.mark.parametrize("facets", [24, 48, 96, 192, 384])
def test_a_hit_on_a_round_wall_loses_what_one_on_a_cylinder_does(facets):
    """However many facets it has, and wherever the ball hits: e^2 of the energy stays."""
    contact = FRICTIONLESS.model_copy(update={"restitution": 0.3})
    angle = 2 * np.pi * np.arange(facets) / facets
    vessel = prism(0.0375 * np.column_stack([np.cos(angle), np.sin(angle)]), 0.05)
    walls, kept = walls_for(vessel, RADIUS), []
    for phi in np.pi / facets * np.linspace(0, 2, 11)[:-1]:
        outwards = np.array([np.cos(phi), np.sin(phi), 0.0])
        start = 0.0322 * outwards + [0, 0, 0.025]
        world = FewBalls(start, 2 * outwards, vessel=vessel, contact=contact, walls=walls, step=5e-7)
        world.run(1.5e-3)
        assert len(world.contacts) == 1
        kept.append((world.balls.velocity[0] ** 2).sum() / 4)
    # A facet is hit at up to an angle of pi / facets, and what moves along it is not damped.
    assert 0.09 - 2e-4 < np.mean(kept) < 0.09 + 0.91 * (np.pi / facets) ** 2 / 2 + 2e-4


def round_room(facets: int, radius: float = 0.03) -> Vessel:
    """A lying cylinder along y."""
    angle = 2 * np.pi * (np.arange(facets) + 0.3) / facets
    turn = np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]])
    return prism(radius * np.column_stack([np.cos(angle), np.sin(angle)]), 0.05, turn)


@cache
def rolled(facets: int, by_facet: bool = False) -> FewBalls:
    """A ball that swings in the bottom of a lying cylinder, in the middle of its length."""
    start = 0.02498 * np.array([np.sin(0.5), 0, -np.cos(0.5)]) - [0, 0.025, 0]
    world = FewBalls(start, vessel=round_room(facets), gravity=9.81, step=2e-6, by_facet=by_facet)
    world.series = world.run(0.5, sample_every=1000)
    return world


def test_a_ball_that_rolls_round_a_jar_keeps_one_contact():
    world = rolled(384)
    assert len(world.contacts) <= 2  # the ball may hop once as it is put on the wall
    assert world.counters[COUNTER.opened] <= 3
    lanes = np.flatnonzero(world.open_contacts.slot >= 0)
    assert len(lanes) == 1


def test_counted_by_facet_a_rolling_contact_has_a_row_for_each_facet_with_the_same_works():
    whole, cut = rolled(384), rolled(384, by_facet=True)
    rows = collision_table(cut.collisions)
    assert len(rows) > 50
    assert np.array_equal(whole.balls.position, cut.balls.position)
    np.testing.assert_allclose(cut.series.to_numpy(), whole.series.to_numpy(), rtol=1e-9, atol=1e-15)
    passed = rows[rows["ended"] == ENDED.passed]
    assert (np.abs(np.diff(passed["facet"])) > 0).all()
    assert (rows.groupby("contact")["second"].nunique() == 1).all()
    joined = by_surface(rows).query("complete == 1")
    assert len(joined) == len(whole.contacts)
    for name in ("normal_J", "sliding_J", "rolling_J", "duration_s", "peak_force_N"):
        np.testing.assert_allclose(joined[name], whole.contacts[name], rtol=1e-9)


def test_swings_do_not_depend_on_the_number_of_facets():
    """The energy that a swinging ball has lost after half a second, of 192 and 384 facets."""
    lost = [world.series["rolling_J"].iloc[-1] for world in (rolled(192), rolled(384))]
    assert lost[0] == pytest.approx(lost[1], rel=0.02)
    for world in (rolled(192), rolled(384)):
        series = world.series
        scale = series["kinetic_J"].max()
        assert np.abs(series["imbalance_J"]).max() < 0.01 * scale


@pytest.mark.parametrize("turn", [0.02, 0.2, 0.6, 1.0])
def test_a_ball_that_rolls_over_a_ridge_keeps_its_contact(turn):
    """A convex edge, shallow or sharp: the contact goes on from facet to edge and to the other facet, and is one."""
    half, wide = turn / 2, 0.05
    outline = np.array([[0, 0], [wide, -wide * np.tan(half)], [wide, 0.1], [-wide, 0.1], [-wide, -wide * np.tan(half)]])
    vessel = prism(outline, 0.05, np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]]))
    along, up = np.array([np.cos(half), 0, np.sin(half)]), np.array([-np.sin(half), 0, np.cos(half)])
    start = 0.9997 * RADIUS * up - 1e-4 * along - [0, 0.025, 0]
    world = FewBalls(start, 0.4 * along, [0, 80, 0], vessel=vessel, gravity=60.0, step=2e-6, by_facet=True)
    world.run(RADIUS * turn / 0.3 + 1e-3)
    assert world.balls.position[0, 0] > RADIUS * np.sin(half)
    (last,) = world.open_contacts.partner[world.open_contacts.slot >= 0]
    facet, edge = collision_table(world.collisions)["facet"]
    assert world.counters[COUNTER.opened] == 1 and facet < edge >= len(vessel.facets) > -1 - last != facet


@pytest.mark.parametrize("side", [-1, 1])
def test_a_ball_that_falls_beside_a_shallow_seam_hits_the_nearer_face_alone(side):
    """Both come within reach in the first step; the nearer one is listed first, or last."""
    slope, wide, speed = 0.02, 0.05, 1.0
    rise = wide * np.tan(slope)
    outline = np.array([[0, 0], [wide, rise], [wide, 0.1], [-wide, 0.1], [-wide, rise]])
    vessel = prism(outline, 0.05, np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]]))
    nearer = np.array([-side * np.sin(slope), 0, np.cos(slope)])
    start = np.array([side * 3e-5, -0.025, 0]) + (RADIUS + 2e-6 + side * 3e-5 * nearer[0]) / nearer[2] * np.eye(3)[2]
    world = FewBalls(start, [0, 0, -speed], vessel=vessel, contact=FRICTIONLESS, gravity=0.0, step=5e-6, by_facet=True)
    world.run(4e-4)
    (hit,) = collision_table(world.collisions).itertuples()
    assert vessel.normals[hit.facet] == pytest.approx(nearer)
    assert hit.approach_speed_m_s == pytest.approx(speed * np.cos(slope), rel=1e-3)


def test_a_seam_that_is_sharp_cuts_no_contact_off_while_it_is_pressed():
    """A foot passes the seam where the other face's overlap is R (1 - cos turn): beyond what any run allows."""
    assert 1 - np.cos(SMOOTH_TURN) >= OVERLAP_LIMIT - 1e-12


def test_corners_and_sharp_seams_keep_a_contact_a_face():
    vessel = box()
    walls = walls_for(vessel, RADIUS)
    for across, count in ((0.0, 2), (0.0952, 3)):
        assert len(open_features(vessel, walls, [0.0952, across, 0.0049])) == count


def filleted_corner(fillet: float, steps: int = 24) -> Vessel:
    """A box with one lying edge rounded, its floor and side joined by `steps` facets."""
    angle = np.linspace(0, np.pi / 2, steps + 1)
    arc = np.column_stack([fillet * (1 - np.sin(angle)), fillet * (1 - np.cos(angle))])
    outline = np.array([*arc, [0.0, 0.1], [0.1, 0.1], [0.1, 0.0]])[::-1]
    return prism(outline, 0.1, np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]]))


@pytest.mark.parametrize(("fillet", "contacts"), [(2.5e-3, 2), (4.5e-3, 2), (6e-3, 1), (12e-3, 1)])
def test_a_ball_in_a_rounded_corner_touches_twice_where_the_rounding_is_tighter_than_the_ball(fillet, contacts):
    vessel = filleted_corner(fillet)
    walls = walls_for(vessel, RADIUS)
    assert features_of(vessel).patches == 5
    if contacts == 2:
        point = [RADIUS - 2e-5, -0.05, RADIUS - 2e-5]
    else:
        deep = fillet - (fillet - RADIUS + 2e-5) * np.sqrt(0.5)
        point = [deep, -0.05, deep]
    assert len(open_features(vessel, walls, point)) == contacts
