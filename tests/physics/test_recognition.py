"""Round walls are found again in a mesh, however finely it is drawn; what is not round stays as it is drawn."""

import re
from pathlib import Path

import numpy as np
import pytest
import trimesh

from millprint.config.mill import StlGeometry
from millprint.mill.distance import signed_distance
from millprint.mill.vessel import Vessel, build_vessel, shape_vessel
from millprint.mill.wall_features import features_of
from millprint.mill.wall_words import drawn_in_words
from tests import profiles
from tests.profiles import Hollow, chain, circle_pieces, random_rotation, rounded, stadium_pieces, write_stl
from tests.surfaces import check_contacts, hollow_of, style_of, vessel_of
from tests.surfaces import from_file as surface_of


@pytest.fixture
def in_project(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def from_file(mesh: trimesh.Trimesh, **keys) -> Vessel:
    """The vessel of a mesh [m], by way of a binary STL."""
    mesh.apply_scale(1e3)
    mesh.export("made.stl")
    geometry = StlGeometry(kind="stl", path="made.stl", unit="mm", **keys)
    return shape_vessel(geometry, "made", solid=False)


def drawn(vessel: Vessel, turn: np.ndarray | None = None) -> trimesh.Trimesh:
    points, triangles = vessel.triangles()
    mesh = trimesh.Trimesh(points, triangles[:, ::-1], process=False)
    if turn is not None:
        mesh.apply_transform(turn)
    return mesh


TURN = trimesh.transformations.rotation_matrix(0.7, [1, 2, 3])


def shaped(mills, name: str, facets: int, fillet_facets: int) -> Vessel:
    mill = mills[name]
    key = "facets_per_half_circle" if name == "emax_smooth" else "facets"
    geometry = mill.geometry.model_copy(update={key: facets, "fillet_facets": fillet_facets})
    return build_vessel(mill.model_copy(update={"geometry": geometry}))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "fillet_facets", "curves", "facets"),
    [
        *(("planetary", 5, 2, facets) for facets in (24, 44, 61)),
        *(("mixer", 6, 3, 24), ("spex", 5, 3, 44), ("drum", 1, 1, 61), ("emax_smooth", 5, 6, 24)),
    ],
)
def test_a_mesh_of_a_jar_is_that_jar(mills, in_project, name, fillet_facets, curves, facets):
    """In whatever direction it lies, with the same distances as from its sizes, to the digits of the file."""
    given = shaped(mills, name, facets, fillet_facets)
    found = from_file(drawn(given, TURN))
    assert len(found.curves) == len(given.curves) == curves
    assert (found.facet_curves < 0).sum() == (given.facet_curves < 0).sum()
    assert found.volume_m3 == pytest.approx(given.volume_m3, rel=1e-6)
    points = np.random.default_rng(0).uniform(*given.bounds, (400, 3))
    moved = trimesh.transform_points(points, TURN)
    assert signed_distance(found)(moved)[0] == pytest.approx(signed_distance(given)(points)[0], abs=3e-7)


@pytest.mark.parametrize("sides", [6, 12, 17])
def test_a_prism_stays_a_prism(in_project, sides):
    mesh = trimesh.creation.cylinder(radius=0.03, height=0.05, sections=sides)
    assert not from_file(mesh).curves


def test_facets_that_are_meant_are_kept(mills, in_project):
    mesh = drawn(shaped(mills, "planetary", 24, 5))
    assert not from_file(mesh, faceted=True).curves


def test_cones_and_rims_are_found(in_project):
    profile = np.array([[0, 0], [20, 0], [35, 30], [35, 40], [25, 40], [25, 50], [0, 50]]) / 1e3
    found = from_file(trimesh.creation.revolve(profile, sections=48))
    assert sorted(curve.kind for curve in found.curves) == ["cone", "cylinder", "cylinder"]
    (rim,) = features_of(found).rims
    assert rim.radius == pytest.approx(0.025, rel=1e-6)


