"""The step loop: lists brought up to date, forces, records, kick and drift; with threads in a large simulation.

Velocities live half a step before positions (leapfrog). Forces need them now, so each ball also carries the velocity
expected now, the last one plus half a step of the last acceleration; it differs from the mean of the two half-step
velocities, with which a kick does its work, by the square of the step. Tangential springs grow by the trapezoidal
rule. So the energy balance closes with the square of the step.

Each thread takes one chunk and adds the forces of its contacts to loads of its own, the first one to those of the
balls; they are then summed in the order of the chunks. So a run depends only on the number of chunks, by rounding: not
on which thread comes first, nor on how many the machine has. Contacts open and close in one thread, in the order of the
serial loop.

A loop over `prange` does not accept nested tuples of arrays, so the parts of a clock are passed separately.
"""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from typing import NamedTuple

import numba
import numpy as np

from millprint.dem import state
from millprint.dem.contact_events import (
    FAR,
    close_contact,
    find_pairs,
    near_pairs_listed,
    open_contacts,
    open_pairs,
    open_walls,
    pairs_listed,
    share_resistance,
    wall_away,
)
from millprint.dem.law import SHARE_EVERY, evaluate, get, get_present, get_vector, put_present
from millprint.dem.layout import (
    COUNTER,
    GROUP,
    GROUPED_TO,
    LANE,
    LANES,
    LOAD,
    LOAD_WIDTH,
    PRESENT,
    SHARE,
    STATUS,
    TOTAL,
)
from millprint.dem.neighbours import check_lists, is_near, list_near, list_near_walls, measure_strides, squares_apart
from millprint.dem.recording import begin_record, count_occupancy, is_due, record, room_left
from millprint.mill.motion import POSE, write_poses
from millprint.mill.vectors import cross, dot, row, scale, subtract, vector
from millprint.mill.walls import body_of, wall_velocity
from millprint.run.cache_lines import CACHE_LINE_BYTES
from millprint.run.kernel import inlined, inner, kernel, merged, threaded
from millprint.run.machine import WAIT_POLICY


@inlined()
def add_to_row(array, i, vector):
    """Add a vector to row i of an array."""
    for c in range(3):
        array[i, c] += vector[c]


@merged()
def gather_pair(balls, contacts, present, lane, block, at, m):
    """Put the state of two balls into their lane; returns whether they still touch."""
    i, j = contacts.ball[lane], np.uint32(contacts.partner[lane])
    away = subtract(row(balls.position, i), row(balls.position, j))
    reach = get(contacts.lanes, block, LANE.law.reach, m)
    put_present(present, at, PRESENT.away, m, away)
    velocity = subtract(row(balls.velocity_now, i), row(balls.velocity_now, j))
    put_present(present, at, PRESENT.velocity, m, velocity)
    put_present(present, at, PRESENT.angular_velocity, m, row(balls.angular_velocity_now, i))
    put_present(present, at, PRESENT.other_angular_velocity, m, row(balls.angular_velocity_now, j))
    return dot(away, away) < reach * reach


@merged()
def gather_wall(balls, candidates, contacts, present, walls, motions, lane, block, at, m):
    """Put the state of a ball and the wall that it touches into their lane; returns whether they still touch."""
    i, body = contacts.ball[lane], body_of(walls, -1 - contacts.partner[lane])
    reach = get(contacts.lanes, block, LANE.law.reach, m)
    position = row(balls.position, i)
    away = wall_away(walls, candidates, motions, np.uint32(contacts.slot[lane]), body, position, reach)
    put_present(present, at, PRESENT.away, m, away)
    velocity = subtract(row(balls.velocity_now, i), wall_velocity(motions, body, subtract(position, away)))
    put_present(present, at, PRESENT.velocity, m, velocity)
    put_present(present, at, PRESENT.angular_velocity, m, row(balls.angular_velocity_now, i))
    turning = vector(motions.pose, body, POSE.angular_velocity)
    put_present(present, at, PRESENT.other_angular_velocity, m, turning)
    return away[0] < FAR


@merged()
def gather(balls, candidates, contacts, present, walls, motions, lane, block, at, m):
    """Put the state of both partners into their lane of present row `at`; returns whether they still touch."""
    if contacts.partner[lane] >= 0:
        return gather_pair(balls, contacts, present, lane, block, at, m)
    return gather_wall(balls, candidates, contacts, present, walls, motions, lane, block, at, m)


