"""Every simulation of this run: the sweeps of the configuration, of each mill and each set-up, and the large mill."""

import math
import re

from millprint.card.experiment_cases import cases_of
from millprint.config.checks import card_experiments
from millprint.config.mill_sweep import MillSweepConfig
from millprint.config.setup_models import SETTINGS, setup_cases
from millprint.dem.lammps.cost import lammps_resources
from millprint.dem.resources import resources_of
from millprint.fingerprint.cases import described_cases, enlarged, held_out_cases, large_case, mapped_cases, mill_cases
from millprint.fingerprint.study_cases import study_variants
from millprint.uncertainty.varied import samples_of_job

MILL = f"{RESULTS}/mills/{{mill}}"
CASE = f"{RESULTS}/dem/{{mill}}/{{contact}}/{{case}}"
BOX = CONFIG.mills.box
# Mills whose own sweep may be simulated.
FURTHER_MILLS = [*CONFIG.mills.named, *CONFIG.uncertainty.mills, *CONFIG.dose.wear.mills, *CONFIG.dose.heat.mills]
SWEPT_MILLS = list(dict.fromkeys([CONFIG.mill, *FURTHER_MILLS]))
SCALE_UP_CASES = {}
# The simulations of the measured set-ups, by set-up and path.
SETUP_CASES = {name: setup_cases(setup, CONFIG.dem) for name, setup in CONFIG.validation.chosen.items()}

with stop_on_bad_input():
    # The experiments of the milling cards, by name.
    CARD_EXPERIMENTS = {experiment.name: experiment for experiment in card_experiments(CONFIG)}

if CONFIG.mills.scale_up is not None:
    # The large mill is a mill like any other, but it is calculated from the small one and has no file.
    SMALL = MILLS[CONFIG.mills.scale_up.mill]
    LARGE, LARGE_FACTOR = enlarged(SMALL, CONFIG.mills.scale_up.volume_l, f"{SMALL.name}_large")
    MILLS[LARGE.name] = LARGE
    LARGE_CASE = large_case(SMALL, LARGE, LARGE_FACTOR, CONFIG.mills)
    SCALE_UP_CASES[LARGE_CASE.path] = LARGE_CASE


def any_of(names) -> str:
    """A wildcard's pattern that matches only these names; without names it matches nothing."""
    return "|".join(map(re.escape, names)) or "(?!)"


def none_of(names) -> str:
    """A wildcard's pattern that matches every name except these."""
    return f"(?!(?:{any_of(names)})(?:/|$))[^/]+"


wildcard_constraints:
    mill="[a-z][a-z0-9_]*",
    contact="[^/]+",
    case="[^/]+",


def mill_named(name: str):
    """A mill of this run. An unknown name ends the program with one line that lists the known mills."""
    with stop_on_bad_input():
        if name not in MILLS:
            raise ConfigError(
                f"{RESULTS}: unknown mill {name!r}; this run has {', '.join(sorted(MILLS))}; "
                f"--config mill={name} takes config/mills/{name}.yaml"
            )
    return MILLS[name]


def shape_files(name: str) -> list:
    """The files that a mill's own file names. They are the user's: a module's `prefix` is for what is written."""
    return [local(path) for path in mill_named(name).source_files]


def dumped(mill) -> dict:
    """A mill as plain values, without its sweep, so that a change of the sweep draws no picture again."""
    return mill.model_dump(mode="json", exclude={"sweep"})


def sweep_of_mill(name: str):
    """The mill with its own sweep. If its file has no sweep, the checkpoint that derives it runs first."""
    mill = mill_named(name)
    if mill.sweep is None:
        with open(checkpoints.derive_sweep.get(mill=name).output.sweep) as file:
            mill = mill.model_copy(update={"sweep": MillSweepConfig(**json.load(file))})
    return mill


# By maker and mill, and by the sweep where a checkpoint derives it: each simulation asks for them several times.
OWN_CASES = {}


def cases_from(make, name: str) -> dict:
    """The cases that `make` gives for a mill with its own sweep, by their path."""
    mill = sweep_of_mill(name)
    key = (make, name, None if MILLS[name].sweep else mill.sweep.model_dump_json())
    if key not in OWN_CASES:
        with stop_on_bad_input():
            OWN_CASES[key] = {case.path: case for case in make(mill, CONFIG.mills)}
    return OWN_CASES[key]


def cases_of_mill(name: str) -> dict:
    """The cases of a mill's own sweep, by their path."""
    return cases_from(mill_cases, name)


def new_cases(name: str) -> dict:
    """The cases of a mill that its fingerprint does not see, by their path."""
    return cases_from(held_out_cases, name)


def contact_of_card(name: str):
    """The contact set of an experiment."""
    return CONTACTS[CARD_EXPERIMENTS[name].contact or CONFIG.mills.contact_set]


def cases_of_card(name: str) -> list:
    """The cases of an experiment: of the sweeps of the configuration, of its mill's own sweep, or its own."""
    experiment, groups = CARD_EXPERIMENTS[name], [described_cases(CONFIG, CASES).values()]
    mill, contact = MILLS[experiment.mill], contact_of_card(name)
    if mill.sweep:
        groups.append(cases_of_mill(mill.name).values())
    with stop_on_bad_input():
        return cases_of(experiment, mill, contact, CONFIG.mills, groups, CONFIG.cards.experiments)


