"""The step loop: lists brought up to date, forces, records, kick and drift."""

from millprint.dem.layout import COUNTER, STATUS
from millprint.dem.near_candidates import list_near, measure_strides
from millprint.dem.neighbours import check_lists
from millprint.dem.recording import begin_record, count_occupancy, is_due, record, room_left
from millprint.dem.steps import apply_forces, drift, kick
from millprint.dem.threads import apply_forces_in_threads, list_near_in_threads, move_in_threads
from millprint.mill.motion import write_poses
from millprint.run.kernel import inlined, kernel


@inlined()
def can_step(balls, candidates, contacts, laws, walls, clock, time, counters, table, recorder, shares):
    """Pose the bodies and bring the lists up to date; whether the step may be taken: no trouble, and room to write."""
    write_poses(clock.motions, time)
    if counters[COUNTER.check_in] <= 0:
        check_lists(balls, candidates, contacts, laws, walls, clock, counters)
        if counters[COUNTER.status] != STATUS.running:
            return False
        measure_strides(balls, candidates, clock)
        counters[COUNTER.look_in] = 0
    if counters[COUNTER.look_in] <= 0:
        if shares is None:
            list_near(balls, candidates, clock, counters)
        else:
            list_near_in_threads(balls, candidates, clock, counters, shares)
    return room_left(candidates, counters, table, recorder)


@kernel()
def advance(
    balls, candidates, contacts, laws, mark, walls, clock, totals, counters, table, recorder, last_step, shares
):  # fmt: skip
    """Run up to and including step `last_step`, or until a buffer is full or something is wrong.

    Everything is changed in place; counters[COUNTER.step] is the step reached and counters[COUNTER.status] whether it
    may go on. Time is the step's number times the step; the mill starts at step 0.

    mark: laws.registry.mark_of; shares: threads.Shares, one row for each thread, or None for the loop without threads.
    Numba compiles one loop for each combination of types, and leaves out what is None.
    """
    # The same numbers as rows of one line each, which make fast loops.
    rate, rate_now, load = balls.rate.reshape(-1), balls.rate_now.reshape(-1), balls.load.reshape(-1)
    # Between two calls, balls and contacts may have been changed.
    measure_strides(balls, candidates, clock)
    counters[COUNTER.look_in] = 0
    while counters[COUNTER.step] <= last_step and counters[COUNTER.status] == STATUS.running:
        time = counters[COUNTER.step] * clock.step
        if not can_step(balls, candidates, contacts, laws, walls, clock, time, counters, table, recorder, shares):
            break
        since = counters[COUNTER.step] - recorder.origin
        is_recorded = begin_record(contacts, totals, counters, recorder, since)
        if shares is None:
            apply_forces(balls, candidates, contacts, laws, mark, walls, clock, time, totals, counters, table)
        else:
            apply_forces_in_threads(
                balls, candidates, contacts, laws, mark, walls, clock, time, totals, counters, table, shares
            )
        if is_recorded:
            record(balls, candidates, contacts, clock, time, since, totals, counters, recorder)
        if is_due(recorder.occupancy_every, since):
            count_occupancy(balls, clock, recorder)
        if shares is None:
            kick(rate, rate_now, load, clock.gain, clock.fall)
            drift(balls.position, balls.rate, clock.step)
        else:
            move_in_threads(balls, clock.gain, clock.fall, clock.step, shares.counts.shape[0])
        counters[COUNTER.step] += 1
        counters[COUNTER.check_in] -= 1
        counters[COUNTER.look_in] -= 1
