"""Two simulations that differ by a nanometre from some time on: equal before, and that far apart afterwards."""

import h5py
import numpy as np
import pytest

from millprint.config.sweep import Case, DemConfig, SweepConfig, expand_sweep
from millprint.dem.run import run_case

START_S = 0.06
DEM = DemConfig(time_step_s=2e-6, settle_s=0.05, window_s=0.1, closure_max=0.05)
CASE = Case(
    mill="emax", contact="calibrated", ball_diameter_m=0.01, fill_ratio=0.10, speed_hz=20.0, seed=0,
    settle_s=0.05, discard_s=0, window_s=0.16, snapshot_interval_s=1e-3,
)  # fmt: skip


@pytest.fixture(scope="module")
def runs(mills, contacts, tmp_path_factory) -> dict[str, dict]:
    """Snapshots of a run from its beginning, of its later part, and of that part disturbed."""
    later = {"discard_s": START_S, "window_s": 0.1}
    cases = {
        "whole": CASE,
        "later": CASE.model_copy(update=later | {"disturbance_m": 0.0}),
        "twin": CASE.model_copy(update=later | {"disturbance_m": 1e-9}),
    }
    found = {}
    for name, case in cases.items():
        path = tmp_path_factory.mktemp(name) / "run.h5"
        run_case(case, mills["emax"], contacts["calibrated"], DEM, path, path.with_name("summary.json"))
        with h5py.File(path) as file:
            group = file["snapshots"]
            found[name] = {key: group[key][:] for key in ("time_s", "position_m", "velocity_m_s", "normal_J")}
    return found


def test_the_later_part_is_the_run_itself_bit_for_bit(runs):
    whole, later = runs["whole"], runs["later"]
    first = int(np.searchsorted(whole["time_s"], START_S - 1e-9))
    for name in ("time_s", "position_m", "velocity_m_s"):
        np.testing.assert_array_equal(later[name], whole[name][first : first + len(later[name])])
    # Both are differences of running sums, which began at other times.
    np.testing.assert_allclose(later["normal_J"][1:], whole["normal_J"][first + 1 :], rtol=1e-9, atol=1e-15)


def test_a_twin_starts_a_nanometre_away_and_parts(runs):
    away = np.linalg.norm(runs["twin"]["position_m"] - runs["later"]["position_m"], axis=-1)
    np.testing.assert_allclose(away[0], 1e-9, rtol=1e-6)
    # A velocity in a snapshot has half a step of the forces there in it.
    np.testing.assert_allclose(runs["twin"]["velocity_m_s"][0], runs["later"]["velocity_m_s"][0], atol=2e-6)
    directions = runs["twin"]["position_m"][0] - runs["later"]["position_m"][0]
    assert np.abs(directions.mean(axis=0)).max() < 0.6e-9
    assert away[-1].max() > 1e3 * away[0].max()


def test_cases_of_twins_have_names_of_their_own():
    sweep = SweepConfig(
        name="twins", contacts=["calibrated"], ball_diameters_mm=[10], fill_ratios=[0.1], speeds_rpm=[300], seeds=[0],
        disturbances_m=[0, 1e-9],
    )  # fmt: skip
    cases = expand_sweep(sweep, DEM, "emax")
    assert [case.name for case in cases] == ["d10_f0.10_n300_e0_s0", "d10_f0.10_n300_e1e-09_s0"]
    assert [case.disturbance_m for case in cases] == [0, 1e-9]
