"""The impact of two spheres, or of a sphere on a wall, as ordinary differential equations solved to ten digits.

An oracle for the regimes that have no closed form: the same law (thesis Eqs 3.3 to 3.14), written for a planar impact
in other variables, with the moments when the spring meets or leaves its limit found as events, and no line shared with
the kernel.
"""

import math
from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp

# State: overlap, radial and tangential relative velocity, the two spins, spring, turn of the normal, three works.
OVERLAP, RADIAL, TANGENTIAL, SPIN_1, SPIN_2, SPRING, TURN, NORMAL_WORK, DAMPING_WORK, TANGENTIAL_WORK = range(10)


@dataclass(frozen=True)
class Pair:
    """Two spheres, or a sphere and a wall (second radius, mass and inertia infinite), and their contact's stiffness.

    kn, kt, cn, ct: coefficients of delta^(3/2), delta^(1/2), delta^(1/4) and delta^(1/4) in K_n delta, K_t, C_n, C_t.
    """

    radius: tuple[float, float]
    mass: tuple[float, float]
    inertia: tuple[float, float]
    kn: float
    kt: float
    cn: float
    ct: float
    mu: float

    @property
    def reduced_mass(self) -> float:
        """m* [kg]."""
        return 1 / (1 / self.mass[0] + 1 / self.mass[1])

    def arms(self, overlap: float) -> tuple[float, float, float]:
        """Centre to contact point of both bodies, and the distance of the centres (infinite for a wall) [m]."""
        first, second = self.radius
        if math.isinf(second):
            return first - overlap, 0.0, math.inf
        distance = first + second - overlap
        arm = (distance**2 + first**2 - second**2) / (2 * distance)
        return arm, distance - arm, distance


class Impact:
    """The equations of motion; `held` tells whether the spring is free (0) or at its limit (+1, -1: its sense)."""

    def __init__(self, pair: Pair) -> None:
        self.pair, self.held = pair, 0
        # |s| <= mu K_n / K_t, which is `ratio` times the overlap.
        self.ratio = pair.mu * pair.kn / pair.kt

    def slip(self, y) -> float:
        """Tangential velocity at the contact point [m/s]."""
        first, second, _ = self.pair.arms(y[OVERLAP])
        return y[TANGENTIAL] - first * y[SPIN_1] - second * y[SPIN_2]

    def rate(self, _, y):
        """d(state)/dt; radial and tangential velocities are those along the turning normal."""
        pair, overlap, slip = self.pair, max(y[OVERLAP], 0.0), self.slip(y)
        first, second, distance = pair.arms(overlap)
        damping = pair.cn * overlap**0.25 * y[RADIAL]
        elastic = pair.kn * overlap**1.5
        cap, viscous = pair.mu * elastic, pair.ct * overlap**0.25 * slip
        trial = (self.held * cap if self.held else pair.kt * overlap**0.5 * y[SPRING]) + viscous
        drag = min(max(trial, -cap), cap)
        inverse = 1 / pair.mass[0] + 1 / pair.mass[1]
        return (
            -y[RADIAL],
            (elastic - damping) * inverse + y[TANGENTIAL] ** 2 / distance,
            -drag * inverse - y[RADIAL] * y[TANGENTIAL] / distance,
            first * drag / pair.inertia[0],
            second * drag / pair.inertia[1],
            -self.held * self.ratio * y[RADIAL] if self.held else slip,
            y[TANGENTIAL] / distance,
            damping * y[RADIAL],
            viscous * slip if drag == trial else 0.0,
            drag * slip,
        )

    def outruns(self, y) -> float:
        """How much faster the slip would draw the spring than its limit grows [m/s], in the sense of `held`."""
        return self.held * self.slip(y) + self.ratio * y[RADIAL]

    def switch(self, _, y) -> float:
        """Positive while the spring's present mode lasts."""
        return self.outruns(y) if self.held else self.ratio * y[OVERLAP] - abs(y[SPRING])

    def begin(self, y) -> None:
        """The mode at first touch."""
        self.held = int(np.sign(self.slip(y)))
        if self.outruns(y) <= 0:
            self.held = 0

    def change(self, y) -> None:
        """The mode after a switch."""
        self.held = 0 if self.held else int(math.copysign(1, y[SPRING]))


def solve_impact(pair: Pair, approach: float, tangential: float, spin: tuple[float, float]) -> tuple[np.ndarray, float]:
    """State at the end of an impact (10,), and its duration [s].

    approach: closing speed along the normal [m/s], tangential: relative velocity of the first body along t [m/s],
    spin: both bodies' angular velocities about n x t [rad/s]. Contact ends where the overlap is back at zero.
    """
    y = np.zeros(10)
    y[RADIAL], y[TANGENTIAL], y[SPIN_1], y[SPIN_2] = -approach, tangential, *spin
    impact = Impact(pair)
    impact.begin(y)
    depth = (1.25 * pair.reduced_mass * approach**2 / pair.kn) ** 0.4
    speed = max(approach, abs(impact.slip(y)))
    energy = pair.reduced_mass * speed**2
    turning = speed / pair.radius[0]
    scale = np.array([depth, speed, speed, turning, turning, depth, depth / pair.radius[0], energy, energy, energy])

    def apart(_, y) -> float:
        return y[OVERLAP]

    def switch(t, y) -> float:
        return impact.switch(t, y)

    apart.terminal = switch.terminal = True
    apart.direction = switch.direction = -1
    time, longest = 0.0, 50 * depth / approach
    for _ in range(50):
        solution = solve_ivp(
            impact.rate, (time, longest), y, method="DOP853", rtol=1e-10, atol=1e-12 * scale, events=(apart, switch),
            first_step=1e-5 * depth / speed,
        )  # fmt: skip
        assert solution.status == 1, solution.message
        time, y = float(solution.t[-1]), solution.y[:, -1].copy()
        if solution.t_events[0].size:
            return y, time
        impact.change(y)
    raise RuntimeError("the impact does not end")
