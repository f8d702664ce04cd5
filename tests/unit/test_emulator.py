"""The emulator and the indices of sensitivity give those of functions whose answer is known."""

import numpy as np
import pandas as pd
import pytest

from millprint.config.fingerprint import DISTRIBUTIONS, PARAMETERS, MeasuredSection
from millprint.uncertainty import samples
from millprint.uncertainty.samples import Emulator, Space, draw, quality, saltelli_shares, sobol_indices, variable_of

# Ishigami's function with a = 7, b = 0.1, and its indices in closed form (Sobol and Levitan 1999).
A, B = 7.0, 0.1


ISHIGAMI_VARIANCE = A**2 / 8 + B * np.pi**4 / 5 + B**2 * np.pi**8 / 18 + 0.5


FIRST = np.array([0.5 * (1 + B * np.pi**4 / 5) ** 2, A**2 / 8, 0.0]) / ISHIGAMI_VARIANCE


TOTAL = FIRST + np.array([1.0, 0.0, 1.0]) * 8 * B**2 * np.pi**8 / 225 / ISHIGAMI_VARIANCE


def ishigami(x: np.ndarray) -> np.ndarray:
    return np.sin(x[:, 0]) + A * np.sin(x[:, 1]) ** 2 + B * x[:, 2] ** 4 * np.sin(x[:, 0])


def uniform_space(names: list[str], low: float, high: float) -> Space:
    section = DISTRIBUTIONS["uniform"](kind="uniform", low=low, high=high, source="a test")
    return Space(tuple(variable_of(name, section, PARAMETERS["restitution"]) for name in names))


@pytest.mark.slow
def test_design_emulator_and_indices_give_those_of_ishigamis_function():
    names = ["x", "y", "z"]
    space = uniform_space(names, -np.pi, np.pi)
    design = space.design(256, seed=1)
    emulator = Emulator.fit(space.places(design), ishigami(design.to_numpy()))
    places = space.places(space.values(saltelli_shares(names, 512, seed=1)))
    table = sobol_indices(draw(emulator, names, places, count=4, seed=1), 0.95, seed=1)
    assert quality(emulator.logs, emulator.left_out)["q2"] > 0.95
    for order, known in (("first", FIRST), ("total", TOTAL)):
        assert table[order].to_numpy() == pytest.approx(known, abs=0.06)
        assert ((table[f"{order}_lower"] <= known + 0.02) & (known - 0.02 <= table[f"{order}_upper"])).all()


def test_interval_and_indices_of_a_linear_function_of_normal_variables():
    """log y = sum a_i x_i: the factor is log-normal, and each index is its share of the variance."""
    slopes, deviations = np.array([1.0, 2.0, -0.5]), np.array([0.03, 0.02, 0.04])
    names = ["x", "y", "z"]
    sections = [MeasuredSection(kind="measured", value=0.5, standard_error=s, source="a test") for s in deviations]
    variables = [variable_of(n, s, PARAMETERS["restitution"]) for n, s in zip(names, sections, strict=True)]
    space = Space(tuple(variables))
    design = space.design(64, seed=0)
    emulator = Emulator.fit(space.places(design), design.to_numpy() @ slopes)
    places = space.places(space.values(saltelli_shares(names, 256, seed=0)))
    reference = space.places(pd.DataFrame([dict.fromkeys(names, 0.5)]))[0]
    drawn = draw(emulator, names, places, count=4, seed=0)
    # A normal distribution that is cut off at three deviations has 0.9733 of the variance.
    variances = 0.9733 * (slopes * deviations) ** 2
    half = 1.96 * np.sqrt(variances.sum())
    assert drawn.ends(0.95) - emulator.predict(reference[None]) == pytest.approx([-half, half], rel=0.04)
    table = sobol_indices(drawn, 0.95, seed=0)
    assert table["first"].to_numpy() == pytest.approx(variances / variances.sum(), abs=0.05)
    assert table["total"].to_numpy() == pytest.approx(variances / variances.sum(), abs=0.05)


