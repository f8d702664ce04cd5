"""The columns of the kernels' arrays: every number by which a kernel finds a quantity comes from a list in this file.

Names with a unit (`peak_force_N`) are also the names of the datasets in run.h5. See
millprint.mill.kernel_columns for how the lists are numbered.
"""

from typing import NamedTuple

from millprint.mill.kernel_columns import Vector, first_column, number_columns, width_of

# Lanes in a block: contacts that go through one instruction.
LANES = 8

# Blocks of lanes that are gathered before their forces are evaluated, one after the other: the processor then works on
# the roots and quotients of several at the same time. With 20,000 balls and thousands of blocks, one block at a time
# was faster; with 764 balls and a hundred blocks it was slower. GROUPED_TO lies between.
GROUP = 4
GROUPED_TO = 512


class LawColumns(NamedTuple):
    """Coefficients of a contact, in a row of state.Laws (see law.law_row); the first four as Hertz's."""

    normal_stiffness: int  # K_n delta over delta^(3/2) [N/m^(3/2)]
    tangential_stiffness: int  # K_t over delta^(1/2) [N/m^(3/2)]
    normal_damping: int  # over delta^(1/4) [N s/m^(5/4)]
    tangential_damping: int  # over delta^(1/4) [N s/m^(5/4)]
    friction: int  # mu [-]
    rolling_friction: int  # mu_r [-]
    largest_resistance: int  # of rolling: torque over angular velocity [N m s]
    reach: int  # distance of centres, or of centre and wall, at which the contact begins [m]
    largest_overlap: int  # at which a run is stopped [m]
    pull: int  # of cohesion [N]


class WorkColumns(NamedTuple):
    """Work of a contact by channel [J]; tangential is all of it, damping the share of the tangential dashpot."""

    normal: int
    damping: int
    tangential: int
    rolling: int


class HistoryColumns(NamedTuple):
    """What a contact carries from step to step. The law changes all but how it began."""

    spring: Vector  # tangential displacement [m]
    last_slip: Vector  # tangential velocity a step ago [m/s]
    peak_force: int  # [N]
    peak_overlap: int  # [m]
    works: WorkColumns  # so far [J]
    start: int  # [s]
    approach_speed: int  # along the normal, at which it began [m/s]
    slip_speed: int  # of the surfaces along each other, at which it began [m/s]
    number: int  # of the contact among all that the run has opened
    resistance: int  # the largest of rolling friction over that of the law (contact_events.share_resistance) [-]


class PresentColumns(NamedTuple):
    """Quantities of an open contact that live for one step: the state of its partners, and the torques on them."""

    away: Vector  # from the second centre, or the wall's foot, to the first centre [m]
    velocity: Vector  # of the first centre relative to the second one, or the foot [m/s]
    angular_velocity: Vector  # of the first [rad/s]
    other_angular_velocity: Vector  # of the second [rad/s]
    torque: Vector  # on the first about its centre [N m]
    other_torque: Vector  # on the second about its centre, or the foot [N m]


class LaneColumns(NamedTuple):
    """Quantities of an open contact between a first ball and a second ball or a wall."""

    is_wall: int  # 1 for a wall, else 0
    radius_difference: int  # radius of the first less that of the second; 0 for a wall [m]
    law: LawColumns
    history: HistoryColumns
    force: Vector  # on the first [N]
    elastic_normal: int  # energy [J]
    elastic_tangential: int  # energy [J]


class TotalColumns(NamedTuple):
    """Works of the walls and of closed contacts so far; elastic energies of the present step."""

    wall_work_J: int
    normal_damping_J: int
    tangential_damping_J: int
    tangential_work_J: int
    rolling_J: int
    elastic_normal_J: int
    elastic_tangential_J: int


class SampleColumns(NamedTuple):
    """An energy sample; the columns of the group `ledger` in run.h5."""

    time_s: int
    totals: TotalColumns
    kinetic_translation_J: int
    kinetic_spin_J: int
    potential_J: int


class CollisionColumns(NamedTuple):
    """Values of a contact in the table of collisions."""

    start_s: int
    duration_s: int
    approach_speed_m_s: int
    slip_speed_m_s: int
    peak_force_N: int
    peak_overlap_m: int
    normal_J: int
    damping_J: int
    tangential_J: int
    rolling_J: int


