"""Candidate lists: which balls and wall features a ball may touch before it has moved by half the skin."""

import math

from millprint.dem.state import (
    BALL,
    CHECK_IN,
    CONTACT_LOST,
    ESCAPED,
    NOT_FINITE,
    REBUILDS,
    RECORD,
    SLOTS_FULL,
    STATUS,
    TANGENT,
)
from millprint.kernel import inlined, kernel
from millprint.mill.vectors import dot, row, subtract
from millprint.mill.walls import cell_of, near

# Below this number of balls every pair is looked at; above it a grid of cells is used.
ALL_PAIRS = 160


@kernel()
def put_aside(slots):
    """Copy the open contacts to the side; returns their number."""
    kept = 0
    for i in range(slots.first_wall.size):
        for k in range(slots.first[i], slots.first[i + 1]):
            if slots.is_open[k]:
                slots.kept_ball[kept] = i
                slots.kept_partner[kept] = slots.partner[k]
                for c in range(TANGENT):
                    slots.kept_tangent[kept, c] = slots.tangent[k, c]
                for c in range(RECORD):
                    slots.kept_record[kept, c] = slots.record[k, c]
                kept += 1
    return kept


@kernel()
def put_back(slots, kept):
    """Give the open contacts their state back, exactly; returns the ball of one that has lost its slot, or -1."""
    for m in range(kept):
        i = slots.kept_ball[m]
        found = False
        for k in range(slots.first[i], slots.first[i + 1]):
            if slots.partner[k] == slots.kept_partner[m]:
                slots.is_open[k] = 1
                for c in range(TANGENT):
                    slots.tangent[k, c] = slots.kept_tangent[m, c]
                for c in range(RECORD):
                    slots.record[k, c] = slots.kept_record[m, c]
                found = True
                break
        if not found:
            return i
    return -1


@inlined()
def add_slot(slots, k, partner, sure):
    if k < slots.partner.size:
        slots.partner[k] = partner
        slots.sure[k] = sure
        slots.is_open[k] = 0
    return k + 1


@inlined()
def add_pair(balls, slots, i, j, skin, k):
    """Append the pair if it is within reach; `slots.anchor` holds the positions."""
    away = subtract(row(slots.anchor, i), row(slots.anchor, j))
    limit = balls.radius[balls.species[i]] + balls.radius[balls.species[j]] + skin
    return add_slot(slots, k, j, 0) if dot(away, away) < limit * limit else k


@kernel()
def add_walls(balls, slots, walls, i, skin, k):
    """Append the wall features near ball i; returns -1 if the ball is outside the vessel's bounding box."""
    point = row(slots.anchor, i)
    cell = cell_of(walls, point)
    if cell < 0:
        return -1
    radius = balls.radius[balls.species[i]]
    # Walls stand still in this frame: the ball alone moves, by half the skin at most.
    margin = 0.5 * skin
    for m in range(walls.cell_first[cell], walls.cell_first[cell + 1]):
        feature = walls.cell_feature[m]
        if walls.cell_sure[m]:
            distance = dot(row(walls.normal, feature), point) - walls.offset[feature]
            closeness = 2 if distance <= radius + margin else 0
        else:
            closeness = near(walls, feature, point, radius, margin)
        if closeness:
            k = add_slot(slots, k, -1 - feature, closeness - 1)
    return k


@kernel()
def sort_into_cells(slots, pitch):
    """Sort the balls into cells of at least `pitch`: slots.cell_place, cell_first and cell_member; returns the shape.

    Where the grid would have more cells than there is room for, the cells grow.
    """
    n = slots.anchor.shape[0]
    low = row(slots.anchor, 0)
    high = low
    for i in range(1, n):
        point = row(slots.anchor, i)
        low = (min(low[0], point[0]), min(low[1], point[1]), min(low[2], point[2]))
        high = (max(high[0], point[0]), max(high[1], point[1]), max(high[2], point[2]))
    width = subtract(high, low)
    shape = (int(width[0] / pitch) + 1, int(width[1] / pitch) + 1, int(width[2] / pitch) + 1)
    while shape[0] * shape[1] * shape[2] >= slots.cell_first.size:
        pitch *= 1.25
        shape = (int(width[0] / pitch) + 1, int(width[1] / pitch) + 1, int(width[2] / pitch) + 1)
    cells = shape[0] * shape[1] * shape[2]
    for c in range(cells + 1):
        slots.cell_first[c] = 0
    for i in range(n):
        for axis in range(3):
            slots.cell_place[i, axis] = int((slots.anchor[i, axis] - low[axis]) / pitch)
        cell = (slots.cell_place[i, 0] * shape[1] + slots.cell_place[i, 1]) * shape[2] + slots.cell_place[i, 2]
        slots.cell_place[i, 3] = cell
        slots.cell_first[cell] += 1
    # Counts become ends; filling from the back turns ends into beginnings.
    for c in range(1, cells + 1):
        slots.cell_first[c] += slots.cell_first[c - 1]
    for i in range(n - 1, -1, -1):
        cell = slots.cell_place[i, 3]
        slots.cell_first[cell] -= 1
        slots.cell_member[slots.cell_first[cell]] = i
    return shape