@merged()
def load_body(walls, motions, load, position, away, feature, force, back):
    """Add the force [N] of a body on a ball, and its torque about the body's origin [N m], to the body's loads.

    The torque does work only on a body that turns, and is left out for the others.
    """
    body = body_of(walls, feature)
    for c in range(3):
        load[body, LOAD.force.x + c] += force[c]
    if motions.turns[body]:
        arm = subtract(subtract(position, away), row(motions.pose, body))
        torque = subtract(cross(arm, force), back)
        for c in range(3):
            load[body, LOAD.torque.x + c] += torque[c]


@merged()
def scatter(balls, contacts, present, walls, motions, forces, torques, body_load, lane, block, at, m):
    """Add the forces of a lane to its partners: to forces and torques (n, 3) of balls, loads (bodies, 6) of bodies."""
    i, j = contacts.ball[lane], contacts.partner[lane]
    force = get_vector(contacts.lanes, block, LANE.force, m)
    back = get_present(present, at, PRESENT.other_torque, m)
    add_to_row(forces, i, force)
    add_to_row(torques, i, get_present(present, at, PRESENT.torque, m))
    if j >= 0:
        add_to_row(forces, np.uint32(j), scale(-1.0, force))
        add_to_row(torques, np.uint32(j), back)
    else:
        away = get_present(present, at, PRESENT.away, m)
        load_body(walls, motions, body_load, row(balls.position, i), away, -1 - j, force, back)


@inlined()
def width_in_use(counters, block):
    """Number of lanes of a block that have been in use."""
    return np.uint64(min(LANES, counters[COUNTER.used] - block * LANES))


@inlined()
def blocks_in_use(counters):
    """The number of blocks of lanes that have been in use."""
    return (counters[COUNTER.used] + LANES - 1) // LANES


@merged()
def gather_open(balls, candidates, contacts, laws, walls, clock, block, at, time, totals, counters, table):
    """Gather the contacts of a block that still touch; the others are closed."""
    first = np.uint64(block * LANES)
    for m in range(width_in_use(counters, block)):
        lane = first + m
        if contacts.slot[lane] < 0:
            continue
        if not gather(balls, candidates, contacts, contacts.present, walls, clock.motions, lane, block, at, m):
            close_contact(balls, candidates, contacts, laws, walls, np.int64(lane), time, totals, counters, table)


@merged()
def scatter_open(balls, contacts, walls, clock, counters, block, at):
    """Add the forces of the open contacts of a block to their partners."""
    first = np.uint64(block * LANES)
    for m in range(width_in_use(counters, block)):
        if contacts.slot[first + m] >= 0:
            scatter(
                balls, contacts, contacts.present, walls, clock.motions, balls.force, balls.torque, clock.load,
                first + m, block, at, m,
            )  # fmt: skip


@merged()
def resolve_blocks(balls, candidates, contacts, laws, mark, walls, clock, begin, end, time, totals, counters, table):
    """The contacts of blocks begin to end: those that have parted are closed, the others act on their partners."""
    for block in range(begin, end):
        at = block - begin
        gather_open(balls, candidates, contacts, laws, walls, clock, block, at, time, totals, counters, table)
    evaluate(mark, contacts.lanes, contacts.present, begin, end, clock.step)
    for block in range(begin, end):
        scatter_open(balls, contacts, walls, clock, counters, block, block - begin)


@inlined()
def book_wall_work(clock, totals):
    """Add the work of every body in this step, force . V + torque . omega, and clear the loads."""
    pose, load = clock.motions.pose, clock.load
    for body in range(load.shape[0]):
        for c in range(3):
            totals[TOTAL.wall_work_J] += clock.step * load[body, LOAD.force.x + c] * pose[body, POSE.velocity.x + c]
        for c in range(3):
            turning = pose[body, POSE.angular_velocity.x + c]
            totals[TOTAL.wall_work_J] += clock.step * load[body, LOAD.torque.x + c] * turning
        for c in range(LOAD_WIDTH):
            load[body, c] = 0.0


