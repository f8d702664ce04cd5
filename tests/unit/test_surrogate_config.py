"""Settings of the surrogate stage, its claims, and its tables."""

from pathlib import Path

import pandas as pd
import pytest
import yaml

from millprint.claims import chapter6
from millprint.config.load import check_model
from millprint.config.surrogate import SurrogateConfig, check_surrogate_cases
from millprint.config.sweep import DemConfig, SweepConfig, expand_sweep
from millprint.errors import ConfigError
from millprint.files import read_table, write_json, write_table
from millprint.surrogate.tables import tabulate

ROOT = Path(__file__).parents[2]


@pytest.fixture
def content() -> dict:
    return yaml.safe_load((ROOT / "config/config.yaml").read_text())["surrogate"]


def settings(content: dict) -> SurrogateConfig:
    return check_model(content, SurrogateConfig, "config.yaml")


def test_the_default_variant_is_the_network_of_the_thesis(content):
    variant = settings(content).variant("thesis")
    assert (variant.graph.window, variant.network.width, variant.network.mlp_layers) == (7, 256, 4)
    assert (variant.network.interaction_layers, variant.training.huber_delta) == (1, 2)
    assert (variant.training.acceleration_weight, variant.training.velocity_noise) == (3, 0.005)
    assert (variant.edges.wall_threshold_m, variant.edges.ball_threshold_m) == (-0.0052, 0.0015)
    assert variant.rollout.snap_back_m == -0.0049


def test_ablations_override_the_budget_and_the_budget_the_sections(content):
    content["ablation_budget"] = {"training": {"epochs": 3, "batch_size": 9}}
    content["ablations"] = {"window3": {"graph": {"window": 3}, "training": {"epochs": 5}}, "baseline": {}}
    found = settings(content).variant("window3")
    assert (found.graph.window, found.training.epochs, found.training.batch_size) == (3, 5, 9)
    assert settings(content).variant("thesis").training.batch_size == content["training"]["batch_size"]


def test_thresholds_are_part_of_the_recipe_only_where_they_train(content):
    content["variants"]["other"] = {"edges": {"wall_threshold_m": -0.0053}}
    content["variants"]["trained"] = {"edges": {"training": "thresholds"}}
    config = settings(content)
    assert config.variant("other").recipe() == config.variant("thesis").recipe()
    assert config.variant("trained").recipe().edges.wall_threshold_m == -0.0052


@pytest.mark.parametrize(
    "variant, message",
    [
        ({"graph": {"window": 0}}, r"x\.graph\.window = 0: .*greater than or equal to 1"),
        ({"network": {"widht": 3}}, r"x\.network\.widht = 3"),
        ({"rollout": {"snap_back_m": -0.006}}, r"must exceed edges\.wall_threshold_m"),
        ({"weights_of": "none"}, r"x\.weights_of = 'none': unknown; known: thesis, contact, x"),
    ],
)
def test_variants_that_do_not_hold(content, variant, message):
    content["variants"]["x"] = variant
    with pytest.raises(ConfigError, match=message) as error:
        settings(content)
    assert "\n" not in str(error.value)


def test_cases_must_be_simulated_long_enough(content):
    config = settings(content)
    dem = DemConfig(time_step_s=2e-6, settle_s=0.1, discard_s=0, window_s=1)
    needed = config.simulated_cases()
    mills = sorted({path.split("/")[0] for path in needed})

    def cases(window_s: float, interval_s: float | None) -> dict:
        sweep = SweepConfig(
            name="surrogate",
            mills=mills,
            contacts=["calibrated"],
            ball_diameters_mm=[10],
            fill_ratios=[0.1],
            speeds_rpm=[300],
            seeds=[0, 1],
            window_s=window_s,
            snapshot_interval_s=interval_s,
        )
        return {case.path: case for case in expand_sweep(sweep, dem, "emax")}

    longest = max(needed.values())
    check_surrogate_cases(config, cases(longest, 1e-4), "config.yaml")
    with pytest.raises(ConfigError, match="at least"):
        check_surrogate_cases(config, cases(longest - 0.1, 1e-4), "config.yaml")
    with pytest.raises(ConfigError, match="snapshot_interval_s"):
        check_surrogate_cases(config, cases(longest, None), "config.yaml")
    with pytest.raises(ConfigError, match="in no sweep"):
        check_surrogate_cases(config, {}, "config.yaml")


def claimed() -> list[str]:
    table = read_table(ROOT / "config/data/claims.tsv", text=["id"])
    return [name for name in table["id"] if name.split(".")[0] in ("6", "A")]


