"""A thermometer and a wattmeter: power of made-up readings, their intervals, verdicts, and the user's table."""

import re
from pathlib import Path

import numpy as np
import pytest

from millprint.cli.commands import main
from millprint.dose.heat_balance import JAR, Balance
from millprint.own_machine.prediction import block_means, fit_power, power_of_charge, unit_response, weighted_quantiles
from millprint.own_machine.readings import TEMPERATURE, append_measured, read_series
from millprint.own_machine.settings import WattSettings
from millprint.validation.measured import measured_points, read_measurements
from tests.refusals import refusals
from tests.unit.own_readings import correlated, events, write_condition, write_readings

TIME_S = np.arange(0.0, 601.0, 10.0)
START_S, STOP_S, POWER_W = 30.0, 150.0, 20.0


def balance(rng: np.random.Generator, samples: int, alone: bool = False) -> Balance:
    """Jars of half a kilogram with balls and powder; alone: a jar that takes all heat and gives it to nobody."""

    def drawn(low: float, high: float) -> np.ndarray:
        return rng.uniform(low, high, samples)

    share = np.zeros(samples) if alone else drawn(0.5, 0.8)
    inside = np.full((samples, 3), 1e-6) if alone else np.column_stack([drawn(1, 4), drawn(0.5, 8), drawn(0.5, 5)])
    return Balance(
        capacity_J_K=np.column_stack([drawn(130, 150), drawn(10, 30), np.full(samples, 240.0)]),
        between_W_K=inside, running_W_K=np.full(samples, 1e-6) if alone else drawn(0.3, 2.0),
        resting_W_K=np.full(samples, 1e-6) if alone else drawn(0.1, 0.5),
        source_W=np.column_stack([0.8 * share, 0.2 * share, 1 - share]), surroundings_degC=np.zeros(samples),
    )  # fmt: skip


def test_a_jar_alone_warms_by_its_power_over_its_heat_capacity():
    response = unit_response(balance(np.random.default_rng(0), 100, alone=True), TIME_S, START_S, STOP_S, JAR)
    ramp = np.clip(TIME_S - START_S, 0, STOP_S - START_S) / 240
    assert np.abs(response - ramp[:, None]).max() < 1e-5
    found = fit_power(response, TIME_S, 22 + POWER_W * ramp, resolution_K=1e-4)
    assert found.power_W.value == pytest.approx(POWER_W, rel=1e-4) and found.described
    assert found.begin_K_min == pytest.approx(60 * POWER_W / 240, rel=1e-4)


def test_intervals_of_the_power_hold_the_truth_as_often_as_they_say():
    known = unit_response(balance(np.random.default_rng(1), 2000), TIME_S, START_S, STOP_S, JAR)
    truths = unit_response(balance(np.random.default_rng(2), 60), TIME_S, START_S, STOP_S, JAR)
    rng, held, widths = np.random.default_rng(3), [], []
    for truth in truths.T:
        read = np.round(22 + POWER_W * truth + 0.1 * correlated(rng, len(TIME_S), 0.3), 1)
        power = fit_power(known, TIME_S, read, 0.1).power_W
        held.append(power.repeats.holds(POWER_W))
        widths.append((power.repeats.upper - power.repeats.lower) / POWER_W)
    assert np.mean(held) >= 0.88 and np.median(widths) < 0.4


def test_readings_that_cool_while_the_mill_runs_are_not_described():
    response = unit_response(balance(np.random.default_rng(1), 200), TIME_S, START_S, STOP_S, JAR)
    wave = 22 + 3 * np.sin(TIME_S / 40)
    assert not fit_power(response, TIME_S, wave, 0.1).described


@pytest.mark.parametrize("memory", [0.0, 0.8])
def test_a_difference_of_powers_holds_the_truth_as_often_as_it_says(memory):
    held, time_s, settings = [], np.arange(300.0), WattSettings(efficiency_low=1, efficiency_high=1)
    for seed in range(60):
        rng = np.random.default_rng(seed)
        loose, fixed = (block_means(time_s, mean + 4 * correlated(rng, 300, memory)) for mean in (130.0, 110.0))
        electric, charge = power_of_charge(loose, fixed, settings)
        assert electric.ends("repeats") == pytest.approx(charge.ends("repeats"))
        held.append(electric.repeats.holds(20.0))
    assert np.mean(held) >= 0.88


def test_the_range_of_the_efficiency_and_the_jars_enter_the_interval():
    settings = WattSettings(efficiency_low=0.5, efficiency_high=0.8, jars=2)
    electric, charge = power_of_charge(np.full(10, 150.0), np.full(10, 110.0), settings)
    assert (electric.value, *electric.ends("repeats")) == (40.0, 40.0, 40.0)
    assert (charge.value, *charge.ends("repeats")) == pytest.approx((13.0, 10.0, 16.0))


def test_quantiles_of_weighted_values():
    assert list(weighted_quantiles(np.array([3.0, 1.0, 2.0]), np.array([1.0, 1.0, 2.0]), [0.25, 0.5, 1.0])) == [1, 2, 3]