@inlined()
def apply_forces(balls, candidates, contacts, laws, mark, walls, clock, time, totals, counters, table):
    """Contact forces and torques on every ball at the present positions; energies go to `totals` and the histories."""
    open_contacts(balls, candidates, contacts, laws, walls, clock, time, totals, counters, table)
    blocks = blocks_in_use(counters)
    group = GROUP if blocks <= GROUPED_TO else 1
    for begin in range(0, blocks, group):
        end = min(begin + group, blocks)
        resolve_blocks(balls, candidates, contacts, laws, mark, walls, clock, begin, end, time, totals, counters, table)
    book_wall_work(clock, totals)


@inlined()
def change_by(speed, speed_now, load, c, gain, fall):
    """A number of a velocity half a step on, and the one expected at the next position; its load is cleared."""
    change = load[c] * gain
    if fall is not None:
        change += fall[c]
    faster = speed[c] + change
    speed[c] = faster
    speed_now[c] = faster + 0.5 * change
    load[c] = 0.0


@inlined()
def kick(speed, speed_now, load, gain, fall):
    """Velocities a step on, in rows of numbers; fall is None for those that gravity does not change.

    A single gain has a loop of its own, which reads an array less.
    """
    if gain.size == 1:
        for c in range(speed.size):
            change_by(speed, speed_now, load, c, gain[0], fall)
    else:
        for c in range(speed.size):
            change_by(speed, speed_now, load, c, gain[c], fall)


@inlined()
def drift(position, velocity, step):
    """Positions a step on, in rows of numbers."""
    for c in range(position.size):
        position[c] += step * velocity[c]


@inlined()
def numbers_of(balls, begin, end):
    """What moves of balls begin to end, each as one row of numbers, which make fast loops."""
    a, b = 3 * begin, 3 * end
    return (
        balls.position.reshape(-1)[a:b],
        (balls.velocity.reshape(-1)[a:b], balls.velocity_now.reshape(-1)[a:b], balls.force.reshape(-1)[a:b]),
        (
            balls.angular_velocity.reshape(-1)[a:b],
            balls.angular_velocity_now.reshape(-1)[a:b],
            balls.torque.reshape(-1)[a:b],
        ),
    )


@inlined()
def move(numbers, gain, turning, fall, step):
    """Kick and drift."""
    position, (velocity, velocity_now, force), (angular, angular_now, torque) = numbers
    kick(velocity, velocity_now, force, gain, fall)
    drift(position, velocity, step)
    kick(angular, angular_now, torque, turning, None)


class Shares(NamedTuple):
    """The arrays of each of `threads` chunks."""

    found: np.ndarray  # (threads, candidates + 1) pairs that have come within reach in the present step
    waiting: np.ndarray  # (threads, blocks) blocks of lanes in which a contact has parted
    counts: np.ndarray  # (threads, numbers of a cache line) layout.ShareColumns; no two threads write to one line
    present: np.ndarray  # (threads, 1, width * LANES) layout.PresentColumns
    force: np.ndarray  # (threads - 1, n, 3) as Balls.force, of the present step; the first has the balls' own
    torque: np.ndarray  # (threads - 1, n, 3)
    body_load: np.ndarray  # (threads, bodies, width) as Clock.load


