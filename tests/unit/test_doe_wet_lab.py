"""Half-life, gas over water, powder masses, wear, and what the literature reports."""

import numpy as np
import pandas as pd
import pytest

from millprint.cli.commands import main as millprint
from millprint.config.doe import ChemistryConfig
from millprint.config.errors import ConfigError
from millprint.run.files import read_table
from millprint.thesis.doe.chemistry import (
    PARAMETERS,
    GasConditions,
    check_formulas,
    excess,
    gas_amount,
    gas_yield,
    half_life,
    literature_checks,
    molar_mass,
    reactant_masses,
    share_lost,
    vapour_pressure,
    yield_error,
)
from millprint.thesis.doe.wet_lab import charge_table, read_wear, solution_table, wear_table, yield_table
from tests.conftest import ROOT
from tests.refusals import refusals
from tests.unit.doe_settings import settings

WEAR = ROOT / "config/data/wear.tsv"

CHEMISTRY = settings().chemistry


BORATE, HYDRIDE = CHEMISTRY.limiting, CHEMISTRY.reductant


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


def test_molar_masses():
    assert 1e3 * molar_mass(BORATE) == pytest.approx(137.86, abs=0.005)
    assert 1e3 * molar_mass(HYDRIDE) == pytest.approx(26.32, abs=0.005)
    assert 1e3 * molar_mass("NaBH4") == pytest.approx(37.83, abs=0.005)


def test_reactant_masses_have_the_powder_mass_and_the_molar_ratio():
    borate, hydride = reactant_masses(3.2e-3, 10, CHEMISTRY)
    assert borate + hydride == pytest.approx(3.2e-3)
    assert (hydride / molar_mass(HYDRIDE)) / (borate / molar_mass(BORATE)) == pytest.approx(10)
    assert [round(100 * excess(ratio, CHEMISTRY)) for ratio in (8, 10, 12)] == [33, 67, 100]


def test_wear_without_a_weighing_of_its_own_is_the_difference_of_the_masses(tmp_path):
    path = tmp_path / "wear.tsv"
    pd.read_csv(WEAR, sep="\t", comment="#").drop(columns="wear_g").to_csv(path, sep="\t", index=False)
    assert wear_table(read_wear(path))["wear_g"].tolist() == pytest.approx([0.33, 0.12])


GAS = settings().gas

READING = {"case": "14", "gas_volume_ml": 578.6, "temperature_k": 298.15, "pressure_pa": 101325} | {
    "limiting_mass_g": 1.1120722
}


def write(path, *rows: dict) -> str:
    pd.DataFrame(rows).to_csv(path, sep="\t", index=False)
    return str(path)


def test_a_gas_volume_gives_the_yield_it_was_made_from(tmp_path):
    row = yield_table(write(tmp_path / "g.tsv", READING), CHEMISTRY, GAS).iloc[0]
    assert row["yield_percent"] == pytest.approx(71.0, abs=0.01)
    # 1.112 g of 137.86 g/mol give 4 mol of gas each.
    assert row["full_mmol"] == pytest.approx(4 * 1112.0722 / 137.8607, rel=1e-5)
    dry = 101325 - 3169.9
    assert row["hydrogen_mmol"] == pytest.approx(dry * 578.6e-6 / (8.314463 * 298.15) * 1e3, rel=1e-4)
    assert row["yield_if_vapour_ignored_percent"] / row["yield_percent"] == pytest.approx(101325 / dry, rel=1e-4)


def test_dry_gas_and_a_head_of_water_change_the_pressure_of_the_hydrogen(tmp_path):
    path = write(tmp_path / "g.tsv", READING, {**READING, "case": "15"})
    dry = yield_table(path, CHEMISTRY, GAS.model_copy(update={"saturated": False}))
    assert (dry["yield_percent"] == dry["yield_if_vapour_ignored_percent"]).all()
    headed = write(tmp_path / "h.tsv", {**READING, "water_head_mm": 0}, {**READING, "case": "15", "water_head_mm": 100})
    low, high = yield_table(headed, CHEMISTRY, GAS)["yield_percent"][::-1]
    # 100 mm of water are 978.7 Pa less on the gas.
    assert low / high == pytest.approx(1 - 978.7 / (101325 - 3169.9), rel=1e-5)


def arguments(readings: dict) -> tuple:
    """The arguments of `gas_yield`."""
    conditions = GasConditions(readings["temperature"], readings["pressure"])
    return readings["volume"], conditions, readings["limiting_mass"], CHEMISTRY


