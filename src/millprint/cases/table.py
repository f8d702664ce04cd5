"""The table of the simulations of a run: every one is a row, whatever it is made for.

Sweeps, fingerprints, studies, cards and set-ups only write rows. Rules, plan and checks read them: what is simulated,
for whom, what it takes, and where its files lie. The Snakefile imports this, so no heavy imports here.

A row is a simulation that is known before the run. Not in the table are those that a result chooses: the jars of a
search (`millprint.thesis.fit.jar_search`), which share `millprint.cases.simulate.simulate_each` with the rows that
are simulated inside a job. Neither are boxes and impacts of the validation, which have no mill.
"""

import math
from collections.abc import Callable, Iterable, Mapping
from enum import StrEnum
from itertools import chain
from typing import NamedTuple

from millprint.cases.of_mill import (
    Variant,
    enlarged,
    held_out_cases,
    large_case,
    mean_samples,
    mill_cases,
    study_variants,
    sweep_of,
    windows_of,
)
from millprint.config.card import Experiment
from millprint.config.charge import diameter_of
from millprint.config.checks import card_experiments
from millprint.config.contact_set import ContactConfig
from millprint.config.errors import ConfigError
from millprint.config.mill import MillConfig
from millprint.config.mill_sweep import PRECISIONS, MillsConfig, MillSweepConfig
from millprint.config.setup_models import setup_cases
from millprint.config.sweep import Case, balls_of, expand_sweep
from millprint.config.view import ViewConfig
from millprint.config.workflow import WorkflowConfig
from millprint.dem.lammps.cost import lammps_resources
from millprint.dem.resources import Resources, resources_of

# Turns of an animation and frames per turn; it has the seed of the first simulation.
TURNS, FRAMES = 2, 40
ANIMATION = ViewConfig(revolutions=TURNS, frames_per_revolution=FRAMES)
# Denser than any powder [g/mL].
DENSEST_G_ML = 25.0


class Why(StrEnum):
    """Why a simulation is made. Where a case is made for several, the first of them says how it is simulated."""

    SWEEP = "sweep of the configuration"
    SCALE_UP = "large mill of a scale-up"
    SET_UP = "set-up of the validation"
    CARD = "milling card"
    MILL = "sweep of a mill"
    NEW = "new condition, to count how often bands hold"
    STUDY = "study of the settings of a mill"
    SAMPLE = "sample of contact parameters"
    IN_SET_UP = "set-up of the validation, inside its job"
    ANIMATION = "animation of a milling card"


# The kinds of a mill that has a sweep.
OF_MILL = (Why.MILL, Why.NEW, Why.STUDY)
# The kinds whose simulations a job of another rule makes, and its folder in the results.
INSIDE = {
    Why.SAMPLE: "uncertainty/{owner}/samples",
    Why.IN_SET_UP: "validation/{owner}",
    Why.ANIMATION: "cards/{owner}",
}


class Row(NamedTuple):
    """One simulation.

    why: what it is made for; owner: the sweep, mill, set-up or card of that name. case: condition, mill, contact set,
    seed and window; folder: where its files lie, below the results.
    """

    why: Why
    owner: str
    case: Case
    folder: str


