"""A fingerprint of a charge of several ball sizes: apart from balls of one size in tables, intervals and sheets."""

import numpy as np
import pytest

from millprint.config.load import load_named
from millprint.config.mill import MillConfig
from millprint.config.mixture import BallMixture
from millprint.errors import ConfigError
from millprint.figures import mills as figures
from millprint.files import write_table
from millprint.fingerprint.descriptors import read_descriptors, tabulate_counting_rules, tabulate_descriptors
from millprint.fingerprint.exponents import fit_exponents
from millprint.fingerprint.inputs import charges_of
from millprint.fingerprint.mill_collapse import UNKNOWN, tabulate_mill_collapse
from millprint.fingerprint.mill_sheet import tabulate_sheet
from millprint.fingerprint.model import Fingerprint
from millprint.fingerprint.zones import find_zones
from millprint.view.mill_picture import picture_mill
from tests.conftest import ROOT
from tests.unit.synthetic_mill import FILLS, VOLUME, summaries, summary

pytestmark = pytest.mark.usefixtures("close_figures")
THREE = BallMixture(name="three", sizes_mm=(12, 10, 6), numbers=(1, 1, 2))
MEAN_M = THREE.mean_diameter_mm / 1e3


def charged(speeds=(600.0, 1200.0), fills=FILLS) -> list[dict]:
    """Runs of the charge alone."""
    return [summary(fill, speed_rpm=speed, mixture=THREE, error=0.002) for fill in fills for speed in speeds]


def fitted(runs: list[dict]) -> Fingerprint:
    return Fingerprint.fit(tabulate_descriptors(runs, "gap_3ms"), VOLUME, 0.95, charges_of(runs))


@pytest.fixture(scope="module")
def both() -> Fingerprint:
    """Balls of 10 and 5 mm, and the charge."""
    return fitted(summaries(error=0.002) + charged())


def outside(fingerprint: Fingerprint, diameter_m: float, charge: str = "") -> tuple[str, ...]:
    condition = fingerprint.condition(speed_hz=12, ball_diameter_m=diameter_m, fill_ratio=0.1)
    return fingerprint.predict(condition, charge=charge).outside


def test_a_table_names_the_charge(tmp_path):
    table = tabulate_descriptors(summaries() + charged(), "gap_3ms")
    assert table.groupby("charge").size().to_dict() == {"": 4 * len(FILLS), "three": 2 * len(FILLS)}
    write_table(table, tmp_path / "descriptors.tsv")
    assert read_descriptors(tmp_path / "descriptors.tsv")["charge"].tolist() == table["charge"].tolist()


def test_a_charge_is_apart_from_balls_of_one_size_as_large_as_its_mean_ball():
    runs = [summary(diameter_mm=THREE.mean_diameter_mm), summary(mixture=THREE)]
    assert sorted(tabulate_descriptors(runs, "gap_3ms")["charge"]) == ["", "three"]


def test_a_prediction_for_other_balls_says_so(both):
    alone = fitted(charged())
    assert outside(alone, MEAN_M, "three") == ()
    assert outside(alone, MEAN_M) == ("charge",)
    assert outside(fitted(summaries(error=0.002)), MEAN_M, "three") == ("charge",)
    assert outside(both, MEAN_M, "three") == () and outside(both, 0.007) == ()
    assert outside(both, 0.007, "three") == ("ball_diameter_m",)
    assert outside(both, MEAN_M, "four") == ("charge",)


def test_a_larger_charge_does_not_widen_the_range_of_balls_of_one_size():
    large = THREE.model_copy(update={"sizes_mm": (24.0, 20.0, 12.0), "name": "large"})
    runs = summaries(error=0.002) + [summary(fill, mixture=large, error=0.002) for fill in FILLS]
    assert outside(fitted(runs), 0.012) == ("ball_diameter_m",)


def test_a_file_holds_the_charge(both, tmp_path):
    both.write(tmp_path / "fingerprint.json")
    again = Fingerprint.read(tmp_path / "fingerprint.json")
    assert again.charges["three"].counts(40) == THREE.counts(40) == [10, 10, 20]
    assert again.charge_diameter_m("three") == pytest.approx(MEAN_M)
    with pytest.raises(ConfigError, match="charge = four: the fingerprint of emax has three"):
        again.charge_diameter_m("four")
    assert "charges" not in fitted(summaries(error=0.002)).about


def test_walls_are_named_where_they_differ():
    runs = [{**run, "wall_static_friction": 0.5} for run in summaries()]
    about = fitted(runs).about
    assert about["wall_static_friction"] == 0.5 and "wall_restitution" not in about


def test_a_charge_is_no_other_size_of_balls():
    """A charge with twice the power changes no exponent of the ball size."""
    runs, odd = (
        summaries(),
        [summary(fill, speed_rpm=s, mixture=THREE, factor=2.0) for fill in FILLS for s in (600, 1200)],
    )
    found = {}
    for name, chosen in {"alone": runs, "both": runs + odd}.items():
        table = fit_exponents(tabulate_descriptors(chosen, "gap_3ms"), tabulate_counting_rules(chosen), 0.95)
        own = table[(table["quantity"] == "power_per_ball_W") & (table["variable"] == "d")].iloc[0]
        collapse = tabulate_mill_collapse(tabulate_descriptors(chosen, "gap_3ms"), 0.95, 0.2).iloc[0]
        found[name] = [own["exponent"], collapse["d"], collapse["omega"]]
    assert found["both"] == pytest.approx(found["alone"], rel=1e-9)


@pytest.mark.parametrize("speeds", [(600.0,), (600.0, 1200.0)])
def test_a_mill_with_a_charge_alone_has_a_sheet(speeds):
    runs = [{**run, "wall_static_friction": 0.5} for run in charged(speeds, FILLS[2:5])]
    table, mill = tabulate_descriptors(runs, "gap_3ms"), load_named(ROOT / "config/mills", "spex", MillConfig, "mill")
    fingerprint, collapse = fitted(runs), tabulate_mill_collapse(table, 0.95, 0.2)
    assert (collapse["collapse"] == UNKNOWN).all() == (len(speeds) == 1)
    assert collapse["d"].isna().all()
    sheet = tabulate_sheet(mill, fingerprint, collapse, find_zones(fingerprint), 1e-4)
    said = sheet[sheet["section"].isin(["mill", "condition"])].set_index("quantity")["text"]
    balls = int(sheet.set_index("quantity")["value"]["balls"])
    assert said["charge"] == THREE.in_words(balls)
    assert said["ball diameter"] == f"three (d30 = {THREE.mean_diameter_mm:.3g} mm), the ball of mean volume"
    assert said["at the wall"] == "static friction 0.5"
    curves = fingerprint.curve(np.geomspace(*fingerprint.fill_range, 20))
    page = figures.plot_sheet(picture_mill(mill), sheet, table, curves)
    labels = {line.get_label() for axis in page.axes for line in axis.lines}
    assert f"three (d30 = {THREE.mean_diameter_mm:.3g} mm), 600 rpm" in labels
    assert THREE.in_words(balls) in " ".join(text.get_text() for axis in page.axes for text in axis.texts)
