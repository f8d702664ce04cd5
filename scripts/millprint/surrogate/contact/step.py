"""One coarse step of all balls: open contacts, predict forces, solve every pair, move the bodies."""

from typing import NamedTuple

import numpy as np

from millprint.dem.lanes import get, get_vector, put, put_vector
from millprint.dem.layout import (
    COUNTER,
    HISTORY_WIDTH,
    LANE,
    LANE_HISTORY,
    LANES,
    RATE,
    RATE_WIDTH,
    STATUS,
    TOTAL_WIDTH,
)
from millprint.dem.recording import all_works
from millprint.dem.steps import blocks_in_use
from millprint.kernel import inlined, inner, kernel
from millprint.mill.motion import write_poses
from millprint.mill.pose import POSE
from millprint.surrogate.contact.listing import close_lane, foresee, update_lists
from millprint.surrogate.contact.pair import LANE_LAST_FORCE, PAIR, substep
from millprint.surrogate.contact.pair_input import expect, gather, put_external, touch_lane
from millprint.surrogate.contact.predictor import predict_all
from millprint.surrogate.contact.scratch import MOVED

# The column after a lane's history.
HISTORY_END = LANE_HISTORY + HISTORY_WIDTH


@inlined()
def clear(array):
    """Set an array (n, k) to zero."""
    for i in range(array.shape[0]):
        for c in range(array.shape[1]):
            array[i, c] = 0.0


@inlined()
def copy(source, target, block, begin, end):
    """Quantities begin to end of a block."""
    for c in range(begin * LANES, end * LANES):
        target[block, c] = source[block, c]


@inner()
def solve(contacts, clock, coarse, counters):
    """The local problem of every open contact; histories are those of the contacts' lanes before and after."""
    for block in range(blocks_in_use(counters)):
        copy(contacts.lanes, coarse.work, block, LANE_HISTORY, HISTORY_END)
        for s in range(coarse.substeps):
            substep(coarse.work, block, s, coarse.substeps - 1 - s, clock.step)
        copy(coarse.work, contacts.lanes, block, LANE_HISTORY, HISTORY_END)
        copy(coarse.work, contacts.lanes, block, LANE.elastic_normal, LANE.elastic_tangential + 1)


@inner()
def scatter(contacts, coarse, lane):
    """Impulse, moment and twist of a contact onto its balls."""
    block, m = lane // LANES, lane % LANES
    i, j = contacts.ball[lane], contacts.partner[lane]
    for c in range(3):
        impulse = get(coarse.work, block, PAIR.impulse.x + c, m)
        moment = get(coarse.work, block, PAIR.moment.x + c, m)
        coarse.moved[i, MOVED.impulse.x + c] += impulse
        coarse.moved[i, MOVED.moment.x + c] += moment
        coarse.moved[i, MOVED.twist.x + c] += get(coarse.work, block, PAIR.twist.x + c, m)
        if j >= 0:
            coarse.moved[j, MOVED.impulse.x + c] -= impulse
            coarse.moved[j, MOVED.moment.x + c] -= moment
            coarse.moved[j, MOVED.twist.x + c] += get(coarse.work, block, PAIR.other_twist.x + c, m)


@inner()
def move(balls, clock, coarse):
    """Move the balls by a step: v += (impulse) / m + g h, x += v h + moment / m + g h^2 / 2, w += twist / I."""
    step = clock.step
    for i in range(balls.species.size):
        inverse_mass = 1.0 / balls.mass[balls.species[i]]
        inverse_inertia = 1.0 / balls.inertia[balls.species[i]]
        for c in range(3):
            fall = clock.gravity[c]
            balls.position[i, c] += (
                step * balls.rate[i, RATE.velocity.x + c]
                + inverse_mass * coarse.moved[i, MOVED.moment.x + c]
                + 0.5 * step * step * fall
            )
            balls.rate[i, RATE.velocity.x + c] += inverse_mass * coarse.moved[i, MOVED.impulse.x + c] + step * fall
            balls.rate[i, RATE.angular_velocity.x + c] += inverse_inertia * coarse.moved[i, MOVED.twist.x + c]


@inner()
def expect_all(contacts, coarse, counters):
    """Sum the predicted forces of all contacts on every ball."""
    clear(coarse.load)
    for lane in range(counters[COUNTER.used]):
        if contacts.slot[lane] >= 0:
            expect(contacts, coarse, lane)


@inner()
def put_all_externals(balls, contacts, walls, clock, coarse, counters):
    """Accelerations of every contact by everything but itself."""
    for lane in range(counters[COUNTER.used]):
        if contacts.slot[lane] >= 0:
            put_external(balls, contacts, walls, clock, coarse, lane)


