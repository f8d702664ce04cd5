"""What of the thesis would fail in a job is refused before anything runs."""

from collections.abc import Iterator

import pandas as pd

from millprint.cases.table import described_cases, has_chapters, is_as_built, mapped_cases
from millprint.config.contact_set import ContactConfig
from millprint.config.errors import ConfigError
from millprint.config.included import SOURCES
from millprint.config.mill import MillConfig
from millprint.config.mill_sweep import FEWEST_FILLS
from millprint.config.surrogate import SurrogateConfig
from millprint.config.sweep import Case
from millprint.config.workflow import ChapterSections, WorkflowConfig
from millprint.dose.wear import read_materials
from millprint.fingerprint.sweep_checks import unknown_faults
from millprint.run.tables import Text, read_measured
from millprint.thesis.claims.conclusions import read_conclusions, read_stored
from millprint.thesis.claims.evidence import BASES, NATURES
from millprint.thesis.doe.chemistry import check_formulas, read_literature, read_reported_yields
from millprint.thesis.doe.factorial_designs import read_runs
from millprint.thesis.doe.wet_lab import read_wear
from millprint.thesis.drop import make_swing, read_heights, read_track
from millprint.thesis.fit import fitted_mill
from millprint.thesis.fit.jar_search import published_values, with_roles
from millprint.thesis.regimes import read_published, read_regimes
from millprint.thesis.yields.experiments import (
    check_folds,
    check_region,
    check_yield_tables,
    read_experiments,
    read_other_runs,
    read_parts,
    read_rows,
    with_other_runs,
)


def calibration_faults(
    config: WorkflowConfig, mills: dict[str, MillConfig], contacts: dict[str, ContactConfig]
) -> Iterator[str]:
    """A line for each fault; none if everything is valid, or if nothing is calibrated."""
    settings, fraction = config.calibration, config.dem.rayleigh_fraction_max
    if settings is None:
        return
    checks = [(read_heights, settings.drop_test.measured)] if settings.drop_test.measured else []
    checks += [(read_track, test.track) for test in settings.oscillation.experiments if test.track]
    for read, path in checks:
        try:
            read(path)
        except ConfigError as error:
            yield str(error)
    for test in settings.oscillation.experiments:
        for name in dict.fromkeys(test.mills(config.mill).values()):
            diameter = test.ball_diameter_mm * 1e-3
            try:
                make_swing(mills[name], contacts[test.contact], fraction, diameter, settings.oscillation)
            except ConfigError as error:
                yield str(error)


def curve_faults(config: WorkflowConfig, cases: dict[str, Case], source: str) -> list[str]:
    """A line for each fault, with file, key, value and what would be right; none if everything is valid.

    Without all simulations of the chapters only the names of contact sets are checked.
    """
    chapters = config.chapters
    if not chapters:
        return []
    faults = list(_contact_faults(config, chapters, source))
    if has_chapters(config, cases):
        faults += _charge_faults(config, cases, source)
        faults += _sweep_faults(config, chapters, cases, source)
        faults += _target_faults(chapters, source)
        faults += _data_faults(config, chapters, cases)
    return faults


def _contact_faults(config: WorkflowConfig, chapters: ChapterSections, source: str) -> Iterator[str]:
    chosen = {
        "fingerprint.inverse.contact": [chapters.inverse.contact],
        "fingerprint.inverse.contacts": chapters.inverse.contacts,
        "partition.contact": [chapters.partition.contact],
    }
    yield from unknown_faults(chosen, config.contacts, "contacts", source)


def _charge_faults(config: WorkflowConfig, cases: dict[str, Case], source: str) -> Iterator[str]:
    """A fault for each charge of several sizes among the conditions of the chapters."""
    names = {case.mixture.name for case in described_cases(config, cases).values() if case.mixture}
    for name in sorted(names):
        yield (
            f"{source}: sweeps: ball_diameters_mm: charge {name}: the chapters of the thesis compare balls of one "
            "size; simulate it in the sweep of a mill, for results/mills, or with snapshots"
        )
    for choice in config.fingerprint.inverse.ball_diameters_mm if config.fingerprint.inverse else []:
        if isinstance(choice, str):
            yield (
                f"{source}: fingerprint.inverse.ball_diameters_mm = {choice}: the chapters of the thesis compare balls "
                "of one size; give a number"
            )


