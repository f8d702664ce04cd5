"""Vessels from files of triangles: the same facets as from parameters, and refusals of invalid surfaces."""

import os
from pathlib import Path

import numpy as np
import pytest
import trimesh

from millprint.config.errors import ConfigError
from millprint.config.included import load_mill
from millprint.config.load import check_model
from millprint.config.mill import MillConfig, StlGeometry
from millprint.config.sweep import Case
from millprint.dem.case_checks import check_ball_size, check_room, checked_bodies
from millprint.mill.bodies import check_volume
from millprint.mill.mesh import read_surface, self_intersection
from millprint.mill.mesh_file import read_triangles, weld, without_slivers
from millprint.mill.outlines import FlatFacets, facets_of, without_overlap
from millprint.mill.vessel import Vessel, build_vessel, drawn_shape
from millprint.mill.wall_features import features_of
from tests.refusals import refusal


@pytest.fixture(autouse=True)
def project(tmp_path, monkeypatch) -> Path:
    """An empty project: paths of files are relative to its root."""
    folder = tmp_path / "project"
    folder.mkdir()
    monkeypatch.chdir(folder)
    return folder


def read(path: str, unit: str = "mm") -> Vessel:
    geometry = StlGeometry(kind="stl", path=path, unit=unit)
    return Vessel(facets_of(drawn_shape(geometry, "mill.yaml: geometry", solid=False)[0]))


def fault(mesh: trimesh.Trimesh, unit: str = "mm") -> str:
    mesh.export("bad.stl")
    message = refusal(read, "bad.stl", unit)
    assert message.startswith("mill.yaml: geometry.path = 'bad.stl': ")
    return message


def block(x: float = 20, y: float = 20, z: float = 20) -> trimesh.Trimesh:
    return trimesh.creation.box((x, y, z))


def join(*meshes: trimesh.Trimesh) -> trimesh.Trimesh:
    return trimesh.util.concatenate(meshes)


@pytest.mark.slow
@pytest.mark.parametrize(("name", "suffix", "rounding_m"), [("emax_post", "stl", 2e-8), ("emax", "obj", 2e-9)])
def test_a_jar_from_a_file_has_the_facets_that_its_parameters_give(name, suffix, rounding_m):
    expected = build_vessel(load_mill(name))
    points, triangles = expected.triangles()
    # A file's normals point out of the hollow; those of the vessel point into it.
    trimesh.Trimesh(points * 1e3, triangles[:, ::-1], process=False).export(f"jar.{suffix}")
    found = read(f"jar.{suffix}")
    assert len(triangles) > 2 * len(found.facets)
    assert matched(found, expected, rounding_m)
    assert found.volume_m3 == pytest.approx(expected.volume_m3, rel=1e-7)
    assert len(features_of(found).lines) == len(features_of(expected).lines)
    assert len(features_of(found).corners) == len(features_of(expected).corners)


def matched(found: Vessel, expected: Vessel, tolerance_m: float) -> bool:
    """Whether each facet of one vessel is one of the other: the same loops of vertices, wherever they begin."""
    left = list(expected.facets)
    for facet in found.facets:
        middle = facet.loops[0].mean(axis=0)
        near = [other for other in left if np.linalg.norm(other.loops[0].mean(axis=0) - middle) < tolerance_m]
        twin = next((other for other in near if same_loops(facet.loops, other.loops, tolerance_m)), None)
        if twin is None or not np.allclose(facet.normal, twin.normal, atol=1e-5):
            return False
        left = [other for other in left if other is not twin]
    return not left


def same_loops(loops: tuple, others: tuple, tolerance_m: float) -> bool:
    return len(loops) == len(others) and all(
        any(
            len(loop) == len(other)
            and any(np.abs(np.roll(other, k, axis=0) - loop).max() < tolerance_m for k in range(len(loop)))
            for other in others
        )
        for loop in loops
    )


def test_a_side_cut_by_vertices_in_its_middle_is_one_side():
    """A box whose faces are cut into many triangles has six facets of four corners."""
    mesh = block()
    for _ in range(3):
        mesh = mesh.subdivide()
    mesh.export("box.stl")
    vessel = read("box.stl")
    assert len(mesh.faces) == 12 * 64
    assert [len(loop) for facet in vessel.facets for loop in facet.loops] == [4] * 6
    assert vessel.volume_m3 == pytest.approx(8e-6)


