"""Checks the sections of chapters 3 and 4 against the sweeps and the data, before a job starts."""

from collections.abc import Iterator

from millprint.config.errors import ConfigError
from millprint.config.sweep import Case
from millprint.config.workflow import ChapterSections, WorkflowConfig
from millprint.fingerprint.cases import described_cases, has_chapters, is_as_built, mapped_cases
from millprint.fingerprint.descriptors import FEWEST_FILLS
from millprint.fingerprint.rule_checks import unknown_faults
from millprint.thesis.curves.published import read_published
from millprint.thesis.curves.regimes import read_regimes


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
