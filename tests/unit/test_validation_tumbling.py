"""Measures of a tumbling charge, power formulas, and the table of runs of a tumbling mill."""

import math

import numpy as np
import pandas as pd
import pytest

from millprint.config.contact_set import ContactConfig
from millprint.config.mill import MillConfig
from millprint.config.setup_models import FILES
from millprint.config.sweep import DemConfig
from millprint.validation.measured import CONTACT, DEM, SCATTER, Inputs, check_predictions, read_other_codes
from millprint.validation.tumbling import (
    ANGLES,
    POWER_W,
    Mill,
    contact_changes,
    hogg_fuerstenau,
    intervals,
    morrell,
    morrell_shape,
    powers_of_other_codes,
    predict_tumbling,
    without_jump,
)
from millprint.validation.tumbling_runs import (
    carried,
    case_of,
    clock_angle,
    complete_rings,
    coverage,
    critical_speed_rpm,
    design,
    net_power,
    sampled_contacts,
    toe_and_shoulder,
)

RADIUS, DIAMETER = 0.275, 0.022
VALUES = {
    "source": "test", "density_kg_m3": 7800, "young_modulus_gpa": 2.0, "poisson_ratio": 0.3, "restitution": 0.6,
    "static_friction": 0.2, "rolling_friction": 0.01,
}  # fmt: skip


def at(angles_deg, distance: float) -> np.ndarray:
    """Places (n, 2) at angles clockwise from 12 o'clock [deg] and a distance from the axis [m]."""
    angles = np.radians(np.asarray(angles_deg, dtype=float))
    return distance * np.column_stack([np.sin(angles), np.cos(angles)])


def ring(distance: float, balls: int) -> np.ndarray:
    return at(np.arange(balls) * 360 / balls, distance)


def contact_set(name: str, **values) -> ContactConfig:
    return ContactConfig(name=name, **VALUES | values)


def test_critical_speed_is_that_at_which_a_ball_weighs_nothing_at_the_top():
    speed = critical_speed_rpm(RADIUS, DIAMETER)
    assert (speed * math.pi / 30) ** 2 * (RADIUS - DIAMETER / 2) == pytest.approx(9.81)
    assert speed == pytest.approx(58.2, abs=0.05)


def test_net_power_is_work_over_time():
    time = np.linspace(2.0, 5.0, 31)
    assert net_power(1.0 + 12.5 * time, time) == pytest.approx(12.5)


def test_clock_angles_grow_clockwise():
    places = np.array([[0.0, 1.0], [1.0, 0.0], [0.0, -1.0], [-1.0, 0.0]])
    assert clock_angle(places) == pytest.approx([0, 90, 180, 270])


def test_a_closed_ring_covers_the_shell_once():
    count = round(math.pi * (2 * RADIUS - DIAMETER) / DIAMETER)
    turned = np.stack(
        [at(np.arange(count) * 360 / count + shift, RADIUS - DIAMETER / 2) for shift in np.arange(0, 5, 0.1)]
    )
    assert coverage(turned, np.full(count, DIAMETER), RADIUS) == pytest.approx(np.ones(120), rel=0.1)


@pytest.mark.parametrize(("toe", "shoulder"), [(150, 290), (120, 340), (170, 20)])
def test_toe_and_shoulder_are_the_ends_of_the_covered_arc(toe, shoulder):
    pitch = math.degrees(DIAMETER / (RADIUS - DIAMETER / 2))
    rng = np.random.default_rng(0)
    arc = (shoulder - toe) % 360
    places = [
        at(toe + rng.uniform(0, pitch) + np.arange(0, arc - pitch, pitch), RADIUS - DIAMETER / 2) for _ in range(400)
    ]
    count = min(map(len, places))
    # Balls in the middle of the drum are not part of the bed at the shell.
    inner = np.zeros((5, 2))
    times = np.stack([np.vstack([place[:count], inner]) for place in places])
    found = toe_and_shoulder(times, np.full(count + 5, DIAMETER), RADIUS)
    assert found[0] == pytest.approx(toe, abs=6)
    assert (found[1] - shoulder + 180) % 360 - 180 == pytest.approx(0, abs=6)


def test_a_centrifuge_has_neither_toe_nor_shoulder():
    places = np.stack([at(np.arange(75) * 4.8 + shift, RADIUS - DIAMETER / 2) for shift in np.arange(0, 4.8, 0.3)])
    assert all(math.isnan(angle) for angle in toe_and_shoulder(places, np.full(75, DIAMETER), RADIUS))


