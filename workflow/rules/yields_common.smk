"""Shared by the rules of chapter 5: its folder, and the machine that its descriptors were calculated for."""

from millprint.thesis.yields.regressors import (
    AVERAGED,
    CLIMATOLOGY,
    PRIMARY,
    REGRESSORS,
    RESIDUAL_WEIGHTS,
    SEARCH_SEED,
    TWO_STEP,
    models_of,
    otherwise,
    searched_again,
)

YIELDS = f"{RESULTS}/yield"
MODELS = models_of(CONFIG.yields.models)
EVERY_MODEL = [*MODELS, (AVERAGED, PRIMARY)]
COMPARED_MODELS = [*EVERY_MODEL, (CLIMATOLOGY, PRIMARY)]
EXPLAINED = [(name, TWO_STEP) for name in CONFIG.yields.models if REGRESSORS[name].explain]
SEARCHED_AGAIN = searched_again(CONFIG.yields.searched_again, MODELS)
YIELD_MODEL = f"{YIELDS}/models/{{model}}_{{strategy}}.json"
OTHER_MODEL = f"{YIELDS}/models/otherwise/{{model}}_{{strategy}}_{{choice}}.json"
HELD_OUT = f"{YIELDS}/held_out/{{model}}_{{strategy}}"
# What a model is trained with, by its file in results/yield/models: regressor, strategy and settings; in the folder
# `otherwise` with another value of a choice that the thesis leaves open.
TRAINED_MODELS = {
    **{f"{model}_{strategy}": (model, strategy, yield_settings("training")) for model, strategy in MODELS},
    **{
        f"otherwise/{model}_{strategy}_{choice}": (
            *(model, strategy),
            otherwise(CONFIG.yields.training, choice).model_dump(mode="json"),
        )
        for model, strategy, choice in SEARCHED_AGAIN
    },
}
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
