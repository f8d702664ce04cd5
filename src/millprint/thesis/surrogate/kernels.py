"""The roll-out as kernels: products of matrices without zeros, the network, and the steps of Fig. 6.5.

Of the numbers that a ReLU hands on, half to three quarters are zero. The others of a row are marked in a word, one bit
for each number. Their products are added up in registers, PANEL columns of the result at a time, and the sum is added
to the value in memory. In single precision, a sum of 256 numbers loses less by rounding if it is taken in parts.
Columns are taken PANEL at a time: arrays are filled up to whole panels with columns of zeros.

The equations are those of `network` (Eqs 6.22 to 6.27) with the weights of `compiled.fold`. Nodes are numbered through
the batch, all balls before all walls. Edges are listed as pairs of balls in both directions, then from the wall to each
ball at it, then from these balls to the wall. They are worked through a piece at a time.
"""

import math
from typing import Any, NamedTuple

import numpy as np
from llvmlite import binding, ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from millprint.mill.distance import distance_at
from millprint.mill.vectors import add_scaled, dot, subtract
from millprint.run.cache_lines import aligned
from millprint.run.kernel import inlined, inner, kernel

LANES = 16
# Eight vectors fill a quarter of the 32 registers of AVX-512, enough to wait for none; others have 16, half as long.
VECTORS = 8 if binding.get_host_cpu_features().get("avx512f") else 4
PANEL = VECTORS * LANES
# Numbers of a row that a word marks. This number of rows of a panel fits into the processor's first cache.
WORD = 64

# A product and a sum as one instruction where the processor has it.
_FUSED = ("contract",)
_INDEX = ir.IntType(64)
_VECTOR = ir.VectorType(ir.FloatType(), LANES)
_ALIGNED = 4
_MATRIX = types.Array(types.float32, 2, "C")


@inlined()
def mark(x, row, first, count):
    """A word for the numbers x[row, first : first + count], WORD of them at most: a bit for each that is not zero.

    NaN has a bit. With fewer than WORD numbers, all have a bit.
    """
    if count == WORD:
        return mark_whole(x, row, first)
    return (np.uint64(1) << np.uint64(count)) - np.uint64(1)


@intrinsic
def mark_whole(typing: Any, x: Any, row: Any, first: Any) -> Any:
    """The word of the WORD numbers from x[row, first] on; see `mark`. Nothing is checked."""
    del typing, x, row, first
    return types.uint64(_MATRIX, types.intp, types.intp), _compare


def _compare(context: Any, builder: ir.IRBuilder, signature: Any, arguments: Any) -> Any:
    """The instructions of `mark_whole`."""
    x = context.make_array(signature.args[0])(context, builder, arguments[0])
    vector = ir.VectorType(ir.FloatType(), WORD)
    place = builder.bitcast(_at(builder, x, *arguments[1:]), vector.as_pointer())
    # The unordered comparison is true of what is not a number.
    marks = builder.fcmp_unordered("!=", builder.load(place, align=_ALIGNED), vector(None))
    return builder.bitcast(marks, _INDEX)


@intrinsic
def add_terms(typing: Any, out: Any, weight: Any, x: Any, word: Any, row: Any, column: Any, first: Any) -> Any:
    """out[row, column:] += the sum of x[row, first + k] weight[first + k] over the bits k of a word, PANEL columns.

    All in single precision and contiguous: out (rows, columns), weight (inputs, PANEL), x (rows, inputs). Nothing is
    checked: rows and columns must be there.
    """
    del typing, word, row, column, first
    if {out, weight, x} != {_MATRIX}:
        raise TypeError(f"add_terms takes contiguous float32 matrices, not {out}, {weight}, {x}")
    return types.void(*[_MATRIX] * 3, types.uint64, *[types.intp] * 3), _generate