@pytest.fixture(scope="module")
def laboratory(tmp_path_factory):
    folder = tmp_path_factory.mktemp("laboratory")
    write_condition(folder / "my_card", *events(np.random.default_rng(7), 1.0, 25.0), 1.0, POWER_W)
    rng = np.random.default_rng(4)
    for name, mean in (("loose", 130.0), ("fixed", 100.0)):
        write_readings(folder / f"{name}.tsv", "power_W", np.arange(300.0), mean + 4 * correlated(rng, 300))
    # The jar of the card with 20 g of balls: nearly all heat capacity is that of the jar, which does not cool.
    warming = POWER_W * 0.9 * np.clip(TIME_S - START_S, 0, STOP_S - START_S) / (0.5 * 480 + 0.02 * 480 + 3.2)
    rows = [
        f"{moment / 60:.4f};{degC:.2f}".replace(".", ",") for moment, degC in zip(TIME_S, 22 + warming, strict=True)
    ]
    (folder / "warm.csv").write_text("\n".join(["# my thermometer", "time_min;temperature_degC", *rows]))
    return folder


@pytest.mark.slow
def test_both_commands_agree_and_validation_reads_their_rows(laboratory, capsys, monkeypatch):
    monkeypatch.chdir(laboratory)
    end = ["--table", "mine.tsv", "--figure", "picture"]
    warm = ["warm", "my_card", "warm.csv", "--jar-kg", "0.5", "--start-s", "30", "--stop-s", "150"]
    assert main([*warm, "--cooling", "still_air", *end]) == 0
    assert main(["watt", "my_card", "loose.tsv", "fixed.tsv", "--efficiency", "0.6", "0.75", *end]) == 0
    assert capsys.readouterr().out.count("verdict: agrees: within both intervals") == 2
    points = measured_points(read_measurements("mine.tsv", []))
    assert list(points["id"]) == ["other_power_by_warming", "other_power_by_wattmeter"]
    assert points["measured_lower"].lt(POWER_W).all() and points["measured_upper"].gt(POWER_W).all()


@pytest.fixture
def readings(laboratory, monkeypatch):
    """Tables of the laboratory: as they should be, swapped, and in other units than they say."""
    monkeypatch.chdir(laboratory)
    warming = 0.9 * np.clip(TIME_S - START_S, 0, STOP_S - START_S) / 253

    def write(name: str, column: str, values: np.ndarray) -> None:
        write_readings(Path(f"{name}.tsv"), column, TIME_S[: len(values)], values)

    write("warms", "temperature_degC", 22 + POWER_W * warming)
    write("cools", "temperature_degC", 22 - POWER_W * warming)
    write("flat", "temperature_degC", 22 + 0 * warming)
    write("in_F", "temperature_degC", 1.8 * (22 + POWER_W * warming) + 32)
    write("loose_W", "power_W", np.full(50, 130.0))
    write("fixed_W", "power_W", np.full(50, 100.0))
    write("in_kW", "power_W", np.full(50, 0.1))


WARM, WATT = ["--jar-kg", "0.5", "--cooling", "still_air"], ["--efficiency", "0.6", "0.75"]


@pytest.mark.parametrize(
    ("command", "verdict"),
    [
        (["warm", "my_card", "warms.tsv", *WARM, "--start-s", "30", "--stop-s", "150"], "agrees"),
        (["warm", "my_card", "flat.tsv", *WARM, "--start-s", "30", "--stop-s", "150"], "differs"),
        (["warm", "my_card", "cools.tsv", *WARM, "--start-s", "30", "--stop-s", "150"], "open: less than zero"),
        (["warm", "my_card", "warms.tsv", *WARM, "--start-s", "0.5", "--stop-s", "2.5"], "open: .* in minutes"),
        (["warm", "my_card", "in_F.tsv", *WARM, "--start-s", "30", "--stop-s", "150"], None),
        (["watt", "my_card", "loose_W.tsv", "fixed_W.tsv", *WATT], "agrees"),
        (["watt", "my_card", "fixed_W.tsv", "loose_W.tsv", *WATT], "open: less than zero"),
        (["watt", "my_card", "loose_W.tsv", "in_kW.tsv", *WATT], None),
    ],
)
def test_a_measurement_that_cannot_be_decides_nothing(readings, capsys, command, verdict):
    """None: refused in one line."""
    assert main(command) == (verdict is None)
    out, err = capsys.readouterr()
    assert re.search(f"verdict: {verdict}", out) if verdict else len(err.splitlines()) == 1 and "verdict" not in out


def test_a_row_is_added_to_a_table_that_keeps_its_rows_and_comments(tmp_path):
    path = tmp_path / "mine.tsv"
    path.write_text("# of my laboratory\nid\tsetup\tquantity\tx\tvalue\tunit\nold\tslice_mill\tpower\t%\t55:17.5\tW\n")
    assert append_measured(path, {"id": "old", "quantity": "power by warming", "value": "20", "unit": "W"}) == "old_2"
    first, _, old, new = path.read_text().splitlines()
    assert (
        first == "# of my laboratory" and old.startswith("old\tslice_mill\tpower") and new.startswith("old_2\tunknown")
    )
    path.write_text("id\tsetup\nold\tslice_mill\n")
    with pytest.raises(Exception, match="column quantity is missing"):
        append_measured(path, {"id": "a"})


@pytest.mark.parametrize(("text", "words"), refusals("a_bad_table_is_one_line"))
def test_a_bad_table_is_one_line(tmp_path, text, words):
    path = tmp_path / "a.tsv"
    path.write_text(text)
    with pytest.raises(Exception) as raised:
        read_series(path, TEMPERATURE, 3)
    assert str(raised.value).startswith(str(path)) and words in str(raised.value)
    assert "\n" not in str(raised.value)


@pytest.mark.parametrize(("words", "said"), refusals("a_bad_option_is_one_line"))
def test_a_bad_option_is_one_line(laboratory, capsys, monkeypatch, words, said):
    monkeypatch.chdir(laboratory)
    assert main(words) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert said in line