def test_a_facet_with_a_hole_keeps_its_hole():
    ring = trimesh.creation.annulus(r_min=10, r_max=20, height=15, sections=16)
    ring.export("ring.stl")
    vessel = read("ring.stl")
    assert sorted(len(facet.loops) for facet in vessel.facets) == [1] * 32 + [2, 2]
    assert all(np.abs(f.loops[0]).max() > 0.015 for f in vessel.facets if len(f.loops) == 2)


def jar(radius: float, height: float, sections: int, fillet: float = 0) -> trimesh.Trimesh:
    """A round hollow [mm], tilted so that no coordinate is exact, with six rows of facets across its fillet."""
    angles = np.linspace(0, np.pi / 2, 7) if fillet else [np.pi / 2]
    edge = [[radius - fillet + fillet * np.sin(angle), fillet * (1 - np.cos(angle))] for angle in angles]
    mesh = trimesh.creation.revolve([[0, 0], *edge, [radius, height], [0, height]], sections=sections)
    return mesh.apply_transform(trimesh.transformations.rotation_matrix(0.7, [0.3, 0.5, 0.8]))


def write_stl(mesh: trimesh.Trimesh, number: str, noise: np.ndarray | float = 0.0) -> None:
    """jar.stl as text, with a format of its numbers."""
    rows = ["solid jar"]
    for corners in mesh.triangles + noise:
        rows += ["facet normal 0 0 0", "outer loop"]
        rows += ["vertex " + " ".join(number % value for value in corner) for corner in corners]
        rows += ["endloop", "endfacet"]
    Path("jar.stl").write_text("\n".join([*rows, "endsolid"]))


@pytest.mark.parametrize(
    ("sizes", "number", "rounding_mm"),
    [
        ((40, 60, 24), "%.2f", 5e-3),
        ((40, 60, 48, 5), "%.2f", 5e-3),
        ((8, 20, 24), "%.3f", 5e-4),
        ((8, 20, 48, 2), "%.3f", 5e-4),
        ((8, 20, 96, 2), "%.4f", 5e-5),
        ((20, 45, 48, 3), "%.6g", 5e-5),
        ((20, 45, 48, 3), "%e", 5e-6),
    ],
)
def test_flat_facets_are_found_with_the_rounding_of_the_file(sizes, number, rounding_mm):
    """Two ends, and a facet for each section and row; corners in place, to what the rounding moves them."""
    sections = sizes[2]
    rows = 7 if len(sizes) > 3 else 1
    write_stl(jar(*sizes), number)
    surface = read_surface(StlGeometry(kind="stl", path="jar.stl", unit="mm"))
    assert surface.rounding == pytest.approx(rounding_mm * 1e-3)
    assert len(surface.facets) == 2 + sections * rows
    assert sorted(len(loop) for loops in surface.facets for loop in loops)[-2:] == [sections] * 2
    for unit, metre in (("inch", 25.4), ("cm", 10)):
        scaled = read_surface(StlGeometry(kind="stl", path="jar.stl", unit=unit, scale=0.5))
        assert scaled.rounding == pytest.approx(rounding_mm * 1e-3 * metre * 0.5)


def test_a_point_that_is_rounded_in_two_ways_is_one():
    """Each triangle has its own copy of a corner, which rounds up in one and down in another."""
    mesh = jar(20, 45, 48, 3)
    noise = np.random.default_rng(0).normal(scale=2e-5, size=mesh.triangles.shape)
    write_stl(mesh, "%.3f", noise)
    assert len(np.unique(read_triangles(Path("jar.stl").read_bytes())[0], axis=0)) > len(mesh.vertices)
    assert read("jar.stl").volume_m3 == pytest.approx(mesh.volume * 1e-9, rel=1e-4)


@pytest.mark.parametrize(("unit", "metre"), [("mm", 1e-3), ("cm", 1e-2), ("m", 1.0), ("inch", 0.0254)])
def test_units(unit, metre):
    size = 0.05 / metre
    block(size, size, size).export("box.stl")
    assert read("box.stl", unit).volume_m3 == pytest.approx(0.05**3, rel=1e-6)


def test_open_is_refused():
    mesh = block()
    mesh.update_faces(np.arange(len(mesh.faces)) > 0)
    assert "open: the edge from" in fault(mesh)


def test_triangles_turned_against_the_rest_are_refused():
    mesh = block()
    mesh.faces[0] = mesh.faces[0][::-1]
    assert "are not oriented alike" in fault(mesh)