def test_a_patch_is_exact_as_a_whole_or_flat_as_a_whole(in_project):
    """A mantle that opens into facets that lie on no surface that is known."""
    angle = 2 * np.pi * np.arange(48) / 48
    mesh = trimesh.creation.revolve(np.array([[0, 0], [20, 0], [20, 30], [25, 50], [0, 50]]) / 1e3, sections=48)
    upper = np.isclose(np.hypot(*mesh.vertices[:, :2].T), 0.025)
    mesh.vertices[upper, :2] *= (1 + 0.1 * np.cos(3 * np.arctan2(*mesh.vertices[upper, 1::-1].T)))[:, None]
    assert len(angle) < upper.sum() + 1
    found = from_file(mesh)
    assert not found.curves
    assert "stay flat" in " ".join(found.report)


def test_noise_of_the_file_is_passed_over_and_more_is_taken_as_drawn(mills, in_project):
    for noise, found in ((5e-8, True), (5e-6, False)):
        mesh = drawn(shaped(mills, "drum", 48, 1))
        mesh.vertices += np.random.default_rng(0).normal(scale=noise, size=mesh.vertices.shape)
        assert bool(from_file(mesh).curves) == found


def test_a_round_jar_holds_what_its_formula_says(mills):
    """A cylinder with a rounded bottom: pi r^2 h, less what the fillet fills in (Pappus)."""
    vessel, r, h, f = shaped(mills, "planetary", 48, 5), 0.0375, 0.058, 0.008
    # The corner between floor and mantle outside of a quarter circle: its area, and its middle from the axis.
    corner = (1 - np.pi / 4) * f**2
    middle = r - f * (10 - 3 * np.pi) / (12 - 3 * np.pi)
    assert vessel.volume_m3 == pytest.approx(np.pi * r**2 * h - 2 * np.pi * middle * corner, rel=2e-5)


def test_what_is_nearly_round_is_said_with_how_far_off_it_is(in_project):
    mesh = trimesh.creation.revolve(np.array([[0, 0], [20, 0], [25, 30], [0, 30]]) / 1e3, sections=48)
    mesh.vertices += np.random.default_rng(0).normal(scale=1e-5, size=mesh.vertices.shape)
    vessel = from_file(mesh)
    (words,) = vessel.report
    assert re.match(r"a cone of (19\.9|20)\S* to 25\S* mm would fit 0 of \d+ facets; vertices are up to 0\.0", words)
    assert "export it with more decimals" in (drawn_in_words(vessel) or "")


def test_decimals_are_not_advised_where_a_wall_is_no_round_surface(in_project):
    mesh = trimesh.creation.cylinder(radius=0.02, height=0.03, sections=96)
    mesh.apply_scale([1.4, 1, 1])
    words = drawn_in_words(from_file(mesh)) or ""
    assert "near no cylinder" in words and "decimals" not in words


def hollow(name: str, radius: float) -> Hollow:
    if name == "turned":
        points = [(0, 0), (radius, 0), (radius, 2 * radius), (0, 2 * radius)]
        return Hollow(name, chain(points, [0.0] * 3, closed=False))
    pieces = circle_pieces(radius) if name == "circle" else stadium_pieces(radius, 1.5 * radius)
    return Hollow(name, pieces, 1.2 * radius)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "radius", "decimals"), [("circle", 15, 3), ("turned", 6, 2), ("circle", 40, None), ("stadium", 20, None)]
)
def test_a_wall_is_known_where_its_facets_are_as_narrow_as_the_rounding(in_project, name, radius, decimals):
    """Rounding folds such an outline and turns its triangles over; a circle through a few vertices is any circle."""
    vessel = surface_of(hollow(name, radius), 5000, decimals).vessel
    off = 1e-3 if decimals is None else 10.0**-decimals
    assert [curve.major * 1e3 for curve in vessel.curves] == pytest.approx([radius] * len(vessel.curves), abs=off)
    assert len(vessel.curves) == (2 if name == "stadium" else 1)
    vessel.triangles()


