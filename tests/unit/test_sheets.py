"""The sheet and the page of a fingerprint: what they state, and the intervals that they show."""

import numpy as np
import pandas as pd
import pytest
from PIL import Image
from tools.draw_pictures import PAGE, made_of

from millprint.dose.spectra_shown import of_sheet, sheet_rows, temperature_rows, with_rows
from millprint.figures import mill_pictures as figures
from millprint.figures import mill_sheet_figure, style
from millprint.fingerprint.bands import checked_factors
from millprint.fingerprint.mill_collapse import UNKNOWN, VERDICTS, one_row_a_mill, tabulate_mill_collapse
from millprint.fingerprint.mill_sheet import SHEET, WHERE, by_columns, sheet_condition, tabulate_sheet
from millprint.fingerprint.model import Fingerprint
from millprint.fingerprint.zones import find_zones
from millprint.observables.definitions import CURVES
from millprint.view.mill_picture import picture_mill
from tests.unit.factor_samples import factors_of
from tests.unit.made_spectra import made_spectra
from tests.unit.synthetic_mill import descriptors, fingerprint
from tests.unit.test_mills import mill

pytestmark = pytest.mark.usefixtures("close_figures")


@pytest.mark.slow
def test_a_sheet_states_what_a_condition_was_given_and_the_intervals_of_its_own_sweep():
    table = tabulate_mill_collapse(descriptors(), 0.95)

    def said(fitted: Fingerprint, own: pd.DataFrame) -> pd.DataFrame:
        sheet = tabulate_sheet(mill("spex"), fitted, table, find_zones(fingerprint()), own)
        return sheet[sheet["section"] == "precision"].set_index("quantity")

    plain, scattered = descriptors(), descriptors().assign(window_s=0.4)
    rng = np.random.default_rng(0)
    for name in CURVES:
        scattered[name] *= np.exp(0.1 * rng.normal(size=len(scattered)))
    wide = Fingerprint.fit(scattered, 65e-6, 0.95)
    exact, rough = said(Fingerprint.fit(plain, 65e-6, 0.95), plain), said(wide, scattered)
    assert tuple(rough.loc["recorded time of a simulation", ["lower", "upper"]]) == (0.4, 0.4)
    assert (exact.loc["simulations of a condition", ["lower", "upper"]] == 1).all()
    # A scatter of 10 % is in the interval, where a sweep without scatter has a narrow one.
    for title in ("normal power", "tangential power", "collisions"):
        for place in WHERE:
            assert rough.at[f"{title}, {place}", "value"] > 10
            assert rough.at[f"{title}, {place}", "value"] > 2 * exact.at[f"{title}, {place}", "value"]
    assert "millprint fingerprint spex --config 'mills={precision" in rough.at["for more", "text"]
    # The condition of the sheet is one of those that were simulated.
    condition, _ = sheet_condition(wide, scattered)
    (row,) = wide.scaled(condition).to_dict("records")
    half = 100 * (np.sqrt(row["Pw_upper"] / row["Pw_lower"]) - 1)
    told = rough.loc["power, where simulated"]
    assert told["lower"] - 1e-6 <= half <= told["upper"] + 1e-6


@pytest.mark.slow
def test_the_sheet_has_every_part_and_only_its_own_columns():
    table = tabulate_mill_collapse(descriptors(), 0.95)
    sheet = tabulate_sheet(mill("spex"), fingerprint(), table, find_zones(fingerprint()), descriptors())
    assert list(sheet.columns) == SHEET
    assert list(dict.fromkeys(sheet["section"])) == [
        *("mill", "condition", "descriptors", "dose", "exponents", "collapse", "zones", "validity", "precision"),
    ]
    verdicts = {"by the scaling law": "collapses by", VERDICTS[2]: "does not collapse by powers of speed"}
    for verdict, words in {**verdicts, UNKNOWN: "unknown: "}.items():
        own = tabulate_sheet(
            mill("spex"), fingerprint(), table.assign(collapse=verdict), find_zones(fingerprint()), descriptors()
        )
        assert own["text"].str.startswith(words).any(), verdict
    described = sheet[sheet["section"] == "descriptors"]
    assert ((described["lower"] < described["value"]) & (described["value"] < described["upper"])).all()
    assert "10 Hz" in sheet["text"].tolist()


def test_a_condition_of_few_turns_has_no_number_without_that_word():
    table, few = tabulate_mill_collapse(descriptors(), 0.95), descriptors().assign(motion="few turns, repeats")
    sheet = tabulate_sheet(mill("spex"), fingerprint(), table, find_zones(fingerprint()), few)
    numbers = sheet[sheet["section"].isin(["descriptors", "dose"]) & sheet["value"].notna()]
    assert len(numbers) == 14 and numbers["text"].str.contains("few turns").all()


@pytest.fixture(scope="module")
def analysed() -> Fingerprint:
    """A fingerprint with the intervals by contact parameters."""
    plain = fingerprint()
    return plain.with_further({"contact": checked_factors(factors_of(), "contact", plain.about, "contact.json")})


