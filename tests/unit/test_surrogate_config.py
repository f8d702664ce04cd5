"""Settings of the surrogate stage, its claims, and its tables."""

import pytest

from millprint.config.errors import ConfigError
from millprint.config.load import check_model
from millprint.config.surrogate import SurrogateConfig
from millprint.config.sweep import DemConfig, SweepConfig, expand_sweep
from millprint.thesis.chapter_checks import check_surrogate_cases
from tests.conftest import configuration


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
