"""Figures of chapter 6."""

import numpy as np
import pandas as pd
import pytest

from millprint.thesis.figures.chapter6_figures import (
    plot_ablations,
    plot_dissipation,
    plot_distributions,
    plot_error_growth,
    plot_loss,
)

pytestmark = pytest.mark.usefixtures("close_figures")


def test_the_losses_and_their_terms():
    history = pd.DataFrame({"epoch": [1, 2], "training_total": [1.0, 0.5], "validation_total": [1.1, 0.6]})
    history = history.assign(training_force=[0.4, 0.2], validation_force=[0.5, 0.3])
    figure = plot_loss(history.assign(validation_mean_square=[2.0, 1.0]))
    assert [len(panel.lines) for panel in figure.axes] == [3, 2]
    assert [text.get_text() for text in figure.axes[1].get_legend().get_texts()] == ["force"]


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


def test_the_figures_state_the_length_of_the_roll_outs_and_which_motion_was_trained_on():
    metrics = pd.DataFrame(
        {"test": ["trained", "motion2"], "measure": "dissipation_error_percent", "value": [5.0, 7.0]}
    )
    metrics = metrics.assign(thesis=np.nan, length_s=[0.2, 0.4])
    curves = pd.DataFrame({"test": ["trained", "motion2"] * 2, "time_s": [0, 0, 0.2, 0.2], "dem_J": [0, 0, 2.0, 2.0]})
    panels = plot_dissipation(curves.assign(surrogate_J=curves["dem_J"]), metrics).axes
    assert [panel.get_title() for panel in panels] == ["motion of the training", "unseen motion 2"]
    assert [panel.texts[0].get_text() for panel in panels] == ["error after 0.2 s: 5 %", "error after 0.4 s: 7 %"]
    places = {"quantity": "speed_m_s", "low": [0.0, 0.1], "high": [0.1, 0.2]}
    shares = {"dem": 5.0, "other_seed": 5.0, "surrogate": 4.0}
    quantities = ("speed_m_s", "wall_distance_m", "contacts", "increment_5ms_J")
    densities = pd.concat([pd.DataFrame(places | shares | {"quantity": name}) for name in quantities])
    figure = plot_distributions(densities.assign(test="motion2"), metrics)
    assert figure.axes[0].get_title(loc="left") == "unseen motion 2, 0.4 s"
    ablations = pd.DataFrame({"variant": ["baseline"], "stable": [1], "thesis_percent": [2.78], "rollout_s": [1.0]})
    figure = plot_ablations(ablations.assign(dissipation_error_percent=4.0, position_mse_plateau_m2=3e-4))
    assert "after 1 s" in figure.axes[0].get_xlabel()
