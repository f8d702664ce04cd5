"""Whether the sweeps simulate what the surrogate stage reads."""

from millprint.config.errors import ConfigError
from millprint.config.surrogate import SurrogateConfig
from millprint.config.sweep import Case


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
