"""Settings of the surrogate stage, its claims, and its tables."""

from pathlib import Path

import pandas as pd
import pytest

from millprint.config.errors import ConfigError
from millprint.config.load import check_model
from millprint.config.surrogate import SurrogateConfig
from millprint.config.sweep import DemConfig, SweepConfig, expand_sweep
from millprint.run.files import read_table, write_json, write_table
from millprint.thesis.chapter_checks import check_surrogate_cases
from millprint.thesis.claims.tabulate import collect_findings
from millprint.thesis.surrogate.measure_tables import is_met, printed_measures, tabulate
from tests.conftest import PRINTED, configuration

ROOT = Path(__file__).parents[2]


@pytest.fixture
def content() -> dict:
    return configuration()["surrogate"]


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


def test_ablations_that_change_only_thresholds_use_the_weights_of_the_thesis(content):
    config = settings(content)
    for name in ("baseline", "phi_shallow", "phi_deep", "centre_distance"):
        assert config.weights_of(name) == "thesis"
        assert config.variant(name).training.epochs == config.variant("thesis").training.epochs
    assert config.weights_of("window3") == "window3"


def test_null_leaves_an_entry_out(content):
    content["tests"]["motion2"] = content["ablations"]["window9"] = None
    config = settings(content)
    assert "motion2" not in config.tests and "motion1" in config.tests and "window9" not in config.ablations
    content["tests"]["trained"] = None
    with pytest.raises(ConfigError, match="trained_test = 'trained': is not among tests"):
        settings(content)


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
        ({"weights_of": "none"}, r"x\.weights_of = 'none': unknown; known: thesis, x"),
        ({"weights_of": "width64"}, r"x\.weights_of = 'width64': unknown; known: thesis, x"),
        ({"weights_of": "thesis", "graph": {"window": 3}}, r"x\.weights_of = 'thesis': those have another graph"),
        ({"weights_of": "thesis", "network": {"width": 9}}, r"x\.weights_of = 'thesis': those have another network"),
    ],
)
def test_variants_that_do_not_hold(content, variant, message):
    content["variants"]["x"] = variant
    with pytest.raises(ConfigError, match=message) as error:
        settings(content)
    assert "\n" not in str(error.value)


def swept(config: SurrogateConfig, **options) -> dict:
    """Every case that the stage reads, recorded in the given way."""
    dem = DemConfig(time_step_s=2e-6, settle_s=0.1, discard_s=0, window_s=1)
    sweep = SweepConfig(
        name="surrogate",
        mills=sorted({path.split("/")[0] for path in config.simulated_cases()}),
        contacts=["calibrated"],
        ball_diameters_mm=[5, 10],
        fill_ratios=[0.1],
        speeds_rpm=[300],
        seeds=[0, 1],
        **options,
    )
    disturbed = sweep.model_copy(update={"disturbances_m": [0, 1e-9]})
    stepped = sweep.model_copy(update={"time_steps_s": [8e-6]})
    return {case.path: case for block in (sweep, disturbed, stepped) for case in expand_sweep(block, dem, "emax")}


