"""What the jar holds: the hydrogen of the reaction, its pressure, and the limits of the region."""

import numpy as np
import pandas as pd
import pytest

from millprint.config.doe import ChemistryConfig
from millprint.config.errors import ConfigError
from millprint.config.yields import RegionConfig
from millprint.thesis.curves.regimes import read_regimes
from millprint.thesis.doe.chemistry import hydrogen_released
from millprint.thesis.yields.averaging import fit_averaged
from millprint.thesis.yields.experiments import region_conditions, safety_warnings, with_hydrogen
from millprint.thesis.yields.proposals import count_reasons, split_region
from tests.unit.doe_settings import settings as doe_settings
from tests.unit.test_yield_domain import CURVES
from tests.unit.test_yield_proposals import MILL, REGIMES, REGION
from tests.unit.yield_settings import all_runs, settings

CHEMISTRY = doe_settings().chemistry


@pytest.mark.parametrize(
    ("limiting", "reductant", "ratio", "released"),
    [
        ("NaBO2.4H2O", "MgH2", 6, 8),  # NaBO2.4H2O + 6 MgH2 -> NaBH4 + 6 MgO + 8 H2
        ("NaBO2.2H2O", "MgH2", 4, 4),  # NaBO2.2H2O + 4 MgH2 -> NaBH4 + 4 MgO + 4 H2
        ("NaBO2", "MgH2", 2, 0),  # NaBO2 + 2 MgH2 -> NaBH4 + 2 MgO
        ("NaBO2.4H2O", "Mg", 6, 2),  # NaBO2.4H2O + 6 Mg -> NaBH4 + 6 MgO + 2 H2
    ],
)
def test_the_hydrogen_of_a_reaction_is_what_its_balance_leaves(limiting, reductant, ratio, released):
    reaction = ChemistryConfig(limiting=limiting, reductant=reductant, stoichiometric_ratio=ratio, gas_per_mole=4)
    assert hydrogen_released(reaction) == released


def charged(**limits) -> tuple[pd.DataFrame, RegionConfig]:
    region = RegionConfig(**(REGION | limits))
    return with_hydrogen(
        region_conditions(region, read_regimes(str(REGIMES)), MILL), region, CHEMISTRY, MILL.volume
    ), region


def test_amount_and_pressure_follow_from_the_masses_by_hand():
    table, _ = charged()
    row = table[(table["fill_ratio"] == 0.10) & (table["bpr"] == 10)].iloc[0]
    # 9.68 g of NaBO2.4H2O (137.86 g/mol) with 10 mol of MgH2 (26.32 g/mol) hold 24.1 mmol of borate, and give 8 H2.
    powder = 24 * 7700 * np.pi / 6 * 0.01**3 / 10
    assert row["powder_mass_g"] == pytest.approx(1e3 * powder)
    borate = powder / (0.13786 + 10 * 0.026321)
    assert row["hydrogen_mmol"] == pytest.approx(8e3 * borate, rel=1e-3)
    free = 125e-6 - 24 * np.pi / 6 * 0.01**3 - powder / 1500
    assert row["hydrogen_pressure_bar"] == pytest.approx(8 * borate * 8.314463 * 298.15 / free / 1e5, rel=1e-3)


def test_the_pressure_goes_with_the_temperature_and_impure_borate_gives_less():
    cold, region = charged()
    hot, _ = charged(gas_temperature_k=2 * region.gas_temperature_k)
    np.testing.assert_allclose(hot["hydrogen_pressure_bar"], 2 * cold["hydrogen_pressure_bar"])
    impure = CHEMISTRY.model_copy(update={"limiting_purity": 0.5})
    conditions = region_conditions(region, read_regimes(str(REGIMES)), MILL)
    assert (with_hydrogen(conditions, region, impure, MILL.volume)["hydrogen_mmol"] < cold["hydrogen_mmol"]).all()
    # A jar that balls and powder fill has no pressure, and no run.
    full = with_hydrogen(conditions, region, CHEMISTRY, 1e-6)
    assert full["hydrogen_pressure_bar"].isna().all()
    assert all("balls and powder fill the jar" in text for text in safety_warnings(full, region))


def test_limits_are_on_by_default_and_each_can_be_set_and_switched_off():
    table, region = charged()
    assert region.powder_max_g is not None and region.hydrogen_max_mmol is not None
    told = pd.Series(safety_warnings(table, region))
    assert (told[table["powder_mass_g"] > region.powder_max_g] != "").all()
    assert (told[(table["powder_mass_g"] <= 6) & (table["hydrogen_mmol"] <= 75)] == "").all()
    assert "powder_mass_g = 9.68 is above 6 (yields.proposals.region.powder_max_g)" in told.str.cat()
    off = {"powder_max_g": None, "hydrogen_max_mmol": None}
    assert set(safety_warnings(*charged(**off))) == {""}
    table, region = charged(**off, pressure_max_bar=10)
    broken = np.array(safety_warnings(table, region)) != ""
    assert 0 < broken.sum() < len(table)
    np.testing.assert_array_equal(broken, table["hydrogen_pressure_bar"] > 10)


def test_what_breaks_a_limit_is_not_proposed_and_the_table_says_why():
    rows, config = all_runs(), settings()
    model = fit_averaged(rows, rows["yield_percent"].to_numpy(float), config.averaging)

    def split(**limits):
        region = RegionConfig(**(REGION | limits))
        proposals = config.proposals.model_copy(update={"region": region})
        conditions = region_conditions(region, read_regimes(str(REGIMES)), MILL)
        return split_region(model, rows, conditions, proposals, config.prediction, CHEMISTRY, MILL, CURVES)

    allowed, left_out = split()
    assert len(allowed) + len(left_out) == 16 and (left_out["reason"] != "").all()
    assert allowed["powder_mass_g"].max() <= 6 and allowed["hydrogen_mmol"].max() <= 75
    # A fill ratio of 6 % is safe, and too far from these runs of 10 %.
    assert left_out.loc[left_out["fill_ratio"] == 0.06, "reason"].str.contains("tangential_share").all()
    counted = count_reasons(left_out, 16).set_index("reason")["conditions"]
    assert counted["powder_mass_g"] == 4 and counted["tangential_share"] == 8
    stricter, _ = split(hydrogen_max_mmol=65)
    assert stricter["hydrogen_mmol"].max() <= 65
    with pytest.raises(ConfigError, match="none of its 16 conditions may be proposed; 16 of them because of") as caught:
        split(hydrogen_max_mmol=1)
    assert "\n" not in str(caught.value)
