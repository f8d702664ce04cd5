"""Frames of an animation: visible parts, their order, the written file; and two runs side by side."""

from itertools import pairwise

import h5py
import numpy as np
import pytest
from PIL import Image

from millprint.cli.commands import main as millprint
from millprint.config.view import ViewConfig
from millprint.figures.animation import Animation, save_animation
from millprint.view.frames import Movie, read_movie
from tests.unit.run_samples import OUTLINE, turn, write_sample

pytestmark = pytest.mark.usefixtures("close_figures")

SETTINGS = ViewConfig(revolutions=1, frames_per_revolution=25)

FEW = ViewConfig(revolutions=0.32, frames_per_revolution=25)


def test_balls_are_drawn_from_the_back_to_the_front_at_their_place(run):
    movie = read_movie(run, SETTINGS)
    with h5py.File(run) as file:
        group = file["snapshots"]
        position = 1e3 * group["position_m"][8]
        relative = np.linalg.norm(group["velocity_m_s"][8] - group["body_velocity_m_s"][8], axis=1)
        body = 1e3 * group["body_position_m"][8]
    above, side = movie.frames[4].pictures
    upwards, towards = np.argsort(position[:, 2]), np.argsort(-position[:, 1])
    np.testing.assert_allclose(above.centre_mm, position[upwards][:, :2])
    np.testing.assert_allclose(side.centre_mm, position[towards][:, [0, 2]])
    np.testing.assert_allclose(above.speed_m_s, relative[upwards], rtol=1e-6)
    np.testing.assert_allclose(side.speed_m_s, relative[towards], rtol=1e-6)
    np.testing.assert_allclose(above.jar_mm, body[:2])
    assert movie.speed_max_m_s == pytest.approx(max(frame.pictures[0].speed_m_s.max() for frame in movie.frames))


@pytest.mark.parametrize("turning", [0.0, 7.0])
def test_the_jar_is_outlined_where_it_is(tmp_path, turning):
    write_sample(tmp_path / "run.h5", turning=turning)
    movie = read_movie(tmp_path / "run.h5", SETTINGS)
    with h5py.File(tmp_path / "run.h5") as file:
        body = file["snapshots/body_position_m"][20]
    rotation = turn(np.array([turning * 0.54]))[0][:2, :2]
    expected = 1e3 * (OUTLINE @ rotation.T + body[:2])
    above, side = movie.frames[10].pictures
    drawn = above.outline_mm.reshape(-1, 2)
    away = np.linalg.norm(drawn[:, None] - expected, axis=-1)
    assert away.min(axis=1).max() < 1e-9 and away.min(axis=0).max() < 1e-9
    # Floor and lid, each once around; upright edges are points from above.
    length = np.linalg.norm(np.diff(above.outline_mm, axis=1)[:, 0], axis=1).sum()
    assert length == pytest.approx(2 * np.linalg.norm(expected - np.roll(expected, 1, axis=0), axis=1).sum())
    # Only the floor faces the viewer, at a right angle.
    assert above.wall_shade == pytest.approx(1)
    assert np.ptp(side.wall_mm[..., 1]) == pytest.approx(30)
    for panel, picture in zip(movie.panels, (above, side), strict=True):
        assert (picture.outline_mm > panel.limits_mm[0]).all() and (picture.outline_mm < panel.limits_mm[1]).all()


def test_slow_motion_that_is_fast_is_told_as_fast():
    told = [Movie("", 1.0, 40, factor, (), ()).pace for factor in (20.0, 1.0, 0.4)]
    assert told == ["20 times slower", "1 times slower", "2.5 times faster"]


@pytest.mark.parametrize("suffix", ["gif", "png"])
@pytest.mark.slow
def test_the_file_plays_every_frame_for_ever(run, tmp_path, suffix):
    path = tmp_path / f"mill.{suffix}"
    movie = read_movie(run, FEW)
    save_animation(movie, path)
    with Image.open(path) as image:
        assert image.n_frames == len(movie.frames) == 8
        assert image.info["loop"] == 0
        seen = []
        for frame in range(8):
            image.seek(frame)
            assert image.info["duration"] == 40
            seen.append(np.asarray(image.convert("RGB")).astype(int))
    assert all((one != other).any() for one, other in pairwise(seen))
    plain = np.asarray(Animation(movie).draw(movie.frames[-1])).astype(int)
    # Paper stays white, and what is drawn keeps its colours.
    assert (seen[-1][plain.min(axis=2) == 255] >= 252).all()
    assert np.abs(seen[-1] - plain).mean() < 1


@pytest.mark.slow
def test_the_command_line(run, capsys):
    command = ["animate", str(run)]
    assert millprint([*command, "--revolutions", "0.2", "--frames-per-revolution", "50", "--start", "0.52"]) == 0
    assert "10 frames, 20 times slower than real time" in capsys.readouterr().out
    with Image.open(run.with_name("mill.gif")) as image:
        assert image.n_frames == 10
    with pytest.raises(SystemExit):
        millprint([*command, "--frames-per-revolution", "0"])
    assert "--frames-per-revolution: '0': must be greater than or equal to 1" in capsys.readouterr().err
