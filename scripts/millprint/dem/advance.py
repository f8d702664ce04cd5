"""The step loop, and what it records on the way: energy samples, snapshots, occupancy and the table of collisions."""

from typing import NamedTuple

import numpy as np

from millprint.dem import lanes, state
from millprint.dem.lanes import HISTORY, LANES
from millprint.dem.neighbours import look
from millprint.dem.steps import apply_forces, drift, kick
from millprint.dem.touching import book_works, listed, write_collision
from millprint.kernel import inlined, inner, kernel
from millprint.mill.motion import write_poses
from millprint.mill.vectors import row, subtract
from millprint.mill.walls import direction_to_body, to_body, wall_velocity

# Columns of an energy sample; all but the first in J.
SAMPLE_COLUMNS = (
    "time_s",
    "wall_work_J",
    "normal_damping_J",
    "tangential_damping_J",
    "tangential_work_J",
    "rolling_J",
    "elastic_normal_J",
    "elastic_tangential_J",
    "kinetic_translation_J",
    "kinetic_spin_J",
    "potential_J",
)


class Table(NamedTuple):
    """Finished contacts; an empty table records none."""

    first: np.ndarray  # (rows,) ball
    second: np.ndarray  # (rows,) ball, or -1 - feature of the wall
    ended: np.ndarray  # (rows,) 0 where the window ended first
    value: np.ndarray  # (rows, 9) start, duration, approach speed, peak force, peak overlap, four works


class Recorder(NamedTuple):
    """Buffers of one call of `advance`, and how often to write to them; an interval of 0 means never."""

    origin: int  # step at which the recorded window begins
    sample_every: int
    snapshot_every: int
    occupancy_every: int
    sample: np.ndarray  # (m, columns)
    snapshot: np.ndarray  # (m, n, 12) position, velocity, spin, contact force
    snapshot_pose: np.ndarray  # (m, bodies, 18) see mill.motion
    snapshot_work: np.ndarray  # (m, 4) time, normal and tangential work, contacts so far in the buffer
    snapshot_contact: np.ndarray  # (contacts, 2)
    grid: np.ndarray  # (3,) low x [m], low y [m], cells a metre
    occupancy: np.ndarray  # (columns, rows, 5) count, sums of the velocity, sum of its square, all relative to the body
    work: np.ndarray  # (2, TOTALS) scratch
    height: np.ndarray  # (2,) sum of heights over the floor, count


@kernel()
def all_works(contacts, counters, totals, out):
    """Totals with the works so far of the contacts that are open, and the elastic energies of the last evaluation."""
    for c in range(state.TOTALS):
        out[c] = totals[c]
    for lane in range(counters[state.USED]):
        if contacts.slot[lane] >= 0:
            book_works(contacts, lane, out)
            block, m = lane // LANES, lane % LANES
            out[state.ELASTIC_NORMAL] += lanes.get(contacts.lanes, block, lanes.STORED, m)
            out[state.ELASTIC_TANGENTIAL] += lanes.get(contacts.lanes, block, lanes.STORED + 1, m)


@inner()
def average_works(before, out):
    """Totals at the present time: half of this step's work is still to come; the elastic energies are those of now."""
    for c in range(state.ELASTIC_NORMAL):
        out[c] = 0.5 * (before[c] + out[c])


@inner()
def write_sample(balls, clock, time, totals, out):
    """One row of SAMPLE_COLUMNS, with the mean of the velocities before and after the coming kick."""
    moving = 0.0
    turning = 0.0
    potential = 0.0
    for i in range(balls.species.size):
        mass, inertia = balls.mass[balls.species[i]], balls.inertia[balls.species[i]]
        for c in range(3):
            speed = balls.rate[i, c] + 0.5 * clock.step * (balls.load[i, c] / mass + clock.gravity[c])
            spin = balls.rate[i, 3 + c] + 0.5 * clock.step * balls.load[i, 3 + c] / inertia
            moving += 0.5 * mass * speed * speed
            turning += 0.5 * inertia * spin * spin
            potential -= mass * clock.gravity[c] * balls.position[i, c]
    out[0] = time
    for c in range(state.TOTALS):
        out[1 + c] = totals[c]
    out[8] = moving
    out[9] = turning
    out[10] = potential


