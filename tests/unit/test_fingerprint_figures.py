"""Figures of chapters 3 and 4 show their input, with units on every axis."""

import h5py
import numpy as np
import pytest

from millprint.config.errors import ConfigError
from millprint.thesis.figures import chapter3_and_4_figures as drawn
from millprint.thesis.regimes import DATASETS, read_occupancy

pytestmark = pytest.mark.usefixtures("close_figures")


def test_maps_are_read_from_a_run_and_masked_where_no_ball_came(tmp_path):
    path = tmp_path / "run.h5"
    count = np.array([[0, 2], [4, 1], [3, 0]])
    arrays = (np.arange(4) * 0.01, np.arange(3) * 0.01, count, np.full((3, 2), 0.5))
    with h5py.File(path, "w") as file:
        for name, values in zip(DATASETS, arrays, strict=True):
            file[f"occupancy/{name}"] = values
    chart = read_occupancy(path, "fill 0.1")
    assert chart.share.max() == 1.0 and chart.share[1, 1] == 0.25
    assert chart.share.mask.sum() == 2 and chart.temperature_m2_s2.mask[0, 0]
    figure = drawn.plot_maps([chart])
    assert figure.axes[0].collections[0].get_array().shape == (2, 3)
    with h5py.File(path, "a") as file:
        del file["occupancy/count"]
    with pytest.raises(ConfigError, match="occupancy/count is missing"):
        read_occupancy(path, "fill 0.1")
