"""What must hold between the fingerprint and partition sections, the sweeps and the data, before a job starts."""

from collections.abc import Iterator

from millprint.config.sweep import Case
from millprint.config.workflow import ChapterSections, WorkflowConfig
from millprint.errors import ConfigError
from millprint.fingerprint.cases import described_cases, has_chapters, is_as_built, mapped_cases
from millprint.fingerprint.curves import FEWEST_FILLS
from millprint.fingerprint.inputs import read_content
from millprint.fingerprint.published import read_published
from millprint.fingerprint.regimes import read_regimes


def fingerprint_faults(config: WorkflowConfig, cases: dict[str, Case], source: str) -> list[str]:
    """A line for each fault, naming file, key, value and what would be right; none if all holds.

    Of a run without chapters the names alone are checked: the rest asks for simulations that it does not have.
    """
    chapters = config.chapters
    faults = [*_rule_faults(config, source)]
    if chapters:
        faults += _contact_faults(config, chapters, source)
    if chapters and has_chapters(config, cases):
        faults += _sweep_faults(config, chapters, cases, source)
        faults += _target_faults(chapters, source)
        faults += _data_faults(config, chapters, cases)
    return faults


def _rule_faults(config: WorkflowConfig, source: str) -> Iterator[str]:
    recorded = [rule.name for rule in config.dem.counting_rules]
    wanted = {
        "fingerprint.counting_rule": [config.fingerprint.counting_rule],
        "convergence.counting_rules": config.convergence.counting_rules,
    }
    for key, names in wanted.items():
        for name in names:
            if name not in recorded:
                yield f"{source}: {key} = {name}: must be one of dem.counting_rules ({', '.join(recorded)})"
    for rule in config.dem.counting_rules:
        if rule.name == config.fingerprint.counting_rule and (rule.peak_force_min_N or rule.duration_min_s):
            yield (
                f"{source}: fingerprint.counting_rule = {rule.name}: has a threshold, so that energy per collision "
                "times frequency would not be the power; a rule with gap_s alone is wanted"
            )


def _contact_faults(config: WorkflowConfig, chapters: ChapterSections, source: str) -> Iterator[str]:
    named = {
        "fingerprint.inverse.contact": [chapters.inverse.contact],
        "fingerprint.inverse.contacts": chapters.inverse.contacts,
        "partition.contact": [chapters.partition.contact],
    }
    for key, contacts in named.items():
        for contact in contacts:
            if contact not in config.contacts:
                yield f"{source}: {key} = {contact!r}: must be one of contacts ({', '.join(config.contacts)})"


def _fills(config: WorkflowConfig, cases: dict[str, Case], contact: str) -> list[float]:
    chosen = filter(is_as_built, described_cases(config, cases).values())
    return sorted({case.fill_ratio for case in chosen if (case.mill, case.contact) == (config.mill, contact)})


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
    fills = _fills(config, cases, chapters.inverse.contact)
    fixed = chapters.inverse.fixed_fill_ratio
    if fills and not fills[0] <= fixed <= fills[-1]:
        yield (
            f"{source}: fingerprint.inverse.fixed_fill_ratio = {fixed:g}: must lie within the simulated fill ratios, "
            f"{fills[0]:g} to {fills[-1]:g}"
        )
    fills = _fills(config, cases, chapters.partition.contact)
    for fill in chapters.partition.fill_ratios:
        if fills and not fills[0] <= fill <= fills[-1]:
            yield (
                f"{source}: partition.fill_ratios = {fill:g}: must lie within the simulated fill ratios of "
                f"{chapters.partition.contact}, {fills[0]:g} to {fills[-1]:g}"
            )


def _target_faults(chapters: ChapterSections, source: str) -> Iterator[str]:
    for target in chapters.inverse.targets:
        if target.like is None:
            continue
        try:
            read_content(target.like.fingerprint)
        except ConfigError as error:
            yield f"{source}: fingerprint.inverse.targets.{target.name}.like: {error}"


def _data_faults(config: WorkflowConfig, chapters: ChapterSections, cases: dict[str, Case]) -> Iterator[str]:
    for read, path in ((read_published, chapters.data.published), (read_regimes, chapters.data.regimes)):
        try:
            table = read(path)
        except ConfigError as error:
            yield str(error)
            continue
        fills = _fills(config, cases, chapters.partition.contact)
        if read is not read_regimes or not fills:
            continue
        for row, fill in enumerate(table["fill_ratio"], start=1):
            if not fills[0] <= fill <= fills[-1]:
                yield (
                    f"{path}: column fill_ratio, row {row} = {fill:g}: must lie within the simulated fill ratios of "
                    f"{chapters.partition.contact}, {fills[0]:g} to {fills[-1]:g}"
                )
