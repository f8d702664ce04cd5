"""Wear by Archard's law: what is fitted and held back, what is predicted, and the tables that are refused."""

import json
from types import SimpleNamespace

import h5py
import numpy as np
import pandas as pd
import pytest

from millprint.cli.commands import main as millprint
from millprint.config.dose import ChargeConfig
from millprint.config.errors import ConfigError
from millprint.dose import wear
from millprint.run.files import write_json
from millprint.thesis.doe import wet_lab
from tests.conftest import ROOT

MATERIALS = ROOT / "config/data/wear_materials.tsv"
STEEL = "stainless_steel"
TRUE = 2e-5
JAR, DENSITY = 125e-6, 7700.0
CHARGES = [ChargeConfig(bpr=50, time_h=20)]


@pytest.fixture
def materials() -> pd.DataFrame:
    return wear.read_materials(str(MATERIALS), STEEL)


def conditions(speeds=(600.0, 1200.0), fill=0.10) -> pd.DataFrame:
    """A mill whose sliding powers follow the cube of the speed."""
    cube = np.array(speeds) ** 3 / 1200.0**3
    table = pd.DataFrame({"mill": "emax", "contact": "calibrated", "ball_diameter_mm": 10.0, "speed_rpm": speeds})
    table = table.assign(fill_ratio=fill, balls=24, balls_mass_kg=fill * JAR * DENSITY, density_kg_m3=DENSITY)
    loads = {"load_ball_ball_N_m_s": 70 * cube, "load_ball_wall_N_m_s": 55 * cube}
    return table.assign(volume_m3=JAR, seeds=2, relative_error=0.02, **loads)


def weighings(factors, speeds=(1200.0, 1000.0, 800.0, 600.0)) -> pd.DataFrame:
    """Weighings by the law with TRUE, each times its factor."""
    hardness = 550 * 9.80665e6
    rows = []
    for speed, factor in zip(speeds, factors, strict=False):
        load = (2 * 70 + 55) * (speed / 1200) ** 3 * 20 * 3600
        grams = 1e3 * DENSITY * TRUE * load / hardness * factor
        unused = 0.1 * JAR * DENSITY * 1e3
        rows.append([10.0, speed, 20.0, 50.0, unused, unused - grams, grams])
    names = ["ball_diameter_mm", "speed_rpm", "time_h", "bpr", "unused_mass_g", "used_mass_g", "wear_g"]
    return wet_lab.wear_table(pd.DataFrame(rows, columns=names))


def test_the_coefficient_comes_from_every_other_row_alone(materials):
    """The held rows are wrong by factors that the coefficient must not see, and that the miss must."""
    table, result = wet_lab.fit_wear(weighings([1, 3, 1, 1 / 3]), conditions(), materials.loc[STEEL], 0.05)
    assert table["role"].tolist() == ["fitted", "held back", "fitted", "held back"]
    assert table["loads_from"].tolist() == ["a run", "between runs", "between runs", "a run"]
    assert result["coefficient"] == pytest.approx(TRUE, rel=1e-9)
    assert result["miss_log"] == pytest.approx(np.log(3), rel=1e-9)
    assert table["measured_over_predicted"].tolist() == pytest.approx([1, 3, 1, 1 / 3], rel=1e-9)
    assert (result["coefficient_lowest"], result["coefficient_highest"]) == pytest.approx((TRUE / 3, 3 * TRUE))


def test_with_two_rows_it_is_said_that_they_are_too_few(materials):
    _, result = wet_lab.fit_wear(weighings([1, 0.6]), conditions(), materials.loc[STEEL], 0.05)
    said = wet_lab.said_of_wear(result)
    assert "missed by a factor of 1.7" in said and "too few to tell" in said
    table = wear.predict_wear(conditions(), materials, CHARGES, result, None)
    assert table["note"].str.contains("too few for a useful interval").all()
    steel = table[table["material"] == STEEL].iloc[-1]
    # 95 % of normal errors of 2 % are within 1.96 of them; Student's t of one degree of freedom is 12.7.
    assert steel["factor_scatter"] == pytest.approx(np.exp(1.959964 * 0.02))
    assert steel["factor_coefficient"] == pytest.approx(0.6**-12.706, rel=1e-3)
    ends = steel[["seen_lower_wear_g", "seen_upper_wear_g"]].tolist()
    assert ends == pytest.approx([0.6 * steel["wear_g"], steel["wear_g"]])


