"""A table of own measurements: what it needs, what is refused, and what it costs."""

from contextlib import nullcontext

import pytest

from millprint.config.checks import load_workflow
from millprint.config.errors import ConfigError
from millprint.config.included import SOURCES, load_mill
from millprint.config.setup_models import SETTINGS
from millprint.config.sweep import DemConfig
from millprint.run.files import write_table
from millprint.validation.measured import check_measured, measured_points, read_measurements
from millprint.validation.setups import predict
from millprint.validation.tumbling_runs import design, measured_speeds
from millprint.validation.verdicts import give_verdicts
from tests.physics.test_impacts import contact_set

OWN = "id\tsetup\tquantity\tx\tvalue\tunit\nmine\tslice_mill\tpower\tspeed\t{value}\tW\n"


def own_table(tmp_path, value: str = "55:.5;65:21.6", old: str = "", new: str = ""):
    path = tmp_path / "mine.tsv"
    path.write_text(OWN.format(value=value).replace(old, new))
    return path


def test_a_table_of_own_rows_is_enough(tmp_path):
    rows = read_measurements(own_table(tmp_path), SETTINGS)
    assert measured_points(rows)["measured"].tolist() == [0.5, 21.6]
    assert rows.loc[0, "class"] == "measured"
    check_measured(own_table(tmp_path), SETTINGS)


@pytest.mark.parametrize(
    ("old", "new", "part"),
    [
        ("power", "powr", "id mine: quantity = 'powr'.*did you mean power?"),
        ("\tW\n", "\tm/s\n", "id mine: unit = 'm/s': must be W"),
        ("power", "power, 169 balls", None),
    ],
)
def test_a_quantity_that_no_run_predicts_is_refused_before_it(tmp_path, old, new, part):
    path = own_table(tmp_path, old=old, new=new)
    with pytest.raises(ConfigError, match=part) if part else nullcontext():
        check_measured(path, SETTINGS)


def test_own_points_cost_one_simulation_each_unless_intervals_are_asked_for(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    points = measured_points(read_measurements(own_table(tmp_path, "20:1;30:2;40:3"), SETTINGS))

    def simulated(**keys) -> int:
        content = {"mill": "slice_mill", "validation": {"measured": "mine.tsv", **keys}}
        config, _, contacts, _ = load_workflow(content, [], SOURCES)
        (settings,) = config.validation.chosen.values()
        return len(design(settings, contacts, measured_speeds(settings, points)))

    assert simulated() == 3
    assert simulated(intervals=True) == 112


def test_a_tumbling_mill_without_intervals_is_compared_too(tmp_path):
    """One seed and one contact set: numbers without intervals, at the measured speeds."""
    settings = SETTINGS["slice_mill"].without_intervals()
    points = measured_points(read_measurements(own_table(tmp_path, "55:17"), SETTINGS))
    slice_contact = contact_set("slice_mill", restitution=0.5)
    runs = design(settings, {settings.contact: slice_contact}, measured_speeds(settings, points))
    results = {"power_W": 18.0, "toe_deg": 130.0, "shoulder_deg": 300.0, "rings": 0.0, "carried": 0}
    write_table(runs.assign(**results), tmp_path / "runs.tsv")
    predicted = predict(
        "slice_mill", settings, load_mill("slice_mill"), {settings.contact: slice_contact}, DemConfig(), {},
        "", points, tmp_path,
    )  # fmt: skip
    (own,) = predicted[predicted["id"] == "mine"].to_dict("records")
    assert own["predicted"] == 18.0 and own["lower"] != own["lower"] and own["interval"] == ""
    verdicts = give_verdicts(points, {"slice_mill": predicted}, {})
    assert verdicts["reason"].tolist() == ["within 10 %"]
