"""Heat: sources by place, what samples are, bands, flash temperatures, bad input."""

import json
from pathlib import Path

import h5py
import numpy as np
import pandas as pd
import pytest

from millprint.config.dose import FlashSection, HeatConfig
from millprint.config.errors import ConfigError
from millprint.dose import flash
from millprint.dose import heat_balance as heat_table
from millprint.dose.heat_balance import (
    RUNNING,
    HeatSource,
    balance_of,
    band,
    heat_by_body,
    heat_tables,
    jar_of_samples,
    ranges_of,
    read_sources,
    sample,
    split_of_summary,
)

SETTINGS = HeatConfig(samples=16)
POWER_W = np.array([[1.0, 2.0, 0.5], [3.0, 4.0, 0.25]])
SOURCE = HeatSource("d10", {"contact": "steel"}, POWER_W, 0.1, 0.02, 0.02, 2e-4)


def write_run(folder: Path, seed: int = 0, histogram: bool = False) -> tuple[str, str]:
    """A run of four contacts in a box of 20 mm: two between balls, two at the wall."""
    place = folder / f"d10_f0.10_n600_s{seed}"
    place.mkdir(parents=True)
    case = {"ball_diameter_m": 0.01, "fill_ratio": 0.1, "speed_hz": 10.0, "seed": seed}
    shares = {"ball_ball": {"normal": 0.25, "tangential": 0.6}, "ball_wall": {"normal": 0.75, "tangential": 0.4}}
    rule = {"dropped": {"count": 0.0, "normal": 0.0, "tangential": 0.0}, "shares": shares}
    power = {"normal": 4.0, "tangential": 2.0 + seed, "rolling": 1.0, "wall": 7.0}
    summary = {"mill": "box", "case": case, "power_W": power, "collisions": [rule], "ball_sizes_m": [0.01]}
    summary |= {"ball_counts": [5], "balls": 5, "ball_mass_kg": 0.004, "jar_volume_m3": 8e-6, "density_kg_m3": 7800.0}
    summary |= {"contact": "steel", "amplitude_m": 0.01}
    summary |= {"young_modulus_pa": 2.05e9, "static_friction": 0.3, "wall_static_friction": 0.3}
    (place / "summary.json").write_text(json.dumps(summary))
    columns = {
        "first": [0, 1, 2, 3], "second": [1, 2, -1, -4], "start_s": [1.0, 1.0, 1.1, 0.2], "duration_s": 4 * [1e-4],
        "approach_speed_m_s": 4 * [1.0], "peak_force_N": [100.0, 100.0, 200.0, 200.0], "normal_J": [1.0, 0.0, 2.0, 1.0],
        "damping_J": [0.1, 0.1, 0.0, 0.0], "sliding_J": [0.1, 0.1, 0.3, 0.3], "rolling_J": [1.0, 0.0, 0.0, 3.0],
        "facet": [-1, -1, 0, 3], "contact": [0, 1, 2, 3], "ended": 4 * [1],
    }  # fmt: skip
    corners = 0.02 * np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)])
    sides = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    with h5py.File(place / "run.h5", "w") as file:
        group = file.create_group("collisions")
        group.attrs.update({"begin_s": 0.5, "window_s": 1.0})
        for name, values in ({} if histogram else columns).items():
            group[name] = values
        file["geometry/vertices_m"] = corners
        file["geometry/triangles"] = [part for a, b, c, d in sides for part in ((a, b, c), (a, c, d))]
        file["balls/radius_m"] = np.full(5, 0.005)
    return str(place / "summary.json"), str(place / "run.h5")


def test_dissipation_is_divided_as_the_contacts_are_and_adds_up_to_the_ledger(tmp_path):
    (source,) = read_sources([write_run(tmp_path)])
    np.testing.assert_allclose(source.power_W, [[4 / 4, 2 * 0.4, 1 / 4], [4 * 3 / 4, 2 * 0.6, 3 / 4]])
    assert source.power_W.sum() == pytest.approx(7.0)
    assert source.inside_m2 == pytest.approx(6 * 0.02**2)
    assert source.balls_m2 == pytest.approx(5 * np.pi * 0.01**2)


def test_seeds_are_averaged_and_histograms_are_divided_by_their_summary(tmp_path):
    (source,) = read_sources([write_run(tmp_path, seed) for seed in (0, 1)])
    assert source.condition == "d10_f0.10_n600" and source.about["seeds"] == 2
    np.testing.assert_allclose(source.power_W.sum(axis=0), [4.0, 2.5, 1.0])
    (one,) = read_sources([write_run(tmp_path / "one")])
    for name in ("balls_kg", "balls_m2", "inside_m2", "inside_m3"):
        assert getattr(source, name) == getattr(one, name) > 0
    (source,) = read_sources([write_run(tmp_path / "histogram", histogram=True)])
    np.testing.assert_allclose(source.power_W, [[1.0, 1.2, 0.6], [3.0, 0.8, 0.4]])