def test_cases_must_be_simulated_when_they_are_read(content):
    for test in content["tests"].values():
        test["starts_s"] = [0.5]
    config = settings(content)
    longest = max(until_s for _, until_s in config.simulated_cases().values())
    undisturbed = {name: test.model_copy(update={"twin": None}) for name, test in config.tests.items()}
    alone = config.model_copy(update={"tests": undisturbed})
    check_surrogate_cases(alone, swept(config, window_s=longest, snapshot_interval_s=1e-4), "config.yaml")
    with pytest.raises(ConfigError, match="at least"):
        check_surrogate_cases(alone, swept(config, window_s=longest - 0.1, snapshot_interval_s=1e-4), "config.yaml")
    with pytest.raises(ConfigError, match=r"snapshots from 0\.6 s .* needed from 0 s"):
        late = swept(config, discard_s=0.6, window_s=longest, snapshot_interval_s=1e-4)
        check_surrogate_cases(alone, late, "config.yaml")
    with pytest.raises(ConfigError, match="snapshot_interval_s"):
        check_surrogate_cases(alone, swept(config, window_s=longest), "config.yaml")
    with pytest.raises(ConfigError, match="in no sweep"):
        check_surrogate_cases(alone, {}, "config.yaml")
    own = config.tests["post"].model_copy(update={"long_step": config.tests["post"].other_seed})
    with pytest.raises(ConfigError, match=r"post\.long_step: .* has no step of its own"):
        check_surrogate_cases(
            alone.model_copy(update={"tests": {"post": own.model_copy(update={"twin": None})}}),
            swept(config, window_s=longest, snapshot_interval_s=1e-4),
            "config.yaml",
        )
    # These are disturbed where the motion begins, and not where the roll-outs do.
    with pytest.raises(ConfigError, match=r"trained\.twin: .* is not disturbed at 0\.5 s"):
        check_surrogate_cases(config, swept(config, window_s=longest, snapshot_interval_s=1e-4), "config.yaml")


def test_a_roll_out_is_no_longer_than_its_test(content):
    content["variants"]["long"] = {"rollout": {"length_s": 15}}
    content["tests"]["rest"]["length_s"] = 2
    config = settings(content)
    assert config.rollout_of("long", "rest").length_s == 2
    assert config.rollout_of("long", "trained").length_s == 15
    assert config.rollout_of("thesis", "rest").length_s == min(2, config.variant("thesis").rollout.length_s)


def claimed() -> list[str]:
    table = read_table(ROOT / "config/data/claims.tsv", text=["id"])
    return [name for name in table["id"] if name.split(".")[0] in ("6", "A")]


def surrogate_findings(results: Path) -> dict:
    return {
        name: finding
        for chapter in ("6.", "A.")
        for name, finding in collect_findings(results, ROOT / "config/data/claims.tsv", chapter).items()
    }


def write_metrics(tables: list[pd.DataFrame], folder: Path) -> None:
    """The measures of all variants, and those of the thesis's."""
    table = pd.concat(tables)
    write_table(table, folder / "metrics.tsv")
    write_table(table[table["variant"] == "thesis"], folder / "thesis/metrics.tsv")


def test_every_claim_has_a_finding_before_anything_has_run(tmp_path):
    found = surrogate_findings(tmp_path)
    assert sorted(found) == sorted(claimed())
    assert found["6.timestep"].value == pytest.approx(10426.3, abs=0.1)
    assert all(
        finding.value is None and finding.explanation.startswith("not run")
        for name, finding in found.items()
        if name != "6.timestep"
    )


def metrics(variant: str, test: str, length_s: float = 15, **values: float) -> pd.DataFrame:
    references = {"increments_5ms_r": 0.4, "cumulative_pearson_r": 0.9999}
    return tabulate(values, references, test, variant, printed_measures(pd.Series(PRINTED)), length_s=length_s)


