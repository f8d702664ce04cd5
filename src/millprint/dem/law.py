"""The contacts of eight lanes: geometry, springs and dashpots of a law, a Coulomb cap, rolling resistance, works.

A loop becomes vector instructions only if no number that it writes can be one that it reads later. Within one row the
compiler sees that by itself; for two arrays it needs the scopes of LLVM's metadata (`alias.scope` and
`noalias` in https://llvm.org/docs/LangRef.html). Rows and columns are not checked and count from the front.

A block of lanes is one row of numbers, LANES for each quantity, so that the compiler knows that quantities never
overlap and makes vector instructions of the loop over the lanes. A lane that is free keeps the numbers of an earlier
contact, or IDLE ones: they cost nothing, and their results are not read.

Quantities of one step only are in separate rows (layout.PresentColumns), GROUP of them, which all blocks use in
turn: so they stay in the processor's nearest memory, however many contacts there are.

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

To add a law: its keys and words in config/contact_set.py, and a file in dem/laws like linear.py.

What is kept is the speed of approach, in the contact's history: where the lists are made again, or the contact goes on
at another feature of the wall, the same speed gives the same coefficients.
"""

import math
from typing import NamedTuple

import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.types import NoneType
from numba.extending import intrinsic, overload
from numba.np.arrayobj import make_array

from millprint.config.contact_set import ContactConfig
from millprint.dem.laws.record import damping_ratio
from millprint.dem.laws.registry import LAWS, law_of
from millprint.dem.layout import LANE, LANES, LAW, LAW_WIDTH, PRESENT
from millprint.mill.kernel_columns import number_columns, span_of, width_of
from millprint.mill.vectors import add, add_scaled, cross, dot, scale, subtract
from millprint.mill.walls import SURFACE
from millprint.run.kernel import INLINED, inlined, inner


def _scope(module: ir.Module, name: str) -> ir.MDValue:
    """A list of one scope, in the form that instructions refer to."""
    domain = module.add_metadata(["millprint"])
    return module.add_metadata([module.add_metadata([name, domain])])


def _place(context, builder, signature, arguments):
    """The address of a number, by the row and the column in the second and third argument."""
    array = make_array(signature.args[0])(context, builder, arguments[0])
    indices = [
        context.cast(builder, index, kind, types.intp)
        for index, kind in zip(arguments[1:3], signature.args[1:3], strict=True)
    ]
    return cgutils.get_item_pointer(context, builder, signature.args[0], array, indices, wraparound=False)


def _mark(builder, instruction, own, other):
    """Declare that an instruction reads or writes the memory `own` and not `other`."""
    instruction.set_metadata("alias.scope", _scope(builder.module, own))
    instruction.set_metadata("noalias", _scope(builder.module, other))
    return instruction


def _access(own: str, other: str):
    """Two functions for kernels, to read a number of an array and to write one."""

    @intrinsic
    def load(typing, array, line, column):
        def code(context, builder, signature, arguments):
            place = _place(context, builder, signature, arguments)
            return _mark(builder, builder.load(place), own, other)

        return array.dtype(array, line, column), code

    @intrinsic
    def store(typing, array, line, column, value):
        def code(context, builder, signature, arguments):
            place = _place(context, builder, signature, arguments)
            number = context.cast(builder, arguments[3], signature.args[3], signature.args[0].dtype)
            _mark(builder, builder.store(number, place), own, other)
            return context.get_dummy_value()

        return types.void(array, line, column, value), code

    return load, store


load_lane, store_lane = _access("lanes", "present")
load_present, store_present = _access("present", "lanes")


# Content of a free lane: two steel balls of 10 mm in contact.
IDLE = np.zeros(width_of(LANE))
IDLE[span_of(LANE.law)] = 1.0
IDLE[LANE.law.reach] = 10e-3
IDLE_PRESENT = np.zeros(width_of(PRESENT))
IDLE_PRESENT[PRESENT.away.x] = 9.99e-3


@inlined()
def get(lanes, block, quantity, m):
    """A quantity of a lane."""
    return load_lane(lanes, block, quantity * LANES + m)


@inlined()
def put(lanes, block, quantity, m, value):
    """Set a quantity of a lane."""
    store_lane(lanes, block, quantity * LANES + m, value)


@inlined()
def get_vector(lanes, block, quantity, m):
    """A vector of a lane, of which `quantity` names the three columns: they follow each other."""
    at = quantity.x * LANES + m
    return load_lane(lanes, block, at), load_lane(lanes, block, at + LANES), load_lane(lanes, block, at + 2 * LANES)


@inlined()
def put_vector(lanes, block, quantity, m, vector):
    """Set a vector of a lane."""
    at = quantity.x * LANES + m
    store_lane(lanes, block, at, vector[0])
    store_lane(lanes, block, at + LANES, vector[1])
    store_lane(lanes, block, at + 2 * LANES, vector[2])


@inlined()
def get_present(present, at, quantity, m):
    """A vector of lane m in row `at` of the present rows."""
    c = quantity.x * LANES + m
    return load_present(present, at, c), load_present(present, at, c + LANES), load_present(present, at, c + 2 * LANES)


@inlined()
def put_present(present, at, quantity, m, vector):
    """Set a vector of lane m in row `at` of the present rows."""
    c = quantity.x * LANES + m
    store_present(present, at, c, vector[0])
    store_present(present, at, c + LANES, vector[1])
    store_present(present, at, c + 2 * LANES, vector[2])


@inlined()
def add_to(lanes, block, quantity, m, value):
    """Add to a quantity of a lane."""
    put(lanes, block, quantity, m, get(lanes, block, quantity, m) + value)