def test_an_inside_out_surface_is_refused_with_a_remedy():
    mesh = block()
    mesh.faces = mesh.faces[:, ::-1]
    message = fault(mesh)
    assert "inside out" in message
    assert "from the hollow into the wall" in message


def test_two_boxes_that_share_an_edge_are_not_manifold():
    other = block()
    other.apply_translation([20, 20, 0])
    assert "not manifold: the edge" in fault(join(block(), other))


def turned(*profile: tuple[float, float], sections: int = 48) -> trimesh.Trimesh:
    """A body of a profile (radius, height) [mm], drawn with 48 facets a turn."""
    return trimesh.creation.revolve(profile, sections=sections)


def hollow(radius: float = 20, height: float = 40, bottom: float = 0) -> trimesh.Trimesh:
    return turned((0, bottom), (radius, bottom), (radius, bottom + height), (0, bottom + height))


def cup(wall: float) -> trimesh.Trimesh:
    return turned((0, 0), (20, 0), (20, 40), (20 - wall, 40), (20 - wall, wall), (0, wall))


def moved(mesh: trimesh.Trimesh, x: float = 0, y: float = 0, z: float = 0) -> trimesh.Trimesh:
    return mesh.apply_translation([x, y, z])


def tilted(mesh: trimesh.Trimesh) -> trimesh.Trimesh:
    return mesh.apply_transform(trimesh.transformations.rotation_matrix(0.9, [1, 1, 0]))


def inside_out(mesh: trimesh.Trimesh) -> trimesh.Trimesh:
    mesh.invert()
    return mesh


ROUNDED = [(20 - 3 * (1 - np.sin(a)), 3 * (1 - np.cos(a))) for a in np.linspace(0, np.pi / 2, 9)]
SPHERE, LESS = ([(r * np.sin(a), 20 - r * np.cos(a)) for a in np.linspace(0, np.pi / 2, 13)] for r in (20, 16))
ROUND = {"kind": "cylinder", "radius_mm": 20, "height_mm": 40}
STADIUM = {"kind": "stadium", "end_radius_mm": 20, "straight_mm": 1, "height_mm": 40, "facets_per_half_circle": 24}
OWN_WALL, NO_ROOM = "drawn as its own wall", "nowhere is room for a ball of 10 mm; at most 7.99 mm"
TWO, LID, BODIES = "two hollows are two mills", "a lid or another body", "there bodies touch"
CUP, CROSSES = "is the wall of a cup", "crosses itself"


