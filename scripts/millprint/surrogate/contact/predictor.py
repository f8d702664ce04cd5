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

from millprint.dem import lanes
from millprint.dem.lanes import LANES
from millprint.dem.law import KN, MU, REACH
from millprint.kernel import inlined, inner
from millprint.mill.vectors import add_scaled, cross, dot, scale, subtract
from millprint.surrogate.contact import pair
from millprint.surrogate.contact.pair import INPUTS, OUTPUTS

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
    mass = 1.0 / lanes.get(work, block, pair.INVERSE_MASS, m)
    root = mass / (lanes.get(work, block, lanes.LAW + KN, m) * step * step)
    length = UNIT * root * root
    return length, mass * length / (step * step)


@inlined()
def directions(work, block, m, step):
    """The scalars x, u, f, a and the vectors normal, p, q, r of a contact, all dimensionless (see `describe`)."""
    length, unit = units(work, block, m, step)
    away = lanes.get_vector(work, block, pair.AWAY, m)
    distance = math.sqrt(dot(away, away))
    normal = scale(1.0 / distance, away)
    reach = lanes.get(work, block, lanes.LAW + REACH, m)
    arm, other = pair.arms(work, block, m, distance)
    velocity = lanes.get_vector(work, block, pair.VELOCITY, m)
    turning = add_scaled(
        scale(arm, lanes.get_vector(work, block, pair.ANGULAR_VELOCITY, m)),
        other,
        lanes.get_vector(work, block, pair.OTHER_ANGULAR_VELOCITY, m),
    )
    external = lanes.get_vector(work, block, pair.EXTERNAL, m)
    twisting = add_scaled(
        scale(arm, lanes.get_vector(work, block, pair.ANGULAR, m)),
        other,
        lanes.get_vector(work, block, pair.OTHER_ANGULAR, m),
    )
    force = scale(1.0 / unit, lanes.get_vector(work, block, pair.FORCE, m))
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
        friction = lanes.get(work, block, lanes.LAW + MU, m)
        size_p, size_q, size_r = math.sqrt(dot(p, p)), math.sqrt(dot(q, q)), math.sqrt(dot(r, r))
        used = size_p / (friction * abs(f) + 1e-3)
        lanes.put(work, block, pair.FEATURES + 0, m, compressed(x))
        lanes.put(work, block, pair.FEATURES + 1, m, compressed(u))
        lanes.put(work, block, pair.FEATURES + 2, m, compressed(f))
        lanes.put(work, block, pair.FEATURES + 3, m, compressed(a))
        lanes.put(work, block, pair.FEATURES + 4, m, compressed(size_p))
        lanes.put(work, block, pair.FEATURES + 5, m, compressed(size_q))
        lanes.put(work, block, pair.FEATURES + 6, m, compressed(size_r))
        lanes.put(work, block, pair.FEATURES + 7, m, dot(p, q) / (size_p * size_q + SMALL))
        lanes.put(work, block, pair.FEATURES + 8, m, dot(p, r) / (size_p * size_r + SMALL))
        lanes.put(work, block, pair.FEATURES + 9, m, dot(q, r) / (size_q * size_r + SMALL))
        lanes.put(work, block, pair.FEATURES + 10, m, used if used < 2.0 else 2.0)
        lanes.put(work, block, pair.FEATURES + 11, m, lanes.get(work, block, lanes.IS_WALL, m))
        lanes.put(work, block, pair.FEATURES + 12, m, compressed(x + u - 0.5 * a))


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
def output(work, block, number, m):
    """A bounded output of the network, which limits its change of a prediction."""
    return bounded(lanes.get(work, block, pair.OUTPUTS_AT + number, m))


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
        cap = lanes.get(work, block, lanes.LAW + MU, m) * (abs(f) + s)
        by_q = SLIP_SHARE * cap / (cap + math.sqrt(dot(q, q)) + SMALL)
        by_r = cap / (cap + math.sqrt(dot(r, r)) + SMALL)
        w = s / (s + abs(f) + SMALL)
        mean = add_scaled(scale(f + NORMAL_SHARE * s * output(work, block, 0, m), normal), 1.0, p)
        mean = add_scaled(mean, w * output(work, block, 2, m), p)
        mean = add_scaled(mean, by_q * output(work, block, 3, m), q)
        mean = add_scaled(mean, by_r * output(work, block, 4, m), r)
        tilt = add_scaled(scale(NORMAL_SHARE * s * output(work, block, 1, m), normal), w * output(work, block, 5, m), p)
        tilt = add_scaled(tilt, by_q * output(work, block, 6, m), q)
        tilt = add_scaled(tilt, by_r * output(work, block, 7, m), r)
        lanes.put_vector(work, block, pair.EXPECTED, m, scale(unit, mean))
        lanes.put_vector(work, block, pair.TILT, m, scale(unit, tilt))


@inner()
def predict_all(weights, layer, coarse, blocks, step):
    """The predictions for all contacts after a round of messages."""
    work, first, second, n = coarse.work, coarse.first_row, coarse.second_row, blocks * LANES
    for block in range(blocks):
        describe(work, block, step)
        for k in range(INPUTS):
            for m in range(LANES):
                first[k * n + block * LANES + m] = lanes.get(work, block, pair.FEATURES + k, m)
    linear(weights.first[layer], weights.first_bias[layer], first, second, n, True)
    linear(weights.second[layer], weights.second_bias[layer], second, first, n, True)
    linear(weights.last[layer], weights.last_bias[layer], first, second, n, False)
    for block in range(blocks):
        for k in range(OUTPUTS):
            for m in range(LANES):
                lanes.put(work, block, pair.OUTPUTS_AT + k, m, second[k * n + block * LANES + m])
        combine(work, block, step)
