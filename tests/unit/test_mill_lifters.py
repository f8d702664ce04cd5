"""Drums with lifters: closed, of the right volume, refused where lifters overlap or leave no room."""

import math

import numpy as np
import pytest
import trimesh
import yaml
from pydantic import TypeAdapter

from millprint.cases.of_mill import enlarged, mill_cases
from millprint.config.load import check_model
from millprint.config.mill import LifterDrumGeometry, MillConfig, VesselGeometry
from millprint.config.mill_sweep import MillsConfig
from millprint.dem.case_checks import check_mixtures
from millprint.mill.bodies import build_bodies, check_volume
from millprint.mill.default_sweep import default_sweep
from millprint.mill.distance import signed_distance
from millprint.mill.outlines import facets_of
from millprint.mill.vessel import Vessel, build_vessel, drawn_shape
from millprint.mill.wall_features import features_of
from tests.conftest import ROOT

TURNING = {"kind": "rotation", "axis": [0, 0, 1]}
LIFTERS = {"number": 12, "height_mm": 22, "width_mm": 22}
DRUM = {"kind": "lifter_drum", "radius_mm": 275, "length_mm": 23.5, "facets": 144, "lifters": LIFTERS}


def drum(lifters: dict | None = None, **changes) -> tuple[LifterDrumGeometry, Vessel]:
    geometry = TypeAdapter(VesselGeometry).validate_python(
        {**DRUM, **changes, "lifters": {**LIFTERS, **(lifters or {})}}
    )
    facets = facets_of(drawn_shape(geometry, "mill.yaml: geometry", solid=False)[0])
    return geometry, Vessel(facets, smooth_axis=geometry.smooth_axis)


def section_mm2(geometry: LifterDrumGeometry) -> float:
    """Area of the section: triangles of the shell's facets, and of each lifter a trapezoid on its foot's chord."""
    radius, foot, lifters = geometry.radius_mm, geometry.foot_angle, geometry.lifters
    gap = 2 * math.pi / lifters.number - 2 * foot
    arcs = max(1, round(geometry.facets * gap / (2 * math.pi)))
    shell = arcs * radius**2 * math.sin(gap / arcs) / 2 + radius**2 * math.sin(2 * foot) / 2
    rise = lifters.height_mm - radius * (1 - math.cos(foot))
    return lifters.number * (shell - rise * (lifters.width_mm / 2 + geometry.top_half_width_mm))


@pytest.mark.parametrize("axis", ["x", "y", "z"])
@pytest.mark.parametrize(
    "lifters", [{}, {"face_angle_deg": 60, "width_mm": 40}, {"number": 8, "height_mm": 40, "width_mm": 40}]
)
def test_a_drum_with_lifters_is_watertight_and_has_the_volume_of_its_section(axis, lifters):
    geometry, vessel = drum(lifters, axis=axis)
    mesh = trimesh.Trimesh(*vessel.triangles(), process=False)
    assert mesh.is_watertight and mesh.is_winding_consistent
    assert vessel.volume_m3 * 1e9 == pytest.approx(section_mm2(geometry) * geometry.length_mm, rel=1e-9)
    # Two corners of each lifter's top jut into the drum.
    assert len(features_of(vessel).lines) == 2 * geometry.lifters.number
    assert np.ptp(vessel.vertices, axis=0)["xyz".index(axis)] == pytest.approx(23.5e-3)


@pytest.mark.parametrize("angle", [90, 70, 60])
def test_the_faces_of_a_lifter_lean_by_their_angle(angle):
    geometry, vessel = drum({"face_angle_deg": angle, "width_mm": 40})
    # The first lifter stands at the top of a drum along y; its faces hold a corner of its top and one on the shell.
    top = (geometry.radius_mm - geometry.lifters.height_mm) / 1e3
    faces = [
        facet
        for facet in vessel.facets
        if abs(facet.normal[1]) < 0.5 and np.isclose(facet.loops[0][:, 2], top).any() and np.ptp(facet.loops[0][:, 2])
        and abs(facet.loops[0][:, 0]).max() < 0.021
    ]  # fmt: skip
    assert len(faces) == 2
    for facet in faces:
        assert abs(facet.normal[2]) == pytest.approx(math.cos(math.radians(angle)), abs=1e-9)


def test_what_is_in_a_lifter_is_in_the_wall_however_near_the_shell():
    """Small balls must not start there: where a lifter stands, the shell is not a wall."""
    geometry = TypeAdapter(VesselGeometry).validate_python({**DRUM, "axis": "z", "length_mm": 200})
    vessel = build_vessel(MillConfig(name="m", title="m", source="s", volume_ml=4e4, geometry=geometry, motion=TURNING))
    angle = np.random.default_rng(0).uniform(-0.1, 0.1, 4000)
    radius = np.random.default_rng(1).uniform(0.245, 0.2745, 4000)
    x, y = radius * np.cos(angle), radius * np.sin(angle)
    distance, _ = signed_distance(vessel)(np.column_stack([x, y, np.zeros_like(x)]))
    in_lifter = (x > 0.253) & (np.abs(y) < 0.011)
    inside = np.minimum(x - 0.253, 0.011 - np.abs(y))[in_lifter]
    np.testing.assert_allclose(distance[in_lifter], inside, atol=1e-9)
    assert in_lifter.sum() > 500 and (distance[~in_lifter] < 0).all()


def test_only_the_ends_of_a_slice_are_smooth():
    _, rough = drum()
    _, slice_ = drum(smooth_ends=True)
    assert not rough.is_smooth.any()
    ends = [abs(facet.normal[1]) == 1 for facet in slice_.facets]
    assert slice_.is_smooth.tolist() == ends and sum(ends) == 2


def example() -> MillConfig:
    """The tumbling mill of the handbook."""
    text = (ROOT / "docs/how_to/mill_from_drawing.md").read_text().split("## A tumbling mill")[1]
    return check_model(yaml.safe_load(text.split("```yaml")[1].split("```")[0]), MillConfig, "tumbler.yaml")


def test_the_example_of_the_handbook_is_a_mill_that_can_be_run():
    mill = example()
    check_volume(mill, build_vessel(mill))
    cases = mill_cases(mill, MillsConfig(contact="steel"))
    check_mixtures(cases, {mill.name: mill}, {mill.name: build_bodies(mill, 0.75)}, "tumbler.yaml: sweep")
    assert len(cases) == 18 and all(case.mixture for case in cases)


def test_a_drum_with_lifters_is_enlarged_and_swept_as_a_drum():
    mill = example()
    large, factor = enlarged(mill, 8 * mill.volume_ml / 1e3, "large")
    assert factor == pytest.approx(2)
    assert build_vessel(large).volume_m3 == pytest.approx(8 * build_vessel(mill).volume_m3, rel=1e-9)
    sweep = default_sweep(mill.model_copy(update={"sweep": None}))
    assert all(size <= 8 for size in sweep.ball_diameters_mm)
    critical = 30 / math.pi * math.sqrt(9.81 / (0.15 - sweep.ball_diameters_mm[0] / 2e3))
    assert sweep.speeds_rpm == pytest.approx([0.6 * critical, 0.8 * critical], rel=0.02)