def test_errors_of_the_readings_propagate_as_a_simulation_of_them_does():
    readings = {"volume": 200e-6, "temperature": 310.0, "pressure": 99e3, "limiting_mass": 0.8e-3}
    errors = {"volume": 3e-6, "temperature": 2.0, "pressure": 600.0, "limiting_mass": 8e-6}
    rng = np.random.default_rng(2)
    drawn = {name: value + errors[name] * rng.normal(size=40_000) for name, value in readings.items()}
    simulated = np.std(gas_yield(*arguments(drawn)))
    assert yield_error(errors, *arguments(readings)) == pytest.approx(simulated, rel=0.02)
    only = yield_error({"volume": 3e-6}, *arguments(readings))
    assert only == pytest.approx(gas_yield(*arguments({**readings, "volume": 3e-6})))


def test_another_reaction_and_impure_powders_are_counted():
    reaction = {"limiting": "NaBO2.2H2O", "reductant": "Mg", "stoichiometric_ratio": 4, "gas_per_mole": 4}
    other = ChemistryConfig(**reaction, limiting_purity=0.9, reductant_purity=0.5)
    limiting, reductant = reactant_masses(1e-3, 5.5, other)
    assert limiting + reductant == pytest.approx(1e-3)
    moles = reductant * 0.5 / molar_mass("Mg"), limiting * 0.9 / molar_mass("NaBO2.2H2O")
    assert moles[0] / moles[1] == pytest.approx(5.5)
    pure, args = ChemistryConfig(**reaction), (100e-6, GasConditions(298.15, 101325), 1e-3)
    assert gas_yield(*args, other) * 0.9 == pytest.approx(gas_yield(*args, pure))
    # Table 2.2, reference 15: 0.43 g and 0.57 g at a molar ratio of 5.5.
    assert reactant_masses(1.0, 5.55, pure) == pytest.approx((0.43, 0.57), abs=0.005)


def test_what_follows_from_the_numbers_of_a_study_is_by_hand():
    """Two balls of 10 mm and five of 6 mm; then balls by their share. Masses of equal moles without the water."""
    same = dict.fromkeys(PARAMETERS, np.nan) | {"borate": "NaBO2", "reductant": "MgH2", "yield_percent": 70.0}
    counted = {"ball_diameter_mm": "10/6", "balls": "2/5", "jar_volume_ml": 50, "ball_volume_percent": 3}
    weighed = {"borate_mass_g": 0.5, "reductant_mass_g": 0.2, "molar_ratio": 2.0}
    weighed |= {"jar_volume_ml": 80, "ball_volume_percent": 25, "powder_mass_g": 0.64, "bpr": 220}
    counted |= {"powder_mass_g": 1.0, "bpr": 11}
    studies = pd.DataFrame([same | counted | {"reference": 1}, same | weighed | {"reference": 2}])
    yields = [(1, "NaBO2", 70.0), (2, "NaBO2", 71.0), (2, "NaBO2.4H2O", 70.0)]
    yields = pd.DataFrame(yields, columns=["reference", "borate", "yield_percent"]).assign(reductant="MgH2")
    found = literature_checks(studies, yields)
    volume = np.pi / 6 * (2 + 5 * 0.6**3)
    moles = 0.2 / 26.32 * 65.80 / 0.5
    follows = [2 * volume, 7.8 * volume, 70, 0.7, moles, 7.8 * 20 / 0.64, 71]
    assert found["follows"].tolist() == pytest.approx(follows, rel=1e-3)
    # Within a tenth: 3.2 for 3 %, 0.7 for 0.64 g; and not 12.6 for 11, 1 for 2, 244 for 220.
    words = ["agrees", "differs", "agrees", "agrees", "differs", "differs", "differs"]
    assert found["verdict"].tolist() == words and found["note"][0] == ""
    assert found["note"][1].startswith(f"balls of {11 / volume:.1f} g/cm3 would be needed")
    assert found["note"][4].endswith("if the borate is NaBO2.4H2O")
    assert found["note"][6] == "Table 2.1 gives this yield for NaBO2.4H2O"


@pytest.mark.parametrize("formula", ["nabo2", "", "Xx2", "NaBO2 and water"])
def test_a_formula_that_is_none_is_refused_in_one_line(formula):
    chemistry = CHEMISTRY.model_copy(update={"limiting": formula})
    with pytest.raises(ConfigError, match=r"config.yaml: doe.chemistry.limiting: formula .* NaBO2.4H2O") as caught:
        check_formulas(chemistry, "config.yaml: doe.chemistry")
    assert "\n" not in str(caught.value)