def _fills(config: WorkflowConfig, cases: dict[str, Case], contact: str) -> list[float]:
    """The fill ratios at which the run's mill is simulated as built with a contact set, in order."""
    chosen = filter(is_as_built, described_cases(config, cases).values())
    return sorted({case.fill_ratio for case in chosen if (case.mill, case.contact) == (config.mill, contact)})


def _fill_faults(place: str, fill: float, fills: list[float], contact: str) -> Iterator[str]:
    """A fault if a fill ratio is outside the simulated ones; place: its file and key."""
    if fills and not fills[0] <= fill <= fills[-1]:
        yield (
            f"{place} = {fill:g}: must lie within the simulated fill ratios of {contact}, {fills[0]:g} to {fills[-1]:g}"
        )


def _sweep_faults(
    config: WorkflowConfig, chapters: ChapterSections, cases: dict[str, Case], source: str
) -> Iterator[str]:
    for contact in config.contacts:
        fills = _fills(config, cases, contact)
        if len(fills) < FEWEST_FILLS:
            yield (
                f"{source}: sweeps: mill {config.mill} with contact set {contact} has {len(fills)} fill ratio(s); "
                f"master curves need at least {FEWEST_FILLS}"
            )
        elif not mapped_cases(config, cases, contact):
            yield (
                f"{source}: fingerprint.maps: no case of {contact} in sweeps has this ball diameter, speed and one of "
                f"the fill ratios {chapters.maps.fill_ratios}"
            )
    inverse, partition = chapters.inverse, chapters.partition
    fills = _fills(config, cases, inverse.contact)
    key = f"{source}: fingerprint.inverse.fixed_fill_ratio"
    yield from _fill_faults(key, inverse.fixed_fill_ratio, fills, inverse.contact)
    fills = _fills(config, cases, partition.contact)
    for fill in partition.fill_ratios:
        yield from _fill_faults(f"{source}: partition.fill_ratios", fill, fills, partition.contact)


def _target_faults(chapters: ChapterSections, source: str) -> Iterator[str]:
    for target in chapters.inverse.targets:
        try:
            if target.like:
                # Its processes bring scikit-learn, a second to import, and few targets name another fingerprint.
                from millprint.fingerprint.model import Fingerprint

                Fingerprint.read(target.like.fingerprint).balls(target.like.ball_diameter_mm)
        except ConfigError as error:
            yield f"{source}: fingerprint.inverse.targets.{target.name}.like: {error}"


def _data_faults(config: WorkflowConfig, chapters: ChapterSections, cases: dict[str, Case]) -> Iterator[str]:
    contact, path = chapters.partition.contact, chapters.data.regimes
    try:
        read_published(chapters.data.published, chapters.data.claims)
    except ConfigError as error:
        yield str(error)
    try:
        table = read_regimes(path)
    except ConfigError as error:
        yield str(error)
        return
    fills = _fills(config, cases, contact)
    for row, fill in enumerate(table["fill_ratio"], start=1):
        yield from _fill_faults(f"{path}: column fill_ratio, row {row}", fill, fills, contact)


def fit_faults(config: WorkflowConfig, mills: dict[str, MillConfig], source: str) -> list[str]:
    """A line for each fault, with file, key, value and what would be right; none if nothing is fitted."""
    fit, data, faults = config.fit, config.data, []
    if fit is None or data is None or fitted_mill(config, mills) is None:
        return []
    search = fit.search
    if search.contact not in config.contacts:
        faults.append(f"{source}: contacts = {config.contacts}: must hold {search.contact}, as there is a section fit")
    free = [rule.name for rule in config.dem.counting_rules if not rule.has_threshold]
    for name in search.counting_rules:
        if name not in free:
            faults.append(
                f"{source}: dem.counting_rules: must hold {name}, without a threshold, as there is a section fit; "
                f"without a threshold: {', '.join(free)}"
            )
    try:
        with_roles(published_values(read_published(data.published, data.claims), search.contact), search.fitted)
    except ConfigError as error:
        faults.append(f"{source}: {error}")
    return faults


def _fault_of(case: Case | None, from_s: float, until_s: float) -> str | None:
    """What keeps a case from having snapshots from `from_s` to `until_s` [s] of motion; None where nothing does."""
    if case is None:
        return "is in no sweep; add a sweep with snapshot_interval_s"
    if case.snapshot_interval_s is None:
        return "records no snapshots: its sweep needs snapshot_interval_s"
    if case.mixture:
        return f"has balls of several sizes (charge {case.mixture.name}); the surrogate knows balls of one size"
    if case.discard_s > from_s + 1e-9:
        begin = f"{case.discard_s:g} s of motion on: they are needed from {from_s:g} s"
        return f"has snapshots from {begin} (its sweep's discard_s)"
    duration_s = case.discard_s + case.window_s
    if duration_s < until_s - 1e-9:
        return f"moves for {duration_s:g} s: it needs at least {until_s:g} s (its sweep's discard_s + window_s)"
    return None


