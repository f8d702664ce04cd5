"""Shared by the rules of validation: folder, settings and files of a set-up."""

VALIDATION = f"{RESULTS}/validation"


def setup_inputs(name: str) -> dict:
    """Section, mill and contact sets of a set-up, as plain values."""
    setup = CONFIG.validation.chosen[name]
    return {
        "settings": setup.model_dump(mode="json"),
        "mill": dumped(MILLS[setup.mill_name]) if setup.mill_name else None,
        "contacts": [CONTACTS[each].model_dump(mode="json") for each in setup.contact_names],
    }


def simulated_inside(name: str) -> list:
    """The simulations of a set-up that a rule has inside, without a file in results/dem."""
    setup = CONFIG.validation.chosen[name]
    return setup.simulated_inside(MILLS[setup.mill_name]) if setup.mill_name else []


def setup_runs(name: str) -> list[str]:
    """The files that a set-up reads of its simulations."""
    files = CONFIG.validation.chosen[name].run_files
    return [f"{RESULTS}/dem/{path}/{file}" for path in SETUP_CASES[name] for file in files]


def own_tables(name: str) -> list[str]:
    """The tables of the simulations that a set-up runs on its own."""
    return [f"{VALIDATION}/{name}/{table}" for table in CONFIG.validation.chosen[name].own_tables]


def bed_case(name: str):
    """The first simulation of a set-up, the one that is drawn."""
    return next(iter(SETUP_CASES[name].values()))
