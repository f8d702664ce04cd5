"""How many balls, as people say it, and the conditions of a sweep: lists, designs and tables."""

import math

import pytest

from millprint.cases import of_mill
from millprint.config.charge import ChargeSection
from millprint.config.checks import load_workflow
from millprint.config.errors import ConfigError
from millprint.config.included import SOURCES
from millprint.config.load import check_model
from millprint.config.mill_sweep import MillSweepConfig, spread, with_fill_ratios
from tests.refusals import refusals

LISTS = {"speeds_rpm": [300, 450], "ball_diameters_mm": [10]}
VOLUME_ML, DENSITY = 200.0, 8000.0
BALL_ML = math.pi / 6


def resolved(**keys) -> MillSweepConfig:
    return with_fill_ratios(check_model(keys, MillSweepConfig, "sweep"), VOLUME_ML, DENSITY, "sweep")


@pytest.mark.parametrize(
    ("charge", "fill"),
    [
        ({"fill_ratio": 0.2}, 0.2),
        ({"number": 50}, 50 * BALL_ML / VOLUME_ML),
        ({"mass_g": 320}, 40 / VOLUME_ML),
        ({"bulk_filling": 1 / 3}, 0.2),
        ({"bulk_filling": 0.5, "packing_fraction": 0.64}, 0.32),
    ],
)
def test_a_charge_is_a_fill_ratio(charge, fill):
    section = ChargeSection(**charge)
    assert section.fill_in(VOLUME_ML, 10, DENSITY) == pytest.approx(fill)
    assert ChargeSection(**section.given) == section


@pytest.mark.parametrize(
    ("key", "values"), [("numbers", [25, 50, 75]), ("masses_g", [100, 200, 300]), ("bulk_fillings", [0.2, 0.3, 0.4])]
)
def test_the_lists_of_a_sweep_may_be_of_any_measure(key, values):
    sweep = resolved(**LISTS, **{key: values})
    measure = {"numbers": "number", "masses_g": "mass_g", "bulk_fillings": "bulk_filling"}[key]
    assert sweep.fills == [ChargeSection(**{measure: value}).fill_in(VOLUME_ML, 10, DENSITY) for value in values]
    assert conditions_of(sweep) == [(10, speed, fill) for speed in (300, 450) for fill in sweep.fills]


def test_a_space_filling_design_covers_its_ranges_evenly():
    lists = {"speeds_rpm": [200, 400], "ball_diameters_mm": [10, 5], "fill_ratios": [0.1, 0.2, 0.4]}
    sweep = resolved(**lists, design="space_filling", points=256)
    conditions = conditions_of(sweep)
    assert len(set(conditions)) == 256
    # A quarter of the points in each quarter of speed and fill, half of them with each ball.
    share = sum(speed < math.sqrt(200 * 400) and fill < 0.2 for _, speed, fill in conditions) / 256
    assert share == pytest.approx(0.25, abs=0.01)
    assert sum(size == 10 for size, _, _ in conditions) == 128
    assert all(200 <= speed <= 400 and 0.1 <= fill <= 0.4 for _, speed, fill in conditions)
    # The conditions that no fit sees are spread alike over a sweep of conditions.
    assert all(0.1 < fill < 0.4 and size in (10, 5) for size, _, fill in as_tuples(spread(sweep, 8, seed=1)))


def conditions_of(sweep) -> list[tuple]:
    """Balls, speed [rpm] and fill ratio of each condition."""
    return as_tuples(of_mill.conditions_of(sweep))


def as_tuples(conditions) -> list[tuple]:
    return [(each.ball_diameter_mm, each.rpm, each.fill_ratio) for each in conditions]


def write_table(folder, text: str) -> str:
    (folder / "conditions.tsv").write_text(text.replace(" ", "\t"))
    return "conditions.tsv"


def test_a_table_may_mix_measures(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    rows = "# mine\nspeed_rpm speed_hz ball_diameter_mm fill_ratio number\n300  10 0.1 \n 5 10  50\n400  5 0.2 \n"
    sweep = resolved(table=write_table(tmp_path, rows), seeds=[0, 1])
    of_number = ChargeSection(number=50).fill_in(VOLUME_ML, 10, DENSITY)
    assert conditions_of(sweep) == [(10, 300, 0.1), (10, 300, of_number), (5, 400, 0.2)]
    assert sweep.seeds == [0, 1] and sweep.speeds == [300, 400] and sweep.balls == [10, 5]
    # What a job is given is read as it was.
    assert MillSweepConfig(**sweep.model_dump(mode="json")) == sweep


@pytest.mark.parametrize(("rows", "part"), refusals("a_table_that_cannot_be_is_refused"))
def test_a_table_that_cannot_be_is_refused(tmp_path, monkeypatch, rows, part):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(ConfigError, match=part):
        resolved(table=write_table(tmp_path, rows))


def test_a_run_has_the_fill_ratios_of_its_balls():
    """The numbers of the run's sweep, with the volume of the mill and the density of its contact set."""
    sweep = {"speeds_rpm": [300], "ball_diameters_mm": [10], "masses_g": [100, 200, 300]}
    content = {"mill": "planetary", "sweep": sweep}
    _, mills, contacts, _ = load_workflow(content, [], SOURCES)
    volume_ml = 1e3 * 200 / contacts["calibrated"].density_kg_m3
    assert mills["planetary"].sweep.fills[1] == pytest.approx(volume_ml / mills["planetary"].volume_ml)