@inlined()
def raise_to(lanes, block, quantity, m, value):
    """Set a quantity of a lane to a value that is larger."""
    old = get(lanes, block, quantity, m)
    put(lanes, block, quantity, m, value if value > old else old)


@inlined()
def get_of(contacts, lane, quantity):
    """A quantity of the contact in a lane, by the number of the lane among all."""
    return get(contacts.lanes, lane // LANES, quantity, lane % LANES)


@inlined()
def put_of(contacts, lane, quantity, value):
    """Set a quantity of the contact in a lane, by the number of the lane among all."""
    put(contacts.lanes, lane // LANES, quantity, lane % LANES, value)


# Keeps a quotient finite if a force [N] or an angular velocity [rad/s] is zero; its root is added to them.
TINY = 1e-60

# The share s of the relative angular velocity that the rolling friction of a contact may take in a step. The z contacts
# of equal balls, or of a ball with walls, take z s at most: each takes s I* (w_i - w_j)^2 <= s (I w_i^2 + I w_j^2).
# Torques are of the velocity expected now (dem/advance.py), w + (w - w_last) / 2, for which w goes to nothing where
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
    if not contact.speed_tables or contact.restitution is None:
        return contact
    return contact.model_copy(update={"restitution": REFERENCE, "wall_restitution": None})


def speed_tables(contact: ContactConfig) -> SpeedTables | None:
    """The tables of a contact set; None if no coefficient depends on the speed of the hit."""
    if not contact.speed_tables:
        return None
    sets = [contact, contact.at_wall, contact.without_friction]
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


@inlined()
def arms_of(lanes, block, m, distance):
    """Distances of both centres from the plane of contact [m]; distance: of the centres, or of centre and foot [m].

    The plane of contact is where the two spheres cut each other, or the wall.
    """
    reach, is_wall = get(lanes, block, LANE.law.reach, m), get(lanes, block, LANE.is_wall, m)
    arm = 0.5 * (distance + get(lanes, block, LANE.radius_difference, m) * reach / distance + is_wall * distance)
    return arm, distance - arm


@inlined()
def mean_arm_of(lanes, block, m, distance, arm, other):
    """The lever of rolling friction [m]: the harmonic mean of both arms, or the arm of a ball at a wall."""
    return 2.0 * arm * other / distance + get(lanes, block, LANE.is_wall, m) * distance


@inlined()
def book_step(lanes, block, m, step, normal_force, overlap, powers):
    """Raise the peaks of a contact [N, m] and add its works in a step [s]; powers: by channel [W]."""
    normal, damping, tangential, rolling = powers
    raise_to(lanes, block, LANE.history.peak_force, m, normal_force)
    raise_to(lanes, block, LANE.history.peak_overlap, m, overlap)
    add_to(lanes, block, LANE.history.works.normal, m, step * normal)
    add_to(lanes, block, LANE.history.works.damping, m, step * damping)
    add_to(lanes, block, LANE.history.works.tangential, m, step * tangential)
    add_to(lanes, block, LANE.history.works.rolling, m, step * rolling)


@inlined()
def evaluate_block(mark, lanes, block, present, at, step):
    """Forces, torques and new histories of the contacts in a block, whose present row is number `at`.

    mark: of their law (laws.registry.mark_of); step [s]. The velocity at the plane of contact is
    v_i + w_i x (-a n) - v_j - w_j x (b n), with a and b the distances of the centres from it. A wall has b = 0.
    """
    for m in range(LANES):
        away = get_present(present, at, PRESENT.away, m)
        distance = math.sqrt(dot(away, away))
        normal = scale(1.0 / distance, away)
        reach = get(lanes, block, LANE.law.reach, m)
        # Rounding may leave nothing of an overlap whose square was still there.
        overlap = reach - distance if reach - distance > 1e-30 else 1e-30
        arm, other = arms_of(lanes, block, m, distance)
        angular = get_present(present, at, PRESENT.angular_velocity, m)
        other_angular = get_present(present, at, PRESENT.other_angular_velocity, m)
        turning = add_scaled(scale(arm, angular), other, other_angular)
        velocity = subtract(get_present(present, at, PRESENT.velocity, m), cross(turning, normal))
        normal_force, tangential, rolling, spring, slip, powers, stored = contact_law(
            mark, lanes, block, m, overlap, normal, mean_arm_of(lanes, block, m, distance, arm, other), velocity,
            subtract(angular, other_angular), get_vector(lanes, block, LANE.history.spring, m),
            get_vector(lanes, block, LANE.history.last_slip, m), step,
        )  # fmt: skip
        put_vector(lanes, block, LANE.history.spring, m, spring)
        put_vector(lanes, block, LANE.history.last_slip, m, slip)
        book_step(lanes, block, m, step, normal_force, overlap, powers)
        force = add_scaled(tangential, normal_force, normal)
        lever = cross(force, normal)
        put_vector(lanes, block, LANE.force, m, force)
        put_present(present, at, PRESENT.torque, m, add_scaled(rolling, arm, lever))
        put_present(present, at, PRESENT.other_torque, m, subtract(scale(other, lever), rolling))
        elastic_normal, elastic_tangential = stored
        put(lanes, block, LANE.elastic_normal, m, elastic_normal)
        put(lanes, block, LANE.elastic_tangential, m, elastic_tangential)


@inner()
def evaluate(mark, lanes, present, begin, end, step):
    """Forces, torques and new histories of the contacts in blocks begin to end.

    Their present rows are the first ones; mark: of their law (laws.registry.mark_of); step [s].
    """
    for block in range(begin, end):
        evaluate_block(mark, lanes, block, present, block - begin, step)
