"""Walls against closed forms that share no code with them: random hollows as meshes and by their sizes.

See `tests.surfaces` for what is checked, and for how the surface of one seed is made again.
"""

import math
from pathlib import Path

import numpy as np
import pytest

from millprint.config.mill import MillConfig
from millprint.config.motion_kinds import RotationMotion
from millprint.config.sweep import Case as RunCase
from millprint.config.sweep import DemConfig
from millprint.dem.ledger import closure, ledger_series
from millprint.dem.simulation import Simulation, walls_for
from millprint.mill.motion import motion_from_law
from millprint.mill.vessel import Vessel
from tests.closed_distances import distance_to_triangles, feet, nearest_on_triangles, solid_angle
from tests.physics.setups import CALIBRATED, FewBalls, prism
from tests.profiles import Hollow, chain, hollow_of, interrupted, mesh, stadium_pieces, write_stl
from tests.surfaces import (
    MM,
    Case,
    check,
    check_contacts,
    check_distance,
    check_hits,
    check_slides,
    check_solid,
    from_file,
    radius_of,
    small,
    style_of,
    vessel_of,
)

ELASTIC = CALIBRATED.model_copy(update={"restitution": 1.0, "static_friction": 0.0, "rolling_friction": 0.0})


@pytest.fixture(autouse=True)
def in_project(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


def upright(pieces: tuple, height: float | None = None, axis: str = "z", shift=(0.0, 0.0, 0.0)) -> Hollow:
    order = {"x": [1, 2, 0], "y": [2, 0, 1], "z": [0, 1, 2]}[axis]
    return Hollow("made", pieces, height).placed(np.eye(3)[:, order], np.array(shift))


# The oracle itself


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(15))
def test_the_closed_form_is_the_distance_to_fine_triangles(seed):
    hollow, rng = hollow_of(seed), np.random.default_rng(seed)
    triangles = mesh(hollow, 120)
    low, high = triangles.min(axis=(0, 1)), triangles.max(axis=(0, 1))
    points = rng.uniform(low, high, (400, 3))
    # Chords are off by the radius times 1 - cos (pi / 120), 3.4e-4.
    off = 7e-4 * float((high - low).max())
    some = points[:20]
    sure = distance_to_triangles(triangles, some) > off
    assert (feet(hollow, some).inside == (np.rint(solid_angle(triangles, some)) == 1))[sure].all()
    inner = points[feet(hollow, points).inside][:15]
    found = feet(hollow, inner)
    np.testing.assert_allclose(found.nearest, distance_to_triangles(triangles, inner), atol=off)
    # The gradient of the distance is the direction from the nearest foot.
    shift = 1e-6 * found.towards
    farther = feet(hollow, inner + shift).nearest - feet(hollow, inner - shift).nearest
    np.testing.assert_allclose(farther, 2e-6, rtol=1e-3)


def test_a_mesh_is_closed_and_faces_outwards():
    for seed in range(40):
        hollow = hollow_of(seed)
        triangles = mesh(hollow, 24)
        _, corner = np.unique(triangles.reshape(-1, 3).round(9), axis=0, return_inverse=True)
        corner = corner.reshape(-1, 3)
        sides = np.concatenate([corner[:, [0, 1]], corner[:, [1, 2]], corner[:, [2, 0]]])
        assert len(np.unique(sides, axis=0)) == len(sides)
        assert {tuple(side) for side in sides.tolist()} == {(b, a) for a, b in sides.tolist()}
        volume = np.einsum("tc,tc->", triangles[:, 0], np.cross(triangles[:, 1], triangles[:, 2])) / 6
        assert volume > 0


def test_a_ball_in_a_corner_has_a_foot_on_each_wall_and_one_at_a_rim():
    """A box with a step, by hand: two walls of a corner, one edge in its wedge, the wall beside it."""
    step = upright(chain([(0, 0), (30, 0), (30, 20), (20, 20), (20, 40), (0, 40)], [0.0] * 6, closed=True), 50.0)
    for point, distances in (
        ([26, 5, 25], [4, 5]), ([18, 18, 25], [math.sqrt(8)]), ([17, 30, 25], [3]), ([25, 17, 25], [3, 5]),
        ([27, 3, 2], [2, 3, 3]),
    ):  # fmt: skip
        found = feet(step, np.array([point], dtype=float))
        assert found.inside.all()
        near = np.sort(found.distance[found.distance < 6])
        assert near == pytest.approx(distances)


