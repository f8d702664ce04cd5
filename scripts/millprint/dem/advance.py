"""The step loop, and what it records on the way: energy samples, snapshots, occupancy and the table of collisions."""

from typing import NamedTuple

import numpy as np

from millprint.dem import state
from millprint.dem.neighbours import refresh
from millprint.dem.steps import apply_forces, book_works, close_contact, kick_and_drift
from millprint.kernel import inlined, kernel
from millprint.mill.motion import write_pose

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
    snapshot_body: np.ndarray  # (m, 10) time, body position and velocity, normal and tangential work, contacts so far
    snapshot_contact: np.ndarray  # (contacts, 2)
    grid: np.ndarray  # (3,) low x [m], low y [m], cells a metre
    occupancy: np.ndarray  # (columns, rows, 5) count, sums of the velocity, sum of its square, all relative to the body
    work: np.ndarray  # (2, TOTALS) scratch
    height: np.ndarray  # (2,) sum of heights over the floor, count


@kernel()
def all_works(slots, totals, out):
    """Totals with the works so far of the contacts that are open."""
    for c in range(state.TOTALS):
        out[c] = totals[c]
    for k in range(slots.first[slots.first_wall.size]):
        if slots.is_open[k]:
            book_works(slots, k, out)


@kernel()
def average_works(before, totals, out):
    """Totals at the present time: half of this step's work is still to come; the elastic energies are those of now."""
    for c in range(state.TOTALS):
        out[c] = 0.5 * (before[c] + out[c])
    out[state.ELASTIC_NORMAL] = totals[state.ELASTIC_NORMAL]
    out[state.ELASTIC_TANGENTIAL] = totals[state.ELASTIC_TANGENTIAL]


@kernel()
def write_sample(balls, clock, time, totals, out):
    """One row of SAMPLE_COLUMNS, with the mean of the velocities before and after the coming kick."""
    moving = 0.0
    turning = 0.0
    potential = 0.0
    for i in range(balls.species.size):
        mass, inertia = balls.mass[balls.species[i]], balls.inertia[balls.species[i]]
        for c in range(3):
            speed = balls.velocity[i, c] + 0.5 * clock.step * (balls.force[i, c] / mass + clock.gravity[c])
            spin = balls.spin[i, c] + 0.5 * clock.step * balls.torque[i, c] / inertia
            moving += 0.5 * mass * speed * speed
            turning += 0.5 * inertia * spin * spin
            potential -= mass * clock.gravity[c] * balls.position[i, c]
    out[0] = time
    for c in range(state.TOTALS):
        out[1 + c] = totals[c]
    out[8] = moving
    out[9] = turning
    out[10] = potential


@kernel()
def write_snapshot(balls, slots, clock, time, totals, counters, recorder):
    """State of every ball now, the body's motion, the work so far, and the open contacts."""
    m = counters[state.SNAPSHOTS]
    counters[state.SNAPSHOTS] += 1
    for i in range(balls.species.size):
        mass, inertia = balls.mass[balls.species[i]], balls.inertia[balls.species[i]]
        for c in range(3):
            half = 0.5 * clock.step
            recorder.snapshot[m, i, c] = balls.position[i, c]
            recorder.snapshot[m, i, 3 + c] = balls.velocity[i, c] + half * (balls.force[i, c] / mass + clock.gravity[c])
            recorder.snapshot[m, i, 6 + c] = balls.spin[i, c] + half * balls.torque[i, c] / inertia
            recorder.snapshot[m, i, 9 + c] = balls.force[i, c]
        for k in range(slots.first[i], slots.first[i + 1]):
            if slots.is_open[k]:
                contact = counters[state.SNAPSHOT_CONTACTS]
                recorder.snapshot_contact[contact, 0] = i
                recorder.snapshot_contact[contact, 1] = slots.partner[k]
                counters[state.SNAPSHOT_CONTACTS] += 1
    body = recorder.snapshot_body[m]
    body[0] = time
    for c in range(6):
        body[1 + c] = clock.pose[c]
    body[7] = totals[state.TOTAL_NORMAL]
    # Dissipated: the work less what the tangential springs still hold.
    body[8] = totals[state.TOTAL_TANGENTIAL] - totals[state.ELASTIC_TANGENTIAL]
    body[9] = counters[state.SNAPSHOT_CONTACTS]