def claim_tables(folder: Path, length_s: float = 15) -> None:
    """Small tables of a run."""
    common = {"stable": 1, "balls_left": 0, "one_step_dissipation_bias_percent": 1, "increments_5ms_r": 0.3} | {
        "mean_square_speed_ratio": 0.9,
        "one_step_acceleration_r2": 0.5,
    }
    tables = [
        metrics(
            variant,
            test,
            length_s,
            dissipation_error_percent=error,
            position_mse_plateau_m2=3e-4,
            position_mse_centroid_m2=4e-4,
            cumulative_pearson_r=1 - error / 1e4,
            **common,
        )
        for variant in ("thesis", "ours")
        for test, error in (("trained", 1.0), ("motion1", 2.0), ("motion2", 3.0), ("post", 4.0))
    ]
    ablations = pd.DataFrame(
        [
            {"variant": name, "stable": stable, "dissipation_error_percent": error, "holds": holds}
            for name, stable, error, holds in (
                ("baseline", 1, 5.0, ""),
                ("window3", 1, 9.0, "yes"),
                ("window9", 0, 9.0, "yes"),
                ("width64", 1, 2.0, "no"),
                ("phi_deep", 1, 7.5, "no"),
            )
        ]
    ).assign(balls_left=0, mean_square_speed_ratio=1.0, one_step_dissipation_bias_percent=-4.0)
    ablations = ablations.assign(epochs=10, training_s=118.0, rollout_s=1.0, thesis_statement="it is so")
    write_metrics(tables, folder)
    write_table(ablations, folder / "ablations.tsv")
    runtimes = [
        {"variant": variant, "balls": balls, "batch": 1, "seconds_for_15_s": seconds, "dem_seconds_for_15_s": dem}
        for variant, balls, seconds, dem in (
            ("thesis", 24, 200.0, 6.0),
            ("thesis", 191, 900.0, 45.0),
            ("ours", 24, 12.0, 6.0),
        )
    ]
    write_table(pd.DataFrame(runtimes).assign(basis="measured"), folder / "runtime.tsv")


def test_claims_read_the_tables(tmp_path):
    claim_tables(tmp_path / "surrogate")
    summary = tmp_path / "dem/emax/calibrated/d10_f0.10_n300_s0/summary.json"
    write_json({"median_contact_duration_s": 5.2e-4}, summary)
    # A shorter run of another seed, which a smoke run has left behind, decides nothing.
    left_behind = tmp_path / "dem/emax/calibrated/d10_f0.10_n300_s1/summary.json"
    write_json({"median_contact_duration_s": 6.2e-4}, left_behind)
    findings = surrogate_findings(tmp_path)
    found = {name: finding.value for name, finding in findings.items()}
    assert (found["6.mse"], found["6.energy"], found["6.energy.motion1"], found["6.geometry"]) == (3e-4, 1, 2, "yes")
    assert found["6.pearson"] == pytest.approx(0.9997)
    assert found["6.runtime.ratio"] == 0.03 and found["6.duration"] == 5.2e-4
    assert [found[f"A.{name}"] for name in ("window3", "window9", "width64")] == ["yes", "yes", "no"]
    assert found["A.layers2"] is None and findings["A.layers2"].explanation.startswith("not run")
    assert found["A.phi.deep"] == 7.5 and found["A.phi.shallow"] is None
    assert "variant ours: 2 %" in findings["6.energy.motion1"].explanation
    assert all(
        findings[name].explanation.startswith("over 15 s of the motion of the training")
        for name in ("6.mse", "6.energy")
    )
    assert all(
        findings[name].explanation.startswith("over 15 s of a motion that was not trained on")
        for name in ("6.energy.motion1", "6.geometry")
    )
    assert "variant ours: 0.5" in findings["6.runtime.ratio"].explanation
    assert "10 epochs in 118 s" in findings["A.window9"].explanation


def test_a_roll_out_that_is_shorter_than_the_stated_one_decides_only_that_it_runs_away(tmp_path):
    claim_tables(tmp_path / "surrogate", 1.5)
    found = surrogate_findings(tmp_path)
    own = [name for name in found if name.startswith(("6.mse", "6.energy", "6.geometry", "6.pearson"))]
    own.remove("6.geometry.dissipation")
    assert all(found[name].value is None and "ends after 1.5 s" in found[name].explanation for name in own)
    assert "dissipation_error_percent 2 " in found["6.energy.motion1"].explanation