def test_a_shallow_cone_whose_facets_were_merged_goes_all_the_way_round(in_project):
    """A merged facet has its vertices nearer to one side, and its middle not in every gap between them."""
    found = surface_of(hollow_of(300415), *style_of(300415)).vessel
    assert [curve.kind for curve in found.curves].count("cone") == 3 and not any(curve.part for curve in found.curves)


def test_the_first_step_of_an_arc_is_not_the_last_of_another(in_project):
    """Both its vertices lie on the finer arc too; the coarse one has five steps with it, and four would be cones."""
    found = surface_of(hollow_of(800198), *style_of(800198)).vessel
    assert sorted(curve.kind for curve in found.curves) == ["cone"] * 3 + ["sphere"] + ["torus"] * 2
    tori = [curve.minor * 1e3 for curve in found.curves if curve.kind == "torus"]
    assert sorted(tori) == pytest.approx([7.02, 17.26], abs=0.03)


@pytest.mark.parametrize(
    ("turn", "facets", "decimals", "steps"), [(30, 24, None, 2), (25, 24, 3, 2), (-45, 24, 4, 3), (30, 48, 3, 4)]
)
def test_a_rounding_of_few_steps_is_an_arc(in_project, monkeypatch, turn, facets, decimals, steps):
    """Between a mantle and a cone that are tangent to it."""
    monkeypatch.setattr(profiles, "FEWEST_STEPS", 1)
    x, z = 15 * np.sin(np.radians(turn)), 15 * np.cos(np.radians(turn))
    corners = [(0, 0), (30, 0), (30, 25), (30 - x, 25 + z), (0, 25 + z)]
    made = Hollow("rounded", rounded(chain(corners, [0.0] * 4, closed=False), 1, 2, 6.0))
    made = made.placed(random_rotation(np.random.default_rng(1)), np.array([3.0, -7.0, 11.0]))
    assert len(profiles.mesh(made, facets)) == 2 * facets * (steps + 3)
    case = surface_of(made, facets, decimals)
    assert [curve.kind for curve in case.vessel.curves] == ["cylinder", "cone", "torus"]
    assert check_contacts(case, 4.0, 30, np.random.default_rng(0)) == []


def on_sphere(angle_deg: float) -> tuple[float, float]:
    """A place (r, z) [mm] on a sphere of 20 mm about the origin, by its angle from the lower pole."""
    return 20 * np.sin(np.radians(angle_deg)), -20 * np.cos(np.radians(angle_deg))


def lathe(points: list, sweeps_deg: list[float]) -> Hollow:
    made = Hollow("lathe", chain(points, list(np.radians(sweeps_deg)), closed=False))
    return made.placed(random_rotation(np.random.default_rng(1)), np.array([3.0, -7.0, 11.0]))


@pytest.mark.parametrize("turn", [[0, 1, 2], [1, 2, 0], [2, 0, 1]])
@pytest.mark.parametrize("facets", [24, 25, 26, 27])
def test_a_whole_sphere_has_no_hole_at_a_pole_of_the_frame(in_project, facets, turn):
    """The axis of the frame goes through a vertex, a facet or a side of it, at either end."""
    for phase in (0.0, np.pi / facets, np.pi / 2, np.pi / 2 + np.pi / facets, 1.0):
        made = profiles.sphere(10.0).placed(np.eye(3)[turn], np.array([1.0, 2.0, 3.0]))
        (curve,) = surface_of(made, facets, None, phase).vessel.curves
        assert curve.kind == "sphere"
        assert curve.arc is None


