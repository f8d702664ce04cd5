"""Every simulation of this run: the table of cases (millprint.cases.table), and the files of its rows."""

import json
import re
from functools import cache

from millprint.cases.table import CaseTable, Why, described_cases, is_as_built, mapped_cases
from millprint.config.mill_sweep import MillSweepConfig
from millprint.config.setup_models import SETTINGS

MILL = f"{RESULTS}/mills/{{mill}}"
CASE = f"{RESULTS}/dem/{{mill}}/{{contact}}/{{case}}"
BOX = CONFIG.mills.box


def derived_sweep_of(name: str) -> MillSweepConfig:
    """The sweep of a mill whose file has none: the checkpoint that derives it runs first."""
    with open(checkpoints.derive_sweep.get(mill=name).output.sweep) as file:
        return MillSweepConfig(**json.load(file))


with stop_on_bad_input():
    TABLE = CaseTable(CONFIG, MILLS, CONTACTS, derived_sweep_of)
MILLS = TABLE.mills
CARD_EXPERIMENTS = TABLE.experiments
# The paths of the simulations that surrogates are trained on or compared with: the longest chain of jobs begins there.
SURROGATE_CASES = set(CONFIG.surrogate.simulated_cases()) if CONFIG.surrogate else set()


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


def rows_of(why: str, *owners: str) -> list:
    """The rows of the table of a kind, by its name in `Why`, and of some sweeps, mills, set-ups or cards."""
    with stop_on_bad_input():
        return TABLE.rows(Why[why], *owners)


def animated(name: str) -> list:
    """The simulation of a card's animation, which runs inside the card's job, if there is one."""
    return rows_of("ANIMATION", name) if CONFIG.cards.animation else []


def files_of(rows, file: str = "summary.json") -> list[str]:
    """A file of the simulation of each row."""
    return [f"{RESULTS}/{row.folder}/{file}" for row in rows]


def summaries_over(key: str) -> list[str]:
    """The summary files of all cases of the sweeps that set the list `key`; empty if no sweep does."""
    return files_of(rows_of("SWEEP", *(sweep.name for sweep in CONFIG.sweeps if getattr(sweep, key))))


def path_at(wildcards) -> str:
    """The path of a case in results/dem, as the table has it."""
    return f"{wildcards.mill}/{wildcards.contact}/{wildcards.case}"


def case_at(wildcards):
    """The case of a folder in results/dem. An unknown case ends the program with one line."""
    with stop_on_bad_input():
        return TABLE.at(path_at(wildcards)).case


def resources_at(wildcards):
    """Threads, time, memory and disk of the case of a folder in results/dem."""
    with stop_on_bad_input():
        return TABLE.resources_at(path_at(wildcards))


@cache
def plain(mill: str, contact: str) -> dict:
    """What the simulations of a mill with a contact set share, as plain values: one object for all of them."""
    return {
        "mill": dumped(mill_named(mill)),
        "contact": CONTACTS[contact].model_dump(mode="json"),
        "settings": CONFIG.dem.model_dump(mode="json", exclude={"lammps"}),
    }


def simulation_at(wildcards) -> dict:
    """A case, its mill, contact set and settings as plain values, and the file for its time.

    Not `benchmark` of the rule, for which Snakemake would measure the script, and not its fork in the server.
    """
    return {
        "case": case_at(wildcards).model_dump(mode="json"),
        "benchmark": f"{BENCHMARKS}/run_dem_case/{path_at(wildcards)}.tsv",
        **plain(wildcards.mill, wildcards.contact),
    }


def mill_named(name: str):
    """A mill of this run. An unknown name ends the program with one line that lists the known mills."""
    with stop_on_bad_input():
        return TABLE.named(name)


@cache
def shape_files(name: str) -> list:
    """The files that a mill's own file names. They are the user's: a module's `prefix` is for what is written."""
    return [local(path) for path in mill_named(name).source_files]


def dumped(mill) -> dict:
    """A mill as plain values, without its sweep, so that a change of the sweep draws no picture again."""
    return mill.model_dump(mode="json", exclude={"sweep"})


def study_plan(name: str) -> list[dict]:
    """The variants of the study of a mill's settings as plain values, with the paths of their cases."""
    with stop_on_bad_input():
        return [
            {
                "setting": each.setting,
                "factor": each.factor,
                "value": each.value,
                "paths": [own.path for own in each.cases],
            }
            for each in TABLE.variants(name)
        ]


def heated_summaries(name: str) -> list[str]:
    """The summary files of the heat balance of a mill: all of its own sweep, or the first one for a smoke test."""
    found = files_of(rows_of("MILL", name))
    return found[:1] if CONFIG.mills.first_case_only else found


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