@pytest.mark.parametrize(
    ("shape", "ball_mm", "cause"),
    [
        # A ball that is larger than a rounding touches both walls, and a tip or a neck is out of its reach.
        pytest.param(ROUND | {"fillet_radius_mm": 3}, 10, "", id="fillet"),
        pytest.param(turned((0, 0), *ROUNDED, (20, 40), (0, 40)), 10, "", id="fillet, file"),
        pytest.param(turned((0, 0), (20, 40), (0, 40)), 10, "", id="cone with its tip down"),
        pytest.param(turned((0, 0), (20, 20), (0, 40)), 10, "", id="two cones"),
        pytest.param(turned((0, 15), (20, 0), (20, 40), (0, 40)), 10, "", id="cone that juts in"),
        pytest.param(turned((0, 0), (20, 0), (20, 40), (4, 40), (4, 60), (0, 60)), 10, "", id="neck"),
        # Hollows that are not convex, and are no cups.
        pytest.param(turned((15, 0), (27, 0), (27, 40), (15, 40), (15, 0)), 10, "", id="ring"),
        pytest.param(turned((0, 20), (8, 20), (8, 0), (20, 0), (20, 40), (0, 40)), 10, "", id="post on the floor"),
        pytest.param(turned((0, 0), (20, 0), (20, 15), (6, 20), (20, 25), (20, 40), (0, 40)), 10, "", id="waist"),
        # Too narrow.
        pytest.param(ROUND | {"radius_mm": 4}, 10, "not fit", id="bore"),
        pytest.param({"kind": "box", "x_mm": 8, "y_mm": 60, "z_mm": 60}, 10, "not fit", id="slit"),
        pytest.param(hollow(4, 60), 10, "not fit in mill planetary; at most 7.9", id="bore, file"),
        pytest.param(hollow(2, 4), 10, "jar.stl in mm is 4 x 4 x 4 mm; if it is not so, correct geom", id="cm as mm"),
        pytest.param(tilted(hollow(4, 60)), 10, "nowhere is room for a ball of 10 mm; at most 7.9", id="bore, tilted"),
        pytest.param(turned((0, 0), (4, 40), (0, 40)), 10, "at most 7.23 mm", id="narrow cone"),
        pytest.param(turned((0, 0), (20, 40), (0, 40)), 30, "nowhere is room for a ball of 30 mm", id="ball too wide"),
        pytest.param(turned((15, 0), (23, 0), (23, 40), (15, 40), (15, 0)), 10, NO_ROOM, id="narrow ring"),
        pytest.param(STADIUM | {"fillet_radius_mm": 0, "post": {"radius_mm": 16}}, 10, "nowhere is room", id="post"),
        # Profiles that cross themselves.
        pytest.param(turned((0, 0), (20, 0), (10, 30), (10, 20), (20, 50), (0, 50)), 5, CROSSES, id="crossing"),
        pytest.param(turned((0, 0), (20, 0), (-5, 40), (0, 40)), 5, CROSSES, id="crossing of the axis"),
        # More than one body.
        pytest.param(join(hollow(), moved(hollow(), 50)), 5, TWO, id="hollows apart"),
        pytest.param(join(hollow(), moved(hollow(), 30)), 5, TWO, id="hollows in each other"),
        pytest.param(join(block(), moved(block(), 20, 20, 20)), 5, TWO, id="hollows that share a corner"),
        pytest.param(join(hollow(), hollow(20, 4, 45)), 5, LID, id="lid apart"),
        pytest.param(join(hollow(), hollow(21, 4, 39)), 5, LID, id="lid in the jar"),
        pytest.param(join(hollow(), hollow(24, 4, 40)), 5, LID, id="lid that touches in a point"),
        pytest.param(join(hollow(), hollow(20, 4, 40)), 5, BODIES, id="lid that touches"),
        pytest.param(join(hollow(), moved(block(4, 8, 20), 0, 0, 20)), 5, "one of `inserts`", id="baffle"),
        # A vessel that is drawn as its own wall.
        pytest.param(join(hollow(), hollow(17, 34, 3)), 5, OWN_WALL + ", with an", id="two surfaces"),
        pytest.param(join(hollow(), inside_out(hollow(17, 34, 3))), 5, "the hollow (30.78 mL", id="two senses"),
        pytest.param(join(inside_out(hollow()), hollow(17, 34, 3)), 5, OWN_WALL, id="two senses, outside in"),
        pytest.param(cup(1), 0.6, CUP, id="thin cup"),
        pytest.param(tilted(cup(4)), 2, "give its hollow, about 28.87 mL", id="cup, tilted"),
        pytest.param(cup(8), 5, CUP, id="thick cup"),
        pytest.param(turned(*SPHERE, *LESS[::-1]), 2, CUP, id="bowl"),
        pytest.param(turned((0, 0), (20, 0), (20, 9), (28, 9), (28, 40), (16, 40), (16, 4), (0, 4)), 2, CUP, id="rim"),
        pytest.param(inside_out(cup(4)), 2, "inside out", id="cup, inside out"),
    ],
)  # fmt: skip
def test_a_shape_in_which_nothing_can_be_milled_is_refused_with_its_cause(shape, ball_mm, cause):
    if isinstance(shape, trimesh.Trimesh):
        shape.export("jar.stl")
        shape = {"kind": "stl", "path": "jar.stl", "unit": "mm"}
    content = load_mill("planetary").model_dump(exclude={"geometry"}, exclude_none=True)
    mill = check_model(content | {"geometry": shape}, MillConfig, "mill.yaml")
    case = Case(
        mill="planetary", contact="calibrated", ball_diameter_m=ball_mm / 1e3, fill_ratio=0.1, speed_hz=1.0, seed=0,
        settle_s=0.1, discard_s=0.1, window_s=0.1, rayleigh_fraction=0.1,
    )  # fmt: skip
    try:
        mill = mill.model_copy(update={"volume_ml": build_vessel(mill).volume_m3 * 1e6})
        bodies = checked_bodies({"planetary": mill})
        check_ball_size(bodies["planetary"][0].vessel, mill, ball_mm / 1e3, "my.yaml: sweep")
        check_room([case], {"planetary": mill}, bodies, "my.yaml: sweep")
        told = ""
    except ConfigError as error:
        told = str(error)
    assert (cause in told if cause else told == "") and "\n" not in told, told