@kernel()
def count_occupancy(balls, clock, recorder):
    """Add every ball to the cell of the horizontal grid that holds it, in the body's frame."""
    for i in range(balls.species.size):
        column = int((balls.position[i, 0] - clock.pose[0] - recorder.grid[0]) * recorder.grid[2])
        line = int((balls.position[i, 1] - clock.pose[1] - recorder.grid[1]) * recorder.grid[2])
        if not (0 <= column < recorder.occupancy.shape[0] and 0 <= line < recorder.occupancy.shape[1]):
            continue
        cell = recorder.occupancy[column, line]
        cell[0] += 1
        for c in range(3):
            speed = balls.velocity_now[i, c] - clock.pose[3 + c]
            cell[1 + c] += speed
            cell[4] += speed * speed
        recorder.height[0] += balls.position[i, 2] - clock.pose[2]
        recorder.height[1] += 1


@inlined()
def room_left(slots, counters, table, recorder):
    """Whether the buffers can take everything that one more step may write."""
    slot_count = slots.first[slots.first_wall.size]
    if table.value.shape[0] > 0 and counters[state.RECORDS] + slot_count > table.value.shape[0]:
        return False
    if recorder.sample_every > 0 and counters[state.SAMPLES] >= recorder.sample.shape[0]:
        return False
    if recorder.snapshot_every == 0:
        return True
    return (
        counters[state.SNAPSHOTS] < recorder.snapshot.shape[0]
        and counters[state.SNAPSHOT_CONTACTS] + slot_count <= recorder.snapshot_contact.shape[0]
    )


@inlined()
def is_due(every, since):
    """Whether something is written in the step that comes `since` steps after the origin."""
    return every > 0 and since >= 0 and since % every == 0


@kernel()
def record(balls, slots, clock, time, since, totals, counters, recorder):
    """Write the energy sample and the snapshot that are due; recorder.work[0] holds the works before this step."""
    now = recorder.work[1]
    all_works(slots, totals, now)
    average_works(recorder.work[0], totals, now)
    if is_due(recorder.sample_every, since):
        write_sample(balls, clock, time, now, recorder.sample[counters[state.SAMPLES]])
        counters[state.SAMPLES] += 1
    if is_due(recorder.snapshot_every, since):
        write_snapshot(balls, slots, clock, time, now, counters, recorder)


@kernel()
def advance(balls, slots, laws, walls, clock, totals, counters, table, recorder, last_step):
    """Run up to and including step `last_step`, or until a buffer is full or something is wrong.

    Everything is changed in place; counters[STEP] tells how far it came and counters[STATUS] whether it may go on.
    Time is the step's number times the step; the mill starts at step 0.
    """
    while counters[state.STEP] <= last_step and counters[state.STATUS] == state.RUNNING:
        time = counters[state.STEP] * clock.step
        write_pose(clock.kind, clock.harmonics, time, clock.pose)
        if counters[state.CHECK_IN] <= 0:
            refresh(balls, slots, walls, clock, counters)
            if counters[state.STATUS] != state.RUNNING:
                break
        if not room_left(slots, counters, table, recorder):
            break
        since = counters[state.STEP] - recorder.origin
        is_recorded = is_due(recorder.sample_every, since) or is_due(recorder.snapshot_every, since)
        if is_recorded:
            all_works(slots, totals, recorder.work[0])
        apply_forces(balls, slots, laws, walls, clock, time, totals, counters, table)
        if is_recorded:
            record(balls, slots, clock, time, since, totals, counters, recorder)
        if is_due(recorder.occupancy_every, since):
            count_occupancy(balls, clock, recorder)
        kick_and_drift(balls, clock)
        counters[state.STEP] += 1
        counters[state.CHECK_IN] -= 1


@kernel()
def begin_window(balls, slots, totals):
    """Book and clear the works of open contacts, so that the table of collisions counts the window alone."""
    for k in range(slots.first[balls.species.size]):
        if slots.is_open[k]:
            book_works(slots, k, totals)
        for c in range(state.NORMAL, state.ROLLING + 1):
            slots.record[k, c] = 0.0


@kernel()
def end_window(balls, slots, time, totals, counters, table):
    """Append every contact that is still open to the table of collisions."""
    for i in range(balls.species.size):
        for k in range(slots.first[i], slots.first[i + 1]):
            if slots.is_open[k]:
                close_contact(slots, i, k, time, 0, totals, counters, table)