# Surfaces given by their sizes


def cylinder(radius: float, height: float, fillet: float, ends: str, axis: str = "z") -> tuple[Hollow, dict]:
    """A cylinder with fillets [mm] about its middle, and its section of the configuration."""
    bottom, top = (fillet if ends in kinds else 0.0 for kinds in (("bottom", "both"), ("both",)))
    points, quarter = [(0.0, -height / 2)], math.pi / 2
    ways = [(radius - bottom, -height / 2, 0.0), (radius, bottom - height / 2, quarter),
            (radius, height / 2 - top, 0.0), (radius - top, height / 2, quarter), (0.0, height / 2, 0.0)]  # fmt: skip
    sweeps = []
    for r, z, sweep in ways:
        if math.dist(points[-1], (r, z)) > 1e-9:
            points.append((r, z))
            sweeps.append(sweep)
    hollow = upright(chain(points, sweeps, closed=False), axis=axis, shift=(1.0, 2.0, 3.0))
    section = {"kind": "cylinder", "radius_mm": radius, "height_mm": height, "fillet_radius_mm": fillet,
               "fillet_ends": ends, "axis": axis, "centre_mm": [1, 2, 3], "facets": 24}  # fmt: skip
    return hollow, section


def lifter_drum(radius: float, length: float, number: int, width: float, height: float) -> tuple[Hollow, dict]:
    foot, pitch = math.asin(width / 2 / radius), 2 * math.pi / number
    points, sweeps = [], []
    for k in range(number):
        turn = np.array([[math.cos(k * pitch), math.sin(k * pitch)], [-math.sin(k * pitch), math.cos(k * pitch)]])
        shell = [[radius * math.cos(angle), radius * math.sin(angle)] for angle in (foot, pitch - foot)]
        points += list(np.array([[radius - height, -width / 2], [radius - height, width / 2], *shell]) @ turn)
        sweeps += [0.0, 0.0, pitch - 2 * foot, 0.0]
    hollow = upright(chain(points, sweeps, closed=True), length, "y", (0.0, -length / 2, 0.0))
    lifters = {"number": number, "height_mm": height, "width_mm": width}
    return hollow, {"kind": "lifter_drum", "radius_mm": radius, "length_mm": length, "axis": "y", "lifters": lifters}


SIZED = {
    "cylinder": lambda: cylinder(30, 40, 0, "none", "x"),
    "jar": lambda: cylinder(30, 40, 5, "bottom", "y"),
    "rounded": lambda: cylinder(30, 60, 8, "both"),
    "capsule": lambda: cylinder(20, 70, 20, "both", "x"),
    "sphere": lambda: cylinder(20, 40, 20, "both"),
    "stadium": lambda: (
        upright(stadium_pieces(20, 30), 25.0),
        {"kind": "stadium", "end_radius_mm": 20, "straight_mm": 30, "height_mm": 25, "fillet_radius_mm": 0,
         "facets_per_half_circle": 12},
    ),
    "box": lambda: (
        upright(chain([(-15, -20), (15, -20), (15, 20), (-15, 20)], [0.0] * 4, closed=True), 50.0),
        {"kind": "box", "x_mm": 30, "y_mm": 40, "z_mm": 50},
    ),
    "lifters": lambda: lifter_drum(50, 40, 6, 6, 5),
}  # fmt: skip


@pytest.mark.parametrize("name", SIZED)
def test_a_surface_of_given_sizes_is_touched_as_its_closed_form_says(name):
    hollow, section = SIZED[name]()
    case, rng = Case(hollow, vessel_of(section), 1e-7, name), np.random.default_rng(0)
    for radius in (0.25, *(radius_of(case, rng) for _ in range(3))):
        assert check_contacts(case, radius, 40, rng) == []
    assert check_hits(case, 0.5 * hollow.tightest, 15, rng) == []
    assert check_slides(case, 0.5 * hollow.tightest, 8, rng) == []
    assert check_distance(case, 100, rng) == []


# Surfaces from files


