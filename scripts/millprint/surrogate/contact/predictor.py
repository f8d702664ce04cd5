"""The network in the step loop: it predicts the force of every contact in the next step from its own state.

All numbers are dimensionless in the units of the contact itself: the step h, the length L = (m / (K h^2))^2 / 16, a
measure of the overlap at which the Hertz force K delta^(3/2) takes a reduced mass m by as much in a step, and the
force m L / h^2. So contacts of other balls, moduli and steps are the same contact where their numbers are. Vectors
enter by invariants alone and come out along the contact's own directions: its normal, the friction so far, the slip,
and the external acceleration sideways.

`millprint.surrogate.contact.network` holds the same formulas for training; a test keeps both the same.
"""

import math

import numpy as np

from millprint.columns import first_column
from millprint.dem.contact import arms_of
from millprint.dem.lanes import get, get_vector, put, put_vector
from millprint.dem.layout import LANE, LANES
from millprint.kernel import inlined, inner
from millprint.mill.vectors import add_scaled, cross, dot, scale, subtract
from millprint.surrogate.contact.pair import INPUTS, OUTPUTS, PAIR

# Where the inputs of the network and its outputs begin.
INPUTS_AT, OUTPUTS_AT = first_column(PAIR.inputs), first_column(PAIR.outputs)

# Where a compressed number changes from linear to its root; keeps quotients finite.
KNEE = 0.02
SMALL = 1e-6
# The unit of length over (m / (K h^2))^2 [-]: so impacts take some units in a step of a tenth of their duration. The
# factors of spring and dashpot in such units follow.
UNIT = 1 / 16
SPRING_FACTOR, DASHPOT_FACTOR = 1.5 * UNIT**0.5, UNIT**0.25
# Largest change of a normal force over that of `may_change`, and of a friction over the Coulomb cap [-].
NORMAL_SHARE = 2.0
SLIP_SHARE = 1.5


@inlined()
def compressed(number):
    """number / sqrt(|number| + KNEE): keeps rest and impact apart in one input."""
    return number / math.sqrt(abs(number) + KNEE)


@inlined()
def units(work, block, m, step):
    """Length [m] and force [N] of a contact."""
    mass = 1.0 / get(work, block, PAIR.inverse_mass, m)
    root = mass / (get(work, block, LANE.law.normal_stiffness, m) * step * step)
    length = UNIT * root * root
    return length, mass * length / (step * step)


@inlined()
def directions(work, block, m, step):
    """The scalars x, u, f, a and the vectors normal, p, q, r of a contact, all dimensionless (see `describe`)."""
    length, unit = units(work, block, m, step)
    away = get_vector(work, block, PAIR.away, m)
    distance = math.sqrt(dot(away, away))
    normal = scale(1.0 / distance, away)
    reach = get(work, block, LANE.law.reach, m)
    arm, other = arms_of(work, block, m, distance)
    velocity = get_vector(work, block, PAIR.velocity, m)
    turning = add_scaled(
        scale(arm, get_vector(work, block, PAIR.angular_velocity, m)),
        other,
        get_vector(work, block, PAIR.other_angular_velocity, m),
    )
    external = get_vector(work, block, PAIR.mean.external, m)
    twisting = add_scaled(
        scale(arm, get_vector(work, block, PAIR.mean.angular, m)),
        other,
        get_vector(work, block, PAIR.mean.other_angular, m),
    )
    force = scale(1.0 / unit, get_vector(work, block, PAIR.force, m))
    slip = scale(step / length, subtract(velocity, cross(turning, normal)))
    shove = scale(step * step / length, subtract(external, cross(twisting, normal)))
    along = dot(force, normal)
    closing, apart = -dot(slip, normal), dot(shove, normal)
    p = add_scaled(force, -along, normal)
    q = add_scaled(slip, closing, normal)
    r = add_scaled(shove, -apart, normal)
    return (reach - distance) / length, closing, along, apart, normal, p, q, r


@inlined()
def may_change(x, u, f, a):
    """By how much a normal force may change in a step: k(y) (|u| + |f + a| / 2).

    k: the stiffness of spring and dashpot, 3/8 y^(1/2) + y^(1/4) / 2 in these units, at y, the larger overlap of both
    ends of the step if the contact did nothing; times how far the bodies may move. Nothing in balance, and where they
    do not touch.
    """
    after = x + u - 0.5 * a
    y = after if after > x else x
    root = math.sqrt(y if y > 0.0 else 0.0)
    return (SPRING_FACTOR * root + DASHPOT_FACTOR * math.sqrt(root)) * (abs(u) + 0.5 * abs(f + a))


@inlined()
def bounded(number):
    """number / sqrt(1 + number^2), between -1 and 1."""
    return number / math.sqrt(1.0 + number * number)