@inlined()
def write_open(candidates, first, i, counters, recorder):
    """Append the open contacts of ball i among first[i] to first[i + 1]."""
    for k in range(first[i], first[i + 1]):
        if candidates.lane[k] >= 0:
            contact = counters[state.SNAPSHOT_CONTACTS]
            recorder.snapshot_contact[contact, 0] = i
            recorder.snapshot_contact[contact, 1] = candidates.partner[k]
            counters[state.SNAPSHOT_CONTACTS] += 1


@inner()
def write_snapshot(balls, candidates, clock, time, totals, counters, recorder):
    """State of every ball and pose of every body now, the work so far, and the open contacts."""
    m = counters[state.SNAPSHOTS]
    counters[state.SNAPSHOTS] += 1
    for i in range(balls.species.size):
        mass, inertia = balls.mass[balls.species[i]], balls.inertia[balls.species[i]]
        for c in range(3):
            half = 0.5 * clock.step
            recorder.snapshot[m, i, c] = balls.position[i, c]
            recorder.snapshot[m, i, 3 + c] = balls.rate[i, c] + half * (balls.load[i, c] / mass + clock.gravity[c])
            recorder.snapshot[m, i, 6 + c] = balls.rate[i, 3 + c] + half * balls.load[i, 3 + c] / inertia
            recorder.snapshot[m, i, 9 + c] = balls.load[i, c]
        write_open(candidates, candidates.first, i, counters, recorder)
        for body in range(candidates.first_wall.shape[0]):
            write_open(candidates, candidates.first_wall[body], i, counters, recorder)
    for body in range(clock.load.shape[0]):
        for c in range(clock.motions.pose.shape[1]):
            recorder.snapshot_pose[m, body, c] = clock.motions.pose[body, c]
    work = recorder.snapshot_work[m]
    work[0] = time
    work[1] = totals[state.TOTAL_NORMAL]
    # Dissipated: the work less what the tangential springs still hold.
    work[2] = totals[state.TOTAL_TANGENTIAL] - totals[state.ELASTIC_TANGENTIAL]
    work[3] = counters[state.SNAPSHOT_CONTACTS]


@inner()
def count_occupancy(balls, clock, recorder):
    """Add every ball to the cell of the horizontal grid that holds it, in the vessel's frame."""
    for i in range(balls.species.size):
        position = row(balls.position, i)
        point = to_body(clock.motions, 0, position)
        column = int((point[0] - recorder.grid[0]) * recorder.grid[2])
        line = int((point[1] - recorder.grid[1]) * recorder.grid[2])
        recorder.height[0] += point[2]
        recorder.height[1] += 1
        if not (0 <= column < recorder.occupancy.shape[0] and 0 <= line < recorder.occupancy.shape[1]):
            continue
        cell = recorder.occupancy[column, line]
        # The velocity that somebody in the vessel sees, along the vessel's axes.
        seen = subtract(row(balls.rate_now, i), wall_velocity(clock.motions, 0, position))
        speed = direction_to_body(clock.motions, 0, seen)
        cell[0] += 1
        for c in range(3):
            cell[1 + c] += speed[c]
            cell[4] += speed[c] * speed[c]


@inlined()
def room_left(candidates, counters, table, recorder):
    """Whether the buffers can take everything that one more step may write."""
    open_at_most = np.int64(listed(candidates))
    if table.value.shape[0] > 0 and counters[state.RECORDS] + open_at_most > table.value.shape[0]:
        return False
    if recorder.sample_every > 0 and counters[state.SAMPLES] >= recorder.sample.shape[0]:
        return False
    if recorder.snapshot_every == 0:
        return True
    return (
        counters[state.SNAPSHOTS] < recorder.snapshot.shape[0]
        and counters[state.SNAPSHOT_CONTACTS] + open_at_most <= recorder.snapshot_contact.shape[0]
    )