@pytest.mark.parametrize("seed", [2, 7, 10, 16, 18, 31, 67, 84, 99, 104, 137, 271])
def test_a_drawn_surface_is_touched_as_its_closed_form_says(seed):
    assert check(seed, places_each=50, shots=10, largest=24) == []


@pytest.mark.parametrize(
    ("facets", "degrees", "decimals"), [(48, 12, None), (72, 8, 3), (96, 20, 2), (192, 8, 6), (192, 16, None)]
)
def test_a_flat_on_a_mantle_is_no_step_of_it(in_project, facets, degrees, decimals):
    """Its vertices are on the mantle as those of a step are, but it is far wider."""
    half = math.radians(degrees) / 2
    ends = [(20 * math.cos(half), 20 * math.sin(half)), (20 * math.cos(half), -20 * math.sin(half))]
    hollow = upright(chain(ends, [2 * math.pi - 2 * half, 0.0], closed=True), 30.0)
    case, rng = from_file(hollow, facets, decimals), np.random.default_rng(0)
    assert [said for radius in (0.5, 2, 5) for said in check_contacts(case, radius, 60, rng)] == []
    assert {round(curve.major / MM, 2) for curve in case.vessel.curves} == {20.0}


def test_what_interrupts_a_mantle_is_touched_as_its_closed_form_says(in_project):
    wrong, checked = [], 0
    for seed in range(40):
        rng = np.random.default_rng([seed, 5])
        facets, decimals = round(24 * 8 ** rng.random()), rng.choice([None, 3, 4, 5, 6])
        if hollow := interrupted(rng, 2 * math.pi / facets):
            checked += 1
            case = from_file(hollow, facets, decimals)
            wrong += [(seed, said) for _ in range(2) for said in check_contacts(case, radius_of(case, rng), 25, rng)]
    assert checked > 20
    assert wrong == []


@pytest.mark.slow
@pytest.mark.parametrize(
    "seed", [91012, 400029, 600041, 600121, 600162, 600207, 601190, 602324, 602374, 602459, 602573, 610011, 610273,
             610611, 610696, 610929, 620098, 620122, 640147, 640164, 660190, 660420, 660596, 660927, 720046, 800135,
             800198, 810436, 810543, 1001165, 1002558, 1020437, 1051239, 1051719, 1051783, 1052880, 1060330,
             3000229],
)  # fmt: skip
def test_a_finely_drawn_surface_of_few_decimals_is_touched_as_its_closed_form_says(seed):
    """Rounding hides the first steps of its roundings, axes of a few facets are off, balls come near the axis.

    A cone ends on the sphere where it begins; one has an arc of 7.7 m over 5 mm; one file draws a line between two
    roundings as well as their meeting, and one a cone that goes on to the end of an arc's first step. Facets of two
    steps have sides across a rim, both of whose ends are put on it. The last step of an arc lies on the next one too.
    The lowest ring of a rounding is one facet but for two steps, or a flat ring, as narrow as a step, below a lid.
    """
    assert check(seed, shots=5) == []


@pytest.mark.slow
def test_a_thousand_drawn_surfaces_are_touched_as_their_closed_forms_say():
    wrong = {}
    for seed in small(1000):
        if found := check(seed, shots=0 if seed % 10 else 5, largest=24, balls=1):
            wrong[seed] = found
    assert not wrong, f"{len(wrong)} surfaces: {wrong}"


def stirrer(hub: float, blades: int, length: float, thickness: float, height: float) -> tuple[Hollow, dict]:
    """Paddles [mm] from z = 0 up."""
    root, pitch = math.asin(thickness / 2 / hub), 2 * math.pi / blades
    points, sweeps = [], []
    for k in range(blades):
        turn = np.array([[math.cos(k * pitch), math.sin(k * pitch)], [-math.sin(k * pitch), math.cos(k * pitch)]])
        x = [hub * math.cos(root), hub + length]
        own = [[x[0], -thickness / 2], [x[1], -thickness / 2], [x[1], thickness / 2], [x[0], thickness / 2]]
        points += list(np.array(own) @ turn)
        sweeps += [0.0, 0.0, 0.0, pitch - 2 * root]
    section = {"kind": "paddles", "hub_radius_mm": hub, "blades": blades, "blade_length_mm": length,
               "blade_thickness_mm": thickness, "height_mm": height, "bottom_mm": 0}  # fmt: skip
    return upright(chain(points, sweeps, closed=True), height), section


