"""Settings of the surrogate stage, its claims, and its tables."""

from pathlib import Path

import pandas as pd
import pytest

from millprint.config.errors import ConfigError
from millprint.config.load import check_model
from millprint.config.surrogate import SurrogateConfig
from millprint.config.sweep import DemConfig, SweepConfig, expand_sweep
from millprint.estimate.judge import AGREES, DIFFERS
from millprint.run.files import write_json, write_table
from millprint.thesis.chapter_checks import check_surrogate_cases
from millprint.thesis.claims.tabulate import collect_findings
from millprint.thesis.surrogate.measures import printed_measures, tabulate
from tests.conftest import PRINTED, configuration

ROOT = Path(__file__).parents[2]


@pytest.fixture
def content() -> dict:
    return configuration()["surrogate"]


def settings(content: dict) -> SurrogateConfig:
    return check_model(content, SurrogateConfig, "config.yaml")


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


def swept(config: SurrogateConfig, **options) -> dict:
    """Every case that the stage reads, recorded in the given way."""
    dem = DemConfig(time_step_s=2e-6, settle_s=0.1, discard_turns=0, window_s=1)
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
    every = {"window_s": longest, "snapshot_interval_s": 1e-4}
    undisturbed = {name: test.model_copy(update={"twin": None}) for name, test in config.tests.items()}
    alone = config.model_copy(update={"tests": undisturbed})
    post = undisturbed["post"].model_copy(update={"long_step": undisturbed["post"].other_seed})
    check_surrogate_cases(alone, swept(config, **every), "config.yaml")
    for checked, options, part in (
        (alone, every | {"window_s": longest - 0.1}, "at least"),
        (alone, every | {"discard_s": 0.6}, "needed from 0 s"),
        (alone, {"window_s": longest}, "snapshot_interval_s"),
        (alone.model_copy(update={"tests": {"post": post}}), every, r"post\.long_step"),
        # These are disturbed where the motion begins, and not where the roll-outs do.
        (config, every, r"trained\.twin: .* is not disturbed at 0\.5 s"),
    ):
        with pytest.raises(ConfigError, match=part):
            check_surrogate_cases(checked, swept(config, **options), "config.yaml")
    with pytest.raises(ConfigError, match="in no sweep"):
        check_surrogate_cases(alone, {}, "config.yaml")


def test_a_roll_out_is_no_longer_than_its_test(content):
    content["variants"]["long"] = {"rollout": {"length_s": 15}}
    content["tests"]["rest"]["length_s"] = 2
    config = settings(content)
    assert config.rollout_of("long", "rest").length_s == 2
    assert config.rollout_of("long", "trained").length_s == 15
    assert config.rollout_of("thesis", "rest").length_s == min(2, config.variant("thesis").rollout.length_s)


def surrogate_findings(results: Path) -> dict:
    claims = ROOT / "config/data/claims.tsv"
    return collect_findings(results, claims, "6.") | collect_findings(results, claims, "A.")


def test_every_claim_has_a_finding_before_anything_has_run(tmp_path):
    found = surrogate_findings(tmp_path)
    assert set(found) == {name for name in PRINTED if name.startswith(("6.", "A."))}
    assert found.pop("6.timestep").value == pytest.approx(10426.3, abs=0.1)
    assert all(finding.value is None for finding in found.values())


def metrics(variant: str, test: str, length_s: float = 15, **values: float) -> pd.DataFrame:
    references = {"increments_5ms_r": 0.4, "cumulative_pearson_r": 0.9999}
    return tabulate(values, references, test, variant, printed_measures(pd.Series(PRINTED)), length_s=length_s)


