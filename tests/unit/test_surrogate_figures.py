"""Figures of chapter 6."""

import numpy as np
import pandas as pd
import pytest

from millprint.thesis.figures.chapter6_figures import (
    plot_ablations,
    plot_dissipation,
    plot_error_growth,
    plot_loss,
)

pytestmark = pytest.mark.usefixtures("close_figures")


def test_every_term_of_a_loss_is_drawn_even_if_there_are_more_than_colours():
    terms = {f"{part}_term{number}": [1.0, 0.5] for number in range(9) for part in ("training", "validation")}
    history = pd.DataFrame({"epoch": [1, 2], "training_total": [1.0, 0.5], "validation_total": [1.1, 0.6]} | terms)
    assert len(plot_loss(history).axes[1].lines) == 2 * 9


def test_roll_outs_that_run_away_leave_the_picture():
    time_s = np.array([0.0, 0.1, 0.2])
    errors = pd.DataFrame({"test": "motion1", "time_s": time_s, "surrogate_m2": [0, 1e-3, 1e40]})
    errors = errors.assign(other_seed_m2=7e-4, centroid_m2=4e-4)
    assert plot_error_growth(errors).axes[0].get_ylim()[1] < 1
    curves = pd.DataFrame({"test": "motion1", "time_s": time_s, "surrogate_J": [0, 1, 1e30], "dem_J": [0, 1, 2.0]})
    metrics = pd.DataFrame({"test": ["motion1"], "measure": ["dissipation_error_percent"], "value": [5.0]})
    metrics = metrics.assign(thesis=np.nan, length_s=0.2)
    panel = plot_dissipation(curves.assign(other_seed_J=[0, 1, 2.1]), metrics).axes[0]
    assert panel.get_ylim() == (0, pytest.approx(3.6))
    ablations = pd.DataFrame({"variant": ["baseline", "window9"], "stable": [1, 0], "thesis_percent": [2.78, np.nan]})
    ablations = ablations.assign(dissipation_error_percent=[4.0, np.inf], position_mse_plateau_m2=[3e-4, 1e41])
    first, second = plot_ablations(ablations.assign(rollout_s=1.0)).axes
    assert [text.get_text() for text in first.texts] == ["not finite"]
    assert second.get_xlim()[1] == pytest.approx(0.1)
