"""Where the files of the surrogate stage are, and what its rules take from the configuration."""

SURROGATE = f"{RESULTS}/surrogate"


def simulated(case: str) -> str:
    """The file of a simulation, with its snapshots."""
    return f"{RESULTS}/dem/{case}/run.h5"


def variant_settings(section: str):
    """A section of a variant's settings, for `params`; it depends on the wildcard `variant`."""
    return lambda wildcards: getattr(CONFIG.surrogate.variant(wildcards.variant), section).model_dump(mode="json")


def test_settings(wildcards) -> dict:
    """Cases and starts of the test of the wildcard `test`."""
    return CONFIG.surrogate.tests[wildcards.test].model_dump(mode="json")


def variant_weights(wildcards) -> str:
    """The weights that a variant is rolled out with: its own, or those of another."""
    return f"{SURROGATE}/{CONFIG.surrogate.weights_of(wildcards.variant)}/weights.pt"


def test_runs(wildcards) -> dict[str, str]:
    """The simulations that a test is measured against."""
    test = CONFIG.surrogate.tests[wildcards.test]
    runs = {"dem": simulated(test.case), "other_seed": simulated(test.other_seed)}
    if test.original:
        runs["original"] = simulated(test.original)
    return runs


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