SOLID = {name: SIZED[name] for name in ("cylinder", "capsule", "box")} | {"paddles": lambda: stirrer(8, 3, 20, 5, 12)}


@pytest.mark.parametrize("name", SOLID)
def test_a_solid_of_given_sizes_is_touched_as_its_fine_mesh_says(name):
    hollow, section = SOLID[name]()
    case, rng = Case(hollow, vessel_of(section, solid=True), 1e-7, name), np.random.default_rng(0)
    assert [said for radius in (1, 8) for said in check_solid(case, radius, 20, rng)] == []


@pytest.mark.parametrize("radius", [2.0, 5.0])
def test_balls_that_moving_paddles_hit_keep_jacobis_integral(radius):
    """Without losses and friction a body that turns at w does work on a ball, v^2 / 2 - w . (r x v) stays as it was."""
    (hollow, section), rng, turning_hz = stirrer(8, 3, 20, 5, 12), np.random.default_rng(0), 12.0
    triangles = mesh(hollow, 120)
    points = rng.uniform([-36, -36, -8], [36, 36, 20], (300, 3))
    nearest, winding = nearest_on_triangles(triangles, points)
    points = points[(winding < 0.5) & (np.linalg.norm(points - nearest, axis=1) > 1.05 * radius)]
    motion = motion_from_law(RotationMotion(kind="rotation", axis=(0, 0, 1)), turning_hz)
    velocity, vessel = rng.normal(size=points.shape), vessel_of(section, solid=True)
    world = FewBalls(
        points * MM, velocity, radius=radius * MM, vessel=vessel, contact=ELASTIC, step=2e-4 * radius * MM,
        motion=motion, walls=walls_for(vessel, radius * MM), friction=np.zeros((len(points), 2)),
        skin=0.1 * radius * MM,
    )  # fmt: skip

    def integral() -> np.ndarray:
        spin = np.cross(world.balls.position, world.balls.velocity)[:, 2]
        return (world.balls.velocity**2).sum(axis=1) / 2 - 2 * np.pi * turning_hz * spin

    before, seconds = integral(), 5e-3
    world.run(seconds)
    free = np.ones(len(points), dtype=bool)
    free[world.open_contacts.ball[world.open_contacts.slot >= 0]] = False
    hit = free & (np.abs((world.balls.velocity**2 - velocity**2).sum(axis=1)) > 0.1)
    assert hit.sum() > 15
    np.testing.assert_allclose(integral()[free], before[free], atol=2e-4)
    angle = 2 * np.pi * turning_hz * seconds
    back = np.array([[math.cos(angle), -math.sin(angle), 0], [math.sin(angle), math.cos(angle), 0], [0, 0, 1]])
    nearest, winding = nearest_on_triangles(triangles, end := world.balls.position[free] / MM @ back)
    assert (winding < 0.5).all()
    assert np.linalg.norm(end - nearest, axis=1).min() > 0.99 * radius


def lathe(*points: tuple[float, float]) -> Hollow:
    """A turned hollow of lines [mm]."""
    return upright(chain(list(points), [0.0] * (len(points) - 1), closed=False))


def closing(half_deg: float) -> Hollow:
    """A cone that closes to a tip."""
    return lathe((0, 0), (60 * math.tan(math.radians(half_deg)), 60), (0, 60))


@pytest.mark.parametrize(
    ("shape", "rest_mm"),
    [
        pytest.param(closing(12), 4 / math.sin(math.radians(12)), id="narrow tip"),
        pytest.param(closing(35), 4 / math.sin(math.radians(35)), id="tip"),
        pytest.param(lathe((0, -20), (2, -20), (2, 0), (30, 0), (30, 30), (0, 30)), math.sqrt(12), id="bore"),
    ],
)
def test_a_ball_that_fits_no_deeper_rests_on_the_axis(shape, rest_mm):
    """It touches a circle, above the tip of a cone or on the rim of a bore, where every direction is as near."""
    case, radius = from_file(shape, 48, None), 4.0
    assert check_contacts(case, radius, 40, np.random.default_rng(0)) == []
    world = FewBalls(
        np.array([0.05, 0.03, rest_mm + 0.3]) * MM, radius=radius * MM, vessel=case.vessel, gravity=9.81, step=2e-6,
        contact=ELASTIC.model_copy(update={"restitution": 0.3}),
    )  # fmt: skip
    world.run(0.2)
    assert world.balls.position[0] / MM == pytest.approx([0, 0, rest_mm], abs=0.01)
    assert np.abs(world.balls.velocity).max() < 2e-3