def _generate(context: Any, builder: ir.IRBuilder, signature: Any, arguments: Any) -> Any:
    """The instructions of `add_terms`."""
    matrix = context.make_array(signature.args[0])
    out, weight, x = (matrix(context, builder, value) for value in arguments[:3])
    word, row, column, first = arguments[3:]

    def vectors(matrix: Any, line: Any, place: Any) -> list[Any]:
        corner = _at(builder, matrix, line, place)
        places = (builder.gep(corner, [_INDEX(part * LANES)]) for part in range(VECTORS))
        return [builder.bitcast(at, _VECTOR.as_pointer()) for at in places]

    numbers = _at(builder, x, row, first)
    before, loop, after = builder.block, builder.append_basic_block("term"), builder.append_basic_block("summed")
    builder.cbranch(builder.icmp_unsigned("!=", word, word.type(0)), loop, after)

    builder.position_at_end(loop)
    left = builder.phi(word.type)
    sums = [builder.phi(_VECTOR) for _ in range(VECTORS)]
    k = builder.cttz(left, ir.IntType(1)(1))
    factor = _repeated(builder, builder.load(builder.gep(numbers, [k])))
    weights = vectors(weight, builder.add(first, k), _INDEX(0))
    added = [
        builder.fadd(total, builder.fmul(factor, builder.load(at, align=_ALIGNED), flags=_FUSED), flags=_FUSED)
        for total, at in zip(sums, weights, strict=True)
    ]
    rest = builder.and_(left, builder.sub(left, left.type(1)))
    left.add_incoming(word, before)
    left.add_incoming(rest, loop)
    for total, of_loop in zip(sums, added, strict=True):
        total.add_incoming(_VECTOR(None), before)
        total.add_incoming(of_loop, loop)
    builder.cbranch(builder.icmp_unsigned("!=", rest, rest.type(0)), loop, after)

    builder.position_at_end(after)
    totals = [builder.phi(_VECTOR) for _ in added]
    for total, of_loop in zip(totals, added, strict=True):
        total.add_incoming(_VECTOR(None), before)
        total.add_incoming(of_loop, loop)
    for total, at in zip(totals, vectors(out, row, column), strict=True):
        builder.store(builder.fadd(builder.load(at, align=_ALIGNED), total), at, align=_ALIGNED)
    return context.get_dummy_value()


def _at(builder: ir.IRBuilder, matrix: Any, line: Any, place: Any) -> Any:
    """Address of a number in a contiguous matrix."""
    width = cgutils.unpack_tuple(builder, matrix.shape)[1]
    return builder.gep(matrix.data, [builder.add(builder.mul(line, width), place)])


def _repeated(builder: ir.IRBuilder, number: Any) -> Any:
    """A vector of the same number in all lanes."""
    nowhere = ir.Constant(_VECTOR, ir.Undefined)
    one = builder.insert_element(nowhere, number, ir.IntType(32)(0))
    return builder.shuffle_vector(one, nowhere, ir.Constant(ir.VectorType(ir.IntType(32), LANES), None))


ZERO = np.float32(0.0)


@inner()
def begin(out, bias, rows):
    """out = bias in every row."""
    for r in range(rows):
        for c in range(bias.size):
            out[r, c] = bias[c]


@inner()
def clear(out, rows):
    """out = 0 in every row."""
    for r in range(rows):
        for c in range(out.shape[1]):
            out[r, c] = ZERO


@inner()
def add_product(out, weight, x, rows):
    """out += x weight, with weight (panels, inputs, PANEL) as `compiled.packed` packs it; zeros of x are left out.

    WORD inputs of a panel stay in the processor's first cache while all rows pass over them.
    """
    inputs = weight.shape[1]
    for number in range(weight.shape[0]):
        panel = weight[number]
        for first in range(0, inputs, WORD):
            count = min(WORD, inputs - first)
            for row in range(rows):
                add_terms(out, panel, x, mark(x, row, first, count), row, number * PANEL, first)


@inner()
def rectify(x, z, rows):
    """x = ReLU(z); what is not a number stays so."""
    for r in range(rows):
        for c in range(z.shape[1]):
            value = z[r, c]
            x[r, c] = ZERO if value < ZERO else value