@pytest.mark.parametrize("decimals", [None, 3, 2])
@pytest.mark.parametrize(("steps", "facets"), [(2, 24), (3, 24), (4, 36), (5, 60), (6, 30)])
@pytest.mark.parametrize("pole", ["vertex", "disc"])
def test_a_dome_of_few_steps_is_a_sphere(in_project, monkeypatch, pole, steps, facets, decimals):
    """Its mantle is not tangent to it; a disc at the pole is as wide as a step."""
    monkeypatch.setattr(profiles, "FEWEST_STEPS", 1)
    step = 360 / facets
    begin = 0 if pole == "vertex" else step / 2
    rim = on_sphere(begin + steps * step)
    mantle = [rim, (rim[0], 25.0), (0.0, 25.0)]
    drawn = lathe([on_sphere(0), *mantle], [steps * step, 0, 0])
    if begin:
        drawn = lathe([(0.0, on_sphere(begin)[1]), on_sphere(begin), *mantle], [0, steps * step, 0, 0])
    case = surface_of(drawn, facets, decimals)
    assert sorted(curve.kind for curve in case.vessel.curves) == ["cylinder", "sphere"]
    assert (case.vessel.facet_curves < 0).sum() == 1
    case = case._replace(hollow=lathe([on_sphere(0), *mantle], [begin + steps * step, 0, 0]))
    assert check_contacts(case, 3.0, 40, np.random.default_rng(0)) == []


@pytest.mark.parametrize("decimals", [None, 3])
@pytest.mark.parametrize("floor", [4, 10, 14])
def test_a_flat_floor_in_a_sphere_stays_one(in_project, floor, decimals):
    made = lathe([(0.0, on_sphere(floor)[1]), on_sphere(floor), on_sphere(90), on_sphere(180)], [0, 90 - floor, 90])
    case = surface_of(made, 48, decimals)
    assert [curve.kind for curve in case.vessel.curves] == ["sphere"]
    assert (case.vessel.facet_curves < 0).sum() == 1
    assert check_contacts(case, 2.0, 40, np.random.default_rng(0)) == []


@pytest.mark.parametrize(("wall", "kind"), [((60, 80), "cone"), ((80, 100), "cylinder")])
def test_a_wall_whose_ends_are_on_one_sphere_is_none_of_its_steps(in_project, wall, kind):
    """It is far longer than they are."""
    low, high = wall
    made = lathe([on_sphere(each) for each in (0, low, high, 180)], [low, 0, 180 - high])
    case = surface_of(made, 48, None)
    assert sorted(curve.kind for curve in case.vessel.curves) == sorted([kind, "sphere", "sphere"])
    assert check_contacts(case, 2.0, 60, np.random.default_rng(0)) == []


def test_cones_that_follow_each_other_stay_cones(in_project):
    """The places of a barrel lie on a circle, and its steps are alike; its ends are not tangent to that."""
    barrel = Hollow("barrel", chain([(0, 0), (18, 0), (20, 12), (20, 24), (18, 36), (0, 36)], [0.0] * 5, closed=False))
    assert sorted(curve.kind for curve in surface_of(barrel, 24, None).vessel.curves) == ["cone", "cone", "cylinder"]


def test_a_file_whose_facets_fold_on_its_walls_is_not_refused(in_project):
    """In inches with three decimals, the steps of its rounding are eight times as long as the grid."""
    drafted = chain([(0, 0), (38.1, 0), (39.763, 63.5), (0, 63.5)], [0.0] * 3, closed=False)
    write_stl(Path("made.stl"), profiles.mesh(Hollow("inch", rounded(drafted, 1, 2, 6.35)), 192, 0.3) / 25.4, 3)
    assert vessel_of({"kind": "stl", "path": "made.stl", "unit": "inch"}).curves


@pytest.mark.slow
@pytest.mark.parametrize("seed", [400017])
def test_a_file_with_too_few_decimals_stays_flat_and_says_so(in_project, seed):
    """Small pieces of it seem to be round; a floor that was made tangent to one goes back to its place."""
    found = surface_of(hollow_of(seed), *style_of(seed))
    assert found.triangles is not None and "stay flat" in found.vessel.report[-1]
