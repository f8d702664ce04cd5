"""The sheet and the page of a fingerprint: what they state, and the intervals that they show."""

from functools import cache

import numpy as np
import pandas as pd
import pytest
from PIL import Image
from tools.draw_pictures import PICTURES, RUNS, made_of

from millprint.dose.spectra_shown import temperature_rows
from millprint.fingerprint.mill_collapse import find_zones, tabulate_mill_collapse
from millprint.fingerprint.mill_sheet import WHERE, tabulate_sheet
from millprint.fingerprint.model import Fingerprint
from millprint.observables.definitions import CURVES
from tests.unit.synthetic_mill import descriptors, fingerprint
from tests.unit.test_mills import mill

pytestmark = pytest.mark.usefixtures("close_figures")


@cache
def collapse() -> pd.DataFrame:
    return tabulate_mill_collapse(descriptors(), 0.95)


@pytest.mark.slow
def test_a_sheet_states_what_a_condition_was_given_and_the_intervals_of_its_own_sweep():
    table = collapse()

    def said(own: pd.DataFrame) -> pd.DataFrame:
        fitted = Fingerprint.fit(own, 65e-6, 0.95)
        sheet = tabulate_sheet(mill("spex"), fitted, table, find_zones(fingerprint()), own)
        return sheet[sheet["section"] == "precision"].set_index("quantity")

    scattered, random = descriptors().assign(window_s=0.4), np.random.default_rng(0)
    for name in CURVES:
        scattered[name] *= np.exp(0.1 * random.normal(size=len(scattered)))
    exact, rough = said(descriptors()), said(scattered)
    assert tuple(rough.loc["recorded time of a simulation", ["lower", "upper"]]) == (0.4, 0.4)
    # A scatter of 10 % is in the interval, where a sweep without scatter has a narrow one.
    for title in (
        f"{title}, {place}" for title in ("normal power", "tangential power", "collisions") for place in WHERE
    ):
        assert rough.at[title, "value"] > max(10, 2 * exact.at[title, "value"])


def test_a_condition_of_few_turns_has_no_number_without_that_word():
    table, few = collapse(), descriptors().assign(motion="few turns, repeats")
    sheet = tabulate_sheet(mill("spex"), fingerprint(), table, find_zones(fingerprint()), few)
    numbers = sheet[sheet["section"].isin(["descriptors", "dose"]) & sheet["value"].notna()]
    assert len(numbers) == 14 and numbers["text"].str.contains("few turns").all()


def sheet_of(own: Fingerprint) -> pd.DataFrame:
    table = collapse()
    return tabulate_sheet(mill("spex"), own, table, find_zones(own), descriptors())


@pytest.mark.parametrize("picture", RUNS)
def test_a_page_among_the_pictures_is_of_the_present_code(picture):
    with Image.open(PICTURES / picture) as page:
        assert page.text["made of"] == made_of(sheet_of(fingerprint()), RUNS[picture][0]), (
            f"python -m tools.draw_pictures {picture}"
        )


def temperatures(sheet: pd.DataFrame, speed_rpm: float | None = None) -> pd.DataFrame:
    """The table of a heat balance at a sheet's condition, or at another speed."""
    told = sheet[sheet["section"] == "condition"].set_index("quantity")["value"]
    row = {
        "ball_diameter_mm": told["ball diameter"],
        "speed_rpm": speed_rpm or told["speed"],
        "fill_ratio": told["fill ratio"],
    }
    bands = {"median": 41.2, "lower": 31.9, "upper": 60.0}
    row |= {f"{body}_steady_degC_{end}": value for body in ("powder", "balls", "jar") for end, value in bands.items()}
    return pd.DataFrame([row])


def test_a_sheet_has_the_dose_and_the_temperatures_of_its_condition():
    sheet = sheet_of(fingerprint())
    told = sheet.drop_duplicates("quantity").set_index("quantity")["value"]
    assert told["power"] == pytest.approx(told[["normal power", "tangential power", "rolling power"]].sum())
    # 10 g of powder in 100 g of balls get in an hour what the balls dissipate.
    dose = told["dose of an hour at a ball-to-powder ratio of 10"]
    assert dose == pytest.approx(3.6e-3 * 10 * told["power of a kilogram of balls"])
    assert told["fill ratio"] in set(descriptors()["fill_ratio"])
    assert temperature_rows(temperatures(sheet), sheet)["value"].tolist() == 3 * [41.2]
    other = temperature_rows(temperatures(sheet, speed_rpm=1.0), sheet)
    assert other["text"].tolist() == ["not calculated here"]
