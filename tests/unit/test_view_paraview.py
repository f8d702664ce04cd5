"""Files for ParaView, read by VTK's own reader, have the same content as the run."""

from pathlib import Path

import h5py
import numpy as np
import pytest
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkPolyData
from vtkmodules.vtkIOHDF import vtkHDFReader

from millprint.cli.commands import main as millprint
from millprint.config.charge import BallMixture
from millprint.config.included import load_contact, load_mill
from millprint.config.sweep import Case, DemConfig, balls_of
from millprint.dem.run import run_case
from millprint.mill.wall_features import features_of
from millprint.run.hdf5 import open_hdf5
from millprint.view import frames as snapshots_module
from millprint.view.frames import Snapshots
from millprint.view.paraview import BALL, WALL, export_run
from tests.unit.run_samples import BALLS, RADIUS, ell, write_sample


def export(run: Path, every: int = 1) -> tuple[Path, Path, Path]:
    paths = tuple(run.with_name(f"{name}.vtkhdf") for name in ("balls", "walls", "contacts"))
    export_run(run, *paths, every)
    return paths


def read(path: Path, step: int) -> tuple[float, vtkPolyData, dict[str, np.ndarray]]:
    """Time, mesh and all arrays of one step, as VTK sees them."""
    reader = vtkHDFReader()
    reader.SetFileName(str(path))
    reader.UpdateInformation()
    assert reader.GetHasTemporalData()
    reader.SetStep(step)
    reader.Update()
    mesh = vtkPolyData()
    mesh.DeepCopy(reader.GetOutput())
    arrays = {}
    for data in (mesh.GetPointData(), mesh.GetCellData(), mesh.GetFieldData()):
        for k in range(data.GetNumberOfArrays()):
            arrays[data.GetArrayName(k)] = vtk_to_numpy(data.GetArray(k))
    return reader.GetTimeValue(), mesh, arrays


def points(mesh: vtkPolyData) -> np.ndarray:
    return vtk_to_numpy(mesh.GetPoints().GetData()) if mesh.GetNumberOfPoints() else np.empty((0, 3))


def steps_of(path: Path) -> int:
    reader = vtkHDFReader()
    reader.SetFileName(str(path))
    reader.UpdateInformation()
    return reader.GetNumberOfSteps()


@pytest.fixture(params=[0.0, 7.0], ids=["translating", "turning"])
def run(request, tmp_path, monkeypatch) -> Path:
    # Blocks of a few snapshots, so that their seams are tested too.
    monkeypatch.setattr(snapshots_module, "BLOCK_VALUES", 3 * 12 * 7)
    write_sample(tmp_path / "run.h5", turning=request.param)
    return tmp_path / "run.h5"


@pytest.mark.parametrize("every", [1, 7])
@pytest.mark.slow
def test_balls_are_where_the_run_has_them(run, every):
    balls, *_ = export(run, every)
    with h5py.File(run) as file:
        expected = {name: dataset[:] for name, dataset in file["snapshots"].items()}
    rows = range(0, 60, every)
    assert steps_of(balls) == len(rows)
    for step, row in enumerate(rows):
        time_s, mesh, arrays = read(balls, step)
        assert time_s == expected["time_s"][row]
        np.testing.assert_array_equal(points(mesh), expected["position_m"][row])
        assert mesh.GetNumberOfVerts() == BALLS
        for name in ("velocity_m_s", "spin_rad_s", "contact_force_N"):
            np.testing.assert_array_equal(arrays[name], expected[name][row])
        np.testing.assert_allclose(
            arrays["speed_m_s"], np.linalg.norm(expected["velocity_m_s"][row], axis=1), rtol=1e-6
        )
        np.testing.assert_array_equal(arrays["radius_m"], RADIUS)
        np.testing.assert_array_equal(arrays["ball"], np.arange(BALLS))
        touching = slice(*expected["contact_offset"][row : row + 2])
        both = np.concatenate([expected["contact_first"][touching], expected["contact_second"][touching]])
        np.testing.assert_array_equal(arrays["contacts"], [(both == ball).sum() for ball in range(BALLS)])


def test_energy_of_snapshots_left_out_is_added(run):
    balls, *_ = export(run, 7)
    with h5py.File(run) as file:
        normal = file["snapshots/normal_J"][:]
    shown = [read(balls, step)[2]["normal_J"].item() for step in range(steps_of(balls))]
    assert shown[0] == 0
    assert shown[1] == pytest.approx(normal[1:8].sum())
    assert sum(shown) == pytest.approx(normal[1:57].sum())


