"""Closed forms for the contact cases: the final state of a set-up from its material, radii and initial state.

Each takes a ContactCase (tests/physics/contact_cases.py) and returns {quantity: expected}, or None where the set-up is
not in the form's regime. Balls are solid spheres; a wall has R* = R and m* = m. v: approach speed, u: slip at first
touch, d: overlap; n points from the second body (or the wall) to the first ball, y is across the plane of motion,
t = y x n.

Regimes of an oblique impact, with K_n d = k_n d^(3/2), K_t = k_t d^(1/2), k_t / k_n = 3 (1 - nu) / (2 - nu):
- u >= 7/2 mu (1 + e) v: slides from first to last touch; with e = 1 (no dashpot) already from mu (7 - k_n / k_t) v on,
  since the spring's limit then recedes as fast as the overlap. All follows from the impulse mu m* (1 + e) v.
- u < mu (k_n / k_t) v: the spring is free at first touch, and the contact sticks until the overlap recedes.
- between: sliding, then sticking. Here and in the regime above the equations of motion are solved (planar_impact).
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from tests.physics.planar_impact import (
    DAMPING_WORK,
    NORMAL_WORK,
    RADIAL,
    SPIN_1,
    SPIN_2,
    TANGENTIAL,
    TANGENTIAL_WORK,
    TURN,
    Pair,
    solve_impact,
)

ACROSS = np.array([0.0, 1.0, 0.0])
UP = np.array([0.0, 0.0, 1.0])

# Duration of a Hertz impact over d_max / v: 2 Int_0^1 dx / sqrt(1 - x^(5/2)).
HERTZ_DURATION = 2 * math.sqrt(math.pi) * math.gamma(1.4) / math.gamma(0.9)


@dataclass(frozen=True)
class ClosedForm:
    """A closed form by name: the function, and the quantities that it gives."""

    function: Callable
    gives: tuple[str, ...]

    def __call__(self, case) -> dict[str, np.ndarray] | None:
        found = self.function(case)
        return None if found is None else {name: np.asarray(value, dtype=float) for name, value in found.items()}


CLOSED_FORMS: dict[str, ClosedForm] = {}


def gives(*quantities: str):
    """Enter a function into the closed forms, with the quantities that it gives."""

    def enter(function):
        CLOSED_FORMS[function.__name__] = ClosedForm(function, quantities)
        return function

    return enter


def normal_of(case) -> np.ndarray:
    """n at the start (3,): from the wall or from the second ball to the first."""
    if case.wall:
        return UP
    away = case.position[0] - case.position[1]
    return away / np.linalg.norm(away)


def stiffness(material, radius: float) -> tuple[float, float]:
    """(k_n, k_t) of an effective radius [m]: k_n = 4/3 E* sqrt(R*), k_t = 8 G* sqrt(R*) (Eqs 3.4, 3.5, 3.11, 3.12).

    Of linear springs, those of the material [N/m].
    """
    if material.kind == "linear":
        return material.normal_stiffness_n_m, material.normal_stiffness_n_m * material.tangential_stiffness_ratio
    modulus, poisson = material.young_modulus_gpa * 1e9, material.poisson_ratio
    shear_modulus = modulus / (2 * (1 + poisson))
    effective = 1 / (2 * (1 - poisson**2) / modulus)
    effective_shear = 1 / (2 * (2 - poisson) / shear_modulus)
    return 4 / 3 * effective * math.sqrt(radius), 8 * effective_shear * math.sqrt(radius)


def pair_of(case) -> Pair:
    """The two bodies of a case with their contact's coefficients (Eqs 3.6 to 3.10)."""
    radius, mass, inertia = ([*array, math.inf][:2] for array in (case.radius, case.mass, case.inertia))
    reduced = 1 / (1 / mass[0] + 1 / mass[1])
    kn, kt = stiffness(case.material, 1 / (1 / radius[0] + 1 / radius[1]))
    logarithm = math.log(case.material.restitution)
    ratio = -logarithm / math.sqrt(logarithm**2 + math.pi**2)
    # C = 2 sqrt(5/6) ratio sqrt(S m*) with the tangent stiffness S_n = 2 E* sqrt(R* d) = 3/2 k_n sqrt(d), S_t = K_t.
    factor, tangent = (1.0, 1.0) if case.material.kind == "linear" else (math.sqrt(5 / 6), 1.5)
    cn, ct = (2 * factor * ratio * math.sqrt(s * reduced) for s in (tangent * kn, kt))
    return Pair(
        tuple(map(float, radius)), tuple(map(float, mass)), tuple(map(float, inertia)), kn, kt, cn, ct,
        case.material.static_friction,
    )  # fmt: skip