def test_a_cup_is_named_where_the_volume_of_its_hollow_is_given():
    """A cup whose wall is so thick that it could be a hollow with a post."""
    cup(11).export("cup.stl")
    content = load_mill("emax").model_dump() | {"volume_ml": np.pi * 9**2 * 29 / 1e3}
    mill = MillConfig(**content | {"geometry": {"kind": "stl", "path": "cup.stl", "unit": "mm"}})
    with pytest.raises(ConfigError, match=CUP):
        check_volume(mill, build_vessel(mill))


def with_point(mesh: trimesh.Trimesh, face: int, point: np.ndarray) -> trimesh.Trimesh:
    """A mesh with a point at the first side of a face, whose neighbour across that side does not know of it."""
    new, (a, b, c) = len(mesh.vertices), mesh.faces[face]
    faces = np.vstack([np.delete(mesh.faces, face, axis=0), [[a, new, c], [new, b, c], [a, b, new]]])
    return trimesh.Trimesh(np.vstack([mesh.vertices, point]), faces, process=False)


def test_a_needle_as_wide_as_the_tolerance_loses_its_short_side():
    """Sides of 0.02 mm of a file of two decimals are that long but for the last bit."""
    sphere, tolerance = trimesh.creation.icosphere(subdivisions=1, radius=0.02), 2e-5
    for face in range(0, len(sphere.faces), 9):
        start, end, _ = sphere.triangles[face]
        beside = start + tolerance * (1 + 1e-12) * (end - start) / np.linalg.norm(end - start)
        split = with_point(sphere, face, beside)
        points, triangles = without_slivers(*weld(split.vertices, split.faces, 1e-9), tolerance)
        assert len(triangles) == len(sphere.faces)
        assert np.linalg.norm(points[:, None] - sphere.vertices, axis=2).min(axis=1).max() < 1.1 * tolerance


@pytest.mark.parametrize("share", [0.5, 0.3, 1e-4, 1e-9])
def test_a_triangle_without_area_is_left_out(share):
    """A corner in the middle of a side, or next to another corner."""
    mesh = block().subdivide()
    for face in range(0, 40, 7):
        start, end, _ = mesh.triangles[face]
        with_point(mesh, face, start + share * (end - start)).export("thin.obj")
        vessel = read("thin.obj")
        assert [len(loop) for facet in vessel.facets for loop in facet.loops] == [4] * 6
        assert vessel.volume_m3 == pytest.approx(8e-6)


@pytest.mark.parametrize(("size", "unit"), [(50, "m"), (200, "inch"), (0.05, "mm"), (400, "cm")])
def test_a_wrong_unit_is_refused(size, unit):
    assert "correct `unit`" in fault(block(size, size, size), unit)


def dented(depth: float) -> trimesh.Trimesh:
    """A box of 20 mm whose top is pushed down in the middle, past the floor if the depth is more than 20 mm."""
    mesh = block().subdivide().subdivide()
    top = np.isclose(mesh.vertices[:, 2], 10) & (np.abs(mesh.vertices[:, :2]).max(axis=1) < 6)
    vertices = mesh.vertices.copy()
    vertices[top, 2] -= depth
    return trimesh.Trimesh(vertices, mesh.faces, process=False)


def test_a_dent_is_a_vessel_until_it_breaks_through_the_floor():
    dented(15).export("dent.stl")
    assert read("dent.stl").volume_m3 < 8e-6
    assert "cuts through itself" in fault(dented(25))


@pytest.mark.parametrize("seed", range(6))
def test_two_bodies_intersect_exactly_if_their_edges_do(seed):
    """Random pairs of tetrahedra: intersecting surfaces are found, and only those."""
    rng = np.random.default_rng(seed)
    found = {True: 0, False: 0}
    for _ in range(40):
        first, second = rng.normal(size=(4, 3)), rng.normal(size=(4, 3)) + rng.uniform(0, 2, 3)
        faces = np.array([[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]])
        meets = self_intersection(np.vstack([first, second]), np.vstack([faces, faces + 4]), 1e-9) is not None
        assert meets == surfaces_meet(first, second, faces)
        found[meets] += 1
    assert min(found.values()) > 3


def surfaces_meet(first: np.ndarray, second: np.ndarray, faces: np.ndarray) -> bool:
    """Whether an edge of one tetrahedron crosses a face of the other, by solving for the crossing."""
    for a, b in ((first, second), (second, first)):
        for i in range(4):
            for j in range(i):
                for face in b[faces]:
                    matrix = np.column_stack([a[j] - a[i], face[0] - face[1], face[0] - face[2]])
                    t, u, v = np.linalg.solve(matrix, face[0] - a[i])
                    if 0 < t < 1 and u > 0 and v > 0 and u + v < 1:
                        return True
    return False


