"""Figures of chapters 3 and 4 show their input, with units on every axis."""

from pathlib import Path

import h5py
import numpy as np
import pandas as pd
import pytest

from millprint.config.errors import ConfigError
from millprint.fingerprint.descriptors import tabulate_descriptors
from millprint.fingerprint.zones import find_zones
from millprint.observables.condition import Condition
from millprint.thesis.curves.cycles import DATASETS, read_occupancy, tabulate_cycles, tabulate_densities
from millprint.thesis.curves.energy import fit_slopes, specific_yields
from millprint.thesis.curves.regimes import (
    design_cases,
    published_curves,
    published_cycles,
    read_published,
    read_regimes,
)
from millprint.thesis.curves.scaling import average_curves, fit_exponents, tabulate_counting_rules
from millprint.thesis.figures import chapter3_and_4_figures as drawn
from tests.conftest import PRINTED
from tests.unit.synthetic_mill import descriptors, fingerprint, overrides, summaries

pytestmark = pytest.mark.usefixtures("close_figures")

DATA = Path(__file__).parents[2] / "config/data"


@pytest.fixture(scope="module")
def published() -> pd.DataFrame:
    return read_published(DATA / "published.tsv", DATA / "claims.tsv")


def assert_units(figure) -> None:
    for axis in figure.axes:
        for label in (axis.get_xlabel(), axis.get_ylabel()):
            assert not label or ("[" in label and label.rstrip().endswith("]")), label
        assert axis.get_ylabel()


def points(axis, label: str) -> np.ndarray:
    line = next(line for line in axis.lines if line.get_label() == label)
    return np.column_stack(line.get_data())


def test_master_curves_show_the_published_values(published):
    marks = published_curves(published, "calibrated")
    curves, zones = fingerprint().curve(np.geomspace(0.04, 0.40, 30)), find_zones(fingerprint())
    figure = drawn.plot_master_curves(descriptors(), average_curves(descriptors()), curves, marks, zones)
    assert_units(figure)
    np.testing.assert_allclose(
        points(figure.axes[0], "published"),
        [[float(fill), float(PRINTED[f"3.curve.{fill}.Pn"])] for fill in ("0.06", "0.10", "0.17")],
    )
    assert len(points(figure.axes[2], "smooth curve")) == len(curves)
    elbow = zones.set_index("zone").loc["elbow", "value"]
    np.testing.assert_allclose(points(figure.axes[3], "elbow")[:, 0], elbow)


@pytest.mark.slow
def test_exponents_are_shown_about_what_is_supposed():
    runs = summaries() + overrides()
    table = fit_exponents(tabulate_descriptors(runs, "gap_0_03"), tabulate_counting_rules(runs), 0.95)
    figure = drawn.plot_exponents(table[table["contact"] == "calibrated"].dropna(subset="exponent"))
    assert len(figure.axes) == 4
    for axis in figure.axes:
        assert axis.get_xlabel().endswith("[-]")
        np.testing.assert_allclose(np.asarray(axis.containers[0].lines[0].get_xdata(), float), 0.0, atol=1e-9)


def test_energies_have_a_line_for_each_condition():
    figure = drawn.plot_energies(descriptors())
    assert_units(figure)
    assert {line.get_label() for line in figure.axes[0].lines} == {
        f"{diameter} mm, {speed} rpm" for diameter in (5, 10) for speed in (600, 1200)
    }


def test_cycles_show_the_means_that_table_3_5_implies(published):
    marks = published_cycles(published)
    expected = marks[(marks["ball_diameter_mm"] == 10) & (marks["speed_rpm"] == 600)].iloc[0]
    assert expected["normal_mean_J"] == pytest.approx(float(PRINTED["3.cycle.10mm.600.n"]), abs=5e-4)
    runs = summaries(fills=(0.08,), contacts=("calibrated", "steel"))
    means = drawn.plot_cycle_means(tabulate_cycles(runs), marks)
    assert_units(means)
    assert len(points(means.axes[0], "published, calibrated")) == 8
    densities = drawn.plot_cycle_densities(tabulate_densities(runs, 0.08))
    assert_units(densities)
    assert len(densities.axes) == 4 and all(len(axis.lines) == 4 for axis in densities.axes)


def test_no_density_is_no_crash():
    assert drawn.plot_cycle_densities(tabulate_densities([], 0.08)).axes


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


def test_chapter_4_draws_both_lines_and_both_sources():
    measured = read_regimes(DATA / "regimes.tsv")
    cases = design_cases(measured, Condition(0.10, 10.0, 0.01, 7700.0, 0.017))
    figure = drawn.plot_yield(cases.assign(yield_percent=measured["yield_percent"]), fit_slopes(measured, 0.95))
    assert_units(figure)
    np.testing.assert_allclose(sorted(points(figure.axes[0], "constant power")[:, 1]), [40, 71, 94])
    table = specific_yields(measured.assign(power_W=cases["power_W"]))
    for draw in (drawn.plot_specific_yield, drawn.plot_mass_per_watt):
        figure = draw(table, table)
        assert_units(figure)
        assert len(figure.axes[0].lines) == 4
