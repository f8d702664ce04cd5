"""The contact of two bodies: springs and dashpots of its law, a Coulomb cap, rolling friction (thesis Eqs 3.3 to 3.16).

A contact set names its law by `kind` (dem/laws/registry.py). The kernels are compiled for each law, so that no contact
asks which law it has.

Choices that the equations leave open, each tested in tests/physics:

- Cap. Spring and damping are capped together, |F_t| <= mu F_n, and the spring is limited to mu F_n / K_t. To set it
  to the capped force over K_t would charge it with the dashpot's share: a contact begins with a dashpot's force above
  the cap, so its spring would be drawn to the limit by a slip that never was, and give that energy back. F_n is here
  the elastic normal force K_n delta. Its impulse over an impact is exactly m (1 + e) v, so that sliding gives
  mu (1 + e) m v; the damped force would not, because it turns tensile before the contact ends.
- The normal force is not clipped where it is tensile: that would turn a restitution of 0.30 into 0.40.
- The tangential spring is turned into the current tangent plane with its length kept.
- Cohesion is a constant pull while two bodies overlap (Derjaguin, Muller and Toporov 1975), so that it has a potential
  and makes no energy. It is not in F_n of the cap and of rolling friction: the elastic force, which it raises, is. So
  friction is mu times load plus pull, as Derjaguin has it (Z. Phys. 88, 1934, 661).
- Rolling friction acts against the relative angular velocity (Eq. 3.16). Near zero it is limited to the torque that
  takes a quarter of that velocity in one step, so that it can stop a ball but never turn it back.
- Damping in the tangential direction counts while the contact sticks; while it slides, all work is sliding.

To add a law: its keys and words in config/contact_laws.py, and a file in dem/laws like linear.py.
"""

import math

import numpy as np
from numba.extending import overload

from millprint.config.contact_set import ContactConfig
from millprint.dem.lanes import get
from millprint.dem.laws.registry import LAWS, law_of
from millprint.dem.layout import LANE, LAW, LAW_WIDTH
from millprint.mill.vectors import add, add_scaled, dot, scale
from millprint.run.kernel import INLINED, inlined

# Keeps a quotient finite if a force [N] or an angular velocity [rad/s] is zero; its root is added to them.
TINY = 1e-60

# Fraction of the relative angular velocity that rolling friction may remove in one step.
STOP_SHARE = 0.25


def law_row(
    contact: ContactConfig,
    radius: float,
    mass: float,
    inertia: float,
    reach: float,
    limit: float,
    step: float,
    pull: float,
) -> np.ndarray:
    """Coefficients of one kind of contact, in the columns of layout.LawColumns.

    radius, mass and inertia are the reduced ones, R* [m], m* [kg] and I* [kg m2]; for a wall those of the ball. reach
    is the distance of centres (or of centre and wall) at which contact begins [m]; limit the bound on the overlap [m];
    step the integration step [s]; pull: of cohesion [N].
    """
    row = np.empty(LAW_WIDTH)
    columns = [LAW.normal_stiffness, LAW.tangential_stiffness, LAW.normal_damping, LAW.tangential_damping]
    row[columns] = law_of(contact).coefficients(contact, radius, mass)
    row[LAW.friction] = contact.value_of("static_friction")
    row[LAW.rolling_friction] = contact.rolling_friction
    row[LAW.largest_resistance] = STOP_SHARE * inertia / step
    row[LAW.reach] = reach
    row[LAW.largest_overlap] = limit
    row[LAW.pull] = pull
    return row


def springs(mark, *numbers):
    """ContactLaw.springs of the law that a mark stands for; only for kernels."""
    raise NotImplementedError


@overload(springs, jit_options=INLINED)
def _springs(mark, overlap, normal, tangential, damping, viscous):
    kind = mark.instance_class
    own = inlined()(next(law.springs for law in LAWS.values() if kind in (law.mark, law.cohesive_mark)))
    return lambda mark, overlap, normal, tangential, damping, viscous: own(
        overlap, normal, tangential, damping, viscous
    )


@inlined()
def pulled(lanes, block, m, overlap, force, stored):
    """A normal force [N] and a stored energy [J] with those of cohesion."""
    pull = get(lanes, block, LANE.law.pull, m)
    return force - pull, stored - pull * overlap