def test_a_law_that_holds_predicts_its_own_weighing_and_iron_follows_powder_and_time(materials):
    _, result = wet_lab.fit_wear(weighings([1, 1.1, 1, 0.9]), conditions(), materials.loc[STEEL], 0.05)
    charges = [ChargeConfig(bpr=50, time_h=20), ChargeConfig(bpr=25, time_h=10)]
    table = wear.predict_wear(conditions(), materials, charges, result, None)
    long, short = table[(table["material"] == STEEL) & (table["speed_rpm"] == 1200)].to_dict("records")
    assert long["wear_g"] == pytest.approx(weighings([1])["wear_g"].iloc[0], rel=1e-9)
    assert long["powder_percent"] == pytest.approx(weighings([1])["iron_percent"].iloc[0], rel=1e-9)
    assert long["iron_percent"] == pytest.approx(0.85 * long["powder_percent"])
    # Half the time, twice the powder.
    assert short["powder_percent"] == pytest.approx(long["powder_percent"] / 4)
    assert long["lower_wear_g"] < long["wear_g"] < long["upper_wear_g"] <= 1e3 * conditions()["balls_mass_kg"].max()
    assert long["jar_g"] == pytest.approx(long["wear_g"] * 55 / 195)


def test_contact_parameters_count_by_what_they_change_since_the_fit(materials):
    """Factors 0.4 to 2 at the condition, 0.25 to 3 at the weighing: 0.4 / 0.25 is more than 3 / 2."""
    _, result = wet_lab.fit_wear(weighings([1, 1]), conditions(), materials.loc[STEEL], 0.05)
    result |= {"mill": "emax", "contact": "calibrated"}
    ends = {"Pt": np.array([[0.4, 0.25], [2.0, 3.0]])}
    for own, fitted, factor in (("emax", "emax", 1.6), ("emax", "spex", 2.5), ("spex", "emax", np.nan)):
        contact = SimpleNamespace(mill=own, contact="calibrated", at=lambda fills: ends)
        table = wear.predict_wear(conditions(), materials, CHARGES, result | {"mill": fitted}, contact)
        assert table["factor_contact"].to_numpy() == pytest.approx(factor, nan_ok=True)


def test_a_harder_and_lighter_ball_loses_less_and_no_iron(materials):
    _, result = wet_lab.fit_wear(weighings([1, 1]), conditions(), materials.loc[STEEL], 0.05)
    table = wear.predict_wear(conditions((1200.0,)), materials, CHARGES, result, None).set_index("material")
    light = 5900 / 7700
    # Loads and mass are proportional to the density, the volume to one over the hardness.
    expected = light**2 * 550 / 1200
    assert table.at["zirconia", "wear_g"] / table.at[STEEL, "wear_g"] == pytest.approx(expected, rel=1e-9)
    assert table.at["zirconia", "iron_percent"] == 0
    assert table.at["zirconia", "factor_hardness"] == pytest.approx(1200 / 1080)
    assert table.at["zirconia", "factor_coefficient"] == pytest.approx(10, rel=1e-6)
    assert table.at[STEEL, "factor_hardness"] == 1
    assert "order of magnitude" in table.at["zirconia", "note"] and "magnitude" not in table.at[STEEL, "note"]


def test_one_speed_is_carried_by_its_cube_and_no_run_gives_no_coefficient(materials):
    table, result = wet_lab.fit_wear(weighings([1, 1]), conditions((600.0,)), materials.loc[STEEL], 0.05)
    assert table["loads_from"].tolist() == [wet_lab.BY_CUBE] * 2
    assert result["coefficient"] == pytest.approx(TRUE, rel=1e-9)
    table, result = wet_lab.fit_wear(weighings([1, 1]), conditions(fill=0.2), materials.loc[STEEL], 0.05)
    assert table["loads_from"].tolist() == ["no run with 10 mm at fill 0.1"] * 2
    assert result["coefficient"] is None and "no coefficient" in wet_lab.said_of_wear(result)
    empty = wear.predict_wear(conditions(), materials, CHARGES, result, None)
    assert empty.empty and list(empty.columns) == wear.WEAR_COLUMNS


def test_seeds_are_averaged_with_their_scatter():
    rows = [
        dict(zip(wear.CONDITION, ["emax", "calibrated", 10.0, 0.1, 600.0], strict=True))
        | {"balls": 24, "balls_mass_kg": 0.1, "density_kg_m3": 7700.0, "volume_m3": JAR, "relative_error": 0.01}
        | {"load_ball_ball_N_m_s": load, "load_ball_wall_N_m_s": 1.0}
        for load in (8.0, 10.0)
    ]
    (row,) = wear.mean_conditions(pd.DataFrame(rows)).to_dict("records")
    assert row["seeds"] == 2 and row["load_ball_ball_N_m_s"] == 9
    assert row["relative_error"] == pytest.approx(np.sqrt(2) / 10 / np.sqrt(2))
    # One seed has no scatter, and that of two that are alike is less than within their windows.
    (alone,) = wear.mean_conditions(pd.DataFrame(rows[:1])).to_dict("records")
    assert alone["relative_error"] == pytest.approx(0.01)
    (alike,) = wear.mean_conditions(pd.DataFrame([rows[0], rows[0] | {"relative_error": 0.03}])).to_dict("records")
    assert alike["relative_error"] == pytest.approx(0.02 / np.sqrt(2))
    (unknown,) = wear.mean_conditions(pd.DataFrame([rows[0] | {"relative_error": np.nan}])).to_dict("records")
    assert np.isnan(unknown["relative_error"])


