"""A roll-out below its simulation: the same moments, each with its own balls."""

from pathlib import Path

import h5py
import numpy as np
import pytest
from millprint.view.replay import Replay, read_comparison
from PIL import Image

from millprint.config.view import ViewConfig
from millprint.errors import ConfigError
from millprint.figures.animation import save_animation
from millprint.figures.style import plt
from tests.unit.run_samples import write_sample

SETTINGS = ViewConfig(revolutions=0.5, frames_per_revolution=25)


@pytest.fixture(autouse=True)
def close_figures():
    yield
    plt.close("all")


@pytest.fixture
def run(tmp_path) -> Path:
    write_sample(tmp_path / "run.h5")
    return tmp_path / "run.h5"


def replay(
    run: Path, start_s: float = 0.52, states: int = 30, interval_s: float = 0.002, shift_m: float = 1e-3
) -> Replay:
    """The balls of the run at its first snapshot, moved aside, standing still."""
    with h5py.File(run) as file:
        position = file["snapshots/position_m"][0] + [shift_m, 0, 0]
    time_s = interval_s * np.arange(states)
    still = np.zeros((states, *position.shape))
    return Replay("surrogate", start_s, time_s, still + position, still)


def test_both_are_shown_at_the_same_moments(run):
    movie = read_comparison(run, replay(run), SETTINGS)
    # 600 rpm and 25 frames a revolution: a frame every 4 ms, to half a revolution.
    assert [frame.time_s for frame in movie.frames] == pytest.approx(0.52 + 0.004 * np.arange(13))
    assert [panel.title for panel in movie.panels] == ["simulation, from above", "surrogate, from above"]
    with h5py.File(run) as file:
        group = file["snapshots"]
        row = int(np.argmin(abs(group["time_s"][:] - movie.frames[3].time_s)))
        truth, first = 1e3 * group["position_m"][row], 1e3 * group["position_m"][0]
    simulated, rolled = movie.frames[3].pictures
    np.testing.assert_allclose(simulated.centre_mm, truth[np.argsort(truth[:, 2])][:, :2], atol=1e-6)
    np.testing.assert_allclose(rolled.centre_mm, first[np.argsort(first[:, 2])][:, :2] + [1.0, 0.0], atol=1e-6)
    # The jar is that of the simulation in both.
    np.testing.assert_array_equal(simulated.outline_mm, rolled.outline_mm)


def test_speeds_are_relative_to_the_wall(run):
    movie = read_comparison(run, replay(run), SETTINGS)
    with h5py.File(run) as file:
        group = file["snapshots"]
        row = int(np.argmin(abs(group["time_s"][:] - movie.frames[0].time_s)))
        wall = np.linalg.norm(group["body_velocity_m_s"][row])
    # A ball at rest in the laboratory passes the wall at the wall's speed.
    assert movie.frames[0].pictures[1].speed_m_s == pytest.approx(wall)


def test_a_short_replay_ends_the_animation_and_a_late_one_is_refused(run):
    assert len(read_comparison(run, replay(run, states=5), SETTINGS).frames) == 3
    with pytest.raises(ConfigError, match=r"no snapshots from 0.61 s on for 0.048 s; there are some from 0.5 to 0.618"):
        read_comparison(run, replay(run, start_s=0.61), SETTINGS)
    with pytest.raises(ConfigError, match=r"no snapshots from 0.4 s on"):
        read_comparison(run, replay(run, start_s=0.4), SETTINGS)


def test_it_is_drawn(run, tmp_path):
    save_animation(read_comparison(run, replay(run), SETTINGS), tmp_path / "rollout.png")
    with Image.open(tmp_path / "rollout.png") as image:
        assert image.n_frames == 13