def with_pull(mark, lanes, block, m, overlap, force, stored):
    """The same, or without change where the law has no cohesion; only for kernels."""
    raise NotImplementedError


@overload(with_pull, jit_options=INLINED)
def _with_pull(mark, lanes, block, m, overlap, force, stored):
    if mark.instance_class in {law.mark for law in LAWS.values()}:
        return lambda mark, lanes, block, m, overlap, force, stored: (force, stored)
    own = pulled
    return lambda mark, lanes, block, m, overlap, force, stored: own(lanes, block, m, overlap, force, stored)


@inlined()
def turn_spring(spring, normal):
    """The tangential spring in the plane across `normal`, its length kept (Eq. 3.3 and the text below it).

    To the second order in the angle turned in the step, which is small: sqrt(1 + x) is taken as 1 + x / 2.
    """
    along = dot(spring, normal)
    flat = add_scaled(spring, -along, normal)
    flat2 = dot(flat, flat)
    # No contact turns that far in a step, but springs as small as rounding errors may seem to.
    stretch = 1.0 + 0.5 * along * along / flat2 if flat2 > along * along else 1.0
    return scale(stretch, flat)


@inlined()
def contact_law(mark, lanes, block, m, overlap, normal, arm, velocity, angular_velocity, spring, last_slip, step):
    """Force and rolling torque on the first body of a contact, its new spring, and the power in each channel.

    mark: of its law. The coefficients are in lane m of a block. overlap: delta_n [m], not zero; normal: unit vector
    (3,) from the second body to the first; arm: distance from the centre to the contact point [m]; velocity: relative
    velocity (3,) of the first body at the contact point [m/s]; angular_velocity: the relative one (3,) [rad/s]; spring:
    tangential displacement (3,) a step ago [m]; last_slip: tangential velocity (3,) a step ago [m/s]; step [s]. Written
    without branches, so that several contacts go through one instruction.

    Returns (normal force along `normal` [N], tangential force [N], torque [N m], spring [m], slip [m/s],
    (normal damping, tangential damping, total tangential, rolling) [W], (normal, tangential) elastic energy [J]).
    """
    approach = dot(velocity, normal)
    elastic, stiffness, dashpot, viscous, stored = springs(
        mark,
        overlap,
        get(lanes, block, LANE.law.normal_stiffness, m),
        get(lanes, block, LANE.law.tangential_stiffness, m),
        get(lanes, block, LANE.law.normal_damping, m),
        get(lanes, block, LANE.law.tangential_damping, m),
    )
    damping = dashpot * approach

    slip = add_scaled(velocity, -approach, normal)
    # The trapezoidal rule: with velocities only at the end of a step, the spring would damp in proportion to the step.
    spring = add_scaled(turn_spring(spring, normal), 0.5 * step, add(slip, last_slip))
    cap = get(lanes, block, LANE.law.friction, m) * elastic
    pull = stiffness * math.sqrt(dot(spring, spring))
    spring = scale(cap / pull if pull > cap else 1.0, spring)
    force = add_scaled(scale(-stiffness, spring), -viscous, slip)
    size = math.sqrt(dot(force, force) + TINY)
    turning = math.sqrt(dot(angular_velocity, angular_velocity) + TINY)
    # Two quotients by one division, the slowest operation of the processor.
    inverse = 1.0 / (size * turning)
    slides = size > cap
    force = scale(cap * inverse * turning if slides else 1.0, force)
    sticking_power = 0.0 if slides else viscous * dot(slip, slip)
    tangential_power = -dot(force, slip)

    # Torque over angular velocity [N m s].
    resistance = get(lanes, block, LANE.law.rolling_friction, m) * elastic * arm * inverse * size
    largest = get(lanes, block, LANE.law.largest_resistance, m)
    resistance = resistance if resistance < largest else largest
    torque = scale(-resistance, angular_velocity)
    powers = (damping * approach, sticking_power, tangential_power, resistance * turning * turning)
    normal_force, stored = with_pull(mark, lanes, block, m, overlap, elastic - damping, stored)
    return normal_force, force, torque, spring, slip, powers, (stored, 0.5 * stiffness * dot(spring, spring))
