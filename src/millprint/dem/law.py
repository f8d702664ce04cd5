"""The contact of two bodies: springs and dashpots of its law, a Coulomb cap, rolling resistance, and coefficients that
depend on the speed of a hit.

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
  takes a share of that velocity in one step (STOP_SHARE), so that all contacts of a ball together stop it and never
  turn it back.
- Damping in the tangential direction counts while the contact sticks; while it slides, all work is sliding.

To add a law: its keys and words in config/contact_laws.py, and a file in dem/laws like linear.py.

What is kept is the speed of approach, in the contact's history: where the lists are made again, or the contact goes on
at another feature of the wall, the same speed gives the same coefficients.
"""

import math
from typing import NamedTuple

import numpy as np
from numba.core.types import NoneType
from numba.extending import overload

from millprint.config.contact_set import ContactConfig
from millprint.dem.lanes import get, get_of, put_of
from millprint.dem.laws.record import damping_ratio
from millprint.dem.laws.registry import LAWS, law_of
from millprint.dem.layout import LANE, LAW, LAW_WIDTH
from millprint.mill.kernel_columns import number_columns, width_of
from millprint.mill.vectors import add, add_scaled, dot, scale
from millprint.mill.walls import SURFACE
from millprint.run.kernel import INLINED, inlined, inner

# Keeps a quotient finite if a force [N] or an angular velocity [rad/s] is zero; its root is added to them.
TINY = 1e-60

# The share s of the relative angular velocity that the rolling friction of a contact may take in a step. The z contacts
# of equal balls, or of a ball with walls, take z s at most: each takes s I* (w_i - w_j)^2 <= s (I w_i^2 + I w_j^2).
# Torques are of the velocity expected now (dem/steps.py), w + (w - w_last) / 2, for which w goes to nothing where
# z s < 1, and for ever turns to and fro beyond; half of that is left to the dashpots of friction. So a contact that
# begins has a twenty-fourth: a ball touches twelve equal ones at most. The less it takes, the faster a ball creeps that
# it should hold. So up to CROWD contacts of a ball get a half together (contact_events.share_resistance), and one or
# FEW a quarter each.
STOP_SHARE = 1 / 24
CROWD, FEW = 12, 2
# Steps from one such sharing to the next.
SHARE_EVERY = 100


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
    largest = get(lanes, block, LANE.law.largest_resistance, m) * get(lanes, block, LANE.history.resistance, m)
    resistance = resistance if resistance < largest else largest
    torque = scale(-resistance, angular_velocity)
    powers = (damping * approach, sticking_power, tangential_power, resistance * turning * turning)
    normal_force, stored = with_pull(mark, lanes, block, m, overlap, elastic - damping, stored)
    return normal_force, force, torque, spring, slip, powers, (stored, 0.5 * stiffness * dot(spring, spring))


# Rows of the laws (law.law_row) have the damping of this restitution where the restitution depends on the speed.
REFERENCE = 0.5
REFERENCE_RATIO = damping_ratio(REFERENCE)
# The slowest approach [m/s]: a contact may begin while its partners part.
SLOWEST = 1e-9

ratio_of = inlined()(damping_ratio)


class ChosenColumns(NamedTuple):
    """Coefficients at a speed."""

    restitution: int
    friction: int


CHOSEN = number_columns(ChosenColumns)


class SpeedTables(NamedTuple):
    """Coefficients at the speeds of all tables of a contact set, so that each stays linear in between."""

    log_speeds: np.ndarray  # (s,) logarithms of speeds [m/s]
    values: np.ndarray  # (1 + surfaces, s, width) ChosenColumns of balls, then of each surface (walls.SURFACE)


def at_reference(contact: ContactConfig) -> ContactConfig:
    """The set that rows of the laws are made of: with the restitution REFERENCE if a coefficient is over speed."""
    if not contact.speed_tables:
        return contact
    if contact.restitution is None:
        return contact
    return contact.model_copy(update={"restitution": REFERENCE, "wall_restitution": None})


def speed_tables(contact: ContactConfig) -> SpeedTables | None:
    """The tables of a contact set; None if no coefficient depends on the speed of the hit."""
    if not contact.speed_tables:
        return None
    sets = [contact, *(getattr(contact, name) for name in ("at_wall", "without_friction"))]
    speeds = sorted({speed for each in sets for table in each.speed_tables.values() for speed in table.speeds_m_s})
    values = np.empty((1 + len(SURFACE), len(speeds), width_of(CHOSEN)))
    for k, each in enumerate(sets):
        for s, speed in enumerate(speeds):
            # A law without a restitution keeps its own damping.
            damped = contact.restitution is not None
            values[k, s, CHOSEN.restitution] = each.value_of("restitution", speed) if damped else REFERENCE
            values[k, s, CHOSEN.friction] = each.value_of("static_friction", speed)
    return SpeedTables(np.log(speeds), values)


@inlined()
def place_among(sorted_values, value):
    """The interval in which a value lies, and where in it: 0 to 1, at an end for a value outside."""
    last = sorted_values.size - 1
    if value <= sorted_values[0]:
        return 0, 0.0
    if value >= sorted_values[last]:
        return last - 1, 1.0
    low, high = 0, last
    while high - low > 1:
        middle = (low + high) // 2
        if sorted_values[middle] <= value:
            low = middle
        else:
            high = middle
    return low, (value - sorted_values[low]) / (sorted_values[high] - sorted_values[low])


def choose_by_speed(by_speed, contacts, laws, lane):
    """Give a lane, whose row of the law is in place, the damping and friction of its speed of approach, if by_speed
    (state.Laws) has tables; only for kernels.
    """
    raise NotImplementedError


@overload(choose_by_speed, jit_options=INLINED)
def _choose_by_speed(by_speed, contacts, laws, lane):
    if isinstance(by_speed, NoneType):
        return lambda by_speed, contacts, laws, lane: None
    own = set_by_speed
    return lambda by_speed, contacts, laws, lane: own(by_speed, contacts, laws, lane)


@inner()
def set_by_speed(by_speed, contacts, laws, lane):
    """Set damping and friction of a lane by its speed of approach."""
    speed = max(get_of(contacts, lane, LANE.history.approach_speed), SLOWEST)
    at, share = place_among(by_speed.log_speeds, math.log(speed))
    partner = contacts.partner[lane]
    kind = 0 if partner >= 0 else 1 + laws.surface[-1 - partner]
    below, above = by_speed.values[kind, at], by_speed.values[kind, at + 1]
    restitution = below[CHOSEN.restitution] + share * (above[CHOSEN.restitution] - below[CHOSEN.restitution])
    damped = ratio_of(restitution) / REFERENCE_RATIO
    for column in (LANE.law.normal_damping, LANE.law.tangential_damping):
        put_of(contacts, lane, column, damped * get_of(contacts, lane, column))
    friction = below[CHOSEN.friction] + share * (above[CHOSEN.friction] - below[CHOSEN.friction])
    put_of(contacts, lane, LANE.law.friction, friction)