def approach_of(case) -> tuple[float, float, np.ndarray]:
    """(approach speed v, slip u at first touch, t): of bodies that touch at the start."""
    normal = normal_of(case)
    along = np.cross(ACROSS, normal)
    relative = case.velocity[0] - (0 if case.wall else case.velocity[1])
    slip = relative @ along - float((case.radius * (case.spin @ ACROSS)).sum())
    return -float(relative @ normal), slip, along


def lab_velocities(case, relative: np.ndarray) -> np.ndarray:
    """Velocities (n, 3) from the relative one, the common momentum kept."""
    if case.wall:
        return relative[None]
    mass = case.mass
    centre = mass @ case.velocity / mass.sum()
    return centre + np.outer([mass[1], -mass[0]], relative) / mass.sum()


@gives("velocity_m_s", "spin_rad_s", "peak_force_N", "peak_overlap_m", "duration_s", "normal_damping_J", "sliding_J")
def hertz_impact(case):
    """Elastic normal impact: d_max = (5 m* v^2 / (4 k_n))^(2/5), F = k_n d_max^(3/2), t = 2.943 d_max / v (Hertz)."""
    pair, (speed, _, _) = pair_of(case), approach_of(case)
    depth = (1.25 * pair.reduced_mass * speed**2 / pair.kn) ** 0.4
    return {
        "velocity_m_s": lab_velocities(case, speed * normal_of(case)),
        "spin_rad_s": case.spin,
        "peak_force_N": pair.kn * depth**1.5,
        "peak_overlap_m": depth,
        "duration_s": HERTZ_DURATION * depth / speed,
        "normal_damping_J": 0.0,
        "sliding_J": 0.0,
    }


@gives("velocity_m_s", "peak_overlap_m", "duration_s", "normal_damping_J")
def damped_hertz_impact(case):
    """Normal impact with restitution e: in x = d^(5/4) the law is a damped linear oscillator (Antypov, Elliott 2011).

    In the time s with dx/ds = d(d)/dt, x'' + (4/5)(c_n / m*) x' + (4/5)(k_n / m*) x = 0, so that rebound and approach
    speed are as exp(-pi zeta / sqrt(1 - zeta^2)) = e at any speed, and dt = (4/5) x^(-1/5) ds.
    """
    pair, (speed, _, _) = pair_of(case), approach_of(case)
    restitution = case.material.restitution
    zeta = -math.log(restitution) / math.hypot(math.log(restitution), math.pi)
    frequency = math.sqrt(0.8 * pair.kn / pair.reduced_mass)
    ringing = frequency * math.sqrt(1 - zeta**2)
    top = math.acos(zeta) / ringing
    deepest = speed / ringing * math.exp(-zeta * frequency * top) * math.sin(ringing * top)
    nodes, weights = np.polynomial.legendre.leggauss(80)
    # s = (pi / ringing) w^5 (6 - 5 w) has no slope at 0, nor the integrand a singularity; mirrored for the other end.
    time = 0.0
    for begin in (0.0, 1.0):
        w = 0.5 * (nodes + 1)
        half, slope = 0.5 * w**5, 2.5 * w**4
        s = np.pi / ringing * (half if begin == 0 else 1 - half)
        sine = np.sin(np.pi * half)
        x = speed / ringing * np.exp(-zeta * frequency * s) * sine
        time += 0.5 * np.pi / ringing * float((weights * slope * 0.8 * x**-0.2).sum())
    return {
        "velocity_m_s": lab_velocities(case, restitution * speed * normal_of(case)),
        "peak_overlap_m": deepest**0.8,
        "duration_s": time,
        "normal_damping_J": 0.5 * pair.reduced_mass * speed**2 * (1 - restitution**2),
    }


@gives("velocity_m_s", "peak_overlap_m", "duration_s", "normal_damping_J")
def damped_linear_impact(case):
    """Normal impact of linear springs: a damped oscillator for half a period, pi / omega_d, at any speed."""
    pair, (speed, slip, _) = pair_of(case), approach_of(case)
    if slip:
        return None
    restitution, frequency = case.material.restitution, math.sqrt(pair.kn / pair.reduced_mass)
    zeta = pair.cn / (2 * math.sqrt(pair.kn * pair.reduced_mass))
    ringing = frequency * math.sqrt(1 - zeta**2)
    top = math.acos(zeta) / ringing
    return {
        "velocity_m_s": lab_velocities(case, restitution * speed * normal_of(case)),
        "peak_overlap_m": speed / ringing * math.exp(-zeta * frequency * top) * math.sin(ringing * top),
        "duration_s": math.pi / ringing,
        "normal_damping_J": 0.5 * pair.reduced_mass * speed**2 * (1 - restitution**2),
    }