def solid_of(seed: int) -> list[str]:
    """What is wrong with the solid that fills the hollow of a seed, for balls outside of it."""
    case, rng = from_file(hollow_of(seed), *style_of(seed, 24), solid=True), np.random.default_rng(seed)
    return [said for radius in (0.5, 4) for said in check_solid(case, radius, 20, rng)]


@pytest.mark.parametrize("seed", [2, 4, 10])
def test_a_drawn_solid_is_touched_as_its_fine_mesh_says(seed):
    assert solid_of(seed) == []


@pytest.mark.slow
def test_further_drawn_solids_are_touched_as_their_fine_meshes_say():
    assert {seed: found for seed in small(8) if (found := solid_of(seed))} == {}


def test_a_ball_between_two_walls_keeps_its_energy_where_one_of_them_goes_on_as_an_arc():
    """It is larger than the rounding that joins the walls; the contact with one goes on while the other is deeper."""
    hollow = hollow_of(640147)
    case, radius = from_file(hollow, 29, 6), 3.503
    start, velocity = np.array([2.18, 0.11, 7.0]), np.array([0.774, -0.633, 0.0])
    world = FewBalls(
        hollow.to_space(start) * MM, hollow.rotation @ velocity, radius=radius * MM, vessel=case.vessel,
        contact=ELASTIC, step=2.5e-4 * radius * MM,
    )  # fmt: skip
    series = world.run(0.15 * radius * MM, sample_every=20)
    elastic, kinetic = series["elastic_J"], series["kinetic_J"].iloc[0]
    assert elastic.max() > 0.5 * kinetic
    assert np.abs(series["imbalance_J"]).max() < 1e-3 * kinetic


def opening(turn_deg: float) -> Hollow:
    """A cylinder of 15 mm that opens into a cone; closes into one if the angle is negative."""
    top = 15 + 20 * math.tan(math.radians(turn_deg))
    return lathe((0, 0), (15, 0), (15, 20), (top, 40), (0, 40))


@pytest.mark.parametrize("turn", [2, 10, 20, 33, 40])
def test_a_hit_on_a_rim_is_one_contact_of_its_restitution(turn):
    """In the wedge between cylinder and cone, over the middle of a facet and over its border."""
    case = from_file(opening(turn), 48, None)
    contact = ELASTIC.model_copy(update={"restitution": 0.5})
    for angle in (0.0, math.pi / 48):
        lean = math.radians(turn) / 2
        inwards = np.array([-math.cos(lean) * math.cos(angle), -math.cos(lean) * math.sin(angle), math.sin(lean)])
        rim = np.array([15 * math.cos(angle), 15 * math.sin(angle), 20.0])
        world = FewBalls((rim + 5.05 * inwards) * MM, -inwards, vessel=case.vessel, contact=contact, step=5e-7)
        world.run(1.5e-3)
        assert len(world.contacts) == 1
        assert world.balls.velocity[0] @ inwards == pytest.approx(0.5, abs=5e-3)


@pytest.mark.parametrize("turn", [1, 5, 15])
def test_a_ball_that_slides_from_a_cylinder_into_a_cone_gains_nothing(turn):
    case = from_file(opening(-turn), 24, None)
    start, gravity = np.array([15 - 5, 0.0, 14.0]) * MM, np.array([0.5, 0.0, 0.0])
    world = FewBalls(start, [0, 0, 0.5], vessel=case.vessel, contact=ELASTIC, gravity=gravity, step=5e-7)
    energy = 0.125 - 0.5 * start[0]
    for _ in world.chunks(0.03, 200):
        now = 0.5 * (world.balls.velocity[0] ** 2).sum() - 0.5 * world.balls.position[0, 0]
        assert now < energy * (1 + 2e-3)
    assert now == pytest.approx(energy, rel=2e-3)


