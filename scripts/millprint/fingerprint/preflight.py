"""What must hold between the fingerprint and partition sections, the sweeps and the data, before a job starts."""

from collections.abc import Iterator

from millprint.config.sweep import Case
from millprint.config.workflow import WorkflowConfig
from millprint.errors import ConfigError
from millprint.fingerprint.content import read_content
from millprint.fingerprint.curves import FEWEST_FILLS
from millprint.fingerprint.published import read_published
from millprint.fingerprint.regimes import read_regimes


def is_as_built(case: Case) -> bool:
    """Whether a case runs the mill and the balls as they are described."""
    return case.amplitude_mm is None and case.density_kg_m3 is None


def has_chapters(config: WorkflowConfig, cases: dict[str, Case]) -> bool:
    """Whether the sweeps of the configuration simulate the run's mill, so that the chapters can be about it."""
    return any(case.mill == config.mill for case in described_cases(config, cases).values())


def described_cases(config: WorkflowConfig, cases: dict[str, Case]) -> dict[str, Case]:
    """The cases that descriptors are made of: snapshots, a changed modulus or step serve other questions.

    Amplitude and density are varied for the fingerprint of the run's own mill: such a case of another mill is left out.
    """
    return {
        path: case
        for path, case in cases.items()
        if case.speed_rpm > 0
        and case.snapshot_interval_s is None
        and case.young_modulus_gpa is None
        and case.time_step_s is None
        and (is_as_built(case) or case.mill == config.mill)
    }


def mapped_cases(config: WorkflowConfig, cases: dict[str, Case], contact: str) -> dict[float, str]:
    """Fill ratio to path of the cases that the heat maps of a contact set show: the first seed of each."""
    maps = config.fingerprint.maps
    chosen: dict[float, str] = {}
    for path, case in described_cases(config, cases).items():
        if not is_as_built(case):
            continue
        place = (case.mill, case.contact, case.ball_diameter_mm, case.speed_rpm)
        if (
            place == (config.mill, contact, maps.ball_diameter_mm, maps.speed_rpm)
            and case.fill_ratio in maps.fill_ratios
        ):
            chosen.setdefault(case.fill_ratio, path)
    return dict(sorted(chosen.items()))


def fingerprint_faults(config: WorkflowConfig, cases: dict[str, Case], source: str) -> list[str]:
    """A line for each fault, naming file, key, value and what would be right; none if all holds.

    Of a run without chapters the names alone are checked: the rest asks for simulations that it does not have.
    """
    if not has_chapters(config, cases):
        return list(_name_faults(config, source))
    return [
        *_name_faults(config, source),
        *_sweep_faults(config, cases, source),
        *_target_faults(config, source),
        *_data_faults(config, cases),
    ]


def _name_faults(config: WorkflowConfig, source: str) -> Iterator[str]:
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
    inverse = config.fingerprint.inverse
    named = {
        "fingerprint.inverse.contact": [inverse.contact],
        "fingerprint.inverse.contacts": inverse.contacts,
        "partition.contact": [config.partition.contact],
    }
    for key, contacts in named.items():
        for contact in contacts:
            if contact not in config.contacts:
                yield f"{source}: {key} = {contact!r}: must be one of contacts ({', '.join(config.contacts)})"


def _fills(config: WorkflowConfig, cases: dict[str, Case], contact: str) -> list[float]:
    chosen = filter(is_as_built, described_cases(config, cases).values())
    return sorted({case.fill_ratio for case in chosen if (case.mill, case.contact) == (config.mill, contact)})


def _sweep_faults(config: WorkflowConfig, cases: dict[str, Case], source: str) -> Iterator[str]:
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
                f"the fill ratios {config.fingerprint.maps.fill_ratios}"
            )
    fills = _fills(config, cases, config.fingerprint.inverse.contact)
    fixed = config.fingerprint.inverse.fixed_fill_ratio
    if fills and not fills[0] <= fixed <= fills[-1]:
        yield (
            f"{source}: fingerprint.inverse.fixed_fill_ratio = {fixed:g}: must lie within the simulated fill ratios, "
            f"{fills[0]:g} to {fills[-1]:g}"
        )
    fills = _fills(config, cases, config.partition.contact)
    for fill in config.partition.fill_ratios:
        if fills and not fills[0] <= fill <= fills[-1]:
            yield (
                f"{source}: partition.fill_ratios = {fill:g}: must lie within the simulated fill ratios of "
                f"{config.partition.contact}, {fills[0]:g} to {fills[-1]:g}"
            )


def _target_faults(config: WorkflowConfig, source: str) -> Iterator[str]:
    for target in config.fingerprint.inverse.targets:
        if target.like is None:
            continue
        try:
            read_content(target.like.fingerprint)
        except ConfigError as error:
            yield f"{source}: fingerprint.inverse.targets.{target.name}.like: {error}"


def _data_faults(config: WorkflowConfig, cases: dict[str, Case]) -> Iterator[str]:
    for read, path in ((read_published, config.data.published), (read_regimes, config.data.regimes)):
        try:
            table = read(path)
        except ConfigError as error:
            yield str(error)
            continue
        fills = _fills(config, cases, config.partition.contact)
        if read is not read_regimes or not fills:
            continue
        for row, fill in enumerate(table["fill_ratio"], start=1):
            if not fills[0] <= fill <= fills[-1]:
                yield (
                    f"{path}: column fill_ratio, row {row} = {fill:g}: must lie within the simulated fill ratios of "
                    f"{config.partition.contact}, {fills[0]:g} to {fills[-1]:g}"
                )