def check_surrogate_cases(config: SurrogateConfig, cases: dict[str, Case], source: str) -> None:
    """Check that the sweeps simulate what the surrogate reads.

    Raises ConfigError for a case that no sweep has, that records no snapshots, or that begins too late or ends too
    early, for a twin that has no disturbance at the start, and for a `long_step` case that does not set a step.
    """
    for path, (from_s, until_s) in config.simulated_cases().items():
        fault = _fault_of(cases.get(path), from_s, until_s)
        if fault:
            raise ConfigError(f"{source}: surrogate: case {path} {fault}")
    for name, test in config.tests.items():
        if test.long_step and cases[test.long_step].time_step_s is None:
            raise ConfigError(
                f"{source}: surrogate.tests.{name}.long_step: {test.long_step} has no step of its own: its sweep needs "
                "time_steps_s"
            )
        twin = cases[test.twin] if test.twin else None
        if twin and not (twin.disturbance_m and abs(twin.discard_s - test.starts_s[0]) < 1e-9):
            raise ConfigError(
                f"{source}: surrogate.tests.{name}.twin: {test.twin} is not disturbed at {test.starts_s[0]:g} s: its "
                "sweep needs disturbances_m above 0, and that time as discard_s"
            )


def chapter_faults(
    config: WorkflowConfig,
    mills: dict[str, MillConfig],
    contacts: dict[str, ContactConfig],
    cases: dict[str, Case],
    source: str,
) -> list[str]:
    """A line for each fault of the chapters' sections; raises ConfigError for a table that cannot be read."""
    faults, chapters = curve_faults(config, cases, source), config.chapters
    if chapters and has_chapters(config, cases):
        check_tables(chapters, source)
        read_materials(config.dose.wear.materials, config.dose.wear.material)
        check_surrogate_cases(chapters.surrogate, cases, source)
        faults += [*calibration_faults(config, mills, contacts), *fit_faults(config, mills, source)]
    return faults


def check_tables(config: ChapterSections, source: str) -> None:
    """Check every measured table, and the formulas of the reaction."""
    check_formulas(config.doe.chemistry, f"{source}: doe.chemistry")
    read_runs(config.data.screening, config.doe.factors, positive=["bpr", "molar_ratio"])
    read_wear(config.data.wear)
    check_claims(config)
    read_literature(SOURCES.find(config.doe.literature))
    read_reported_yields(SOURCES.find(config.doe.literature_yields))
    check_yield_tables(config.yields, config.data.screening, config.data.split, config.doe, source)
    regimes = read_regimes(config.data.regimes)
    check_other_sources(config, regimes, source)
    proposals, published = config.yields.proposals, config.yields.proposals.curves == "published"
    if published:
        check_region(proposals.region, regimes, source)
    if proposals.experiments:
        runs = read_runs(config.data.screening, config.doe.factors)["case"]
        read_experiments(proposals.experiments, regimes if published else None, [*runs.astype(str), *regimes["case"]])


def check_claims(config: ChapterSections) -> None:
    """Check what the claims are, what rests on them, and their verdicts on other machines."""
    columns = [Text("id", unique=True), Text("nature", list(NATURES)), Text("basis", list(BASES))]
    claims = read_measured(config.data.claims, columns)
    read_conclusions(SOURCES.find(config.data.conclusions), claims["id"])
    read_stored(SOURCES.find(config.data.verdicts))


def check_other_sources(config: ChapterSections, regimes: pd.DataFrame, source: str) -> None:
    """Check the table of others' runs, and that every source leaves enough runs to train on."""
    own = pd.concat(read_parts(config.data.screening, config.data.split, config.doe.factors), ignore_index=True)
    taken = {
        config.data.screening: own["case"],
        config.data.regimes: regimes["case"],
        config.yields.out_of_domain: read_rows(config.yields.out_of_domain)["case"],
    }
    settings = config.yields.other_sources
    others = read_other_runs(settings, taken, source)
    check_folds(with_other_runs(own, others, settings.own), config.yields.evaluation.folds, source)