def test_loads_come_from_the_nearest_fill_and_follow_a_power_law_between_speeds():
    table = pd.concat([conditions(fill=0.097), conditions(fill=0.102), conditions(fill=0.2)])
    table["load_ball_ball_N_m_s"] *= [1, 1, 2, 2, 5, 5]
    for fill, factor in ((0.098, 1), (0.101, 2), (0.2, 5)):
        loads, error, origin = wet_lab.loads_at(table, 10.0, fill, 1200.0, 0.05)
        assert loads["ball_ball"] == pytest.approx(70 * factor) and (error, origin) == (0.02, wet_lab.AS_RUN)
    loads, error, origin = wet_lab.loads_at(table, 10.0, 0.2, 900.0, 0.05)
    assert loads["ball_wall"] == pytest.approx(55 * 0.75**3) and (error, origin) == (0.02, wet_lab.BETWEEN)


def write_run(folder, total=0.75, histogram=False) -> tuple[str, str]:
    """A run of three contacts: 0.25 J between balls, 0.5 J at the wall."""
    folder.mkdir(exist_ok=True)
    case = {"mill": "emax", "contact": "calibrated", "ball_diameter_m": 0.01, "fill_ratio": 0.1, "speed_hz": 10}
    with h5py.File(folder / "run.h5", "w") as file:
        file.attrs["config"] = json.dumps({"case": {**case, "seed": 0}})
        group = file.create_group("collisions")
        if not histogram:
            group["second"], group["sliding_J"] = np.array([1, -1, -3]), np.array([0.25, 0.2, 0.3])
    summary = {
        "balls": 24, "ball_mass_kg": 0.004, "density_kg_m3": 7700.0, "nominal_volume_m3": JAR, "window_s": 0.5,
        "static_friction": 0.25, "wall_static_friction": 0.5, "ledger_J": {"sliding": total},
        "power_W": {"tangential": 2.0}, "power_standard_error_W": {"tangential": 0.1},
        "collisions": [{"shares": {"ball_ball": {"tangential": 0.4}, "ball_wall": {"tangential": 0.6}}}],
    }  # fmt: skip
    write_json(summary, folder / "summary.json")
    return str(folder / "run.h5"), str(folder / "summary.json")


def test_sliding_work_is_split_by_the_contacts_and_each_kind_has_its_own_friction(tmp_path):
    row = wear.sliding_of_run(*write_run(tmp_path))
    assert row["split"] == wear.CONTACTS and row["relative_error"] == pytest.approx(0.05)
    assert (row["balls_mass_kg"], row["volume_m3"], row["window_s"]) == pytest.approx((0.096, JAR, 0.5))
    assert (row["sliding_ball_ball_W"], row["sliding_ball_wall_W"]) == pytest.approx((0.5, 1.0))
    assert (row["load_ball_ball_N_m_s"], row["load_ball_wall_N_m_s"]) == pytest.approx((2.0, 2.0))
    # A run without its contacts is split by the shares.
    row = wear.sliding_of_run(*write_run(tmp_path / "histogram", histogram=True))
    assert (row["sliding_ball_ball_W"], row["sliding_ball_wall_W"]) == pytest.approx((0.6, 0.9))
    with pytest.raises(ConfigError, match=r"run.h5: sliding work of all contacts 0.75 J, of the ledger 0.8 J"):
        wear.sliding_of_run(*write_run(tmp_path / "other", total=0.8))


def test_the_command_predicts_a_run_and_names_what_is_wrong(tmp_path, materials, capsys):
    write_run(tmp_path / "run")
    coefficient = tmp_path / "wear_coefficient.json"
    common = ["wear", str(tmp_path / "run"), "--bpr", "30", "--hours", "10", "--materials", str(MATERIALS)]
    common += ["--coefficient", str(coefficient)]
    assert millprint(common) == 1 and "no such file" in capsys.readouterr().err
    _, result = wet_lab.fit_wear(weighings([1, 0.6]), conditions(), materials.loc[STEEL], 0.05)
    write_json(result, coefficient)
    millprint([*common, "--material", STEEL, "--out", str(tmp_path / "out.tsv")])
    row = pd.read_csv(tmp_path / "out.tsv", sep="\t").iloc[0]
    assert row["wear_g"] == pytest.approx(1e3 * 7700 * TRUE * 6.0 * 36000 / (550 * 9.80665e6), rel=1e-6)
    assert millprint([*common, "--material", "chocolate"]) == 1 and "chocolate" in capsys.readouterr().err
