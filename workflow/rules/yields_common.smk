"""Shared by the rules of chapter 5: its folder, and the machine that its descriptors were calculated for."""

from millprint.predict.regressors import (
    AVERAGED,
    CLIMATOLOGY,
    PRIMARY,
    REGRESSORS,
    RESIDUAL_WEIGHTS,
    SEARCH_SEED,
    TWO_STEP,
    is_quick,
    models_of,
    otherwise,
    searched_again,
)

YIELDS = f"{RESULTS}/yield"
MODELS = models_of(CONFIG.yields.models)
EVERY_MODEL = [*MODELS, (AVERAGED, PRIMARY)]
COMPARED_MODELS = [*EVERY_MODEL, (CLIMATOLOGY, PRIMARY)]
# The models whose predictions of every run share a job: those of one strategy, or all where there are few folds.
HELD_OUT_TOGETHER = [
    (name, strategy)
    for name, strategy in COMPARED_MODELS
    if CONFIG.yields.honest.is_quick or name not in REGRESSORS or not REGRESSORS[name].two_step
]
EXPLAINED = [(name, TWO_STEP) for name in CONFIG.yields.models if REGRESSORS[name].explain]
SEARCHED_AGAIN = searched_again(CONFIG.yields.searched_again, MODELS)
# Strategy and choice of the further trainings of a model; those that are trained again have the same.
TRAINED_OTHERWISE = list(dict.fromkeys((strategy, choice) for _, strategy, choice in SEARCHED_AGAIN))
YIELD_MODEL = f"{YIELDS}/models/{{model}}_{{strategy}}.json"
OTHER_MODEL = f"{YIELDS}/models/otherwise/{{model}}_{{strategy}}_{{choice}}.json"
HELD_OUT = f"{YIELDS}/held_out/{{model}}_{{strategy}}"
STRATEGIES = [PRIMARY, TWO_STEP]
# Both strategies of a regressor are one job; what is quick shares a job with the others that are.
QUICK = [name for name in CONFIG.yields.models if is_quick(name, CONFIG.yields.search)]
TRAINED_ALONE = any_of([name for name in REGRESSORS if name not in QUICK])
HELD_OUT_ALONE = any_of(
    [] if CONFIG.yields.honest.is_quick else [name for name, regressor in REGRESSORS.items() if regressor.two_step]
)
# The machine of the cases of chapter 4, whose descriptors follow from the master curves. The mill gives the amplitude.
YIELD_CONTACT = CONTACTS[CONFIG.partition.contact]
YIELD_MACHINE = {
    "reference_speed": CONFIG.partition.reference_speed_rpm / 60,
    "density": YIELD_CONTACT.density_kg_m3,
    "diameter": CONFIG.partition.ball_diameter_mm * 1e-3,
}
# Runs of others, and the fingerprints of their mills.
OTHER_SOURCES = CONFIG.yields.other_sources
OTHER_FILES = {
    **({"others": OTHER_SOURCES.runs} if OTHER_SOURCES.runs else {}),
    "fingerprints": [source.fingerprint for source in OTHER_SOURCES.sources if source.fingerprint],
}
# Experiments that were proposed, are running or done.
TOLD_EXPERIMENTS = {"experiments": CONFIG.yields.proposals.experiments} if CONFIG.yields.proposals.experiments else {}


def trained_otherwise(strategy: str, choice: str) -> tuple[str, dict]:
    """A strategy, and the settings of its training with another value of a choice."""
    return strategy, otherwise(CONFIG.yields.training, choice).model_dump(mode="json")