def test_half_lives_and_what_is_lost_while_waiting(tmp_path):
    path = write(tmp_path / "s.tsv", {"case": "a", "ph": 11, "temperature_k": 298, "wait_h": 10.229367})
    table = solution_table(path)
    assert table["half_life_h"][0] == pytest.approx(10.229, abs=1e-3)
    assert table["lost_percent"][0] == pytest.approx(50, abs=1e-4)
    assert share_lost(2.0, 1.0) == pytest.approx(0.75)
    assert share_lost(0.0, half_life(11, 298)) == 0


def test_a_charge_from_counted_balls_is_that_of_their_mass(tmp_path):
    same = {"case": "a", "bpr": 30, "molar_ratio": 10}
    counted = same | {"balls": 24, "ball_diameter_mm": 10, "ball_density_kg_m3": 7700}
    row = charge_table(write(tmp_path / "c.tsv", counted), CHEMISTRY).iloc[0]
    assert row["ball_mass_g"] == pytest.approx(24 * 7.7 * np.pi / 6, rel=1e-9)
    weighed = same | {"ball_mass_g": row["ball_mass_g"]}
    assert charge_table(write(tmp_path / "w.tsv", weighed), CHEMISTRY)["limiting_mass_g"][0] == row["limiting_mass_g"]
    assert row["powder_mass_g"] == pytest.approx(row["limiting_mass_g"] + row["reductant_mass_g"])
    # The powder charged gives back its own gas at a full yield.
    volume = 1 / gas_yield(1.0, GasConditions(298.15, 101325), 1e-3 * row["limiting_mass_g"], CHEMISTRY)
    dry = 101325 - vapour_pressure(298.15)
    assert volume * dry / (8.314462618 * 298.15) * 1e3 == pytest.approx(row["full_gas_mmol"])


WORN = {"ball_diameter_mm": 10, "speed_rpm": 1000, "time_h": 20, "bpr": 50, "unused_mass_g": 97.06}


@pytest.mark.parametrize(
    ("calculation", "reading", "column", "value"),
    [
        ("yield", READING, "yield_percent", 71.0),
        ("yield --dry-gas", READING, "yield_percent", 73.29),
        ("half-life", {"case": "a", "ph": 11, "temperature_k": 298}, "half_life_h", 10.229),
        ("charge", {"case": "a", "bpr": 30, "molar_ratio": 10, "ball_mass_g": 97.06}, "limiting_mass_g", 1.11207),
        ("wear", WORN | {"used_mass_g": 96.94}, "iron_percent", 6.18),
    ],
)
def test_the_command_calculates_each_table(tmp_path, calculation, reading, column, value):
    (name, *option), out = calculation.split(), tmp_path / "out.tsv"
    paths = [write(tmp_path / "in.tsv", reading), str(out), "--config", str(ROOT / "config/config.yaml")]
    millprint(["wet-lab", name, *paths, *option])
    assert read_table(out, numeric=[column])[column][0] == pytest.approx(value, rel=1e-3)


def test_only_what_needs_a_reaction_needs_its_file(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    write(tmp_path / "in.tsv", {"case": "a", "ph": 11, "temperature_k": 298})
    assert not millprint(["wet-lab", "half-life", "in.tsv", "out.tsv"])
    write(tmp_path / "in.tsv", READING)
    assert millprint(["wet-lab", "yield", "in.tsv", "other.tsv"]) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert "no such file; name one with your reaction, doe.chemistry, by --config FILE" in line


@pytest.mark.parametrize(
    ("wrong", "hint"),
    [({"temperature_k": 25}, "is it in °C? Write 298.15"), ({"pressure_pa": 1013.25}, "is it in hPa? Write 101325")],
)
def test_a_reading_in_another_unit_is_named(tmp_path, capsys, wrong, hint):
    config = ["--config", str(ROOT / "config/config.yaml")]
    paths = [write(tmp_path / "in.tsv", READING | wrong), str(tmp_path / "out.tsv")]
    assert millprint(["wet-lab", "yield", *paths, *config]) == 1
    assert hint in capsys.readouterr().err


@pytest.mark.parametrize(("config", "words"), refusals("the_command_refuses_in_one_line_and_writes_nothing"))
def test_the_command_refuses_in_one_line_and_writes_nothing(tmp_path, capsys, config, words):
    (tmp_path / "lab.yaml").write_text(config)
    out, path = tmp_path / "out.tsv", write(tmp_path / "in.tsv", READING)
    assert millprint(["wet-lab", "yield", path, str(out), "--config", str(tmp_path / "lab.yaml")]) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("error: ") and "lab.yaml" in line and words in line and not out.exists()
