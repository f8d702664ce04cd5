"""Half-life, gas over water, powder masses and wear."""

import pandas as pd
import pytest

from millprint.thesis.doe.chemistry import (
    GasConditions,
    excess,
    gas_amount,
    gas_volume,
    gas_yield,
    half_life,
    molar_mass,
    powder_mass,
    reactant_masses,
    vapour_pressure,
)
from millprint.thesis.doe.wet_lab import half_life_table, read_wear, wear_table
from tests.conftest import ROOT
from tests.unit.doe_settings import settings

WEAR = ROOT / "config/data/wear.tsv"
CHEMISTRY = settings().chemistry
ROOM = GasConditions(298.15, 101325)
BORATE, HYDRIDE = CHEMISTRY.limiting, CHEMISTRY.reductant


def test_half_life_is_10_2_hours_at_298_kelvin_and_10_1_at_25_degrees():
    assert f"{half_life(11, 298) / 3600:.1f}" == "10.2"
    assert f"{half_life(11, 298.15) / 3600:.1f}" == "10.1"
    table = half_life_table()
    assert table["half_life_h"][0] == pytest.approx(half_life(11, 298) / 3600)


@pytest.mark.parametrize(
    ("celsius", "pascal"), [(0.01, 611.657), (25, 3169.9), (50, 12352), (80, 47414), (100, 101418)]
)
def test_vapour_pressure_of_water_is_that_of_the_steam_tables(celsius, pascal):
    assert vapour_pressure(273.15 + celsius) == pytest.approx(pascal, rel=3e-4)


def test_a_mole_of_dry_gas_fills_its_molar_volume():
    # 22.414 L at 273.15 K and 1 atm; just above the triple point, with the vapour's share on top.
    temperature, dry = 273.16, 101325.0
    volume = 22.413969e-3 * temperature / 273.15
    conditions = GasConditions(temperature, dry + vapour_pressure(temperature))
    assert gas_amount(volume, conditions) == pytest.approx(1, rel=1e-6)


def test_gas_yield_has_its_closed_form():
    # 1 g of borate: 4 / 137.86 mol of hydrogen. At 25 degC and 1 atm the dry pressure is 98155 Pa.
    amount = 4 * 1e-3 / molar_mass(BORATE)
    volume = amount * 8.314462618 * 298.15 / (101325 - 3169.9)
    assert gas_yield(volume, ROOM, 1e-3, CHEMISTRY) == pytest.approx(1, rel=1e-4)
    assert gas_yield(volume / 2, ROOM, 1e-3, CHEMISTRY) == pytest.approx(0.5, rel=1e-4)
    assert volume == pytest.approx(732.8e-6, rel=1e-3)


def test_gas_volume_inverts_gas_yield():
    conditions = GasConditions(300, 99000)
    volume = gas_volume(0.71, conditions, 1.1e-3, CHEMISTRY)
    assert gas_yield(volume, conditions, 1.1e-3, CHEMISTRY) == pytest.approx(0.71, rel=1e-12)


def test_vapour_above_the_pressure_is_refused():
    with pytest.raises(ValueError, match="vapour"):
        gas_amount(1e-3, GasConditions(360, 5e4))
    with pytest.raises(ValueError, match="positive volume"):
        gas_amount(-1e-3, GasConditions(300, 1e5))


def test_molar_masses():
    assert 1e3 * molar_mass(BORATE) == pytest.approx(137.86, abs=0.005)
    assert 1e3 * molar_mass(HYDRIDE) == pytest.approx(26.32, abs=0.005)
    assert 1e3 * molar_mass("NaBH4") == pytest.approx(37.83, abs=0.005)


def test_reactant_masses_have_the_powder_mass_and_the_molar_ratio():
    borate, hydride = reactant_masses(3.2e-3, 10, CHEMISTRY)
    assert borate + hydride == pytest.approx(3.2e-3)
    assert (hydride / molar_mass(HYDRIDE)) / (borate / molar_mass(BORATE)) == pytest.approx(10)
    assert [round(100 * excess(ratio, CHEMISTRY)) for ratio in (8, 10, 12)] == [33, 67, 100]


def test_the_reference_case_of_chapter_4_is_charged_with_1_1_grams_of_borate():
    # Table 4.4 prints 1.10 g for ball-to-powder ratio 30 and molar ratio 10.
    borate, _ = reactant_masses(powder_mass(97.06, 30), 10, CHEMISTRY)
    assert borate == pytest.approx(1.10, rel=0.015)


def test_the_powder_at_a_ratio_of_50_gives_17_and_6_per_cent_of_iron():
    table = wear_table(read_wear(WEAR)).set_index("speed_rpm")
    assert table["powder_mass_g"].tolist() == pytest.approx([97.06 / 50] * 2)
    assert [f"{value:.0f}" for value in table["iron_percent"]] == ["17", "6"]
    # No other multiple of the powder would do: iron over the mixture prints as 14 %.
    assert f"{table.loc[1200, 'iron_of_mixture_percent']:.0f}" == "14"
    assert f"{table.loc[1200, 'weight_loss_percent']:.3f}" == "0.333"
    assert f"{table.loc[1200, 'weight_loss_by_difference_percent']:.2f}" == "0.34"
    assert powder_mass(97.06, 50) == pytest.approx(1.9412)


def test_wear_without_a_weighing_of_its_own_is_the_difference_of_the_masses(tmp_path):
    path = tmp_path / "wear.tsv"
    pd.read_csv(WEAR, sep="\t", comment="#").drop(columns="wear_g").to_csv(path, sep="\t", index=False)
    assert wear_table(read_wear(path))["wear_g"].tolist() == pytest.approx([0.33, 0.12])