def test_a_surface_folded_onto_itself_is_found():
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0.2, 0.3, 0]], dtype=float)
    assert self_intersection(points, np.array([[0, 1, 2], [1, 0, 3]]), 1e-9) == (0, 1)
    beside = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0.2, -0.3, 0]], dtype=float)
    assert self_intersection(beside, np.array([[0, 1, 2], [1, 0, 3]]), 1e-9) is None


@pytest.mark.parametrize(("turn", "overlaps"), [(300, False), (420, True)])
def test_a_flat_ring_that_runs_over_itself_is_known(turn, overlaps):
    """Its triangles all turn alike, and each meets only its neighbours in a side."""
    angle = np.radians(np.linspace(0, turn, 40))
    arm = np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])
    facets = FlatFacets([[np.concatenate([2 * arm, arm[::-1]])]], np.zeros(78, dtype=int))
    assert (without_overlap(facets) < 0).all() == overlaps


def test_a_link_out_of_the_project_is_refused(project):
    block().export(project.parent / "outside.stl")
    (project / "jar.stl").symlink_to(project.parent / "outside.stl")
    with pytest.raises(ConfigError, match="leads out of the project"):
        read("jar.stl")


def test_a_missing_file_and_a_missing_unit_are_refused():
    with pytest.raises(ConfigError, match="no such file"):
        read("jar.stl")
    content = load_mill("emax").model_dump()
    content["geometry"] = {"kind": "stl", "path": "jar.stl"}
    with pytest.raises(ConfigError, match=r"emax.yaml: geometry.unit: this key is missing"):
        check_model(content, MillConfig, "emax.yaml")


def test_the_volume_in_the_yaml_must_be_that_of_the_file():
    block(50, 50, 50).export("box.stl")
    content = load_mill("emax").model_dump()
    content["geometry"] = {"kind": "stl", "path": "box.stl", "unit": "mm"}
    vessel = build_vessel(MillConfig(**content))
    assert vessel.volume_m3 == pytest.approx(125e-6)
    check_volume(MillConfig(**content), vessel)
    content["volume_ml"] = 130
    with pytest.raises(
        ConfigError, match=r"volume_ml = 130: box.stl in mm holds 125 mL; correct it, or geometry.unit, or"
    ):
        check_volume(MillConfig(**content), vessel)
    check_volume(MillConfig(**content, volume_tolerance=0.1), vessel)
    with pytest.raises(ConfigError, match=r"holds 125 mL; correct it, or write unit: cm in geometry, or"):
        check_volume(MillConfig(**content | {"volume_ml": 125000}), vessel)
    content["geometry"]["volume_tolerance"] = 0.1
    with pytest.raises(ConfigError) as caught:
        check_model(content, MillConfig, "emax.yaml")
    line = "emax.yaml: geometry.volume_tolerance = 0.1: unknown key; it belongs to the top level"
    assert str(caught.value) == line


def test_a_shape_has_one_vessel_until_its_file_is_written_again():
    content = load_mill("emax").model_dump() | {"volume_tolerance": 1.0}
    content["geometry"] = {"kind": "stl", "path": "box.stl", "unit": "mm"}
    block(50, 50, 50).export("box.stl")
    first = build_vessel(MillConfig(**content))
    assert build_vessel(MillConfig(**content)) is first
    block(60, 50, 50).export("box.stl")
    os.utime("box.stl", ns=(0, 0))
    assert build_vessel(MillConfig(**content)).volume_m3 == pytest.approx(150e-6)
    content["geometry"]["unit"] = "cm"
    assert build_vessel(MillConfig(**content)).volume_m3 == pytest.approx(150e-3)


def test_a_flat_facet_keeps_the_circle_in_which_it_meets_a_nearly_flat_one():
    """A disc in a shallow ring, of which several facets in a row are flat within the rounding of two decimals."""
    mesh = turned((0, 0), (17, 0), (17, 19.97), (16, 20), (0, 20), sections=168)
    mesh.vertices = mesh.vertices.round(2)
    mesh.export("jar.stl")
    facets = facets_of(
        drawn_shape(StlGeometry(kind="stl", path="jar.stl", unit="mm"), "mill.yaml: geometry", solid=False)[0]
    )
    lid = max(facets, key=lambda facet: facet.area * -facet.normal[2])
    assert lid.area == pytest.approx(np.pi * 0.016**2, rel=3e-3)