def test_a_source_knows_its_condition(tmp_path):
    files = write_run(tmp_path)
    summary = json.loads(Path(files[0]).read_text())
    (plain,) = read_sources([files])
    summary["case"] |= {"mixture": {"name": "graded"}, "density_kg_m3": 7800.0}
    Path(files[0]).write_text(json.dumps(summary))
    (charged,) = read_sources([files])
    assert [(own.about["charge"], own.about["varied"]) for own in (plain, charged)] == [
        ("", "nothing"),
        ("graded", "density"),
    ]


def test_a_run_without_an_unfiltered_rule_is_refused():
    summary = {"mill": "box", "collisions": [{"dropped": {"count": 0.1, "normal": 0.1, "tangential": 0.0}}]}
    with pytest.raises(ConfigError, match="without a threshold"):
        split_of_summary(summary)


def test_a_mill_at_rest_has_no_heat_balance(tmp_path):
    files = write_run(tmp_path)
    summary = json.loads(Path(files[0]).read_text())
    summary["power_W"] = dict.fromkeys(("normal", "tangential", "rolling", "wall"), 0.0)
    Path(files[0]).write_text(json.dumps(summary))
    with pytest.raises(ConfigError, match="a mill at rest has no heat balance"):
        read_sources([files])


def test_a_wall_whose_triangles_are_damaged_is_refused_in_one_line(tmp_path):
    paths = write_run(tmp_path)
    with h5py.File(paths[1], "r+") as file:
        file["geometry/triangles"][0] = 35
    with pytest.raises(ConfigError, match="truncated or damaged"):
        read_sources([paths])


def test_samples_fill_every_range_evenly_and_are_the_same_again():
    drawn = sample(SETTINGS, "spex")
    pd.testing.assert_frame_equal(drawn, sample(SETTINGS, "spex"))
    for name, (given, _, _) in ranges_of(SETTINGS, "spex").items():
        low, high, values = given.low, given.high, drawn[name].to_numpy()
        share = np.log(values / low) / np.log(high / low) if given.logarithmic else (values - low) / (high - low)
        # A Latin hypercube has one sample in each sixteenth.
        assert sorted(np.floor(share * 16)) == list(range(16)), name


def test_all_heat_goes_somewhere_and_nothing_else_does():
    drawn = sample(SETTINGS, "emax")
    heat = heat_by_body(SOURCE, drawn)
    np.testing.assert_allclose(heat.sum(axis=1), POWER_W.sum() * drawn["heat_share"], rtol=1e-12)
    assert (heat > 0).all()


@pytest.mark.parametrize(
    ("shares", "expected"),
    [
        ({"powder_share_normal": 1.0, "powder_share_shear": 1.0, "wall_share": 0.5}, [0.0, 10.75, 0.0]),
        ({"powder_share_normal": 0.0, "powder_share_shear": 0.0, "wall_share": 1.0}, [3.5, 0.0, 7.25]),
        ({"powder_share_normal": 1.0, "powder_share_shear": 0.0, "wall_share": 0.0}, [6.75, 4.0, 0.0]),
    ],
)
def test_heat_goes_where_the_shares_say(shares, expected):
    drawn = pd.DataFrame({name: [value] for name, value in {**shares, "heat_share": 1.0}.items()})
    np.testing.assert_allclose(heat_by_body(SOURCE, drawn)[0], expected, atol=1e-12)


def test_contacts_split_their_energy_between_balls_and_wall():
    """mJ of two pairs and a wall: 3 to 1; nothing below zero; halves of nothing."""
    values = {"normal_J": [3, 1, 0], "damping_J": [1, 0, 0], "sliding_J": [0, -3, 1], "rolling_J": [0, 0, 0]}
    group = {name: 1e-3 * np.array(own) for name, own in values.items()} | {"second": np.array([3, -1, 4])}
    assert heat_table.split_of_contacts(group).tolist() == [[0.75, 1.0, 0.5], [0.25, 0.0, 0.5]]


def test_a_jar_of_a_cube_has_the_shell_of_a_larger_cube():
    cube = HeatSource("d10", {}, POWER_W, 0.1, 0.02, 6 * 0.05**2, 0.05**3)
    drawn = pd.DataFrame({"wall_thickness_mm": [5.0], "jar_density_kg_m3": [8000.0]})
    mass, outside = jar_of_samples(SETTINGS, "spex", cube, drawn)
    assert mass[0] == pytest.approx(8000 * (0.06**3 - 0.05**3))
    assert outside[0] == pytest.approx(6 * 0.06**2)