@kernel()
def gather_all(balls, candidates, contacts, laws, walls, clock, coarse, totals, counters, table, time):
    """List, open and close contacts at `time` [s], and put into the lanes what their local problems begin with."""
    write_poses(clock.motions, time + clock.step)
    for body in range(coarse.wall_velocity.shape[0]):
        for c in range(3):
            pose = clock.motions.pose
            coarse.wall_velocity[body, RATE.velocity.x + c] = pose[body, POSE.velocity.x + c]
            coarse.wall_velocity[body, RATE.angular_velocity.x + c] = pose[body, POSE.angular_velocity.x + c]
    write_poses(clock.motions, time)
    update_lists(balls, candidates, contacts, laws, walls, clock, coarse, totals, counters)
    if counters[COUNTER.status] != STATUS.running:
        return
    foresee(balls, candidates, contacts, laws, walls, clock, coarse, counters, time)
    for lane in range(counters[COUNTER.used]):
        if contacts.slot[lane] < 0:
            put(coarse.work, lane // LANES, PAIR.substep_length, lane % LANES, 0.0)
        elif not gather(balls, candidates, contacts, walls, clock, coarse, lane):
            close_lane(candidates, contacts, coarse, lane, time, totals, counters, table)
            put(coarse.work, lane // LANES, PAIR.substep_length, lane % LANES, 0.0)
    for block in range(blocks_in_use(counters)):
        copy(contacts.lanes, coarse.work, block, LANE.is_wall, LANE_HISTORY)


@kernel()
def predict(balls, contacts, walls, clock, coarse, counters):
    """Rounds of messages: external accelerations from the predicted forces, then new predictions."""
    expect_all(contacts, coarse, counters)
    put_all_externals(balls, contacts, walls, clock, coarse, counters)
    for layer in range(coarse.weights.first.shape[0]):
        predict_all(coarse.weights, layer, coarse, blocks_in_use(counters), clock.step)
        expect_all(contacts, coarse, counters)
        put_all_externals(balls, contacts, walls, clock, coarse, counters)


@inner()
def finish(balls, contacts, clock, coarse, counters):
    """Solve every local problem and move the balls."""
    for lane in range(counters[COUNTER.used]):
        if contacts.slot[lane] >= 0:
            touch_lane(contacts, clock, coarse, lane)
    solve(contacts, clock, coarse, counters)
    clear(coarse.moved)
    for lane in range(counters[COUNTER.used]):
        if contacts.slot[lane] >= 0:
            scatter(contacts, coarse, lane)
            block, m = lane // LANES, lane % LANES
            # What the contact did at the end of the step is where the next one's expectation begins.
            force = get_vector(coarse.work, block, PAIR.force, m)
            put_vector(contacts.lanes, block, LANE_LAST_FORCE, m, force)
    move(balls, clock, coarse)


@kernel()
def run_steps(balls, candidates, contacts, laws, walls, clock, coarse, totals, counters, table, last_step):
    """Coarse steps up to and including `last_step`, or until something is wrong."""
    while counters[COUNTER.step] <= last_step:
        time = counters[COUNTER.step] * clock.step
        gather_all(balls, candidates, contacts, laws, walls, clock, coarse, totals, counters, table, time)
        if counters[COUNTER.status] != STATUS.running:
            break
        predict(balls, contacts, walls, clock, coarse, counters)
        finish(balls, contacts, clock, coarse, counters)
        counters[COUNTER.step] += 1


class Frames(NamedTuple):
    """The stored frames of a roll-out; `works` and `ended` count from its start."""

    position: np.ndarray  # (frames, n, 3) [m]
    rate: np.ndarray  # (frames, n, width) layout.RateColumns
    works: np.ndarray  # (frames, width) layout.TotalColumns [J]
    ended: np.ndarray  # (frames,) contacts that have ended


def make_frames(frames: int, balls: int) -> Frames:
    """Arrays for `frames` states; states that are never written stay NaN."""
    return Frames(
        position=np.full((frames, balls, 3), np.nan),
        rate=np.full((frames, balls, RATE_WIDTH), np.nan),
        works=np.full((frames, TOTAL_WIDTH), np.nan),
        ended=np.full(frames, np.nan),
    )


@kernel()
def run_frames(balls, candidates, contacts, laws, walls, clock, totals, counters, table, coarse, per_frame, frames, at):
    """Run until the frames from `at` on are written, `per_frame` steps apart; returns how many of them were."""
    for frame in range(at, frames.position.shape[0]):
        run_steps(
            balls, candidates, contacts, laws, walls, clock, coarse, totals, counters, table,
            counters[COUNTER.step] + per_frame - 1,
        )  # fmt: skip
        if counters[COUNTER.status] != STATUS.running:
            return frame - at
        for i in range(balls.species.size):
            for c in range(3):
                frames.position[frame, i, c] = balls.position[i, c]
            for c in range(RATE_WIDTH):
                frames.rate[frame, i, c] = balls.rate[i, c]
        all_works(contacts, counters, totals, frames.works[frame])
        frames.ended[frame] = coarse.ended[0]
    return frames.position.shape[0] - at
