"""Shared by the rules of chapter 6 and appendix A: their files, and the tests of each surrogate."""

import math

SURROGATE = f"{RESULTS}/surrogate"
SURROGATE_TESTS = list(CONFIG.surrogate.tests)
# By variant, the names of all of its trainings.
TRAININGS = {variant: CONFIG.surrogate.trainings_of(variant) for variant in CONFIG.surrogate.variants}
ROLLOUT = f"{SURROGATE}/{{variant}}/{{test}}/rollout.h5"
# The names of the variants, the ablations and their further trainings.
SURROGATES = [*CONFIG.surrogate.every, *CONFIG.surrogate.trained_again]
MOVING_TESTS = [name for name, test in CONFIG.surrogate.tests.items() if not test.driven]
# Every training of an ablation.
ABLATED = [name for name in SURROGATES if CONFIG.surrogate.training_of(name)[0] in CONFIG.surrogate.ablations]


wildcard_constraints:
    variant="|".join(SURROGATES),
    test="|".join(SURROGATE_TESTS),


def simulated(case: str) -> str:
    """The file of a simulation, with its snapshots."""
    return f"{RESULTS}/dem/{case}/run.h5"


def tests_of(variant: str) -> list[str]:
    """The tests in which a variant is rolled out: all tests; for an ablation only the test on the training motion."""
    return [CONFIG.surrogate.trained_test] if variant in ABLATED else SURROGATE_TESTS


def measured(variant: str) -> list[str]:
    """The tables of measures of a variant: of its roll-outs and of its single steps."""
    return [f"{SURROGATE}/{variant}/{name}.tsv" for name in ("metrics", "single_steps")]


def measured_trainings(variant: str) -> list[str]:
    """The tables of measures of every training of a variant or ablation."""
    return [path for training in CONFIG.surrogate.trainings_of(variant) for path in measured(training)]


def edges_of(variant: str) -> dict:
    """The rules for the edges of a variant, as plain values."""
    return CONFIG.surrogate.variant(variant).edges.model_dump(mode="json")


def rollout_in(variant: str, test: str) -> dict:
    """Settings, case with its simulation, and starts of a variant's roll-out in a test."""
    chosen = CONFIG.surrogate.tests[test]
    return {
        "settings": CONFIG.surrogate.rollout_of(variant, test).model_dump(mode="json"),
        "case": chosen.case,
        "run": simulated(chosen.case),
        "starts_s": chosen.starts_s,
    }


def weights_for(variant: str) -> str:
    """The weights for the roll-out of a variant: its own, or those of another variant."""
    return f"{SURROGATE}/{CONFIG.surrogate.weights_of(variant)}/weights.pt"


def runs_of(test: str) -> dict[str, str]:
    """The reference simulations of a test."""
    return {role: simulated(case) for role, case in CONFIG.surrogate.tests[test].runs().items()}


def compared_runs(tests) -> dict[str, str]:
    """The reference simulations of some tests, named `test_role`."""
    return {f"{test}_{role}": path for test in tests for role, path in runs_of(test).items()}


def starts_in(tests) -> dict[str, float]:
    """Those tests in which the balls move, with their first starts [s]; single steps are evaluated from there."""
    moving = [test for test in tests if test in MOVING_TESTS]
    return {test: CONFIG.surrogate.tests[test].starts_s[0] for test in moving}


def changes(variant: str) -> str:
    """The settings that an ablation changes, as text."""
    own = CONFIG.surrogate.ablations[variant]
    sections = ("graph", "edges", "network", "training", "rollout")
    keys = {f"{section}.{key}": value for section in sections for key, value in getattr(own, section).items()}
    return ", ".join(f"{key} = {value}" for key, value in keys.items()) or "nothing"


def stepped_in(tests) -> list[str]:
    """The simulations from whose states single steps are evaluated, for some tests."""
    return [simulated(CONFIG.surrogate.tests[name].case) for name in starts_in(tests)]


def training_minutes(variant: str) -> int:
    """The time that a training requests: twice its own limit, plus 20 min to start [min]."""
    return 20 + math.ceil(CONFIG.surrogate.variant(variant).training.wall_time_max_s / 30)
