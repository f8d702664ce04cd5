"""Predictions for new conditions: intervals, refusals, and the command."""

import numpy as np
import pytest

from millprint.cli.commands import main as millprint
from millprint.run.files import read_table
from millprint.thesis.yields.averaging import fit_averaged
from millprint.thesis.yields.model_files import save_averaged, save_model
from millprint.thesis.yields.new_conditions import predict_conditions
from millprint.thesis.yields.yield_model import Trainer
from tests.conftest import ROOT
from tests.unit.yield_settings import parts, settings

CONDITIONS_TABLE = ROOT / "config/data/conditions.tsv"


@pytest.fixture(scope="module")
def models(tmp_path_factory) -> dict[str, str]:
    """One stored model for each kind of interval."""
    folder, config = tmp_path_factory.mktemp("models"), settings()
    rows, _ = parts()
    yields = rows["yield_percent"].to_numpy(float)
    paths = {name: str(folder / f"{name}.json") for name in ("mixture", "gaussian", "cv_plus")}
    averaged = fit_averaged(rows, yields, config.averaging)
    save_averaged(averaged, rows, config.averaging.margin, paths["mixture"])
    for name, kind in (("gaussian", ("gpr", "two_step")), ("cv_plus", ("svr", "primary"))):
        model, results = Trainer(config.training, config.search).train(*kind, rows, yields)
        save_model(model, results, rows, config.training, paths[name])
    return paths


def arguments(level: float) -> tuple:
    """The arguments of predict_conditions after model and conditions: limits, training, folds, level."""
    config = settings()
    return config.prediction, config.training, config.evaluation.conformal_folds, level


@pytest.mark.parametrize("kind", ["mixture", "gaussian", "cv_plus"])
def test_every_kind_of_model_predicts_with_its_interval(models, kind):
    rows, _ = parts()
    table = predict_conditions(models[kind], rows, *arguments(0.8))
    assert (table["interval"] == kind).all() and (table["warning"] == "").all()
    assert (table["lower_percent"] <= table["upper_percent"]).all()
    wider = predict_conditions(models[kind], rows, *arguments(0.95))
    assert (wider["upper_percent"] - wider["lower_percent"] >= table["upper_percent"] - table["lower_percent"]).all()


def test_conditions_outside_the_trained_ranges_are_refused_with_the_reason(models):
    rows, _ = parts()
    requested = rows.head(4).reset_index(drop=True)
    requested.loc[1, "bpr"] = 80.0
    requested.loc[2, "time_h"] = 20.1  # within one per cent of the trained 15 h
    # Another fill ratio: both energies are within their ranges, but their share is not.
    requested.loc[3, ["normal_energy_uJ", "tangential_energy_uJ"]] = [500.0, 600.0]
    table = predict_conditions(models["mixture"], requested, *arguments(0.95))
    assert table["predicted_percent"].isna().tolist() == [False, True, False, True]
    assert table["warning"][1] == "bpr = 80 is outside 9.6 to 50.4"
    assert table["warning"][3].startswith("tangential_share = 0.5455 is outside")
    assert (table["interval"] == "").tolist() == [False, True, False, True]
    extrapolated = predict_conditions(models["mixture"], requested, *arguments(0.95), extrapolate=True)
    assert (
        extrapolated["predicted_percent"].notna().all()
        and extrapolated["warning"].tolist() == table["warning"].tolist()
    )


@pytest.mark.slow
def test_the_command_predicts_the_example(models, tmp_path, capsys, monkeypatch):
    out = tmp_path / "out.tsv"
    monkeypatch.chdir(ROOT)
    assert millprint(["yields", models["mixture"], str(CONDITIONS_TABLE), str(out)]) == 0
    said = capsys.readouterr().err
    assert "1 rows are outside the domain" in said
    assert "mill.json: no such file: the descriptors are not compared with the curves of a mill" in said
    table = read_table(out, text=["case", "warning"]).set_index("case")
    assert np.isnan(table.loc["low_fill", "predicted_percent"])
    assert "tangential_share = 0.7653" in table.loc["low_fill", "warning"]
    assert table.loc["shorter", "lower_percent"] < table.loc["shorter", "predicted_percent"]