def sheet_of(own: Fingerprint) -> pd.DataFrame:
    table = tabulate_mill_collapse(descriptors(), 0.95)
    return tabulate_sheet(mill("spex"), own, table, find_zones(own), descriptors())


def page_of(name: str, sheet: pd.DataFrame, own: Fingerprint, curves: pd.DataFrame):
    """The page of a mill with made-up spectra."""
    spectra, read_off = made_spectra(descriptors())
    whole = with_rows(sheet, sheet_rows(read_off, own))
    return mill_sheet_figure.plot_sheet(
        picture_mill(mill(name)), whole, descriptors(), curves, of_sheet(spectra, whole), of_sheet(read_off, whole)
    )


@pytest.mark.slow
def test_a_sheet_tells_intervals_apart_and_is_else_as_before(analysed):
    plain, sheet = sheet_of(fingerprint()), sheet_of(analysed)
    assert sheet.iloc[: len(plain)][SHEET].astype(object).equals(plain.astype(object))
    described = sheet[sheet["section"] == "descriptors"]
    condition, _ = sheet_condition(analysed, descriptors())
    factor = analysed.further["contact"].at(np.array([condition.fill_ratio]))["En_star"]
    lower, upper = described[by_columns("contact")].iloc[0]
    assert (lower, upper) == pytest.approx(tuple(described["value"].iloc[0] * factor[:, 0]), rel=1e-12)
    assert described[by_columns("shape")].isna().all(axis=None)
    said = sheet[sheet["section"] == "intervals"].set_index("quantity")["text"]
    assert list(said.index) == ["a new simulation", "the mean", "contact parameters", "shape of the jar"]
    assert said["shape of the jar"] == "not analysed" and "frictions" in said["contact parameters"]


def test_the_page_in_the_readme_is_of_the_present_code():
    with Image.open(PAGE) as page:
        assert page.text["made of"] == made_of(sheet_of(fingerprint())), "python tools/draw_pictures.py FOLDER"


@pytest.mark.slow
def test_the_page_of_a_fingerprint_shows_every_interval_in_a_column_of_its_own(analysed):
    curves = analysed.further_curve(analysed.curve(np.geomspace(0.04, 0.4, 20)))
    page = page_of("spex", sheet_of(analysed), analysed, curves)
    assert page.get_size_inches() == pytest.approx([8.27, 11.69])
    (table,) = [table for axis in page.axes for table in axis.tables]
    heads = [table[0, column].get_text().get_text() for column in range(2, 5)]
    # Nothing is known by the shape of the jar: it has no column.
    assert heads == ["a new simulation", "the mean", "contact parameters"]
    cells = [table[1, column].get_text().get_text() for column in range(2, 5)]
    assert all(" to " in cell for cell in cells)
    labels = {line.get_label() for axis in page.axes for line in axis.lines}
    assert "by contact parameters" in labels and "by shape of the jar" not in labels


@pytest.mark.parametrize("title", ["Jar $x_{$", "Jar of $5, lid of $6", "one $"])
def test_a_title_with_dollars_is_drawn_as_it_is(tmp_path, title):
    axis = style.plt.subplots()[1]
    style.write_rows(axis, [(title, title)], 0.5, (30, 30), 8, 5)
    style.draw_table(axis, ["a", "b"], [[title, title]], 8)
    for number, figure in enumerate([axis.figure, figures.plot_geometry(picture_mill(mill("spex", title=title)))]):
        style.save(figure, tmp_path / f"{number}.svg", tmp_path / f"{number}.png", tmp_path / f"{number}.pdf")
        assert (tmp_path / f"{number}.svg").read_text().count(f">{title}</text>") == (1 if number else 4)


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


@pytest.mark.slow
def test_the_page_of_a_fingerprint_and_the_collapse_of_mills_show_their_tables():
    table = tabulate_mill_collapse(descriptors(), 0.95)
    sheet = tabulate_sheet(mill("attritor"), fingerprint(), table, find_zones(fingerprint()), descriptors())
    curves = fingerprint().curve(np.geomspace(0.04, 0.4, 20))
    sheet = with_rows(sheet, temperature_rows(temperatures(sheet), sheet))
    page = page_of("attritor", sheet, fingerprint(), curves)
    assert page.get_size_inches() == pytest.approx([8.27, 11.69])
    words = " ".join(text.get_text() for axis in page.axes for text in axis.texts)
    for part in (
        "normal energy of a collision",
        "of speed 3",
        "Holds from",
        "0.04 to 0.4",
        "power of a kilogram of balls",
        "41 °C (32 to 60)",
        "drum 0.578 to 2.07, ",
    ):
        assert part in words
    assert " - (" not in words and "(- " not in words
    collapse = figures.plot_collapse(one_row_a_mill([table]), 0.2)
    assert [label.get_text() for label in collapse.axes[0].get_yticklabels()] == ["emax"]
