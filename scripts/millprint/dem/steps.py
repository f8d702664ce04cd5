"""One step: the forces of every open contact, then kick and drift.

Velocities live half a step before positions (leapfrog). Forces need them now, so each ball also carries the velocity
expected now, the last one plus half a step of the last acceleration; it differs from the mean of the two half-step
velocities, with which a kick does its work, by the square of the step. Tangential springs grow by the trapezoidal
rule. So the energy balance closes with the square of the step.
"""

import math

from millprint.dem import state
from millprint.dem.law import REACH, contact_law
from millprint.kernel import inlined
from millprint.mill.vectors import add, add_scaled, cross, dot, row, scale, subtract
from millprint.mill.walls import touch


@inlined()
def accumulate(array, index, vector):
    array[index, 0] += vector[0]
    array[index, 1] += vector[1]
    array[index, 2] += vector[2]


@inlined()
def open_contact(slots, k, time, approach):
    """Begin the record of a contact."""
    slots.is_open[k] = 1
    for c in range(state.TANGENT):
        slots.tangent[k, c] = 0.0
    for c in range(state.RECORD):
        slots.record[k, c] = 0.0
    slots.record[k, state.START] = time
    slots.record[k, state.APPROACH] = approach


@inlined()
def book_works(slots, k, totals):
    """Add the works of slot k's contact to the running totals."""
    totals[state.TOTAL_NORMAL] += slots.record[k, state.NORMAL]
    totals[state.TOTAL_DAMPING] += slots.record[k, state.DAMPING]
    totals[state.TOTAL_TANGENTIAL] += slots.record[k, state.TANGENTIAL]
    totals[state.TOTAL_ROLLING] += slots.record[k, state.ROLLING]


@inlined()
def close_contact(slots, i, k, time, ended, totals, counters, table):
    """End a contact: book its works, and append it to the table of collisions, if that has rows.

    ended: 1 if the bodies came apart, 0 if the window ends with them in contact.
    """
    slots.is_open[k] = 0
    book_works(slots, k, totals)
    if table.value.shape[0] == 0:
        return
    m = counters[state.RECORDS]
    counters[state.RECORDS] += 1
    table.first[m] = i
    table.second[m] = slots.partner[k]
    table.ended[m] = ended
    table.value[m, 0] = slots.record[k, state.START]
    table.value[m, 1] = time - slots.record[k, state.START]
    for c in range(1, state.RECORD):
        table.value[m, 1 + c] = slots.record[k, c]


@inlined()
def resolve(slots, k, law, overlap, normal, arm, velocity, spin, time, step, totals):
    """Apply the contact law in slot k and book its works; returns the force and the rolling torque on the first."""
    if not slots.is_open[k]:
        open_contact(slots, k, time, -dot(velocity, normal))
    tangent = slots.tangent[k]
    record = slots.record[k]
    normal_force, tangential, rolling, spring, slip, powers, stored = contact_law(
        law, overlap, normal, arm, velocity, spin,
        (tangent[0], tangent[1], tangent[2]), (tangent[3], tangent[4], tangent[5]), step,
    )  # fmt: skip
    tangent[0], tangent[1], tangent[2] = spring
    tangent[3], tangent[4], tangent[5] = slip
    record[state.PEAK_FORCE] = max(record[state.PEAK_FORCE], normal_force)
    record[state.PEAK_OVERLAP] = max(record[state.PEAK_OVERLAP], overlap)
    record[state.NORMAL] += step * powers[0]
    record[state.DAMPING] += step * powers[1]
    record[state.TANGENTIAL] += step * powers[2]
    record[state.ROLLING] += step * powers[3]
    totals[state.ELASTIC_NORMAL] += stored[0]
    totals[state.ELASTIC_TANGENTIAL] += stored[1]
    return add_scaled(tangential, normal_force, normal), rolling


@inlined()
def check_overlap(laws, species, overlap, i, partner, counters):
    if overlap > laws.overlap_max[species]:
        counters[state.STATUS] = state.OVERLAP
        counters[state.BALL] = i
        counters[state.PARTNER] = partner


