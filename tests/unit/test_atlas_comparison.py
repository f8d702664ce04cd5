"""What the atlas's tables of errors say, of models whose errors are known."""

import math
import shutil
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from millprint.atlas import compare_atlas
from millprint.atlas.atlas_model import FITTED, MARKS, PREDICTED
from millprint.atlas.compare_atlas import cross_validated, errors, judged, linear, nearest, regions, scaling_law
from millprint.atlas.fit_atlas import Rows, rows_of, scaled
from millprint.atlas.kinds import MIXER, PLANETARY, balls_of
from millprint.config.included import SOURCES, load_contact, load_mill
from millprint.fingerprint.model import Fingerprint
from millprint.fingerprint.readers import find_fingerprint
from millprint.run.files import read_table
from tests.conftest import ROOT

# Of each number, the share by which a model is off, up for every second row; half of its interval.
OFF = dict(zip(MARKS, (0.02, 0.06, 0.11, 0.14, 0.30), strict=True))
WIDE = 0.11


@pytest.fixture(scope="module")
def table():
    return read_table(ROOT / "config/atlas/simulations.tsv")


@pytest.fixture(scope="module")
def rows(table):
    return rows_of(table, MIXER, "training").some(np.arange(200))


def off_by(rows: Rows) -> dict[str, np.ndarray]:
    """Logarithms of MARKS that are off by OFF."""
    actual, up = scaled(rows.table, MIXER), np.arange(len(rows)) % 2
    return {
        name: actual[name].to_numpy() + np.where(up, math.log(1 + off), math.log(1 - off)) for name, off in OFF.items()
    }


def told_by(rows: Rows) -> SimpleNamespace:
    """A model of these rows that is off by OFF, is sure of half of them, and tells nine of ten motions right."""
    values = {**{name: rows.fitted[name] for name in FITTED}, **dict(zip(FITTED, off_by(rows).values(), strict=False))}
    number = np.arange(len(rows))
    return SimpleNamespace(
        kind=MIXER, fitted=lambda inputs: values,
        logarithms=lambda inputs: {name: (off_by(rows)[name], np.full(len(rows), WIDE)) for name in MARKS},
        widths=dict.fromkeys(PREDICTED, SimpleNamespace(typical=lambda inputs: 1.0 * (2 * number >= len(rows)))),
        probability=lambda inputs: np.where((number % 10 == 0) ^ rows.hits, 0.9, 0.1),
    )  # fmt: skip


def test_errors_are_relative_and_none_where_nothing_is_hit(rows):
    found = errors(MIXER, rows, off_by(rows))
    for name, off in OFF.items():
        told = rows.hits | (name == "wall_power_W")
        assert found[name].isna().to_numpy().tolist() == (~told).tolist()
        assert found.loc[told, name].abs().to_numpy() == pytest.approx(off)
    assert 0 < (~rows.hits).sum() < len(rows)


def test_a_model_of_known_errors_is_judged_by_them(rows, monkeypatch):
    monkeypatch.setattr(compare_atlas, "MODELS", {"nearest neighbour": nearest, "atlas": compare_atlas.atlas})
    found = judged(told_by(rows), rows, rows).set_index("model")
    names = list(MARKS)
    assert found.loc["nearest neighbour", names].astype(float).to_numpy() == pytest.approx(0, abs=1e-12)
    for row in ("atlas", "atlas where it asks for no simulation"):
        assert found.loc[row, names].to_dict() == pytest.approx(OFF)
    # Of 11 %, ln 1.11 is inside the interval and -ln 0.89 is not.
    held = found.loc["share held by the 90 % interval", names].astype(float)
    assert held.iloc[:2].tolist() == [1.0, 1.0]
    assert held.iloc[2] == pytest.approx(0.5, abs=0.02)
    assert held.iloc[3:].tolist() == [0.0, 0.0]
    assert found.loc["share of such mills", "wall_power_W"] == 0.5
    assert found.loc["share of motions told right", "wall_power_W"] == pytest.approx(0.9)
    assert found.loc["mark", names].to_dict() == MARKS
    spread = rows.table.loc[rows.hits, "wall_power_relative_se"].median()
    assert found.loc["scatter of one simulation", "wall_power_W"] == pytest.approx(0.6745 * spread)