@kernel()
def add_cell_pairs(balls, slots, i, skin, shape, k):
    """Append the pairs of ball i with higher numbers in the 27 cells around it."""
    x, y, z = slots.cell_place[i, 0], slots.cell_place[i, 1], slots.cell_place[i, 2]
    for a in range(max(x - 1, 0), min(x + 2, shape[0])):
        for b in range(max(y - 1, 0), min(y + 2, shape[1])):
            # Cells along the last axis follow each other in the list of members.
            start = (a * shape[1] + b) * shape[2]
            begin, end = slots.cell_first[start + max(z - 1, 0)], slots.cell_first[start + min(z + 2, shape[2])]
            for m in range(begin, end):
                if slots.cell_member[m] > i:
                    k = add_pair(balls, slots, i, slots.cell_member[m], skin, k)
    return k


@kernel()
def rebuild(balls, slots, walls, clock, counters):
    """Make the candidate lists anew, open contacts kept; sets counters[STATUS] if a ball is lost or a list full."""
    kept = put_aside(slots)
    n = balls.species.size
    for i in range(n):
        for axis in range(3):
            slots.anchor[i, axis] = balls.position[i, axis] - clock.pose[axis]
            if not math.isfinite(slots.anchor[i, axis]):
                counters[STATUS] = NOT_FINITE
                counters[BALL] = i
                return
    crowded = n > ALL_PAIRS
    shape = (1, 1, 1)
    if crowded:
        largest = 0.0
        for radius in balls.radius:
            largest = max(largest, radius)
        shape = sort_into_cells(slots, 2 * largest + clock.skin)
    k = 0
    for i in range(n):
        slots.first[i] = k
        if crowded:
            k = add_cell_pairs(balls, slots, i, clock.skin, shape, k)
        else:
            for j in range(i + 1, n):
                k = add_pair(balls, slots, i, j, clock.skin, k)
        slots.first_wall[i] = k
        k = add_walls(balls, slots, walls, i, clock.skin, k)
        if k < 0 or k > slots.partner.size:
            counters[STATUS] = ESCAPED if k < 0 else SLOTS_FULL
            counters[BALL] = i
            return
    slots.first[n] = k
    loser = put_back(slots, kept)
    if loser >= 0:
        counters[STATUS] = CONTACT_LOST
        counters[BALL] = loser
    counters[REBUILDS] += 1


@kernel()
def refresh(balls, slots, walls, clock, counters):
    """Rebuild the lists if a ball may leave its skin within the next step; plan the next look.

    No ball is taken to become faster, relative to the vessel, than twice the fastest one between two looks.
    """
    travelled2 = 0.0
    fastest2 = 0.0
    total = 0.0
    for i in range(balls.species.size):
        moved2 = 0.0
        speed2 = 0.0
        for axis in range(3):
            moved = balls.position[i, axis] - clock.pose[axis] - slots.anchor[i, axis]
            speed = balls.velocity[i, axis] - clock.pose[3 + axis]
            moved2 += moved * moved
            speed2 += speed * speed
        travelled2 = max(travelled2, moved2)
        fastest2 = max(fastest2, speed2)
        total += moved2 + speed2
    stride = 2 * clock.step * math.sqrt(fastest2) + 1e-12
    room = 0.5 * clock.skin - math.sqrt(travelled2)
    # A lost number shows in the sum; the rebuild finds and reports it.
    if room <= stride or not math.isfinite(total):
        rebuild(balls, slots, walls, clock, counters)
        room = 0.5 * clock.skin
    counters[CHECK_IN] = max(1, int(min(room / stride, 1000.0)))