def make_shares(
    threads: int, balls: int, bodies: int, candidates: state.Candidates, contacts: state.Contacts
) -> Shares:
    """Empty shares; candidates and contacts that are made longer need new ones."""
    return Shares(
        found=np.zeros((threads, candidates.found.size), dtype=np.uint32),
        waiting=np.zeros((threads, len(contacts.lanes)), dtype=np.int64),
        counts=np.zeros((threads, CACHE_LINE_BYTES // 8), dtype=np.int64),
        present=state.make_present(threads)[:, np.newaxis],
        force=np.zeros((threads - 1, balls, 3)),
        torque=np.zeros((threads - 1, balls, 3)),
        body_load=np.zeros((threads, bodies, LOAD_WIDTH)),
    )


@contextmanager
def _waiting_awake() -> Iterator[None]:
    """Let threads started in this context wait actively for some milliseconds before they sleep.

    Every job has OMP_WAIT_POLICY=PASSIVE (millprint.run.machine), with which threads sleep at once. A step wakes them
    four or five times, and with 20,000 balls two such threads took longer than one.
    """
    policy = os.environ.pop(WAIT_POLICY, None)
    try:
        yield
    finally:
        if policy is not None:
            os.environ[WAIT_POLICY] = policy


@contextmanager
def use_threads(threads: int) -> Iterator[None]:
    """Let loops run in up to `threads` threads; where the process has been given fewer, in those, with equal results.

    A nested call keeps the number it was given; the number is restored at the end.
    """
    with _waiting_awake():
        # Numba starts its threads at the first call.
        given = numba.get_num_threads()
    numba.set_num_threads(min(threads, given))
    try:
        yield
    finally:
        numba.set_num_threads(given)


@inlined()
def chunk(whole, t, threads):
    """Where chunk t of `threads` begins and ends in `whole` things."""
    return whole * t // threads, whole * (t + 1) // threads


@inner()
def look_chunk(balls, candidates, nearer, shares, t):
    """Pairs of one chunk of the candidates that are nearer to contact than `nearer` [m]."""
    begin, end = chunk(np.int64(pairs_listed(candidates)), t, shares.counts.shape[0])
    more, found, count = squares_apart(balls, nearer), shares.found[t], np.uint64(0)
    for k in range(np.uint64(begin), np.uint64(end)):
        near = is_near(balls, candidates, k, more)
        found[count] = k
        count += near
    shares.counts[t, SHARE.found] = count


@threaded()
def look_in_threads(balls, candidates, nearer, shares):
    """Pairs that are near, chunk by chunk."""
    for t in numba.prange(shares.counts.shape[0]):
        look_chunk(balls, candidates, nearer, shares, t)


@inner()
def join_near(candidates, shares):
    """List the near pairs of all threads."""
    count = np.uint64(0)
    for t in range(shares.counts.shape[0]):
        for at in range(shares.counts[t, SHARE.found]):
            candidates.near[count] = shares.found[t, at]
            count += np.uint64(1)
    candidates.near_end[candidates.near_end.size - 1] = count


@inlined()
def list_near_in_threads(balls, candidates, clock, counters, shares):
    """As near_candidates.list_near."""
    look_in_threads(balls, candidates, list_near_walls(balls, candidates, clock, counters), shares)
    join_near(candidates, shares)


@inner()
def find_chunk(balls, candidates, shares, t):
    """Pairs of one chunk of the candidates that have come within reach."""
    begin, end = chunk(np.int64(near_pairs_listed(candidates)), t, shares.counts.shape[0])
    found = find_pairs(balls, candidates, np.uint64(begin), np.uint64(end), shares.found[t])
    shares.counts[t, SHARE.found] = found


@threaded()
def find_in_threads(balls, candidates, shares):
    """Pairs that have come within reach, chunk by chunk."""
    for t in numba.prange(shares.counts.shape[0]):
        find_chunk(balls, candidates, shares, t)


@inlined()
def gather_block(balls, candidates, contacts, present, walls, motions, block, width):
    """Fill the lanes of a block and its present row; returns whether all its contacts still touch."""
    touch = True
    first = np.uint64(block * LANES)
    for m in range(width):
        if contacts.slot[first + m] >= 0:
            touch = gather(balls, candidates, contacts, present, walls, motions, first + m, block, 0, m) and touch
    return touch


@inner()
def resolve_chunk(mark, balls, candidates, contacts, walls, motions, counters, shares, t, step):
    """The contacts of one chunk of the blocks; a block in which one has parted is listed as waiting."""
    begin, end = chunk(blocks_in_use(counters), t, shares.counts.shape[0])
    forces = balls.force if t == 0 else shares.force[t - 1]
    torques = balls.torque if t == 0 else shares.torque[t - 1]
    body_load, present, waiting = shares.body_load[t], shares.present[t], 0
    for block in range(begin, end):
        width = width_in_use(counters, block)
        if not gather_block(balls, candidates, contacts, present, walls, motions, block, width):
            shares.waiting[t, waiting] = block
            waiting += 1
            continue
        evaluate(mark, contacts.lanes, present, block, block + 1, step)
        first = np.uint64(block * LANES)
        for m in range(width):
            if contacts.slot[first + m] >= 0:
                scatter(balls, contacts, present, walls, motions, forces, torques, body_load, first + m, block, 0, m)
    shares.counts[t, SHARE.waiting] = waiting


@threaded()
def resolve_in_threads(mark, balls, candidates, contacts, walls, motions, counters, shares, step):
    """The contacts of all blocks but those that wait."""
    for t in numba.prange(shares.counts.shape[0]):
        resolve_chunk(mark, balls, candidates, contacts, walls, motions, counters, shares, t, step)


@inner()
def sum_chunk(balls, shares, t):
    """Add the loads of the other threads to one chunk of the balls, in the threads' order, and clear them."""
    begin, end = chunk(balls.species.size, t, shares.counts.shape[0])
    for source in range(shares.force.shape[0]):
        for i in range(begin, end):
            for c in range(3):
                balls.force[i, c] += shares.force[source, i, c]
                balls.torque[i, c] += shares.torque[source, i, c]
                shares.force[source, i, c] = shares.torque[source, i, c] = 0.0


@threaded()
def sum_in_threads(balls, shares):
    """The load of every ball."""
    for t in numba.prange(shares.counts.shape[0]):
        sum_chunk(balls, shares, t)


@inner()
def move_chunk(balls, gain, turning, fall, step, threads, t):
    """Kick and drift of one chunk of the balls."""
    begin, end = chunk(balls.species.size, t, threads)
    a, b = (0, 1) if gain.size == 1 else (3 * begin, 3 * end)
    move(numbers_of(balls, begin, end), gain[a:b], turning[a:b], fall[3 * begin : 3 * end], step)


@threaded()
def move_in_threads(balls, gain, turning, fall, step, threads):
    """Kick and drift of all balls."""
    for t in numba.prange(threads):
        move_chunk(balls, gain, turning, fall, step, threads, t)


@inner()
def open_in_order(balls, candidates, contacts, laws, walls, clock, time, totals, counters, table, shares):
    """Open the contacts of all that have come within reach, in the order of the lists."""
    count = 0
    for t in range(shares.counts.shape[0]):
        for at in range(shares.counts[t, SHARE.found]):
            candidates.found[count] = shares.found[t, at]
            count += 1
    open_pairs(balls, candidates, contacts, laws, counters, count, time)
    open_walls(balls, candidates, contacts, laws, walls, clock, time, totals, counters, table)


@inner()
def resolve_waiting(balls, candidates, contacts, laws, mark, walls, clock, time, totals, counters, table, shares):
    """The blocks in which a contact has parted, in their order, and the loads of the bodies."""
    for t in range(shares.counts.shape[0]):
        for at in range(shares.counts[t, SHARE.waiting]):
            begin, end = shares.waiting[t, at], shares.waiting[t, at] + 1
            resolve_blocks(
                balls, candidates, contacts, laws, mark, walls, clock, begin, end, time, totals, counters, table
            )
        for body in range(clock.load.shape[0]):
            for c in range(LOAD_WIDTH):
                clock.load[body, c] += shares.body_load[t, body, c]
                shares.body_load[t, body, c] = 0.0
    book_wall_work(clock, totals)


@inlined()
def apply_forces_in_threads(
    balls, candidates, contacts, laws, mark, walls, clock, time, totals, counters, table, shares
):  # fmt: skip
    """As steps.apply_forces."""
    find_in_threads(balls, candidates, shares)
    open_in_order(balls, candidates, contacts, laws, walls, clock, time, totals, counters, table, shares)
    resolve_in_threads(mark, balls, candidates, contacts, walls, clock.motions, counters, shares, clock.step)
    resolve_waiting(balls, candidates, contacts, laws, mark, walls, clock, time, totals, counters, table, shares)
    sum_in_threads(balls, shares)


@inlined()
def can_step(balls, candidates, contacts, laws, walls, clock, time, counters, table, recorder, shares):
    """Pose the bodies and bring the lists up to date; whether the step may be taken: no trouble, and room to write."""
    write_poses(clock.motions, time)
    if counters[COUNTER.step] % SHARE_EVERY == 0:
        share_resistance(balls, contacts, counters)
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
    numbers = numbers_of(balls, 0, balls.species.size)
    # Between two calls, balls and contacts may have been changed; after a restart, no pose is known.
    write_poses(clock.motions, counters[COUNTER.step] * clock.step)
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
            move(numbers, clock.gain, clock.turn, clock.fall, clock.step)
        else:
            move_in_threads(balls, clock.gain, clock.turn, clock.fall, clock.step, shares.counts.shape[0])
        counters[COUNTER.step] += 1
        counters[COUNTER.check_in] -= 1
        counters[COUNTER.look_in] -= 1