@inner()
def describe(work, block, step):
    """Inputs of the network for the contacts of a block, (INPUTS, LANES).

    x overlap, u approach speed, f normal force at the end of the last step, a external acceleration apart; p friction
    at the end of the last step, q slip, r external acceleration sideways: their lengths and the cosines between them;
    which share of the Coulomb cap is used; 1 for a wall; the overlap at the end of the step if the contact did nothing.
    """
    for m in range(LANES):
        x, u, f, a, _, p, q, r = directions(work, block, m, step)
        friction = get(work, block, LANE.law.friction, m)
        size_p, size_q, size_r = math.sqrt(dot(p, p)), math.sqrt(dot(q, q)), math.sqrt(dot(r, r))
        used = size_p / (friction * abs(f) + 1e-3)
        put(work, block, PAIR.inputs.overlap, m, compressed(x))
        put(work, block, PAIR.inputs.approach_speed, m, compressed(u))
        put(work, block, PAIR.inputs.normal_force, m, compressed(f))
        put(work, block, PAIR.inputs.external, m, compressed(a))
        put(work, block, PAIR.inputs.friction, m, compressed(size_p))
        put(work, block, PAIR.inputs.slip, m, compressed(size_q))
        put(work, block, PAIR.inputs.sideways, m, compressed(size_r))
        put(work, block, PAIR.inputs.friction_with_slip, m, dot(p, q) / (size_p * size_q + SMALL))
        put(work, block, PAIR.inputs.friction_with_sideways, m, dot(p, r) / (size_p * size_r + SMALL))
        put(work, block, PAIR.inputs.slip_with_sideways, m, dot(q, r) / (size_q * size_r + SMALL))
        put(work, block, PAIR.inputs.cap_share, m, used if used < 2.0 else 2.0)
        put(work, block, PAIR.inputs.is_wall, m, get(work, block, LANE.is_wall, m))
        put(work, block, PAIR.inputs.next_overlap, m, compressed(x + u - 0.5 * a))


@inner()
def linear(weight, bias, inputs, outputs, lanes_used, activate):
    """outputs = weight inputs + bias for all lanes; the squareplus (z + sqrt(z^2 + 4)) / 2 on top if asked.

    Flat arrays, a neuron's numbers for all lanes in a row: so long loops that become vector instructions.
    """
    n, columns = lanes_used, weight.shape[1]
    for o in range(weight.shape[0]):
        out = outputs[o * n : (o + 1) * n]
        for c in range(n):
            out[c] = bias[o]
        # Four at a time, which spares most of the loading and storing of what is summed up.
        for k in range(0, columns - columns % 4, 4):
            w0, w1, w2, w3 = weight[o, k], weight[o, k + 1], weight[o, k + 2], weight[o, k + 3]
            x0, x1 = inputs[k * n : (k + 1) * n], inputs[(k + 1) * n : (k + 2) * n]
            x2, x3 = inputs[(k + 2) * n : (k + 3) * n], inputs[(k + 3) * n : (k + 4) * n]
            for c in range(n):
                out[c] += w0 * x0[c] + w1 * x1[c] + w2 * x2[c] + w3 * x3[c]
        for k in range(columns - columns % 4, columns):
            w, x = weight[o, k], inputs[k * n : (k + 1) * n]
            for c in range(n):
                out[c] += w * x[c]
        if activate:
            for c in range(n):
                z = out[c]
                out[c] = np.float32(0.5) * (z + math.sqrt(z * z + np.float32(4)))


@inlined()
def output(work, block, quantity, m):
    """A bounded output of the network, which limits its change of a prediction."""
    return bounded(get(work, block, quantity, m))


@inner()
def combine(work, block, step):
    """The mean force expected in the step and its tilt, from the network's bounded outputs o.

    F = f + 2 s o_0 along the normal and p (1 + w o_2) + q' o_3 + r' o_4 across it, the tilt likewise with o_1, o_5,
    o_6, o_7 and without f and p. s (see `may_change`) is zero in balance, w = s / (s + |f|); q' and r' are q and r,
    shortened to about the Coulomb cap mu (|f| + s) (q to 1.5 of it). In balance no change is
    expected.
    """
    for m in range(LANES):
        x, u, f, a, normal, p, q, r = directions(work, block, m, step)
        _, unit = units(work, block, m, step)
        s = may_change(x, u, f, a)
        cap = get(work, block, LANE.law.friction, m) * (abs(f) + s)
        by_q = SLIP_SHARE * cap / (cap + math.sqrt(dot(q, q)) + SMALL)
        by_r = cap / (cap + math.sqrt(dot(r, r)) + SMALL)
        w = s / (s + abs(f) + SMALL)
        mean = add_scaled(scale(f + NORMAL_SHARE * s * output(work, block, PAIR.outputs.normal, m), normal), 1.0, p)
        mean = add_scaled(mean, w * output(work, block, PAIR.outputs.friction, m), p)
        mean = add_scaled(mean, by_q * output(work, block, PAIR.outputs.slip, m), q)
        mean = add_scaled(mean, by_r * output(work, block, PAIR.outputs.sideways, m), r)
        tilt = add_scaled(
            scale(NORMAL_SHARE * s * output(work, block, PAIR.outputs.normal_tilt, m), normal),
            w * output(work, block, PAIR.outputs.friction_tilt, m),
            p,
        )
        tilt = add_scaled(tilt, by_q * output(work, block, PAIR.outputs.slip_tilt, m), q)
        tilt = add_scaled(tilt, by_r * output(work, block, PAIR.outputs.sideways_tilt, m), r)
        put_vector(work, block, PAIR.expected_force, m, scale(unit, mean))
        put_vector(work, block, PAIR.expected_tilt, m, scale(unit, tilt))


@inner()
def predict_all(weights, layer, coarse, blocks, step):
    """The predictions for all contacts after a round of messages."""
    work, first, second, n = coarse.work, coarse.first_row, coarse.second_row, blocks * LANES
    for block in range(blocks):
        describe(work, block, step)
        for k in range(INPUTS):
            for m in range(LANES):
                first[k * n + block * LANES + m] = get(work, block, INPUTS_AT + k, m)
    linear(weights.first[layer], weights.first_bias[layer], first, second, n, True)
    linear(weights.second[layer], weights.second_bias[layer], second, first, n, True)
    linear(weights.last[layer], weights.last_bias[layer], first, second, n, False)
    for block in range(blocks):
        for k in range(OUTPUTS):
            for m in range(LANES):
                put(work, block, OUTPUTS_AT + k, m, second[k * n + block * LANES + m])
        combine(work, block, step)
