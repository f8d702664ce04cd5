"""Where the files of the surrogate stage are, and what its rules take from the configuration."""

from types import SimpleNamespace

SURROGATE = f"{RESULTS}/surrogate"


def simulated(case: str) -> str:
    """The file of a simulation, with its snapshots."""
    return f"{RESULTS}/dem/{case}/run.h5"


def variant_settings(section: str):
    """A section of a variant's settings, for `params`; it depends on the wildcard `variant`."""
    return lambda wildcards: getattr(CONFIG.surrogate.variant(wildcards.variant), section).model_dump(mode="json")


def rollout_settings(wildcards) -> dict:
    """The recursive stage of a variant in a test."""
    return CONFIG.surrogate.rollout_of(wildcards.variant, wildcards.test).model_dump(mode="json")


def test_settings(wildcards) -> dict:
    """Cases and starts of the test of the wildcard `test`."""
    return CONFIG.surrogate.tests[wildcards.test].model_dump(mode="json")


def variant_weights(wildcards) -> str:
    """The weights that a variant is rolled out with: its own, or those of another."""
    return f"{SURROGATE}/{CONFIG.surrogate.weights_of(wildcards.variant)}/weights.pt"


def test_runs(wildcards) -> dict[str, str]:
    """The simulations that a test is measured against, and the summaries of those whose collisions are counted."""
    cases = CONFIG.surrogate.tests[wildcards.test].runs()
    runs = {role: simulated(case) for role, case in cases.items()}
    return runs | {f"{role}_summary": f"{RESULTS}/dem/{cases[role]}/summary.json" for role in ("dem", "other_seed")}


def trained_runs(wildcards) -> dict[str, str]:
    """The simulations of the test on the motion of the training."""
    return test_runs(SimpleNamespace(test=CONFIG.surrogate.trained_test))


def compared_runs(wildcards) -> dict[str, str]:
    """What the tests of a variant are measured against, each as `test_role`."""
    return {
        f"{test}_{role}": path
        for test in tests_of(wildcards.variant)
        for role, path in test_runs(SimpleNamespace(test=test)).items()
    }


def tests_of(variant: str) -> list[str]:
    """The tests that a variant is rolled out in: all, and for an ablation the trained one."""
    ablation = variant in CONFIG.surrogate.ablations
    return [CONFIG.surrogate.trained_test] if ablation else list(CONFIG.surrogate.tests)


def moving_tests_of(variant: str) -> list[str]:
    """Those of them in which the balls move: single steps are judged in them."""
    return [name for name in tests_of(variant) if not CONFIG.surrogate.tests[name].driven]


def measured(variant: str) -> list[str]:
    """The tables of measures of a variant: of its roll-outs, and of single steps."""
    names = ["metrics", *(["single_steps"] if is_graph_network(variant) else [])]
    return [f"{SURROGATE}/{variant}/{name}.tsv" for name in names]


def is_graph_network(variant: str) -> bool:
    """Whether a variant predicts accelerations of the whole graph, which single steps can be judged by."""
    settings = (CONFIG.surrogate.variants | CONFIG.surrogate.ablations)[variant]
    return getattr(settings, "kind", "graph") == "graph"


def changes(variant: str) -> str:
    """What an ablation changes, in words."""
    own = CONFIG.surrogate.ablations[variant]
    sections = ("graph", "edges", "network", "training", "rollout")
    keys = {f"{section}.{key}": value for section in sections for key, value in getattr(own, section).items()}
    return ", ".join(f"{key} = {value}" for key, value in keys.items()) or "nothing"


def any_of(names: list[str]) -> str:
    """A wildcard's pattern for these names; one that nothing matches where there are none."""
    return "|".join(names) or "(?!)"


def contact_settings() -> dict:
    """What the rules of the contact surrogate take: its settings, and what its simulations are made of."""
    settings = CONFIG.surrogate.contact
    return {
        "settings": settings.model_dump(mode="json"),
        "mills": {trace.mill: MILLS[trace.mill].model_dump(mode="json") for trace in settings.traces},
        "contacts": {trace.contact: CONTACTS[trace.contact].model_dump(mode="json") for trace in settings.traces},
        "dem": CONFIG.dem.model_dump(mode="json"),
    }