def test_balls_that_go_round_at_one_distance_are_carried_and_others_are_not():
    angles = np.linspace(0, 2 * math.pi, 60)
    turns = np.degrees(angles)
    with_shell, slipping, left_behind = (at(share * turns + 40, 0.2) for share in (1.0, 0.8, 0.3))
    falling = at(turns, 1.0) * (0.2 + DIAMETER * np.sin(angles))[:, None]
    resting = np.full((60, 2), 0.1)
    places = np.stack([with_shell, slipping, left_behind, falling, resting], axis=1)
    stay = carried(places, angles, np.full(5, DIAMETER))
    assert stay.tolist() == [True, True, False, False, False]


def test_rings_are_counted_from_the_shell_until_one_has_room_for_two_balls():
    outer, inner = ring(RADIUS - DIAMETER / 2, 74), ring(RADIUS - 1.4 * DIAMETER, 66)
    assert complete_rings(outer, DIAMETER, RADIUS) == 1
    assert complete_rings(np.vstack([outer, inner]), DIAMETER, RADIUS) == 2
    assert complete_rings(np.vstack([outer[1:], inner]), DIAMETER, RADIUS) == 2
    assert complete_rings(np.vstack([outer[2:], inner]), DIAMETER, RADIUS) == 0
    assert complete_rings(np.empty((0, 2)), DIAMETER, RADIUS) == 0


def test_a_lifter_in_the_ring_is_no_gap():
    pitch = math.degrees(2 * math.asin(DIAMETER / 2 / (RADIUS - DIAMETER / 2)))
    # Between two lifters five balls have room, at most; here two of them are missing everywhere.
    pockets = np.concatenate([30 * k + 5 + pitch * np.arange(4) for k in range(12)])
    places = at(pockets, RADIUS - DIAMETER / 2)
    assert complete_rings(places, DIAMETER, RADIUS, lifter_height_m=0.022, lifter_width_m=0.022) == 1
    assert complete_rings(places, DIAMETER, RADIUS) == 0


# Erdem, Ergun and Benzer, Physicochem. Probl. Miner. Process. 38 (2004): two chambers of a cement mill of 3.27 m, net
# powers by the C-model, as quoted in a public code. One density of the charge must give both.
CHAMBERS = [(3.60, 0.2748, 341.97e3), (7.00, 0.2663, 650.69e3)]


def chamber(length: float, filling: float, density: float) -> Mill:
    return Mill(1.635, length, filling, density * math.pi * 1.635**2 * length * filling)


def test_the_c_model_gives_both_chambers_of_the_published_example_by_one_density():
    densities = [net / morrell(chamber(length, filling, 1.0), 0.7267) for length, filling, net in CHAMBERS]
    assert densities[0] == pytest.approx(densities[1], rel=0.01)
    assert densities == pytest.approx([3960, 3960], rel=0.01)


def test_the_c_model_ends_where_its_charge_centrifuges():
    mill = chamber(3.6, 0.25, 4000)
    shape = morrell_shape(mill, 0.7)
    assert math.pi < shape.toe < 3 * math.pi / 2
    assert 0 < shape.shoulder < math.pi / 2
    with pytest.raises(ValueError, match=r"ends at 1\.09"):
        morrell(mill, 1.1)


@pytest.mark.parametrize("filling", [0.2, 0.3, 0.4])
def test_hogg_and_fuerstenau_agrees_with_its_form_in_feet(filling):
    diameter, length, share, density, foot = 4.0, 6.0, 0.72, 4800.0, 0.3048
    mill = Mill(diameter / 2, length, filling, density * math.pi * diameter**2 / 4 * length * filling)
    turns_hz = share * math.sqrt(9.81 / (diameter / 2)) / (2 * math.pi)
    in_feet = 0.238 * (diameter / foot) ** 3.5 * (length / diameter) * share * density / 1e3
    in_feet *= (filling - 1.065 * filling**2) * math.sin(math.radians(35))
    assert hogg_fuerstenau(mill, turns_hz, 35) == pytest.approx(1e3 * in_feet, rel=0.02)
    assert hogg_fuerstenau(mill, turns_hz, 0) == 0