@inlined()
def pair_contact(balls, slots, laws, i, k, time, step, totals, counters):
    """The contact of ball i and slot k's ball, if any: (1, force on i, torque on i, torque on the other)."""
    j = slots.partner[k]
    nothing = (0.0, 0.0, 0.0)
    law = laws.pair[balls.species[i], balls.species[j]]
    away = subtract(row(balls.position, i), row(balls.position, j))
    squared = dot(away, away)
    if squared >= law[REACH] * law[REACH]:
        return 0, nothing, nothing, nothing
    distance = math.sqrt(squared)
    overlap = law[REACH] - distance
    # Rounding may leave nothing of an overlap whose square was still there.
    if overlap <= 0.0:
        return 0, nothing, nothing, nothing
    normal = scale(1.0 / distance, away)
    check_overlap(laws, balls.species[i], overlap, i, j, counters)
    # The plane of contact is where the two spheres cut each other.
    difference = balls.radius[balls.species[i]] - balls.radius[balls.species[j]]
    arm = 0.5 * (distance + difference * law[REACH] / distance)
    other = distance - arm
    # Velocity at the contact point: v_i + w_i x (-arm n) - v_j - w_j x (other n).
    turning = add_scaled(scale(arm, row(balls.spin_now, i)), other, row(balls.spin_now, j))
    velocity = subtract(row(balls.velocity_now, i), row(balls.velocity_now, j))
    velocity = subtract(velocity, cross(turning, normal))
    spin = subtract(row(balls.spin_now, i), row(balls.spin_now, j))
    mean_arm = 2 * arm * other / distance
    force, rolling = resolve(slots, k, law, overlap, normal, mean_arm, velocity, spin, time, step, totals)
    lever = cross(force, normal)
    return 1, force, add_scaled(rolling, arm, lever), subtract(scale(other, lever), rolling)


@inlined()
def wall_contact(balls, slots, laws, walls, pose, i, k, time, step, totals, counters):
    """The contact of ball i and slot k's feature of the wall, if any: (1, force on i, torque on i)."""
    law = laws.wall[balls.species[i]]
    point = subtract(row(balls.position, i), (pose[0], pose[1], pose[2]))
    distance, normal = touch(walls, -1 - slots.partner[k], slots.sure[k], point, law[REACH])
    if distance < 0.0:
        return 0, normal, normal
    overlap = law[REACH] - distance
    check_overlap(laws, balls.species[i], overlap, i, slots.partner[k], counters)
    wall_velocity = (pose[3], pose[4], pose[5])
    spin = row(balls.spin_now, i)
    velocity = subtract(row(balls.velocity_now, i), wall_velocity)
    velocity = add_scaled(velocity, -distance, cross(spin, normal))
    force, rolling = resolve(slots, k, law, overlap, normal, distance, velocity, spin, time, step, totals)
    totals[state.WALL_WORK] += step * dot(force, wall_velocity)
    return 1, force, add_scaled(rolling, distance, cross(force, normal))


@inlined()
def apply_forces(balls, slots, laws, walls, clock, time, totals, counters, table):
    """Contact forces and torques on every ball at the present positions; energies go to `totals` and the records."""
    totals[state.ELASTIC_NORMAL] = 0.0
    totals[state.ELASTIC_TANGENTIAL] = 0.0
    for i in range(balls.species.size):
        total_force = (0.0, 0.0, 0.0)
        total_torque = (0.0, 0.0, 0.0)
        for k in range(slots.first[i], slots.first_wall[i]):
            touching, force, torque, back = pair_contact(balls, slots, laws, i, k, time, clock.step, totals, counters)
            if touching:
                total_force = add(total_force, force)
                total_torque = add(total_torque, torque)
                accumulate(balls.force, slots.partner[k], scale(-1.0, force))
                accumulate(balls.torque, slots.partner[k], back)
            elif slots.is_open[k]:
                close_contact(slots, i, k, time, 1, totals, counters, table)
        for k in range(slots.first_wall[i], slots.first[i + 1]):
            touching, force, torque = wall_contact(
                balls, slots, laws, walls, clock.pose, i, k, time, clock.step, totals, counters
            )
            if touching:
                total_force = add(total_force, force)
                total_torque = add(total_torque, torque)
            elif slots.is_open[k]:
                close_contact(slots, i, k, time, 1, totals, counters, table)
        accumulate(balls.force, i, total_force)
        accumulate(balls.torque, i, total_torque)


@inlined()
def kick_and_drift(balls, clock):
    """Advance velocities by a step of the forces, positions by a step of the new velocities; clears the forces."""
    step = clock.step
    for i in range(balls.species.size):
        by_mass = step / balls.mass[balls.species[i]]
        by_inertia = step / balls.inertia[balls.species[i]]
        for c in range(3):
            kick = balls.force[i, c] * by_mass + step * clock.gravity[c]
            twist = balls.torque[i, c] * by_inertia
            velocity = balls.velocity[i, c] + kick
            spin = balls.spin[i, c] + twist
            balls.velocity[i, c] = velocity
            balls.spin[i, c] = spin
            balls.velocity_now[i, c] = velocity + 0.5 * kick
            balls.spin_now[i, c] = spin + 0.5 * twist
            balls.position[i, c] += step * velocity
            balls.force[i, c] = 0.0
            balls.torque[i, c] = 0.0
