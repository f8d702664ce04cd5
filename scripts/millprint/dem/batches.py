"""Short simulations that share a job: starting Python takes longer than many of them.

Each case of a job keeps its own log, restart file and failure, as the seeds of a condition do (millprint.dem.seeds).
"""

from collections.abc import Callable, Mapping

from millprint.config.sweep import Case
from millprint.dem.resources import Resources
from millprint.dem.seeds import condition_of

# The longest cases of a job together [s], by the estimate of millprint.dem.resources: some four times what they take.
# So whoever wants one of them waits for a quarter of a minute, and several cores end together.
BATCH_S = 60
# A condition that takes more has a job of its own.
CONDITION_S = 25


def short_batches(
    sources: Mapping[str, Mapping[str, Case]], estimate: Callable[[Case], Resources]
) -> dict[str, list[Case]]:
    """Cases that share a job, by the name of their source and a number: all seeds of several short conditions.

    sources: cases by path that are wanted together, such as all sweeps of a configuration. A path counts in the first
    source that has it. A condition without another to share a job with is in no list.
    """
    known: set[str] = set()
    found = {}
    for name, cases in sources.items():
        conditions: dict[str, list[Case]] = {}
        for path, case in cases.items():
            # A disturbed twin is compared with one run, so that often only one of its seeds is wanted.
            if path not in known and not case.disturbance_m:
                conditions.setdefault(condition_of(case), []).append(case)
        known.update(cases)
        filled: list[list[list[Case]]] = []
        left = 0.0
        for own in conditions.values():
            each = [estimate(case) for case in own]
            seconds = sum(one.seconds for one in each)
            if seconds > CONDITION_S or any(one.needs_own_job for one in each):
                continue
            if seconds > left:
                filled.append([])
                left = BATCH_S
            filled[-1].append(own)
            left -= seconds
        shared = [[case for own in batch for case in own] for batch in filled if len(batch) > 1]
        found.update({f"{name}_{number}": batch for number, batch in enumerate(shared, start=1)})
    return found
