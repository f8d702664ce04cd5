"""Checks that the counting rules of the sections are recorded, before a job starts."""

from collections.abc import Iterator

from millprint.config.workflow import WorkflowConfig


def fingerprint_faults(config: WorkflowConfig, source: str) -> Iterator[str]:
    """A line for each fault, with file, key, value and what to write; none if everything is valid."""
    recorded = [rule.name for rule in config.dem.counting_rules]
    chosen = {
        "fingerprint.counting_rule": [config.fingerprint.counting_rule],
        "mills.counting_rule": [config.mills.rule],
        "convergence.counting_rules": config.convergence.counting_rules,
        "dose.spectra.counting_rules": config.dose.spectra.counting_rules,
    }
    yield from unknown_faults(chosen, recorded, "dem.counting_rules", source)
    thresholds = {rule.name for rule in config.dem.counting_rules if rule.has_threshold}
    for key in ("fingerprint.counting_rule", "mills.counting_rule"):
        for name in thresholds.intersection(chosen[key]):
            yield (
                f"{source}: {key} = {name}: has a threshold, so that energy per collision times frequency would not be "
                "the power; choose a rule with only gap_turns"
            )


def unknown_faults(chosen: dict[str, list[str]], known: list[str], where: str, source: str) -> Iterator[str]:
    """A line for each name, by the key that has it, that is not one of `known`; where: the key that lists those."""
    for key, names in chosen.items():
        for name in names:
            if name not in known:
                yield f"{source}: {key} = {name}: must be one of {where} ({', '.join(known)})"
