"""A prediction next to the simulation: the right frames in the right panels."""

from pathlib import Path

import h5py
import numpy as np
import pytest
from PIL import Image

from millprint.config.errors import ConfigError
from millprint.figures.animation import save_animation
from millprint.figures.style import save
from millprint.thesis.figures.chapter6_figures import plot_motion
from millprint.thesis.surrogate.side_by_side import movie_side_by_side

pytestmark = pytest.mark.usefixtures("close_figures")


def recorded(run: Path) -> dict[str, np.ndarray]:
    with h5py.File(run) as file:
        return {name: file[f"snapshots/{name}"][:] for name in ("time_s", "position_m", "velocity_m_s")}


def test_simulation_on_the_left_and_prediction_on_the_right_at_the_same_moments(run):
    truth = recorded(run)
    rows = slice(10, 31)
    predicted = truth["position_m"][rows] + [0.001, 0, 0]
    movie = movie_side_by_side(run, truth["time_s"][rows], predicted, truth["velocity_m_s"][rows], 5, 20)
    assert len(movie.frames) == 5 and movie.columns == 2
    assert [panel.title.split(",")[0] for panel in movie.panels] == ["DEM", "surrogate"] * 2
    assert [frame.time_s for frame in movie.frames] == pytest.approx(truth["time_s"][rows][::5])
    for frame in movie.frames:
        left, right = frame.pictures[:2]
        np.testing.assert_allclose(right.centre_mm - left.centre_mm, np.tile([1.0, 0.0], (len(left.centre_mm), 1)))
        np.testing.assert_allclose(right.speed_m_s, left.speed_m_s, rtol=1e-6)
    above = truth["position_m"][15][np.argsort(truth["position_m"][15][:, 2])]
    np.testing.assert_allclose(movie.frames[1].pictures[0].centre_mm, 1e3 * above[:, :2])


@pytest.mark.slow
def test_balls_that_ran_away_are_drawn_outside(run, tmp_path):
    truth = recorded(run)
    position = truth["position_m"][:4].copy()
    position[2:] = np.nan
    position[1, 0] = 1e30
    movie = movie_side_by_side(run, truth["time_s"][:4], position, truth["velocity_m_s"][:4], 1, 10)
    limits = movie.panels[1].limits_mm
    assert (movie.frames[3].pictures[1].centre_mm > limits[1]).all()
    assert np.isfinite(movie.speed_max_m_s)
    save_animation(movie, tmp_path / "movie.gif")
    with Image.open(tmp_path / "movie.gif") as image:
        assert image.n_frames == 4
    figure = plot_motion(movie, [0, 3])
    assert len(figure.axes) == 9  # four panels at two moments, and the colour bar
    save(figure, tmp_path / "motion.svg", tmp_path / "motion.png")


def test_moments_that_were_not_recorded_are_refused(run):
    truth = recorded(run)
    with pytest.raises(ConfigError, match="no snapshots at the frames of the roll-out"):
        movie_side_by_side(run, truth["time_s"][:4] + 1e-3, truth["position_m"][:4], truth["velocity_m_s"][:4], 1, 10)