@inner()
def through(weight, bias, x, z, rows):
    """x through hidden layers, each with a ReLU; z: what it is before that."""
    for layer in range(weight.shape[0]):
        begin(z, bias[layer], rows)
        add_product(z, weight[layer], x, rows)
        rectify(x, z, rows)


@inner()
def enter(layers, x, hidden, hidden_sum, rows):
    """x through the first layer of a perceptron and its hidden ones; hidden_sum: what these are before their ReLU."""
    begin(hidden_sum, layers.first_bias, rows)
    add_product(hidden_sum, layers.first, x, rows)
    rectify(hidden, hidden_sum, rows)
    through(layers.hidden.weight, layers.hidden.bias, hidden, hidden_sum, rows)


# Edges in a piece: their hidden values stay in the processor's second cache.
PIECE = 64
ONE = np.float32(1.0)
TINY = np.finfo(np.float32).tiny
# Rows of compiled.Folded.mean and .deviation.
BALL, WALL, PAIR, WALL_EDGE, ACCELERATION, DISSIPATION = range(6)


class Scratch(NamedTuple):
    """What a step writes over: node rows hold all balls, then all walls; piece rows hold edges."""

    place: np.ndarray  # (balls, 3) positions in single precision [m]
    source: np.ndarray  # (edges,) node that sends
    target: np.ndarray  # (edges,) node that receives
    features: np.ndarray  # (nodes, window * 7) normalised
    node: np.ndarray  # (nodes, width)
    node_sum: np.ndarray  # (nodes, width) before the ReLU
    to_target: np.ndarray  # (nodes, width) a node's share in the first layer of messages that it receives
    to_source: np.ndarray  # (nodes, width) and sends
    received: np.ndarray  # (nodes, width) mean of the messages
    messages: np.ndarray  # (nodes,) how many they are
    vector: np.ndarray  # (piece, 3) of an edge, normalised
    edge: np.ndarray  # (piece, width)
    edge_sum: np.ndarray  # (piece, width)
    pooled: np.ndarray  # (graphs, width)
    pooled_sum: np.ndarray  # (graphs, width)
    acceleration: np.ndarray  # (balls, PANEL) the first three [m/s2]
    dissipation: np.ndarray  # (graphs, PANEL) the first [J]


def make_scratch(graphs: int, balls: int, inputs: int, width: int) -> Scratch:
    """Scratch for graphs of `balls` balls each; inputs of a node, and width filled up to whole panels."""
    nodes, edges = graphs * (balls + 1), graphs * balls * (balls + 1)

    def rows(count: int, columns: int) -> np.ndarray:
        return aligned(np.zeros((count, columns), dtype=np.float32))

    return Scratch(
        place=rows(graphs * balls, 3),
        source=np.empty(edges, dtype=np.int32),
        target=np.empty(edges, dtype=np.int32),
        features=rows(nodes, inputs),
        **{name: rows(nodes, width) for name in ("node", "node_sum", "to_target", "to_source", "received")},
        messages=np.zeros(nodes, dtype=np.int64),
        vector=rows(PIECE, 3),
        edge=rows(PIECE, width),
        edge_sum=rows(PIECE, width),
        pooled=rows(graphs, width),
        pooled_sum=rows(graphs, width),
        acceleration=rows(graphs * balls, PANEL),
        dissipation=rows(graphs, PANEL),
    )