class CaseTable:
    """The rows of a run, made when they are asked for.

    mills: those of the run by name, and the large mill of a scale-up. derived: gives the sweep of a mill whose file has
    none, by the mill's name; without it, the table derives it.
    """

    def __init__(
        self,
        config: WorkflowConfig,
        mills: Mapping[str, MillConfig],
        contacts: Mapping[str, ContactConfig],
        derived: Callable[[str], MillSweepConfig] | None = None,
    ) -> None:
        self.config, self.mills, self.contacts, self._derived = config, dict(mills), contacts, derived
        self.experiments = {experiment.name: experiment for experiment in card_experiments(config)}
        further = (config.mills.named, config.uncertainty.mills, config.dose.heat.mills)
        self._swept_mills = {config.mill, *chain.from_iterable(further)}
        self._made: dict[tuple, list[Row]] = {}
        self._by_path: dict[tuple, dict[str, Row]] = {}
        # A job asks for its row and its resources some ten times.
        self._found: dict[tuple, Row] = {}
        self._resources: dict[tuple, Resources] = {}
        if plan := config.mills.scale_up:
            # The large mill is a mill like any other, but it is calculated from the small one and has no file.
            small = mills[plan.mill]
            large, factor = enlarged(small, plan.volume_l, f"{small.name}_large")
            self.mills[large.name] = large
            self._large = large_case(small, large, factor, config.mills)

    def rows(self, why: Why, *owners: str) -> list[Row]:
        """The rows of a kind, of some owners. Raises ConfigError for a mill, a charge or powder that cannot be."""
        return [row for owner in owners for row in self._rows(why, owner)]

    def cases(self, why: Why, *owners: str) -> dict[str, Case]:
        """The cases of these rows by their path."""
        return {row.case.path: row.case for row in self.rows(why, *owners)}

    def at(self, path: str) -> Row:
        """The row of a folder in results/dem, MILL/CONTACT/NAME. Raises ConfigError where no row has it."""
        key = self._place(path)
        if key not in self._found:
            self._found[key] = self._search(path)
        return self._found[key]

    def _place(self, path: str) -> tuple[str, str | None]:
        """What decides the row of a folder: its path, and the sweep that a job derives."""
        mill = path.partition("/")[0]
        return path, self._sweep_key(mill) if mill in self._swept_mills else None

    def _search(self, path: str) -> Row:
        mill = path.partition("/")[0]
        owners = {
            Why.SWEEP: [sweep.name for sweep in self.config.sweeps],
            Why.SCALE_UP: [self.config.mills.scale_up.mill] if self.config.mills.scale_up else [],
            Why.SET_UP: list(self.config.validation.chosen),
            Why.CARD: list(self.experiments),
            **dict.fromkeys(OF_MILL, [mill] if mill in self._swept_mills else []),
        }
        for why, names in owners.items():
            key = (why, *names, *(self._sweep_key(name) for name in names if why in OF_MILL))
            if key not in self._by_path:
                self._by_path[key] = {row.case.path: row for row in reversed(self.rows(why, *names))}
            if path in self._by_path[key]:
                return self._by_path[key][path]
        raise ConfigError(
            f"{self.config.results.rstrip('/')}/dem/{path}: no such case; neither the sweeps of the configuration nor "
            f"the sweep of mill {mill} contain it"
        )

    def resources(self, case: Case) -> Resources:
        """Threads, time, memory and disk of a case, by the engine of the run."""
        given = case, self.config.dem, self.mills[case.mill], self.contacts[case.contact]
        return lammps_resources(*given) if self.config.dem.engine == "lammps" else resources_of(*given)

    def resources_at(self, path: str) -> Resources:
        """As `resources`, of the case of a folder in results/dem."""
        key = self._place(path)
        if key not in self._resources:
            self._resources[key] = self.resources(self.at(path).case)
        return self._resources[key]

    def processor_s(self, rows: Iterable[Row]) -> int:
        """Processor time that simulations are likely to take [s], for the plan of a run; 0 without any."""
        return math.ceil(sum(self.resources(row.case).processor_s for row in rows))

    def named(self, name: str) -> MillConfig:
        """A mill of the run. Raises ConfigError, in one line that lists the known mills, for another name."""
        if name not in self.mills:
            raise ConfigError(
                f"{self.config.results.rstrip('/')}: unknown mill {name!r}; this run has "
                f"{', '.join(sorted(self.mills))}; --config mill={name} takes config/mills/{name}.yaml"
            )
        return self.mills[name]

    def swept(self, name: str) -> MillConfig:
        """A mill with its own sweep, or the one that is derived from it. Raises ConfigError as `named`."""
        mill = self.named(name)
        if mill.sweep:
            return mill
        return mill.model_copy(update={"sweep": self._derived(name) if self._derived else sweep_of(mill)})

    def variants(self, name: str) -> list[Variant]:
        """The variants of one condition of a mill's sweep that tell whether its settings are good enough."""
        config = self.config
        taken = self.cases(Why.SWEEP, *(sweep.name for sweep in config.sweeps))
        taken = {**self.cases(Why.SET_UP, *config.validation.chosen), **taken}
        contact, study = self.contacts[config.mills.contact_set], config.convergence.study
        return study_variants(self.swept(name), contact, config.mills, config.dem, study, taken)

    def _sweep_key(self, name: str) -> str | None:
        """The sweep of a mill that a job derives, which may differ once that job has run; else None."""
        sweep = None if self.named(name).sweep else self.swept(name).sweep
        return sweep.model_dump_json() if sweep else None

    def _rows(self, why: Why, owner: str) -> list[Row]:
        """The rows of a kind and an owner; each is made once, since every simulation asks for them several times."""
        key = (why, owner, self._sweep_key(owner) if why in OF_MILL else None)
        if key not in self._made:
            found = MAKERS[why](self, owner)
            if why is not Why.SWEEP and self.config.dem.engine == "lammps":
                # LAMMPS records a window of a given length.
                found = [case.model_copy(update={"power_error_max": None, "window_max_s": None}) for case in found]
            place = INSIDE.get(why, "dem/{case.path}")
            self._made[key] = [Row(why, owner, case, place.format(owner=owner, case=case)) for case in found]
        return self._made[key]

    def _samples(self, name: str) -> list[Case]:
        """Those of one job; none for a mill whose sweep is derived during the run, which are not counted before."""
        mill = self.named(name)
        return mean_samples(mill, self.config.mills, self.config.uncertainty) if mill.sweep else []

    def _of_sweep(self, name: str) -> list[Case]:
        (sweep,) = (each for each in self.config.sweeps if each.name == name)
        return expand_sweep(sweep, self.config.dem, self.config.mill)

    def _of_set_up(self, name: str) -> Iterable[Case]:
        return setup_cases(self.config.validation.chosen[name], self.config.dem).values()

    def _in_set_up(self, name: str) -> list[Case]:
        setup = self.config.validation.chosen[name]
        return setup.simulated_inside(self.mills[setup.mill_name]) if setup.mill_name else []

    def contact_of(self, name: str) -> ContactConfig:
        """The contact set of an experiment."""
        return self.contacts[self.experiments[name].contact or self.config.mills.contact_set]

    def _of_card(self, name: str) -> list[Case]:
        """The cases of an experiment: of the sweeps of the configuration, of its mill's own sweep, or its own."""
        experiment, config = self.experiments[name], self.config
        mill, contact = self.mills[experiment.mill], self.contact_of(name)
        swept = self.cases(Why.SWEEP, *(sweep.name for sweep in config.sweeps))
        groups = [described_cases(config, swept).values()]
        if mill.sweep:
            groups.append(self.cases(Why.MILL, mill.name).values())
        return cases_of(experiment, mill, contact, config.mills, groups, str(config.cards.experiments))


