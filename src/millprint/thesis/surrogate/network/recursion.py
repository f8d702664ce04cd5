"""Steps of a roll-out as one kernel: edges, network, motion, snap-back and the next snapshot (thesis Fig. 6.5)."""

import math
from typing import NamedTuple

import numpy as np

from millprint.mill.distance import distance_at
from millprint.mill.vectors import add_scaled, dot, subtract
from millprint.run.kernel import inner, kernel
from millprint.thesis.surrogate.network.forward import join, predict


class Rules(NamedTuple):
    """The rules of the recursion; snap_back_m is infinite for never. Thresholds of edges are in single precision."""

    step_s: float
    speed_rpm: float
    reach_squared_m2: np.float32
    wall_threshold_m: np.float32
    snap_back_m: float


class Batch(NamedTuple):
    """The state of a batch (surrogate.State), written over step by step, and what is added up over the steps."""

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

    As in surrogate.euler_step and surrogate.snap_back; a ball counts as outside before the snap-back.
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