@inner()
def join(scratch, position, ball, reach_squared, wall_threshold):
    """List the edges of every graph (dataset.threshold_edges); returns how many join two balls, and balls to walls.

    position (graphs, balls, 3), ball (graphs, balls, window, 7); reach_squared [m2] and wall_threshold [m] in single
    precision, as the network's inputs are.
    """
    graphs, balls, window = ball.shape[0], ball.shape[1], ball.shape[2]
    place, source, target = scratch.place, scratch.source, scratch.target
    for g in range(graphs):
        for b in range(balls):
            for c in range(3):
                place[g * balls + b, c] = np.float32(position[g, b, c])
    count = 0
    for g in range(graphs):
        for i in range(g * balls, (g + 1) * balls):
            for j in range(i + 1, (g + 1) * balls):
                x, y, z = place[j, 0] - place[i, 0], place[j, 1] - place[i, 1], place[j, 2] - place[i, 2]
                if x * x + y * y + z * z <= reach_squared:
                    source[count], target[count] = j, i
                    source[count + 1], target[count + 1] = i, j
                    count += 2
    walls = 0
    for g in range(graphs):
        for b in range(balls):
            if ball[g, b, window - 1, 3] >= wall_threshold:
                source[count + walls], target[count + walls] = graphs * balls + g, g * balls + b
                walls += 1
    for w in range(count, count + walls):
        source[w + walls], target[w + walls] = target[w], source[w]
    return count, walls


@inner()
def normalise(weights, scratch, ball, wall):
    """The features of balls (graphs, balls, window, 7) and walls (graphs, window, 7), normalised, a row a node.

    Here and for edges in double precision, which costs nothing: a rounding at the start reaches everything after it.
    """
    graphs, balls, window, channels = ball.shape
    features, mean, deviation = scratch.features, weights.mean, weights.deviation
    for g in range(graphs):
        for t in range(window):
            for c in range(channels):
                at = t * channels + c
                for b in range(balls):
                    features[g * balls + b, at] = (np.float64(ball[g, b, t, c]) - mean[BALL, c]) / deviation[BALL, c]
                features[graphs * balls + g, at] = (np.float64(wall[g, t, c]) - mean[WALL, c]) / deviation[WALL, c]


