"""The tables of the benchmark: ratios and differences of both codes with their intervals."""

import math

import numpy as np
import pandas as pd
import pytest
from scipy import stats

from benchmarks import compare, drums, physics
from benchmarks.compare import (
    spread,
    summarise,
)


def repetitions() -> pd.DataFrame:
    def rows(case, code, times):
        own = {"ns_per_ball_step": times, "processor_ns_per_ball_step": np.array(times) / 2, "repetition": range(3)}
        # Half a core: something else ran.
        return pd.DataFrame({"case": case, "balls": 24, "code": code, "wall": "w", **own})

    cylinder = [rows("cylinder", "millprint", [40, 50, 45]), rows("cylinder", "LAMMPS", [900, 200, 360])]
    return pd.concat([rows("emax", "millprint", [10, 90, 20]), *cylinder])


def test_ratio_is_theirs_over_ours_on_the_same_case():
    table = summarise(repetitions())
    assert list(table["ns_per_ball_step"]) == [20, 45, 360]
    # Of each repetition: 900 / 40, 200 / 50, 360 / 45. Three are too few for an interval.
    assert list(table["ratio_to_us"]) == [1, 1, pytest.approx(11.5)] and table["ratio_95"].isna().all()
    assert table["steps_per_s"].to_numpy() == pytest.approx(1e9 / (24 * np.array([20, 45, 360])))
    assert list(spread(repetitions())["processor_ns"]) == [10, 22.5, 180]
    more = pd.concat([repetitions(), repetitions().assign(repetition=lambda rows: rows["repetition"] + 3)])
    half = 2.5706 * np.std([22.5, 4, 8] * 2, ddof=1) / 6**0.5
    assert summarise(more)["ratio_95"].iloc[-1] == pytest.approx(half, 1e-4)


def test_other_work_is_told():
    table = repetitions()
    assert "50 % of a core" in compare.other_work(table, 0.1, 2)
    idle = table.assign(processor_ns_per_ball_step=table["ns_per_ball_step"])
    assert compare.other_work(idle, 0.1, 2) == "" and "1.7 of 2 cores" in compare.other_work(idle, 1.7, 2)


def test_the_interval_of_a_difference_is_welchs():
    """Against scipy's own test of samples with unequal spreads."""
    a, b = [1.0, 2.0, 3.0, 4.5, 2.5], [5.0, 9.0, 6.0, 20.0, 7.0]
    own = physics.half_width([np.std(x, ddof=1) / math.sqrt(5) for x in (a, b)], 5)
    interval = stats.ttest_ind(b, a, equal_var=False).confidence_interval(0.95)
    assert own == pytest.approx((interval.high - interval.low) / 2)


def test_the_table_of_powers_has_a_row_for_each_speed():
    rows = [(40.0, 120, 20.0, 22.0, 1e-5, "x"), (40.0, 120, 22.0, 20.0, 1e-5, "x"), (20.0, 120, 10.0, 11.0, 2e-5, "x")]
    table = drums.tabulate_power(rows, "drum", "steel").set_index("speed_rpm")
    assert table.loc[40.0, ["millprint_W", "power_W", "difference_pct", "runs"]].tolist() == [21.0, 21.0, 0.0, 2]
    assert table.loc[20.0, "difference_pct"] == pytest.approx(10)
    assert table.loc[40.0, "millprint_se_W"] == pytest.approx(1.0)