class SnapshotColumns(NamedTuple):
    """State of a ball in a snapshot."""

    position_m: Vector
    velocity_m_s: Vector
    spin_rad_s: Vector
    contact_force_N: Vector


class SnapshotTotalColumns(NamedTuple):
    """What a snapshot holds once: energies dissipated so far, and the contacts in the buffer after it."""

    time_s: int
    normal_J: int
    tangential_J: int
    contacts: int


class OccupancyColumns(NamedTuple):
    """Sums over the balls that were in a cell of the grid; velocities are relative to the vessel."""

    balls: int  # number of them
    velocity: Vector  # [m/s]
    speed_squared: int  # [m2/s2]


class GridColumns(NamedTuple):
    """The grid of occupancy: its low corner in the vessel's frame, and how fine it is."""

    low_x: int  # [m]
    low_y: int  # [m]
    cells_per_m: int


class HeightColumns(NamedTuple):
    """What the mean height of the balls over the floor is made of, and their mean speeds."""

    total: int  # sum of heights [m]
    balls: int  # number of them
    relative_squared: int  # sum of squares of their speeds relative to the vessel [m2/s2]
    vessel_squared: int  # sum of squares of the vessel's speeds at their places [m2/s2]


class LoadColumns(NamedTuple):
    """What the balls load a body with."""

    force: Vector  # [N]
    torque: Vector  # [N m]


class CellColumns(NamedTuple):
    """Where a ball is in the grid of cells."""

    place: Vector  # cell along each axis
    number: int


class ShareColumns(NamedTuple):
    """Counts of one thread."""

    found: int  # pairs that have come within reach
    waiting: int  # blocks in which a contact has parted


class CounterColumns(NamedTuple):
    """Counters of a run."""

    step: int  # number of the step that comes next
    check_in: int  # steps until the lists are checked again
    look_in: int  # steps until the candidates that are near are listed again
    status: int  # see Statuses
    ball: int  # number of the ball that a status concerns
    partner: int  # number of the partner that a status concerns
    records: int  # rows in the table of collisions
    samples: int  # rows in the buffer
    snapshots: int  # rows in the buffer
    snapshot_contacts: int  # rows in the buffer
    rebuilds: int  # of the lists
    used: int  # lanes below the highest open one, that one included
    free: int  # lanes among them that hold no contact
    opened: int  # contacts so far
    aside: int  # contacts that are set aside while the lists are rebuilt; -1 where none are
    sorted_at: int  # rebuilds after which the rows of the balls were sorted (dem.neighbours)


class RowEnds(NamedTuple):
    """How a row of the table of collisions ended."""

    cut: int  # the window ended before it
    parted: int  # the bodies came apart
    passed: int  # the contact went on on another facet, in a row of its own


class Statuses(NamedTuple):
    """Status of a run. With full lists of candidates it may go on once they are longer; all others end it."""

    running: int
    overlap: int
    escaped: int
    not_finite: int
    contact_lost: int
    candidates_full: int


LAW = number_columns(LawColumns)
HISTORY = number_columns(HistoryColumns)
PRESENT = number_columns(PresentColumns)
LANE = number_columns(LaneColumns)
TOTAL = number_columns(TotalColumns)
SAMPLE = number_columns(SampleColumns)
COLLISION = number_columns(CollisionColumns)
SNAPSHOT = number_columns(SnapshotColumns)
SNAPSHOT_TOTAL = number_columns(SnapshotTotalColumns)
GRID = number_columns(GridColumns)
HEIGHT = number_columns(HeightColumns)
OCCUPANCY = number_columns(OccupancyColumns)
LOAD = number_columns(LoadColumns)
CELL = number_columns(CellColumns)
SHARE = number_columns(ShareColumns)
ENDED = number_columns(RowEnds)
COUNTER = number_columns(CounterColumns)
STATUS = number_columns(Statuses)

LAW_WIDTH, HISTORY_WIDTH, TOTAL_WIDTH = width_of(LAW), width_of(HISTORY), width_of(TOTAL)
LOAD_WIDTH = width_of(LOAD)
# Where the law's coefficients and the history begin in a lane.
LANE_LAW, LANE_HISTORY = first_column(LANE.law), first_column(LANE.history)