# What makes the cases of a kind for an owner.
MAKERS: dict[Why, Callable[[CaseTable, str], Iterable[Case]]] = {
    Why.SWEEP: CaseTable._of_sweep,
    Why.SCALE_UP: lambda table, name: [table._large],
    Why.SET_UP: CaseTable._of_set_up,
    Why.CARD: CaseTable._of_card,
    Why.MILL: lambda table, name: mill_cases(table.swept(name), table.config.mills),
    Why.NEW: lambda table, name: held_out_cases(table.swept(name), table.config.mills),
    Why.STUDY: lambda table, name: [case for each in table.variants(name) for case in each.cases],
    Why.SAMPLE: CaseTable._samples,
    Why.IN_SET_UP: CaseTable._in_set_up,
    Why.ANIMATION: lambda table, name: [animated_case(table.rows(Why.CARD, name)[0].case)],
}


def is_as_built(case: Case) -> bool:
    """Whether a case changes neither mill nor balls."""
    return case.amplitude_mm is None and case.density_kg_m3 is None


def has_chapters(config: WorkflowConfig, cases: dict[str, Case]) -> bool:
    """Whether the configuration has the chapters' sections, and its sweeps simulate the mill that they are about."""
    simulated = {case.mill for case in described_cases(config, cases).values()}
    return config.chapters is not None and config.mill in simulated