def gutter(middle: float) -> Vessel:
    """Floors that turn by -20, 0 and 20 degrees, the flat one between the others of a width [m]."""
    side, rise = 0.05, 0.05 * math.tan(math.radians(20))
    outline = [(-middle / 2 - side, rise), (-middle / 2, 0), (middle / 2, 0), (middle / 2 + side, rise)]
    outline += [(middle / 2 + side, 0.2), (-middle / 2 - side, 0.2)]
    return prism(np.array(outline), 0.1, np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]]))


@pytest.mark.parametrize("middle", [0.8e-3, 1.744e-3, 3e-3])
@pytest.mark.parametrize("x", [0.0, 2e-5, 3e-4])
def test_a_hit_in_a_narrow_gutter_makes_no_energy(middle, x):
    """Where the contact goes on to another wall the force has a kink, whose error falls with the step."""
    for step in (5e-8, 1.25e-8):
        world = FewBalls([x, -0.05, 5.3e-3], [0, 0, -0.3], vessel=gutter(middle), contact=ELASTIC, step=step)
        world.run(3e-3)
        assert not (world.open_contacts.slot >= 0).any()
        assert (world.balls.velocity**2).sum() == pytest.approx(0.09, rel=2e3 * step)


@pytest.mark.parametrize("facets", [24, 48, 72])
@pytest.mark.parametrize("radius", [0.5, 0.25, 0.1])
def test_a_bead_rests_on_the_floor_of_a_round_jar_beside_its_mantle(facets, radius):
    """In the crescent between the polygon of the floor's drawing and the circle."""
    vessel = vessel_of({"kind": "cylinder", "radius_mm": 40, "height_mm": 60, "facets": facets})
    angle = math.pi / facets
    start = np.array([(40 - 1.02 * radius) * math.cos(angle), (40 - 1.02 * radius) * math.sin(angle), 1.1 * radius])
    world = FewBalls(
        start * MM, [0, 0, -0.05], radius=radius * MM, vessel=vessel, gravity=9.81, step=1e-6 * radius,
        skin=radius * MM / 5,
    )  # fmt: skip
    world.run(4e-3)
    assert world.balls.position[0, 2] / MM == pytest.approx(radius, rel=0.02)


# Mills


JARS = {
    "rim": opening(10),
    "closing": opening(-5),
    "seat": lathe((0, 0), (20, 0), (20, 30), (22, 30), (22, 34), (0, 34)),
    "neck": lathe((0, 0), (20, 0), (20.5, 30), (14, 33), (14, 45), (0, 45)),
    "tip": lathe((0, 6), (20, 0), (20, 35), (0, 35)),
    "stadium": upright(stadium_pieces(15, 12), 35.0),
    "dome": upright(chain([(0, -8), (20, 0), (21, 30), (0, 35)], [0.8, 0.0, 0.5], closed=False)),
}
MOTIONS = {
    "planetary": ({"kind": "planetary", "sun_radius_mm": 70, "ratio": -2}, 400),
    "shaken": ({"kind": "lissajous", "terms": [{"axis": "x", "amplitude_mm": 8},
                                               {"axis": "z", "amplitude_mm": 8, "multiple": 2}]}, 900),
}  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("name", JARS)
@pytest.mark.parametrize("motion", MOTIONS)
def test_the_energy_balance_of_a_mill_with_a_drawn_jar_closes(name, motion):
    keys, speed_rpm = MOTIONS[motion]
    write_stl(Path("made.stl"), mesh(JARS[name], 24), None)
    geometry = {"kind": "stl", "path": "made.stl", "unit": "mm"}
    volume_ml = float(np.einsum("tc,tc->", (t := mesh(JARS[name], 24))[:, 0], np.cross(t[:, 1], t[:, 2]))) / 6e3
    mill = MillConfig(name="made", title="x", source="x", volume_ml=volume_ml, volume_tolerance=0.05,
                      geometry=geometry, motion=keys)  # fmt: skip
    run = RunCase(mill="made", contact="calibrated", ball_diameter_m=0.006, fill_ratio=0.15, speed_hz=speed_rpm / 60,
                  seed=0, settle_s=0.02, discard_s=0.0, window_s=0.15, rayleigh_fraction=0.04)  # fmt: skip
    simulation = Simulation(run, mill, CALIBRATED, DemConfig())
    assert closure(ledger_series(np.concatenate(simulation.run("test").samples))) < 2e-3