def test_a_jar_and_a_powder_that_are_weighed_are_taken_as_they_are():
    settings = HeatConfig(samples=16, powder_mass_g=5, jars={"spex": {"mass_kg": 1.5, "surface_cm2": 300}})
    drawn = sample(settings, "spex")
    balance = balance_of(settings, "spex", SOURCE, drawn)
    np.testing.assert_allclose(balance.capacity_J_K[:, 1], 0.005 * drawn["powder_heat_capacity_J_kgK"])
    np.testing.assert_allclose(balance.capacity_J_K[:, 2], 1.5 * drawn["jar_heat_capacity_J_kgK"])
    np.testing.assert_allclose(balance.running_W_K, 0.03 * drawn[RUNNING])


def test_a_band_counts_what_never_happens_as_longest():
    np.testing.assert_array_equal(band(np.array([1.0, 2.0, np.inf, np.inf, np.inf]), 0.8), [1.0, np.inf, np.inf])


def test_shares_of_samples_are_by_hand(monkeypatch):
    pauses, milled = np.array([*8 * [0.0], *6 * [300.0], *2 * [np.inf]]), 60 * SETTINGS.programme.milling_min
    monkeypatch.setattr(heat_table, "pause_needed", lambda *given: pauses if given[3] == milled else -pauses)
    row = heat_tables(SETTINGS, "spex", [SOURCE], times=5).limits.iloc[0]
    assert (row["no_pause_share"], row["interval_too_long_share"]) == (0.5, 0.125)
    assert row["pause_needed_min_median"] == 0 and row["pause_needed_min_upper"] == np.inf
    assert row["total_W"] == POWER_W.sum()
    # Half of 16 samples are over their median.
    limit = {"body": "balls", "temperature_degC": row["balls_peak_degC_median"]}
    half = heat_tables(HeatConfig(samples=16, limit=limit), "spex", [SOURCE], times=5).limits.iloc[0]
    assert half["over_limit_share"] == 0.5


def test_more_cooling_and_more_pauses_make_it_colder(monkeypatch):
    hot = heat_tables(SETTINGS, "spex", [SOURCE], times=5).limits.iloc[0]
    cold = heat_tables(SETTINGS, "emax", [SOURCE], times=5).limits.iloc[0]
    paused = HeatConfig(samples=16, programme={"duration_h": 5, "cycle_min": 30, "pause_min": 20})
    phases_of, asked = heat_table.programme_phases, []
    monkeypatch.setattr(heat_table, "programme_phases", lambda *given: asked.append(given) or phases_of(*given))
    rested = heat_tables(paused, "spex", [SOURCE], times=5).limits.iloc[0]
    assert asked == [(5 * 3600, 10 * 60, 20 * 60)]
    assert cold["balls_steady_degC_median"] < hot["balls_steady_degC_median"]
    assert rested["balls_peak_degC_median"] < hot["balls_peak_degC_median"]
    for row in (hot, cold, rested):
        assert 0 <= row["balance_error"] < 1e-8


def impacts_of(slip: float, duration: float, energy=1e-3) -> flash.Impacts:
    one = {"radius_m": 1e-4, "duration_s": duration, "normal_J": 0.0, "sliding_J": energy, "slip_speed_m_s": slip}
    columns = {name: np.atleast_1d(value + 0.0 * energy) for name, value in one.items()}
    return flash.Impacts(**columns, at_wall=np.zeros(np.size(energy), dtype=bool))


def test_a_slow_contact_is_as_warm_as_a_steady_circle():
    """The centre of a circle of even flux on a half space: q a / k (Carslaw and Jaeger, Sec. 10.5)."""
    impacts, settings, even = impacts_of(slip=0.0, duration=10.0), FlashSection(), 0.5e-3 / 10 / (np.pi * 1e-4)
    assert flash.flash_K(impacts, np.array([1e-3]), settings, 30.0)[0] == pytest.approx(even / 30.0, rel=1e-3)
    # Of 1 to 5 mJ the median is of 3, and (1 + 4 + 9 + 16 + 25) / 15 the mean by energy; a low conductivity makes high.
    (row, *_) = flash.flash_rows("d10", impacts_of(0.0, 10.0, 1e-3 * np.arange(1, 6)), settings)
    found = [row[f"{name}_high_K"] for name in ("median", "p99", "largest", "mean_by_energy")]
    each = even / settings.conductivity_W_mK.low
    assert found == pytest.approx(each * np.array([3, 4.96, 5, 55 / 15]), rel=1e-2)


