"""Formulas for the net power of tumbling mills, as reference lines for the simulation.

Both treat the charge as a continuum of one bulk density that fills a share J of the drum, its voids included. Neither
includes lifters, friction, or balls that are carried past the top.
"""

import math
from dataclasses import dataclass

GRAVITY = 9.81
# Lift angle of Hogg and Fuerstenau [deg], a free parameter. 35 deg is a usual choice for ball mills.
LIFT_ANGLE_DEG = 35.0


@dataclass(frozen=True)
class Mill:
    """What the formulas need.

    Radius and length inside the shell [m], share J that the charge fills, voids included [-], mass [kg]. The critical
    speed is for a point at the shell, sqrt(g / R).
    """

    radius_m: float
    length_m: float
    filling: float
    mass_kg: float

    @property
    def bulk_density(self) -> float:
        """Mass of the charge over the volume that it fills, with its voids [kg/m3]."""
        return self.mass_kg / (math.pi * self.radius_m**2 * self.length_m * self.filling)


def half_angle(filling: float) -> float:
    """Half the angle of a segment of a circle [rad], from its share of the area: J = (t - sin t cos t) / pi."""
    # Slow to import, and every set-up imports this module.
    from scipy.optimize import brentq

    return float(brentq(lambda angle: (angle - math.sin(angle) * math.cos(angle)) / math.pi - filling, 0, math.pi))


def hogg_fuerstenau(mill: Mill, turns_hz: float, lift_angle_deg: float = LIFT_ANGLE_DEG) -> float:
    """Net power of a charge in the shape of a tilted segment, 2/3 rho g L R^3 sin^3(t) sin(a) 2 pi N [W].

    turns_hz: N [1/s]; t: half the angle of the segment; a: lift_angle_deg, the tilt of its surface. The torque is the
    weight of the segment times the horizontal distance of its centre from the axis (Hogg and Fuerstenau, Trans.
    SME-AIME 252 (1972) 418). In feet, short of a factor near 1, it is 0.238 D^3.5 (L/D) N_c rho (J - 1.065 J^2) sin a.
    """
    arm_m4 = 2 / 3 * mill.radius_m**3 * math.sin(half_angle(mill.filling)) ** 3 * mill.length_m
    torque = mill.bulk_density * GRAVITY * arm_m4 * math.sin(math.radians(lift_angle_deg))
    return torque * 2 * math.pi * turns_hz


@dataclass(frozen=True)
class ChargeShape:
    """The charge of Morrell's C-model: angles counter-clockwise from 3 o'clock [rad], inner radius [m].

    The mill turns counter-clockwise. profile: z of the velocity, which equals the shell's at r = R and
    2 pi N R (r - z r_i) / (R - z r_i) further in.
    """

    toe: float
    shoulder: float
    inner_radius_m: float
    profile: float


def morrell_shape(mill: Mill, critical_share: float) -> ChargeShape:
    """Shape of a dry or grate-discharge charge in the C-model (Morrell, Trans. IMM 105 (1996) C43 and C54).

    critical_share: speed over the critical speed [-]. Raises ValueError where the whole charge centrifuges: from
    phi_c = 0.35 (3.364 - J) on, no charge moves in the model.
    """
    filling = mill.filling
    centrifuge = 0.35 * (3.364 - filling)
    if critical_share >= centrifuge:
        raise ValueError(f"critical_share = {critical_share:g}: the C-model ends at {centrifuge:.3g}")
    rise = 2.5307 * (1.2796 - filling) * (1 - math.exp(-19.42 * (centrifuge - critical_share)))
    toe = math.pi / 2 + rise
    shoulder = math.pi / 2 - rise * (0.3386 + 0.1041 * centrifuge + (1.54 - 2.5673 * centrifuge) * filling)
    # The charge fills the arc from toe over the bottom to shoulder, between the inner radius and the shell.
    inner = mill.radius_m * math.sqrt(max(0.0, 1 - 2 * math.pi * filling / (2 * math.pi + shoulder - toe)))
    return ChargeShape(toe, shoulder, inner, (1 - filling) ** 0.4532)


def morrell(mill: Mill, critical_share: float) -> float:
    """Net power of the C-model: the rate at which the charge gains potential and kinetic energy [W].

    P = rho L { pi g N R / (3 (R - z r_i)) [2 R^3 - 3 z R^2 r_i + r_i^3 (3 z - 2)] (sin s - sin t)
                + (pi N R / (R - z r_i))^3 [(R - z r_i)^4 - r_i^4 (1 - z)^4] }

    with t, s, r_i and z of `morrell_shape`: the integrals over r from r_i to R of rho L g r v (sin s - sin t) and of
    rho L v^3 / 2. No-load power and losses, by which the model makes gross power, are left out. Raises ValueError as
    `morrell_shape`.
    """
    shape, radius = morrell_shape(mill, critical_share), mill.radius_m
    inner, z = shape.inner_radius_m, shape.profile
    turns_hz = critical_share * math.sqrt(GRAVITY / radius) / (2 * math.pi)
    reach = radius - z * inner
    lift = math.pi * GRAVITY * turns_hz * radius / (3 * reach)
    lift *= 2 * radius**3 - 3 * z * radius**2 * inner + inner**3 * (3 * z - 2)
    lift *= math.sin(shape.shoulder) - math.sin(shape.toe)
    throw = (math.pi * turns_hz * radius / reach) ** 3 * (reach**4 - inner**4 * (1 - z) ** 4)
    return mill.bulk_density * mill.length_m * (lift + throw)