def test_mills_beyond_the_limit_are_refused_and_not_judged(table, monkeypatch):
    monkeypatch.setattr(compare_atlas, "MODELS", {"nearest neighbour": nearest, "atlas": nearest})
    rows = rows_of(table, PLANETARY, "training").some(np.arange(150))
    beyond = int((~rows.within).sum())
    asked = rows.asked()
    model = SimpleNamespace(
        kind=PLANETARY, fitted=lambda inputs: {name: asked.fitted[name] for name in FITTED},
        logarithms=lambda inputs: {name: (scaled(asked.table, PLANETARY)[name], np.ones(len(asked))) for name in MARKS},
        widths=dict.fromkeys(MARKS, SimpleNamespace(typical=lambda inputs: np.zeros(len(asked)))),
        probability=lambda inputs: asked.hits.astype(float),
    )  # fmt: skip
    found = judged(model, rows, rows).set_index("model")
    assert beyond > 0
    assert found.loc["refused", "mills"] == beyond
    assert found.loc["nearest neighbour", "mills"] == len(rows) - beyond


def test_regions_are_tenths_of_the_fill_ratio(rows):
    found = regions(told_by(rows), rows)
    fill = np.sort(rows.table["fill"])
    assert found["mills"].sum() == len(rows)
    assert found["mills"].tolist() == [20] * 10
    assert found["fill_from"].tolist() == pytest.approx(fill[::20])
    assert found["fill_to"].tolist() == pytest.approx(fill[19::20])
    assert found["wall_power_W_error"].to_numpy() == pytest.approx(OFF["wall_power_W"])
    assert (found["weighted_tangential_frequency_hz_held"].dropna() == 0).all()


@pytest.mark.parametrize(("share", "used"), [(1.0, 160), (0.25, 40)])
def test_a_model_is_asked_for_rows_that_it_was_not_given(rows, share, used):
    seen = []

    def twice(kind, training, test):
        given = {tuple(row) for row in training.inputs.tolist()}
        assert not any(tuple(row) in given for row in test.inputs.tolist())
        seen.append((len(training), len(test)))
        return {name: values + math.log(2) for name, values in scaled(test.table, kind).items()}

    found = cross_validated(MIXER, rows, twice, share)
    assert seen == [(used, 40)] * 5
    assert found == {"kind": "mixer", "rows": used, **dict.fromkeys(MARKS, pytest.approx(1.0))}


def test_a_linear_model_learns_a_power_law_of_the_groups_and_no_more(rows):
    """Not what the kind derives from them, which the atlas has."""
    law = rows.inputs[:, : len(MIXER.groups)] @ np.linspace(-1, 1, len(MIXER.groups))
    scales = [MIXER.scales(MIXER.condition_of(row))["power"] for row in rows.table.to_dict("records")]
    made = rows.table.assign(wall_power_W=np.exp(law) * scales)
    training, test = (Rows(rows.inputs[own], rows.hits[own], {}, {}, made.iloc[own].reset_index(drop=True),
                           rows.within[own]) for own in (np.arange(150), np.arange(150, 200)))  # fmt: skip
    assert np.abs(errors(MIXER, test, linear(MIXER, training, test))["wall_power_W"]).max() < 1e-3


def test_the_scaling_law_says_of_the_included_mill_what_its_fingerprint_does(rows):
    """The table has its groups only; a mill of another size has the same ones."""
    built, contact = MIXER.recognised(load_mill("mixer")), load_contact("calibrated")
    condition = {**built, **balls_of(contact), "ball_diameter_mm": 10.0, "number": 20, "speed_hz": 25.0}
    table = pd.DataFrame([{**MIXER.groups_of(condition), "number": 20}])
    told = scaling_law(MIXER, rows, Rows(rows.inputs[:1], rows.hits[:1], {}, {}, table, rows.within[:1]))
    fingerprint = Fingerprint.read(find_fingerprint("mixer", sources=SOURCES))
    known = fingerprint.predict(fingerprint.condition(speed_hz=25.0, ball_diameter_mm=10.0, number=20)).known
    for name in MARKS:
        scale = MIXER.scales(condition)[PREDICTED[name]]
        # The nominal volume of the jar, and so the fill ratio, is 0.25 % off.
        assert told[name][0] == pytest.approx(math.log(known[name].value / scale), abs=3e-3)


def test_the_scaling_law_does_not_depend_on_what_lies_in_the_folder(rows, tmp_path, monkeypatch):
    """A run of a mill of the same name, and that mill."""
    few = rows.some(np.arange(5))
    expected = scaling_law(MIXER, rows, few)
    run, mill = tmp_path / "results/mills/mixer/fingerprint.json", tmp_path / "config/mills/mixer.yaml"
    run.parent.mkdir(parents=True)
    mill.parent.mkdir(parents=True)
    shutil.copy(ROOT / "config/fingerprints/spex.json", run)
    mill.write_text((ROOT / "config/mills/mixer.yaml").read_text().replace("amplitude_deg: 8.8", "amplitude_deg: 12"))
    monkeypatch.chdir(tmp_path)
    found = scaling_law(MIXER, rows, few)
    for name, values in expected.items():
        assert found[name].tolist() == values.tolist()