def runs_of(powers: dict[tuple[str, int, float, int], float], **angles: list[float]) -> pd.DataFrame:
    """A table of runs; angles: toe_deg or shoulder_deg of each run."""
    columns = {"speed_rpm": 30.0, "toe_deg": 150.0, "shoulder_deg": 300.0, "rings": 0, "carried": 12, "contact": "set"}
    return pd.DataFrame(
        [
            {"role": role, "number": number, "speed": speed, "seed": seed, "power_W": power, **columns}
            for (role, number, speed, seed), power in powers.items()
        ]
    ).assign(**angles)


def test_the_effect_of_contact_parameters_is_relative_to_the_same_seed_and_interpolated():
    runs = runs_of(
        {
            ("predicts", 120, 20.0, 0): 5.0, ("predicts", 120, 30.0, 0): 8.0, ("predicts", 120, 40.0, 0): 10.0,
            ("further", 120, 20.0, 0): 4.0, ("further", 120, 40.0, 0): 12.0,
            ("predicts", 120, 20.0, 1): 5.5, ("predicts", 120, 30.0, 1): 8.2, ("predicts", 120, 40.0, 1): 10.4,
            ("predicts", 169, 20.0, 0): 7.0, ("predicts", 169, 20.0, 1): 7.0,
        }
    )  # fmt: skip
    factors = contact_changes(runs, POWER_W)
    assert factors.to_numpy() == pytest.approx(np.array([[0.8, 1.0], [1.0, 1.2]]))
    table = intervals(runs, FILES["slice_mill"].read(numbers=[169, 120])).set_index(["number", "speed"])
    assert list(table.index) == [(169, 20.0), (120, 20.0), (120, 30.0), (120, 40.0)]
    ends = ["power_contact_lower_W", "power_contact_upper_W"]
    assert table.loc[(120, 30.0), ends].tolist() == pytest.approx([8.1 * 0.9, 8.1 * 1.1])
    assert table.loc[(169, 20.0), ends].tolist() == pytest.approx([5.6, 7.0])
    assert table.loc[(120, 20.0), "carried_share"] == pytest.approx(0.1)


POWERS = {
    ("predicts", 120, 20.0, 0): 5.0, ("predicts", 120, 20.0, 1): 5.5,
    ("predicts", 120, 40.0, 0): 10.0, ("predicts", 120, 40.0, 1): 10.4,
    ("further", 120, 20.0, 0): 4.0, ("further", 120, 40.0, 0): 12.0,
}  # fmt: skip


def test_the_effect_of_contact_parameters_on_an_angle_is_a_difference_the_short_way_round():
    shoulders = [355.0, 359.0, 10.0, 12.0, 3.0, 4.0]
    runs = runs_of(POWERS, shoulder_deg=shoulders)
    changes = contact_changes(runs, ANGLES["shoulder_deg"])
    # 355 to 3 is 8 degrees on; 10 to 4 is 6 degrees back.
    assert changes.to_numpy() == pytest.approx(np.array([[0.0, 8.0], [-6.0, 0.0]]))
    row = intervals(runs, FILES["slice_mill"].read(numbers=[120], fillings=[0.25])).iloc[0]
    assert row["shoulder_deg"] == pytest.approx(357.0)
    ends = [f"shoulder_{by}_{end}_deg" for by in ("scatter", "contact") for end in ("lower", "upper")]
    assert row[ends].tolist() == pytest.approx([357 - 12.706 * 2, 357 + 12.706 * 2, 357.0, 365.0], abs=1e-2)


def test_a_charge_without_an_angle_has_no_effect_on_it():
    runs = runs_of(POWERS, toe_deg=[140.0, 141.0, np.nan, np.nan, 138.0, 130.0])
    assert contact_changes(runs, ANGLES["toe_deg"]).index.tolist() == [20.0]
    nowhere = runs_of(POWERS, toe_deg=[np.nan] * 6)
    assert contact_changes(nowhere, ANGLES["toe_deg"]).empty
    assert intervals(nowhere, FILES["slice_mill"].read(numbers=[120], fillings=[0.25]))["toe_deg"].isna().all()