@gives("velocity_m_s", "spin_rad_s")
def linear_grip(case):
    """Oblique impact of undamped linear springs without sliding: u' = u cos(pi sqrt(7/2 k_t / k_n)).

    The slip swings at sqrt(7/2 k_t / m*) for half a period of the normal spring. Impulse J = 2/7 m* (u - u').
    """
    pair, (speed, slip, along) = pair_of(case), approach_of(case)
    impulse = 2 / 7 * pair.reduced_mass * slip * (1 - math.cos(math.pi * math.sqrt(3.5 * pair.kt / pair.kn)))
    tangential = float(case.velocity[0] @ along) - impulse / pair.reduced_mass
    return {
        "velocity_m_s": lab_velocities(case, speed * normal_of(case) + tangential * along),
        "spin_rad_s": case.spin + np.outer(2.5 * impulse / (case.mass * case.radius), ACROSS),
    }


@lru_cache(maxsize=512)
def _solved(pair: Pair, approach: float, tangential: float, spin: tuple[float, float]):
    return solve_impact(pair, approach, tangential, spin)


@gives(
    "velocity_m_s", "rim_over_slip", "duration_s", "normal_damping_J", "tangential_damping_share", "sliding_share"
)  # fmt: skip
def planar_impact(case):
    """Oblique impact in any regime, from the equations of motion (tests/physics/planar_impact.py).

    Spins and tangential works are over the slip: R w / u, and the work over m* u^2 / 7, which it takes to end the slip.
    """
    approach, slip, along = approach_of(case)
    slip_energy = pair_of(case).reduced_mass * slip**2 / 7
    relative = case.velocity[0] - (0 if case.wall else case.velocity[1])
    spins = [*(case.spin @ ACROSS), 0.0][:2]
    end, duration = _solved(pair_of(case), approach, float(relative @ along), tuple(map(float, spins)))
    turn, normal = end[TURN], normal_of(case)
    # A turn about y takes n to t.
    normal, along = (math.cos(turn) * normal + math.sin(turn) * along, math.cos(turn) * along - math.sin(turn) * normal)
    return {
        "velocity_m_s": lab_velocities(case, end[RADIAL] * normal + end[TANGENTIAL] * along),
        "rim_over_slip": np.outer(case.radius * end[[SPIN_1, SPIN_2]][: len(case.balls)] / abs(slip), ACROSS),
        "duration_s": duration,
        "normal_damping_J": end[NORMAL_WORK],
        "tangential_damping_share": end[DAMPING_WORK] / slip_energy,
        "sliding_share": (end[TANGENTIAL_WORK] - end[DAMPING_WORK]) / slip_energy,
    }


def slides_throughout(case) -> bool:
    """Whether an oblique impact slides from first to last touch (the regimes at the head of this file)."""
    pair, (speed, slip, _) = pair_of(case), approach_of(case)
    restitution = case.material.restitution
    bound = 3.5 * (1 + restitution) - (pair.kn / pair.kt if restitution == 1 else 0)
    return abs(slip) > pair.mu * bound * speed


@gives("velocity_m_s", "spin_rad_s", "tangential_damping_J", "sliding_J")
def gross_sliding(case):
    """Impact that slides throughout: the rigid-body impulse J = mu (1 + e) m* v against the slip (Walton 1993).

    Delta v = J / m, Delta w = 5/2 J / (m R), work J (u + u') / 2 with u' = u - 7/2 J / m*. Levers are taken as the
    radii, which the overlap shortens: an error of up to d_max / R in the spins.
    """
    if not slides_throughout(case):
        return None
    pair, (speed, slip, along) = pair_of(case), approach_of(case)
    impulse = math.copysign(pair.mu * (1 + case.material.restitution) * pair.reduced_mass * speed, slip)
    relative = case.velocity[0] - (0 if case.wall else case.velocity[1])
    normal = normal_of(case)
    tangential = float(relative @ along) - impulse / pair.reduced_mass
    rebound = case.material.restitution * speed * normal
    return {
        "velocity_m_s": lab_velocities(case, rebound + tangential * along),
        "spin_rad_s": case.spin + np.outer(2.5 * impulse / (case.mass * case.radius), ACROSS),
        "tangential_damping_J": 0.0,
        "sliding_J": impulse * (slip - 1.75 * impulse / pair.reduced_mass),
    }