def claim_tables(folder: Path, length_s: float = 15) -> None:
    """Small tables of a run."""
    values = {"stable": 1, "balls_left": 0, "one_step_dissipation_bias_percent": 1, "increments_5ms_r": 0.3}
    values |= {"mean_square_speed_ratio": 0.9, "one_step_acceleration_r2": 0.5, "position_mse_plateau_m2": 3e-4}
    values |= {"position_mse_centroid_m2": 4e-4}
    errors = {"trained": 1.0, "motion1": 2.0, "motion2": 3.0, "post": 4.0}
    tables = [
        metrics(name, test, length_s, **values, dissipation_error_percent=error, cumulative_pearson_r=1 - error / 1e4)
        for name in ("thesis", "ours")
        for test, error in errors.items()
    ]
    write_table(pd.concat(tables), folder / "metrics.tsv")
    write_table(pd.concat(tables[:4]), folder / "thesis/metrics.tsv")
    rows = [("baseline", 1, 5.0, ""), ("window3", 1, 9.0, AGREES)]
    rows += [("window9", 0, 9.0, AGREES), ("width64", 1, 2.0, DIFFERS)]
    rows.append(("phi_deep", 1, 7.5, DIFFERS))
    ablations = pd.DataFrame(rows, columns=["variant", "stable", "dissipation_error_percent", "verdict"])
    ablations = ablations.assign(balls_left=0, mean_square_speed_ratio=1.0, one_step_dissipation_bias_percent=-4.0)
    ablations = ablations.assign(epochs=10, training_s=118.0, rollout_s=1.0, thesis_statement="it is so")
    write_table(ablations, folder / "ablations.tsv")
    rows = [("thesis", 24, 200.0, 6.0), ("thesis", 191, 900.0, 45.0), ("ours", 24, 12.0, 6.0)]
    runtimes = pd.DataFrame(rows, columns=["variant", "balls", "seconds_for_15_s", "dem_seconds_for_15_s"])
    write_table(runtimes.assign(batch=1, basis="measured"), folder / "runtime.tsv")


def test_claims_read_the_tables(tmp_path):
    claim_tables(tmp_path / "surrogate")
    # A shorter run of another seed, which a smoke run has left behind, decides nothing.
    for seed, duration in enumerate((5.2e-4, 6.2e-4)):
        summary = tmp_path / f"dem/emax/calibrated/d10_f0.10_n300_s{seed}/summary.json"
        write_json({"median_contact_duration_s": duration}, summary)
    found = {name: finding.value for name, finding in surrogate_findings(tmp_path).items()}
    expected = {"6.mse": 3e-4, "6.energy": 1, "6.energy.motion1": 2, "6.geometry": "yes", "6.runtime.ratio": 0.03}
    expected |= {"6.duration": 5.2e-4}
    expected |= {"A.window3": "yes", "A.window9": "yes", "A.width64": "no", "A.layers2": None, "A.phi.deep": 7.5}
    assert {name: found[name] for name in expected} == expected and found["6.pearson"] == pytest.approx(0.9997)


def test_a_roll_out_that_is_shorter_than_the_stated_one_decides_only_that_it_runs_away(tmp_path):
    claim_tables(tmp_path / "surrogate", 1.5)
    found = surrogate_findings(tmp_path)
    own = [name for name in found if name.startswith(("6.mse", "6.energy", "6.geometry", "6.pearson"))]
    own.remove("6.geometry.dissipation")
    assert all(found[name].value is None and "ends after 1.5 s" in found[name].explanation for name in own)


def test_every_training_has_its_own_seed(content):
    config = settings(content)
    assert config.trainings_of("thesis") == ["thesis", *(f"thesis_training{number}" for number in range(2, 6))]
    own = [config.variant(name).training for name in config.trainings_of("thesis")]
    assert [one.seed for one in own] == [0, 1, 2, 3, 4]
    assert len({one.model_copy(update={"seed": 0}).model_dump_json() for one in own}) == 1
    assert [config.weights_of(name) for name in config.trainings_of("thesis")] == config.trainings_of("thesis")
    assert [config.weights_of(name) for name in config.trainings_of("baseline")] == config.trainings_of("thesis")
    # Each ablation with weights of its own is trained once.
    assert config.trainings_of("window3") == ["window3"]
    assert settings(content | {"trainings": 1}).trained_again == {}