@inner()
def write_vectors(weights, scratch, ball, first, count):
    """The normalised vectors of the edges first to first + count (Eqs 6.20 and 6.21)."""
    graphs, balls, window = ball.shape[0], ball.shape[1], ball.shape[2]
    place, vector, mean, deviation = scratch.place, scratch.vector, weights.mean, weights.deviation
    for e in range(count):
        source, target = scratch.source[first + e], scratch.target[first + e]
        at = min(source, target)
        if max(source, target) < graphs * balls:
            for c in range(3):
                length = np.float64(place[source, c]) - place[target, c]
                vector[e, c] = (length - mean[PAIR, c]) / deviation[PAIR, c]
        else:
            newest = ball[at // balls, at % balls, window - 1]
            x, y, z = np.float64(newest[4]), np.float64(newest[5]), np.float64(newest[6])
            size = max(np.sqrt(x * x + y * y + z * z), TINY)
            for c in range(3):
                length = newest[3] * newest[4 + c] / size
                vector[e, c] = (length - mean[WALL_EDGE, c]) / deviation[WALL_EDGE, c]


@inner()
def exchange(weights, scratch, ball, layer, edges, nodes):
    """The mean of the messages along the first `edges` edges into each of the first `nodes` nodes (Eqs 6.24, 6.25)."""
    received, messages, edge, edge_sum = scratch.received, scratch.messages, scratch.edge, scratch.edge_sum
    width = edge.shape[1]
    clear(received, nodes)
    for n in range(nodes):
        messages[n] = 0
    for first in range(0, edges, PIECE):
        count = min(PIECE, edges - first)
        write_vectors(weights, scratch, ball, first, count)
        enter(weights.edge, scratch.vector, edge, edge_sum, count)
        for e in range(count):
            to_target = scratch.to_target[scratch.target[first + e]]
            to_source = scratch.to_source[scratch.source[first + e]]
            for c in range(width):
                edge_sum[e, c] = to_target[c] + to_source[c]
        add_product(edge_sum, weights.to_edge[layer], edge, count)
        rectify(edge, edge_sum, count)
        through(weights.message.weight[layer], weights.message.bias[layer], edge, edge_sum, count)
        for e in range(count):
            target = scratch.target[first + e]
            messages[target] += 1
            for c in range(width):
                received[target, c] += edge[e, c]
    for n in range(nodes):
        if messages[n] > 1:
            share = ONE / np.float32(messages[n])
            for c in range(width):
                received[n, c] *= share


@inner()
def update(weights, scratch, layer, nodes):
    """The new values of the first `nodes` nodes from their own and their messages (Eq. 6.26)."""
    node, node_sum = scratch.node, scratch.node_sum
    begin(node_sum, weights.own_bias[layer], nodes)
    for n in range(nodes):
        if scratch.messages[n] > 0:
            for c in range(node.shape[1]):
                node_sum[n, c] += weights.received_bias[layer, c]
    add_product(node_sum, weights.own[layer], node, nodes)
    add_product(node_sum, weights.received[layer], scratch.received, nodes)
    rectify(node, node_sum, nodes)
    through(weights.updated.weight[layer], weights.updated.bias[layer], node, node_sum, nodes)


@inner()
def read_out(weights, scratch, graphs, balls):
    """The dissipation of every graph [J], from the mean of its balls that have an edge (Eq. 6.27)."""
    node, pooled, pooled_sum, out = scratch.node, scratch.pooled, scratch.pooled_sum, scratch.dissipation
    width = node.shape[1]
    begin(pooled_sum, weights.readout.first_bias, graphs)
    for g in range(graphs):
        touched = 0
        for c in range(width):
            pooled[g, c] = ZERO
        for n in range(g * balls, (g + 1) * balls):
            if scratch.messages[n] > 0:
                touched += 1
                for c in range(width):
                    pooled[g, c] += node[n, c]
        if touched > 0:
            share = ONE / np.float32(touched)
            for c in range(width):
                pooled[g, c] *= share
                pooled_sum[g, c] += weights.readout_any_bias[c]
    add_product(pooled_sum, weights.readout.first, pooled, graphs)
    rectify(pooled, pooled_sum, graphs)
    through(weights.readout.hidden.weight, weights.readout.hidden.bias, pooled, pooled_sum, graphs)
    begin(out, weights.readout_last_bias, graphs)
    add_product(out, weights.readout_last, pooled, graphs)
    for g in range(graphs):
        out[g, 0] = out[g, 0] * weights.deviation[DISSIPATION, 0] + weights.mean[DISSIPATION, 0]


@inner()
def decode(weights, scratch, count):
    """The acceleration of every ball [m/s2]."""
    node, node_sum, out = scratch.node, scratch.node_sum, scratch.acceleration
    enter(weights.decoder, node, node, node_sum, count)
    begin(out, weights.decoder_last_bias, count)
    add_product(out, weights.decoder_last, node, count)
    for n in range(count):
        for c in range(3):
            out[n, c] = out[n, c] * weights.deviation[ACCELERATION, c] + weights.mean[ACCELERATION, c]


@inner()
def predict(weights, scratch, ball, wall, pairs, walls):
    """Accelerations and dissipation, into the scratch, from features and the edges that `join` has listed."""
    graphs, balls = ball.shape[0], ball.shape[1]
    node, node_sum, nodes = scratch.node, scratch.node_sum, graphs * (balls + 1)
    normalise(weights, scratch, ball, wall)
    enter(weights.node, scratch.features, node, node_sum, nodes)
    rounds = weights.own.shape[0]
    for layer in range(rounds):
        # Of the wall's own output nothing is used, so nothing is sent to it in the last round.
        last = layer == rounds - 1
        receivers = graphs * balls if last else nodes
        begin(scratch.to_target, weights.message_bias[layer], receivers)
        clear(scratch.to_source, nodes)
        add_product(scratch.to_target, weights.to_target[layer], node, receivers)
        add_product(scratch.to_source, weights.to_source[layer], node, nodes)
        exchange(weights, scratch, ball, layer, pairs + walls if last else pairs + 2 * walls, receivers)
        update(weights, scratch, layer, receivers)
    read_out(weights, scratch, graphs, balls)
    decode(weights, scratch, graphs * balls)


class Rules(NamedTuple):
    """The rules of the recursion; snap_back_m is infinite for never. Thresholds of edges are in single precision."""

    step_s: float
    speed_rpm: float
    reach_squared_m2: np.float32
    wall_threshold_m: np.float32
    snap_back_m: float


class Batch(NamedTuple):
    """The state of a batch (graph_surrogate.State), written over step by step, and what is added up over the steps."""

    position: np.ndarray  # (graphs, balls, 3) [m]
    velocity: np.ndarray  # (graphs, balls, 3) [m/s]
    ball: np.ndarray  # (graphs, balls, window, 7) single precision
    wall: np.ndarray  # (graphs, window, 7) single precision
    dissipated: np.ndarray  # (graphs,) [J]
    crossed: np.ndarray  # (graphs, balls) the first step after which a centre was outside; infinity if never
    edges: np.ndarray  # (2,) to walls and between balls, counted once each


@inner()
def place_at(surface, point, wall):
    """Signed distance [m] and gradient at a point with the vessel at `wall`; not a number where the point is none."""
    relative = subtract(point, wall)
    if math.isfinite(relative[0]) and math.isfinite(relative[1]) and math.isfinite(relative[2]):
        return distance_at(surface, relative)
    return np.nan, (np.nan, np.nan, np.nan)


@inner()
def move_ball(batch, surface, rules, g, b, acceleration, wall):
    """Explicit Euler (Eqs 6.31 and 6.32), snap-back, and the ball's newest features; True if it was outside.

    As in graph_surrogate.euler_step and snap_back; a ball counts as outside before the snap-back.
    """
    position, velocity, ball = batch.position[g, b], batch.velocity[g, b], batch.ball[g, b]
    for c in range(3):
        position[c] += velocity[c] * rules.step_s
        velocity[c] += np.float64(acceleration[c]) * rules.step_s
    point = (position[0], position[1], position[2])
    distance, gradient = place_at(surface, point, wall)
    outside = not distance < 0.0
    if distance >= rules.snap_back_m:
        back = (rules.snap_back_m - distance) / math.sqrt(dot(gradient, gradient))
        point = add_scaled(point, back, gradient)
        position[0], position[1], position[2] = point
        distance, gradient = place_at(surface, point, wall)
    last = ball.shape[0] - 1
    for t in range(last):
        for c in range(ball.shape[1]):
            ball[t, c] = ball[t + 1, c]
    ball[last, 0], ball[last, 1], ball[last, 2] = velocity[0], velocity[1], velocity[2]
    ball[last, 3] = distance
    ball[last, 4], ball[last, 5], ball[last, 6] = gradient
    return outside


@inner()
def move_wall(batch, rules, g, wall):
    """The newest features of a wall."""
    features = batch.wall[g]
    last = features.shape[0] - 1
    for t in range(last):
        for c in range(features.shape[1]):
            features[t, c] = features[t + 1, c]
    for c in range(features.shape[1]):
        features[last, c] = 0.0
    features[last, 0], features[last, 1], features[last, 2] = wall
    features[last, 3] = rules.speed_rpm


@kernel()
def roll(weights, scratch, surface, rules, batch, walls):
    """Advance a batch through as many steps as there are positions of its vessels, walls (steps, graphs, 3) [m]."""
    graphs, balls = batch.ball.shape[0], batch.ball.shape[1]
    for step in range(walls.shape[0]):
        pairs, at_wall = join(scratch, batch.position, batch.ball, rules.reach_squared_m2, rules.wall_threshold_m)
        predict(weights, scratch, batch.ball, batch.wall, pairs, at_wall)
        batch.edges[0] += at_wall
        batch.edges[1] += pairs // 2
        for g in range(graphs):
            batch.dissipated[g] += scratch.dissipation[g, 0]
            wall = (walls[step, g, 0], walls[step, g, 1], walls[step, g, 2])
            for b in range(balls):
                acceleration = scratch.acceleration[g * balls + b]
                if move_ball(batch, surface, rules, g, b, acceleration, wall) and batch.crossed[g, b] > step + 1:
                    batch.crossed[g, b] = step + 1
            move_wall(batch, rules, g, wall)