@pytest.mark.slow
def test_contacts_are_lines_between_centres_or_to_the_wall(run):
    *_, contacts = export(run)
    with h5py.File(run) as file:
        expected = {name: dataset[:] for name, dataset in file["snapshots"].items()}
    for step in range(60):
        _, mesh, arrays = read(contacts, step)
        rows = slice(*expected["contact_offset"][step : step + 2])
        first, second = expected["contact_first"][rows], expected["contact_second"][rows]
        assert mesh.GetNumberOfLines() == len(first) == (0 if step == 3 else mesh.GetNumberOfCells())
        if step == 3:
            continue
        np.testing.assert_array_equal(arrays["first"], first)
        np.testing.assert_array_equal(arrays["second"], second)
        np.testing.assert_array_equal(arrays["partner"], np.where(second < 0, WALL, BALL))
        ends = points(mesh)[vtk_to_numpy(mesh.GetLines().GetConnectivityArray())].reshape(-1, 2, 3)
        position, pair = expected["position_m"][step], second >= 0
        np.testing.assert_array_equal(ends[:, 0], position[first])
        np.testing.assert_array_equal(ends[pair, 1], position[second[pair]])
        length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
        np.testing.assert_allclose(arrays["overlap_m"], np.where(pair, 2, 1) * RADIUS - length, atol=1e-8)


def test_feet_lie_on_facets_edges_and_corners(tmp_path):
    write_sample(tmp_path / "run.h5")
    with open_hdf5(tmp_path / "run.h5") as file:
        snapshots = Snapshots(file)
        geometry = snapshots.geometry
    vessel = ell()
    assert (len(geometry.edge_m), len(geometry.corner_m)) == (1, 2)
    point = np.array([[0.01, 0.012, 0.011]])
    for feature, facet in enumerate(vessel.facets):
        (foot,) = geometry.foot(np.array([feature]), point)
        assert foot @ facet.normal == pytest.approx(facet.offset)
        assert np.linalg.norm(np.cross(point[0] - foot, facet.normal)) == pytest.approx(0, abs=1e-12)
    (foot,) = geometry.foot(np.array([len(vessel.facets)]), point)
    assert foot == pytest.approx([0, 0, 0.011])
    (foot,) = geometry.foot(np.array([len(vessel.facets) + 1]), point)
    assert foot == pytest.approx(features_of(vessel).corners[0].point)


THREE = BallMixture(name="three", sizes_mm=(12, 10, 6), numbers=(1, 1, 2))


@pytest.mark.parametrize("mixture", [None, THREE], ids=["one size", "three sizes"])
@pytest.mark.slow
def test_every_contact_of_a_simulation_overlaps(tmp_path, mixture):
    """The features of run.h5's geometry are numbered as the simulation numbers them, post and its edges included."""
    case = Case(
        mill="emax_post", contact="calibrated", fill_ratio=0.1, speed_hz=5.0, seed=0, **balls_of(mixture or 10.0),
        settle_s=0.05, discard_s=0.0, window_s=0.2, snapshot_interval_s=1e-3,
    )  # fmt: skip
    dem = DemConfig(time_step_s=4e-6, settle_s=0.1, window_s=0.1)
    mill = load_mill("emax_post")
    contact = load_contact("calibrated")
    summary = run_case(case, mill, contact, dem, tmp_path / "run.h5", tmp_path / "summary.json")
    balls, _, contacts = export(tmp_path / "run.h5", 5)
    sizes = zip(summary["ball_sizes_m"], summary["ball_counts"], strict=True)
    charge = np.concatenate([np.full(count, size / 2) for size, count in sizes])
    np.testing.assert_allclose(np.sort(read(balls, 0)[2]["radius_m"]), np.sort(charge))
    assert 0 < summary["max_overlap_fraction"] < 0.15
    arrays = [read(contacts, step)[2] for step in range(steps_of(contacts))]
    overlap = np.concatenate([array["overlap_m"] for array in arrays if "overlap_m" in array])
    partner = np.concatenate([array["partner"] for array in arrays if "partner" in array])
    assert (partner == WALL).sum() > 20 and (partner == BALL).sum() > 5
    # A contact that has just ended may still be listed: by then it is apart by less than a step's way.
    assert overlap.min() > -1e-5
    assert overlap.max() < 0.15 * RADIUS


@pytest.mark.slow
def test_the_command_line_writes_to_the_folder_of_the_run_or_to_another(tmp_path):
    write_sample(tmp_path / "run.h5")
    command = ["export", str(tmp_path / "run.h5"), "--every", "20"]
    assert millprint([*command, "--out", str(tmp_path / "there")]) == 0
    names = sorted(path.name for path in (tmp_path / "there").iterdir())
    assert names == ["run.vtkhdf", "run_contacts.vtkhdf", "run_walls.vtkhdf"]
    assert steps_of(tmp_path / "there/run_walls.vtkhdf") == 3