def described_cases(config: WorkflowConfig, cases: dict[str, Case]) -> dict[str, Case]:
    """The cases that give descriptors: without snapshots, and with the configured modulus and step.

    Amplitude and density are varied for the fingerprint of the run's own mill: such a case of another mill is left out.
    """
    return {
        path: case
        for path, case in cases.items()
        if case.speed_hz > 0
        and case.snapshot_interval_s is None
        and case.young_modulus_gpa is None
        and case.time_step_s is None
        and (is_as_built(case) or case.mill == config.mill)
    }


def mapped_cases(config: WorkflowConfig, cases: dict[str, Case], contact: str) -> dict[float, str]:
    """Fill ratio to path of the cases that the heat maps of a contact set show: the first seed of each, if any."""
    maps = config.fingerprint.maps
    chosen: dict[float, str] = {}
    if maps is None:
        return chosen
    for path, case in described_cases(config, cases).items():
        if not is_as_built(case):
            continue
        place = (case.mill, case.contact, case.ball_diameter_m, case.speed_hz)
        if (
            place == (config.mill, contact, maps.ball_diameter_mm / 1e3, maps.speed_rpm / 60)
            and case.fill_ratio in maps.fill_ratios
        ):
            chosen.setdefault(case.fill_ratio, path)
    return dict(sorted(chosen.items()))


def fill_of(experiment: Experiment, mill: MillConfig, contact: ContactConfig, place: str) -> float:
    """The fill ratio of an experiment [-]. Raises ConfigError, in one line, for too many balls; place: its file."""
    balls = experiment.balls
    density = balls.density_kg_m3 or contact.density_kg_m3
    try:
        return balls.fill_in(mill.volume_ml, diameter_of(balls.diameter_mm), density)
    except ValueError as error:
        raise ConfigError(f"{place}: balls: {error}") from None


def own_cases(
    experiment: Experiment, mill: MillConfig, contact: ContactConfig, settings: MillsConfig, place: str
) -> list[Case]:
    """A case for each seed, with the settings of a mill's sweep. Raises ConfigError as `fill_of`, and for powder
    that the jar cannot hold.
    """
    powder = experiment.powder
    if powder and powder.mass_g and powder.mass_g > DENSEST_G_ML * mill.volume_ml:
        raise ConfigError(
            f"{place}: powder.mass_g = {powder.mass_g:g}: more than the jar of {mill.volume_ml:g} mL can hold"
        )
    return [
        Case(
            mill=mill.name, contact=contact.name,
            **balls_of(experiment.balls.diameter_mm), fill_ratio=fill_of(experiment, mill, contact, place),
            speed_hz=experiment.hz, seed=seed, density_kg_m3=experiment.balls.density_kg_m3,
            rayleigh_fraction=settings.rayleigh_fraction, settle_s=settings.settle_s,
            **windows_of(mill, experiment.hz, experiment, PRECISIONS["standard"]._replace(seeds=len(experiment.seeds))),
        )
        for seed in experiment.seeds
    ]  # fmt: skip


def cases_of(
    experiment: Experiment,
    mill: MillConfig,
    contact: ContactConfig,
    settings: MillsConfig,
    groups: Iterable[Iterable[Case]],
    place: str,
) -> list[Case]:
    """The cases of an experiment: from the first group that simulates its condition, or the experiment's own.

    groups: the cases of the configuration, then of the mill's own sweep. If these have one seed and the experiment
    several, the experiment's seeds are added.
    """
    fill = fill_of(experiment, mill, contact, place)
    own = own_cases(experiment, mill, contact, settings, place)
    for group in groups:
        if found := [case for case in group if experiment.is_case(case, contact.name, fill)]:
            paths = {case.path for case in found}
            few = len(found) < min(2, len(own))
            return [*found, *(case for case in own if few and case.path not in paths)]
    return own


def animated_case(case: Case) -> Case:
    """The first turns of a case after its balls circulate, with a snapshot for each frame."""
    turn_s = 1 / case.speed_hz
    return case.model_copy(
        update={
            "window_s": TURNS * turn_s,
            "power_error_max": None,
            "window_max_s": None,
            "snapshot_interval_s": turn_s / FRAMES,
        }
    )