@gives("velocity_m_s", "spin_rad_s", "rolling_J", "sliding_J")
def rolling_impulse(case):
    """Smooth normal impact of spinning balls: the rolling torque's impulse is mu_r R' (1 + e) m* v (Eq. 3.16).

    R' is the mean lever 2 R_1 R_2 / (R_1 + R_2), R for a wall. Delta w = impulse / I against the relative spin, as much
    angular momentum to one ball as the other loses; the work is impulse (w_rel + w_rel') / 2.
    """
    pair, (speed, _, _) = pair_of(case), approach_of(case)
    lever = case.radius[0] if case.wall else 2 * case.radius.prod() / case.radius.sum()
    relative = case.spin[0] - (0 if case.wall else case.spin[1])
    size = float(np.linalg.norm(relative))
    impulse = case.material.rolling_friction * lever * (1 + case.material.restitution) * pair.reduced_mass * speed
    change = -np.outer([1.0, -1.0][: len(case.balls)] / case.inertia, impulse * relative / size)
    left = size - impulse * float((1 / case.inertia).sum())
    assert left > 0, "the rolling torque would stop the spin within the impact"
    return {
        "velocity_m_s": lab_velocities(case, case.material.restitution * speed * normal_of(case)),
        "spin_rad_s": case.spin + change,
        "rolling_J": impulse * (size + left) / 2,
        "sliding_J": 0.0,
    }


@gives("position_m", "velocity_m_s", "spin_rad_s", "sliding_J")
def slip_cessation(case):
    """A ball set down sliding and spinning on a plane under gravity: rolls on at (5 v + 2 R w) / 7 (5/7 v with w = 0).

    It slides for 2 |u| / (7 mu g) at the deceleration mu g and loses (1/7) m u^2.
    """
    (mass,), (radius,) = case.mass, case.radius
    speed, rim = case.velocity[0, 0], radius * case.spin[0, 1]
    slip, friction = speed - rim, case.material.static_friction * case.gravity_m_s2
    sliding = 2 * abs(slip) / (7 * friction)
    assert sliding < case.duration_s, "the ball still slides at the end"
    rolling = (5 * speed + 2 * rim) / 7
    travelled = speed * sliding - math.copysign(friction, slip) * sliding**2 / 2 + rolling * (case.duration_s - sliding)
    return {
        "position_m": case.position + np.array([travelled, 0, 0]),
        "velocity_m_s": [[rolling, 0, 0]],
        "spin_rad_s": [[0, rolling / radius, 0]],
        "sliding_J": mass * slip**2 / 7,
    }


@gives("position_m", "velocity_m_s", "spin_rad_s", "rolling_J", "sliding_J")
def rolling_decay(case):
    """A ball that rolls without slip under rolling friction: decelerates at 5/7 mu_r g until it stands still."""
    (mass,), (radius,) = case.mass, case.radius
    speed, slowing = case.velocity[0, 0], 5 / 7 * case.material.rolling_friction * case.gravity_m_s2
    time = min(case.duration_s, speed / slowing)
    left = speed - slowing * time
    return {
        "position_m": case.position + np.array([speed * time - slowing * time**2 / 2, 0, 0]),
        "velocity_m_s": [[left, 0, 0]],
        "spin_rad_s": [[0, left / radius, 0]],
        "rolling_J": 0.7 * mass * (speed**2 - left**2),
        "sliding_J": 0.0,
    }


@gives("position_m", "velocity_m_s", "spin_rad_s")
def free_fall(case):
    """x + v t - g t^2 / 2, with v - g t."""
    fall, time = np.array([0, 0, case.gravity_m_s2]), case.duration_s
    return {
        "position_m": case.position + case.velocity * time - fall * time**2 / 2,
        "velocity_m_s": case.velocity - fall * time,
        "spin_rad_s": case.spin,
    }


@gives("overlap_m")
def static_stack(case):
    """Balls at rest on each other, the first on the wall: d = (W / k_n)^(2/3) under the weight W above a contact."""
    radii, weight = [math.inf, *case.radius], case.mass * case.gravity_m_s2
    return {
        "overlap_m": [
            (weight[k:].sum() / stiffness(case.material, 1 / (1 / radii[k] + 1 / radii[k + 1]))[0]) ** (2 / 3)
            for k in range(len(case.balls))
        ]
    }


@gives("momentum_drift", "angular_momentum_drift")
def conservation(case):
    """Momentum, and angular momentum about the origin, of balls that touch nothing but each other: no change.

    Both are over the sum of the sizes of every ball's part; for the angular momentum R |p| counts too.
    """
    return {"momentum_drift": np.zeros(3), "angular_momentum_drift": np.zeros(3)}


def momenta(case, position, velocity, spin) -> tuple[np.ndarray, np.ndarray]:
    """Momentum [kg m/s] and angular momentum about the origin [kg m2/s] of each ball (n, 3)."""
    momentum = case.mass[:, None] * velocity
    return momentum, np.cross(position, momentum) + case.inertia[:, None] * spin