@inlined()
def is_due(every, since):
    """Whether something is written in the step that comes `since` steps after the origin."""
    return every > 0 and since >= 0 and since % every == 0


@inner()
def record(balls, candidates, contacts, clock, time, since, totals, counters, recorder):
    """Write the energy sample and the snapshot that are due; recorder.work[0] holds the works before this step."""
    now = recorder.work[1]
    all_works(contacts, counters, totals, now)
    average_works(recorder.work[0], now)
    if is_due(recorder.sample_every, since):
        write_sample(balls, clock, time, now, recorder.sample[counters[state.SAMPLES]])
        counters[state.SAMPLES] += 1
    if is_due(recorder.snapshot_every, since):
        write_snapshot(balls, candidates, clock, time, now, counters, recorder)


@inlined()
def can_step(balls, candidates, contacts, laws, walls, clock, time, counters, table, recorder):
    """Pose the bodies and bring the lists up to date; whether the step may be taken: no trouble, and room to write."""
    write_poses(clock.motions, time)
    if counters[state.CHECK_IN] <= 0:
        look(balls, candidates, contacts, laws, walls, clock, counters)
        if counters[state.STATUS] != state.RUNNING:
            return False
    return room_left(candidates, counters, table, recorder)


@inlined()
def record_due(recorder, since):
    """Whether an energy sample or a snapshot is written."""
    return is_due(recorder.sample_every, since) or is_due(recorder.snapshot_every, since)


@inlined()
def count_step(counters):
    """One step is done."""
    counters[state.STEP] += 1
    counters[state.CHECK_IN] -= 1


@kernel()
def advance(balls, candidates, contacts, laws, walls, clock, totals, counters, table, recorder, last_step):
    """Run up to and including step `last_step`, or until a buffer is full or something is wrong.

    Everything is changed in place; counters[STEP] tells how far it came and counters[STATUS] whether it may go on.
    Time is the step's number times the step; the mill starts at step 0.
    """
    # The same numbers as rows of one line each, which make fast loops.
    rate, rate_now, load = balls.rate.reshape(-1), balls.rate_now.reshape(-1), balls.load.reshape(-1)
    while counters[state.STEP] <= last_step and counters[state.STATUS] == state.RUNNING:
        time = counters[state.STEP] * clock.step
        if not can_step(balls, candidates, contacts, laws, walls, clock, time, counters, table, recorder):
            break
        since = counters[state.STEP] - recorder.origin
        is_recorded = record_due(recorder, since)
        if is_recorded:
            all_works(contacts, counters, totals, recorder.work[0])
        apply_forces(balls, candidates, contacts, laws, walls, clock, time, totals, counters, table)
        if is_recorded:
            record(balls, candidates, contacts, clock, time, since, totals, counters, recorder)
        if is_due(recorder.occupancy_every, since):
            count_occupancy(balls, clock, recorder)
        kick(rate, rate_now, load, clock.gain, clock.fall)
        drift(balls.position, balls.rate, clock.step)
        count_step(counters)


@kernel()
def begin_window(contacts, totals, counters):
    """Book and clear the works of open contacts, so that the table of collisions counts the window alone."""
    for lane in range(counters[state.USED]):
        if contacts.slot[lane] < 0:
            continue
        book_works(contacts, lane, totals)
        for c in range(lanes.NORMAL, lanes.ROLLING + 1):
            lanes.put(contacts.lanes, lane // LANES, HISTORY + c, lane % LANES, 0.0)


@kernel()
def end_window(candidates, contacts, time, counters, table):
    """Append every contact that is still open to the table of collisions; nothing else is changed."""
    for k in range(listed(candidates)):
        if candidates.lane[k] >= 0:
            write_collision(contacts, candidates.lane[k], time, 0, counters, table)