def test_metrics_carry_the_figures_of_the_thesis_and_the_aims():
    table = metrics("thesis", "motion2", dissipation_error_percent=1.0).iloc[0]
    assert (table["thesis"], table["aim"]) == (float(PRINTED["6.energy.motion2"]), 5.0)
    table = tabulate({"horizon_s": 0.1, "speed_wasserstein_m_s": 1.0}, {"horizon_s": 0.4}, "motion1", "ours")
    assert table["aim"].tolist()[0] == 0.2 and pd.isna(table["aim"][1])
    assert is_met("horizon_s", 0.2, 0.2) and not is_met("horizon_s", 0.1, 0.2)
    assert is_met("balls_left", 0, 0) and not is_met("balls_left", float("nan"), 0)


def test_the_claims_explain_a_roll_out_that_runs_away(tmp_path):
    """The cause is given with the verdict: what left when, and how long the network was trained."""
    values = {"stable": 0, "balls_left": 3, "first_left_s": 0.25, "mean_square_speed_ratio": 9e9}
    values |= {"one_step_dissipation_bias_percent": -8.0, "one_step_acceleration_r2": 0.1}
    values |= {"dissipation_error_percent": 400.0, "position_mse_plateau_m2": 1.0, "position_mse_centroid_m2": 4e-4}
    values |= {"cumulative_pearson_r": 0.5, "increments_5ms_r": 0.0}
    tables = [metrics("thesis", test, 1.5, **values) for test in ("trained", "motion1", "motion2", "post")]
    folder = tmp_path / "surrogate"
    write_metrics(tables, folder)
    write_table(pd.DataFrame({"epoch": [1, 2], "elapsed_s": [50.0, 100.0]}), folder / "thesis/loss.tsv")
    found = surrogate_findings(tmp_path)
    assert found["6.geometry"].value == "no"
    for claim in ("6.energy", "6.geometry"):
        assert "3 ball(s) cross the wall, the first after 0.25 s" in found[claim].explanation
    assert "trained for 2 epochs in 100 s" in found["6.energy"].explanation


def test_every_training_has_its_own_seed(content):
    config = settings(content)
    assert config.trainings_of("thesis") == ["thesis", "thesis_training2", "thesis_training3"]
    own = [config.variant(name).training for name in config.trainings_of("thesis")]
    assert [one.seed for one in own] == [0, 1, 2]
    assert len({one.model_copy(update={"seed": 0}).model_dump_json() for one in own}) == 1
    assert [config.weights_of(name) for name in config.trainings_of("thesis")] == config.trainings_of("thesis")
    assert [config.weights_of(name) for name in config.trainings_of("baseline")] == config.trainings_of("thesis")
    # Each ablation with weights of its own is trained once.
    assert config.trainings_of("window3") == ["window3"]
    assert settings(content | {"trainings": 1}).trained_again == {}


def test_a_variant_with_the_name_of_a_further_training_is_refused(content):
    variants = {"thesis": {}, "thesis_training2": {}}
    with pytest.raises(ConfigError, match="thesis_training2: is the name of a further training"):
        settings(content | {"ablations": {}, "variants": variants})


def test_a_claim_says_how_many_trainings_failed(tmp_path):
    folder = tmp_path / "surrogate"
    claim_tables(folder)
    measures = ("dissipation_error_percent", "position_mse_plateau_m2", "balls_left", "mean_square_speed_ratio")
    draws = ((1.0, 2e-4, 0, 1.0), (2.5, 3e-4, 1, 1.1), (3e20, 1e15, 24, 1e20))
    rows = [
        {"variant": "thesis", "training": number, "test": "trained", "measure": measure, "value": value}
        for number, draw in enumerate(draws, start=1)
        for measure, value in zip(measures, draw, strict=True)
    ]
    write_table(pd.DataFrame(rows), folder / "trainings.tsv")
    findings = surrogate_findings(tmp_path)
    for name, others in (("6.energy", "1, 2.5 %"), ("6.mse", "0.0002, 0.0003 m2")):
        told = findings[name].explanation
        assert f"1 of 3 trainings failed (lost balls and ran away); the others: {others}" in told
        assert "e+" not in told