def test_the_interval_of_an_index_is_that_of_its_sums_and_of_the_draws():
    names, slopes, rng, found = ["x", "y"], np.array([1.0, 2.0]), np.random.default_rng(3), []
    for seed in range(60):
        first, last = rng.random((2, 256, 2))
        # Saltelli's blocks of independent numbers: all of the first, one of the last in each, all of the last.
        mixed = [np.where(np.arange(2) == place, last, first) for place in range(2)]
        logs = (np.stack([first, *mixed, last], axis=1) @ slopes).reshape(1, -1)
        found.append(sobol_indices(samples.Draws(names, logs), 0.95, seed))
    for order in ("first", "total"):
        values = np.array([each[order] for each in found])
        half = np.mean([each[f"{order}_upper"] - each[order] for each in found], axis=0)
        # The standard deviation of 60 values is known within 9 %.
        assert half == pytest.approx(1.96 * values.std(axis=0), rel=0.35)
    # The same draw twice tells no more and no less.
    pd.testing.assert_frame_equal(sobol_indices(samples.Draws(names, np.repeat(logs, 2, axis=0)), 0.95, 59), found[-1])
    # Of one draw only x counts, of the other only y: indices of 0 and 1, a deviation of 0.5.
    # Independent of each other are the first and the last of each block.
    assert samples.Draws(names, np.arange(8.0)[None]).independent.tolist() == [[0, 3, 4, 7]]
    apart = samples.Draws(
        names, np.array([(np.stack([first, *mixed, last], axis=1) @ own).ravel() for own in np.eye(2)])
    )
    table = sobol_indices(apart, 0.95, 0)
    assert table["total"].to_numpy() == pytest.approx(0.5, abs=0.1)
    assert (table["total_upper"] - table["total_lower"]).to_numpy() / 2 == pytest.approx(0.98, rel=0.25)


def test_emulator_finds_a_function_and_the_noise_on_it():
    rng = np.random.default_rng(0)
    space = uniform_space(["x", "y"], 0.0, 1.0)
    places = space.places(space.design(128, seed=0))

    def known(x: np.ndarray) -> np.ndarray:
        return np.exp(-x[:, 0]) + 0.5 * np.sin(3 * x[:, 1])

    emulator = Emulator.fit(places, known(places) + 0.05 * rng.standard_normal(len(places)))
    new = rng.random((200, 2))
    assert emulator.predict(new) == pytest.approx(known(new), abs=0.06)
    assert emulator.noise == pytest.approx(0.05, rel=0.2)
    assert quality(emulator.logs, emulator.left_out)["leave_one_out_error"] == pytest.approx(0.05, rel=0.25)


def test_the_quality_of_an_emulator_by_hand():
    # Errors of -1 and 0 where the values vary by 1 about their mean: 1 - 1 / 2, and the root of 1 / 2.
    found = quality(np.array([0.0, 2.0]), np.array([1.0, 2.0]))
    assert found == {"q2": pytest.approx(0.5), "leave_one_out_error": pytest.approx(0.5**0.5)}


def test_the_noise_is_not_below_what_the_runs_state():
    space = uniform_space(["x"], 0.0, 1.0)
    places = space.places(space.design(16, seed=0))
    assert Emulator.fit(places, places[:, 0], run_error=0.02).noise >= 0.02 * (1 - 1e-6)


def test_draws_agree_with_the_design_and_spread_away_from_it():
    places = np.append(np.linspace(0, 0.4, 9), [0.9, 0.95, 1.0])[:, None]
    emulator = Emulator.fit(places, np.sin(6 * places[:, 0]))
    new = np.array([[0.2], [0.65]])
    drawn = emulator.draws(new, 400, np.random.default_rng(0))
    assert drawn[:, 0].std() < 0.2 * drawn[:, 1].std()
    assert np.abs(drawn.mean(axis=0) - emulator.predict(new)).max() < 0.2 * drawn[:, 1].std()
