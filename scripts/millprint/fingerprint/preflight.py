"""What must hold between the fingerprint and partition sections, the sweeps and the data, before a job starts."""

import math
from collections.abc import Iterator

from millprint.config.sweep import Case
from millprint.config.workflow import WorkflowConfig
from millprint.errors import ConfigError
from millprint.fingerprint.published import read_published
from millprint.fingerprint.regimes import read_regimes

FEWEST_FILLS = 3  # a master curve needs


def described_cases(cases: dict[str, Case]) -> dict[str, Case]:
    """The cases that descriptors are made of: snapshots or a changed modulus serve other questions."""
    return {
        path: case
        for path, case in cases.items()
        if case.snapshot_interval_s is None and case.young_modulus_gpa is None and case.speed_rpm > 0
    }


def mapped_cases(config: WorkflowConfig, cases: dict[str, Case], contact: str) -> dict[float, str]:
    """Fill ratio to path of the cases that the heat maps of a contact set show: the first seed of each."""
    maps = config.fingerprint.maps
    chosen: dict[float, str] = {}
    for path, case in described_cases(cases).items():
        place = (case.mill, case.contact, case.ball_diameter_mm, case.speed_rpm)
        if (
            place == (config.mill, contact, maps.ball_diameter_mm, maps.speed_rpm)
            and case.fill_ratio in maps.fill_ratios
        ):
            chosen.setdefault(case.fill_ratio, path)
    return dict(sorted(chosen.items()))


def fingerprint_faults(config: WorkflowConfig, cases: dict[str, Case], source: str) -> list[str]:
    """A line for each fault, naming file, key, value and what would be right; none if all holds."""
    return [*_name_faults(config, source), *_sweep_faults(config, cases, source), *_data_faults(config, cases)]


def _name_faults(config: WorkflowConfig, source: str) -> Iterator[str]:
    gap = config.fingerprint.collision_gap_s
    recorded = config.dem.collision_gaps_s
    if not any(math.isclose(gap, other, abs_tol=1e-12) for other in recorded):
        known = ", ".join(f"{other:g}" for other in recorded)
        yield f"{source}: fingerprint.collision_gap_s = {gap:g}: must be one of dem.collision_gaps_s ({known})"
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
    chosen = described_cases(cases).values()
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
