"""How long jobs take on some cores: each starts as soon as its inputs are made and enough cores are free."""

import heapq
from collections.abc import Sequence
from dataclasses import dataclass

from millprint.plan.jobs import PlannedJob


@dataclass(frozen=True)
class Timetable:
    """wall_s: from the first job to the end of the last [s]; memory_mb: the most that jobs hold at the same time."""

    wall_s: float
    memory_mb: float


def timetable(
    jobs: Sequence[PlannedJob], seconds: dict[int, float], memory_mb: dict[int, float], cores: int
) -> Timetable:
    """Run the jobs of which `seconds` has a time, by place in `jobs`, on `cores` cores.

    Of the jobs that may start, the one with the longest chain of jobs behind it starts first. memory_mb: of each.
    A job with several threads holds as many cores, and `seconds` is its time on all of them.
    """
    waiting = {place: sum(before in seconds for before in jobs[place].after) for place in seconds}
    behind: dict[int, list[int]] = {place: [] for place in seconds}
    for place in seconds:
        for before in jobs[place].after:
            if before in seconds:
                behind[before].append(place)
    chain = _chains(seconds, behind, waiting)
    ready = [(-chain[place], place) for place, count in waiting.items() if not count]
    heapq.heapify(ready)
    running: list[tuple[float, int]] = []
    now, free, held, most = 0.0, cores, 0.0, 0.0
    while ready or running:
        later = []
        while ready and free:
            first = heapq.heappop(ready)
            place = first[1]
            threads = min(jobs[place].threads, cores)
            if threads > free:
                later.append(first)
                continue
            free, held = free - threads, held + memory_mb[place]
            most = max(most, held)
            heapq.heappush(running, (now + seconds[place], place))
        for each in later:
            heapq.heappush(ready, each)
        now, place = heapq.heappop(running)
        free, held = free + min(jobs[place].threads, cores), held - memory_mb[place]
        for after in behind[place]:
            waiting[after] -= 1
            if not waiting[after]:
                heapq.heappush(ready, (-chain[after], after))
    return Timetable(now, most)


def _chains(seconds: dict[int, float], behind: dict[int, list[int]], waiting: dict[int, int]) -> dict[int, float]:
    """The time of the longest chain of jobs that begins with each job [s]."""
    left = dict(waiting)
    order = [place for place, count in left.items() if not count]
    for place in order:
        for after in behind[place]:
            left[after] -= 1
            if not left[after]:
                order.append(after)
    chain: dict[int, float] = {}
    for place in reversed(order):
        chain[place] = seconds[place] + max((chain[after] for after in behind[place]), default=0.0)
    return chain