def test_a_fast_slider_is_as_warm_as_a_half_space_heated_while_it_passes():
    diffusivity, radius, speed = 8e-6, 1e-4, 1e5
    sliding = flash.sliding_circle_K(np.array([1e6]), np.array([radius]), np.array([speed]), 30.0, diffusivity)
    passing = flash.half_space_K(np.array([1e6]), np.array([2 * radius / speed]), 30.0, diffusivity)
    assert sliding[0] == pytest.approx(passing[0], rel=1e-3)


def test_a_contact_is_hertzian_until_it_yields():
    force, curvature = np.array([1.0, 1e5]), np.array([0.0025, 0.0025])
    found = flash.contact_radius(force, curvature, 1.1e11, 7e9)
    assert found[0] == pytest.approx(np.cbrt(0.75 * 0.0025 / 1.1e11))
    assert found[1] == pytest.approx(np.sqrt(1e5 / np.pi / 7e9))


def test_slip_follows_from_the_impulse_of_a_half_sine(tmp_path):
    """Work = mu v times the integral of F sin(pi t / d), which is 2 F d / pi; softness changes neither F d nor work."""
    summary, run = write_run(tmp_path)
    impacts = flash.read_impacts(run, json.loads(Path(summary).read_text()), FlashSection())
    work, force = np.array([0.2, 0.2, 0.3]), np.array([100.0, 100.0, 200.0])
    np.testing.assert_allclose(impacts.slip_speed_m_s, work / (0.3 * 2 * force * 1e-4 / np.pi))
    np.testing.assert_allclose(impacts.normal_J, [1.0, 0.0, 2.0])


def test_impacts_do_not_depend_on_how_soft_the_simulation_was(tmp_path):
    """Force and duration of Hertz's impact at 1 m/s, softened a hundredfold and as stiff as steel."""
    reduced, curvature, stiff = 0.002, 0.0025, 205e9 / (2 * (1 - 0.09))
    found = []
    for factor in (1.0, 0.01):
        files = write_run(tmp_path / str(factor))
        # Johnson 1985, Eqs 11.23 and 11.24.
        overlap = (15 * reduced / (16 * np.sqrt(curvature) * factor * stiff)) ** 0.4
        with h5py.File(files[1], "a") as file:
            file["collisions/peak_force_N"][:] = 4 / 3 * factor * stiff * np.sqrt(curvature) * overlap**1.5
            file["collisions/duration_s"][:] = 2.9432 * overlap
        summary = json.loads(Path(files[0]).read_text()) | {"young_modulus_pa": factor * 205e9}
        found.append(flash.read_impacts(files[1], summary, FlashSection()))
    soft, hard = found[1], found[0]
    assert soft is not None and hard is not None and len(soft) == len(hard) == 3
    np.testing.assert_allclose(soft.radius_m, hard.radius_m, rtol=1e-6)
    np.testing.assert_allclose(soft.duration_s, hard.duration_s, rtol=1e-6)


@pytest.mark.parametrize(("between", "at_wall", "left"), [(0.99, 0.99, 3), (1.01, 0.99, 1), (0.99, 1.01, 2)])
def test_what_lasts_longer_than_an_impact_is_none(tmp_path, between, at_wall, left):
    """Hertz's 2.868 (m^2 / (E*^2 R v))^(1/5) at 3 m/s, with m / 2 and R / 2 of two balls and m and R at a wall."""
    mass, modulus = 7800 * 4 / 3 * np.pi * 0.005**3, 2.05e9 / (2 * 0.91)
    balls, wall = (2.868 * (m**2 / (modulus**2 * r * 3)) ** 0.2 for m, r in ((mass / 2, 0.0025), (mass, 0.005)))
    summary, run = write_run(tmp_path)
    with h5py.File(run, "a") as file:
        longest = flash.LONGEST_IMPACT * np.array([between * balls, between * balls, at_wall * wall, at_wall * wall])
        file["collisions/duration_s"][:], file["collisions/approach_speed_m_s"][:] = longest, 3.0
    impacts = flash.read_impacts(run, json.loads(Path(summary).read_text()), FlashSection())
    assert len(impacts) == left
    # A row for each place and kind of heat, and of the two conductivities the smaller makes it hotter.
    rows = pd.DataFrame(flash.flash_rows("d10", impacts, FlashSection())).set_index(["place", "kind"])
    assert rows.xs("all", level="kind")["impacts"].to_dict() == {
        "ball_ball": 2 * (between < 1),
        "ball_wall": int(at_wall < 1),
    }
    known = rows["mean_by_energy_low_K"].notna()
    assert known.any() and (rows["mean_by_energy_low_K"] < rows["mean_by_energy_high_K"])[known].all()