def study_of(name: str) -> list:
    """The variants of one condition of a mill's sweep that tell whether its settings are good enough."""
    contact, study = CONTACTS[CONFIG.mills.contact_set], CONFIG.convergence.study
    taken = {path: case for known in (CASES, *SETUP_CASES.values()) for path, case in known.items()}
    with stop_on_bad_input():
        return study_variants(sweep_of_mill(name), contact, CONFIG.mills, CONFIG.dem, study, taken)


def study_plan(name: str) -> list[dict]:
    """The variants as plain values, with the paths of their cases."""
    return [
        {"setting": each.setting, "factor": each.factor, "value": each.value, "paths": [own.path for own in each.cases]}
        for each in study_of(name)
    ]


def study_cases(name: str) -> dict:
    """The cases of the study of a mill's settings, by their path."""
    return {case.path: case for each in study_of(name) for case in each.cases}


def study_summaries(name: str) -> list[str]:
    """The summary files of all variants of a mill."""
    return summary_files(path for each in study_plan(name) for path in each["paths"])


def mill_summaries(name: str) -> list[str]:
    """The summary files of all cases of a mill's own sweep."""
    return summary_files(cases_of_mill(name))


def heated_summaries(name: str) -> list[str]:
    """The summary files of the heat balance of a mill: all of its own sweep, or the first one for a smoke test."""
    return mill_summaries(name)[:1] if CONFIG.mills.first_case_only else mill_summaries(name)


def derived_sweep(wildcards) -> list[str]:
    """The file of a mill's sweep, if its own file has none."""
    return [] if mill_named(wildcards.mill).sweep else [f"{MILL}/sweep.json".format(mill=wildcards.mill)]


def own_sweep(wildcards) -> dict | None:
    """The sweep in a mill's own file, as plain values."""
    sweep = mill_named(wildcards.mill).sweep
    return sweep and sweep.model_dump(mode="json")


def described(name: str) -> str:
    """The fingerprint file of a mill."""
    return f"{RESULTS}/mills/{name}/fingerprint.json"


def predicting(name: str) -> str:
    """The fingerprint file that predicts a mill: with all its intervals if the whole run has their analysis."""
    return f"{RESULTS}/uncertainty/{name}/fingerprint.json" if name in CONFIG.uncertainty.mills else described(name)


def mapped_runs(contact: str) -> dict[float, str]:
    """The record of the simulation that the maps of a contact set show at each fill ratio."""
    return {fill: f"{RESULTS}/dem/{path}/run.h5" for fill, path in mapped_cases(CONFIG, CASES, contact).items()}


def case_at(wildcards):
    """The case of a folder in results/dem. An unknown case ends the program with one line."""
    path = f"{wildcards.mill}/{wildcards.contact}/{wildcards.case}"
    # If a sweep of the configuration has the same case, its settings apply.
    for known in (CASES, SCALE_UP_CASES, *SETUP_CASES.values(), CARD_CASES):
        if path in known:
            return known[path]
    for own in (cases_of_mill, new_cases, study_cases) if wildcards.mill in SWEPT_MILLS else ():
        if path in (known := own(wildcards.mill)):
            return known[path]
    with stop_on_bad_input():
        raise ConfigError(
            f"{RESULTS}/dem/{path}: no such case; neither the sweeps of the configuration nor the sweep of mill "
            f"{wildcards.mill} contain it"
        )


def resources_at(wildcards):
    """Threads, time and memory of the case of a folder in results/dem."""
    return estimate(case_at(wildcards))


def lammps_at(wildcards):
    """Ranks, time and memory of the case of a folder in results/dem by LAMMPS."""
    case = case_at(wildcards)
    return lammps_resources(case, CONFIG.dem, MILLS[case.mill], CONTACTS[case.contact])


def estimate(case):
    """Threads, time, memory and disk of a case."""
    return resources_of(case, CONFIG.dem, MILLS[case.mill], CONTACTS[case.contact])


def likely_s(cases) -> int:
    """Processor time that simulations are likely to take [s], for the plan of a run; 0 without any."""
    return math.ceil(sum(estimate(case).processor_s for case in cases))


def likely_mb(cases) -> int:
    """Size of the files of simulations [MB], for the plan of a run."""
    return math.ceil(sum(estimate(case).disk_mb for case in cases))


def samples_of(name: str) -> list:
    """A case for each sample of a job, without one for a mill whose sweep is derived during the run."""
    mill = mill_named(name)
    return samples_of_job(mill, CONFIG.mills, CONFIG.uncertainty) if mill.sweep else []


def urgency(case) -> int:
    """The priority of a case: 1 if a surrogate is trained on it or compared with it, else 0.

    The longest chain of jobs of a run begins with these.
    """
    return int(case.path in SURROGATE_CASES)


# The paths of the simulations that surrogates are trained on or compared with.
SURROGATE_CASES = set(CONFIG.surrogate.simulated_cases()) if CONFIG.surrogate else set()
# The simulations of the milling cards, by path.
CARD_CASES = {case.path: case for name in CARD_EXPERIMENTS for case in cases_of_card(name)}