def test_every_claim_has_a_finding_before_anything_has_run(tmp_path):
    found = chapter6.findings(tmp_path, ROOT / "config/data")
    assert sorted(found) == sorted(claimed())
    assert found["6.timestep"].value == pytest.approx(10426.3, abs=0.1)
    assert all(
        finding.value is None and finding.explanation.startswith("not run")
        for name, finding in found.items()
        if name != "6.timestep"
    )


def metrics(variant: str, test: str, **values: float) -> pd.DataFrame:
    return tabulate(values, {"increments_5ms_r": 0.4, "cumulative_pearson_r": 0.9999}, test, variant)


def test_claims_read_the_tables(tmp_path):
    common = {"stable": 1, "balls_left": 0, "one_step_dissipation_bias_percent": 1, "increments_5ms_r": 0.3} | {
        "mean_square_speed_ratio": 0.9
    }
    tables = [
        metrics(
            "thesis",
            test,
            dissipation_error_percent=error,
            position_mse_plateau_m2=3e-4,
            position_mse_centroid_m2=4e-4,
            cumulative_pearson_r=1 - error / 1e4,
            **common,
        )
        for test, error in (("trained", 1.0), ("motion1", 2.0), ("motion2", 3.0), ("post", 4.0))
    ]
    ablations = [
        metrics(name, "trained", stable=stable, dissipation_error_percent=error, position_mse_plateau_m2=1e-4)
        for name, stable, error in (
            ("baseline", 1, 5.0),
            ("window3", 1, 9.0),
            ("window9", 0, 9.0),
            ("layers2", 0, 300.0),
            ("width64", 1, 2.0),
            ("phi_deep", 1, 7.5),
        )
    ]
    folder = tmp_path / "surrogate"
    write_table(pd.concat(tables), folder / "metrics.tsv")
    write_table(pd.concat(ablations), folder / "ablations.tsv")
    runtime = {"variant": "thesis", "balls": 24, "batch": 1, "seconds_for_15_s": 200.0, "basis": "measured"}
    write_table(pd.DataFrame([runtime | {"dem_seconds_for_15_s": 6.0}]), folder / "runtime.tsv")
    summary = tmp_path / "dem/emax/calibrated/d10_f0.10_n300_s0/summary.json"
    write_json({"median_contact_duration_s": 5.2e-4}, summary)
    found = {name: finding.value for name, finding in chapter6.findings(tmp_path, ROOT / "config/data").items()}
    assert (found["6.mse"], found["6.energy"], found["6.energy.motion1"], found["6.geometry"]) == (3e-4, 1, 2, "yes")
    assert found["6.pearson"] == pytest.approx(0.9997)
    assert (found["6.runtime.ratio"], found["6.runtime.sgn"], found["6.runtime.dem"]) == (0.03, 200, 6)
    assert found["6.duration"] == 5.2e-4 and found["6.contacts"] is None
    assert [found[f"A.{name}"] for name in ("window3", "window9", "layers2", "width64")] == ["yes", "yes", "yes", "no"]
    assert found["A.phi.deep"] == 7.5 and found["A.phi.shallow"] is None


def test_metrics_carry_the_figures_of_the_thesis_and_the_aims():
    table = metrics("thesis", "motion2", dissipation_error_percent=1.0).iloc[0]
    assert (table["thesis"], table["aim"]) == (46.62, 5.0)
    ablations = [
        tabulate({"dissipation_error_percent": 1.0}, {}, "trained", name, True) for name in ("phi_deep", "mlp2")
    ]
    assert [part.iloc[0]["thesis"] for part in ablations] == [4.18, None]


def test_the_contact_surrogate_never_learns_from_a_test(content):
    content["contact"]["traces"][1]["mill"] = "emax_motion2"
    with pytest.raises(ConfigError, match=r"contact.traces\[1\].mill = 'emax_motion2': is that of a test"):
        settings(content)


def test_kinds_of_variants_are_told_apart(content):
    config = settings(content)
    assert config.of_kind("contact") == ["contact"]
    assert "thesis" in config.of_kind("graph")
    assert set(config.of_kind("graph")) | {"contact"} == set(config.variants) | set(config.ablations)


def test_a_trace_without_time_is_refused(content):
    content["contact"]["traces"][0]["until_s"] = 0.01
    with pytest.raises(ConfigError, match=r"until_s = 0\.01: must exceed from_s = 0\.05"):
        settings(content)