def test_toe_and_shoulder_are_predicted_with_an_interval_by_contact_parameters_too(tmp_path):
    settings = FILES["slice_mill"].read(numbers=[120], fillings=[0.25])
    runs = runs_of(POWERS, toe_deg=[150.0, 150.2, 140.0, 140.2, 145.0, 141.0])
    runs.to_csv(tmp_path / "runs.tsv", sep="\t", index=False)
    places = pd.DataFrame(columns=["id", "quantity", "unit", "x"])
    contact = contact_set(settings.contact)
    inputs = Inputs(settings, MILL, {contact.name: contact}, DemConfig(), {}, tmp_path, places, tmp_path)
    table = check_predictions(predict_tumbling(inputs), "slice_mill")
    toe = table[table["quantity"] == "toe angle"].set_index("x")
    assert set(toe["interval"]) == {f"{SCATTER} and {CONTACT}"}
    half = 12.706 * 0.1
    assert toe.loc[20.0, ["lower", "predicted", "upper"]].tolist() == pytest.approx(
        [150.1 - math.hypot(half, 5.0), 150.1, 150.1 + half], abs=1e-3
    )
    power = table[(table["quantity"] == "power") & (table["model"] == DEM)]
    assert (power["lower"] >= 0).all()


def test_the_design_has_every_measured_speed_and_every_contact_set_once():
    settings = FILES["slice_mill"].read(
        speeds=[20.0], seeds=[3, 5], samples=4, sample_speeds=[20.0], numbers=[120, 169]
    )
    contacts = {name: contact_set(name, restitution=0.5) for name in settings.contact_names}
    table = design(settings, contacts, {120: [70.0], 169: []})
    assert table["run"].is_unique
    assert table.groupby("role").size().to_dict() == {"predicts": 8, "further": 2, "sample": 4}
    assert sorted(table["speed"].unique()) == [20.0, 70.0]
    sampled = pd.DataFrame(sampled_contacts(settings))
    assert sampled["restitution"].between(*settings.restitution).all()
    # A Latin hypercube has one point in each quarter of each range.
    low, high = settings.wall_static_friction
    assert sorted(((sampled["wall_static_friction"] - low) / (high - low) * 4).astype(int)) == [0, 1, 2, 3]


MILL = MillConfig(
    name="drum", title="drum", source="test", volume_ml=235,
    geometry={"kind": "cylinder", "axis": "y", "radius_mm": 50, "height_mm": 30, "fillet_ends": "none"},
    motion={"kind": "rotation", "axis": [0, 1, 0]},
)  # fmt: skip


def test_windows_are_whole_turns_or_longer():
    settings = FILES["slice_mill"].read()
    table = design(settings, {name: contact_set(name) for name in settings.contact_names}, {})
    slow, fast = (case_of(table[table["speed"] == speed].iloc[0].to_dict(), settings, MILL) for speed in (20.0, 140.0))
    assert slow.window_s == pytest.approx(settings.window_turns * 60 / (0.2 * 58.3))
    assert fast.window_s == settings.window_s


@pytest.mark.parametrize(("angles", "mean"), [([350.0, 10.0], 0.0), ([359.0, 2.0, 5.0], 2.0), ([140.0, 150.0], 145.0)])
def test_angles_about_the_top_have_a_mean_there(angles, mean):
    near = without_jump(np.array(angles))
    assert (near.mean() - mean + 180) % 360 - 180 == pytest.approx(0.0, abs=0.2)
    assert np.ptp(near) < 30


def test_the_power_by_another_code_stands_beside_ours_where_mill_contacts_and_balls_agree(tmp_path):
    table = tmp_path / "codes.tsv"
    table.write_text(
        "mill\tcontact\tcode\tspeed_rpm\tballs\tpower_W\n"
        "slice_mill\tslice_mill\tLAMMPS\t29.15\t120\t14\n"
        "slice_mill\tslice_mill\tLAMMPS\t29.15\t169\t18\n"
        "slice_mill\tsteel\tLAMMPS\t29.15\t120\t15\n"
        "slice_mill\tslice_mill\tLAMMPS\t29.15\t121\t14\n"
        "bond_mill\tslice_mill\tLAMMPS\t29.15\t120\t14\n"
    )
    inputs = Inputs(
        FILES["slice_mill"].read(),
        None,
        {},
        DemConfig(),
        {},
        tmp_path,
        pd.DataFrame(),
        other_codes=read_other_codes(table),
    )
    rows = powers_of_other_codes(inputs)
    assert [(row["quantity"], row["predicted"], row["model"]) for row in rows] == [
        ("power", 14, "LAMMPS"),
        ("power, 169 balls", 18, "LAMMPS"),
    ]
    # Half of the critical speed of 58.3 rpm.
    assert [row["x"] for row in rows] == pytest.approx([50, 50])
