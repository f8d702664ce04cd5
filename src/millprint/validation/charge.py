"""Measures of the charge of a tumbling mill: critical speed, net power, toe and shoulder, rings of centrifuging balls.

Functions of numbers and positions, without files. A place in the drum is (x, z) [m] from its axis, with z up and the
drum turning clockwise: x points to the right for a drum that turns about +y. Angles are clockwise from 12 o'clock
[deg], so they grow in the direction of the turning: 180 is the bottom, 270 is 9 o'clock, where the balls are lifted.
Morrell's angles, counter-clockwise from 3 o'clock in a drum that turns counter-clockwise, are 90 deg larger.
"""

import math

import numpy as np

GRAVITY = 9.81
# At toe and shoulder, the shell is covered by half as many balls as in a closed ring.
COVERED = 0.5
BINS = 120
# For a ball that centrifuges: upper bound of the change of its distance from the axis over its diameter, and lower
# bound of the angle that it goes round over the drum's.
CARRIED = 0.5
# Distance of two rings over the ball diameter: between 0.87, for balls in the gaps of the other ring, and 1.
RING_PITCH = 0.9


def critical_speed_rpm(radius_m: float, ball_diameter_m: float) -> float:
    """The speed at which a ball at the shell weighs nothing at the top, sqrt(g / (R - d / 2)) [rpm].

    radius_m: of the shell R; ball_diameter_m: d [m].
    """
    return math.sqrt(GRAVITY / (radius_m - ball_diameter_m / 2)) * 30 / math.pi


def net_power(wall_work_J: np.ndarray, time_s: np.ndarray) -> float:
    """Mean power that the walls give to the balls [W]: the work between the first and the last sample over the time.

    wall_work_J, time_s: (m,) of the energy ledger. It is net of bearings, gears and motor.
    """
    return float((wall_work_J[-1] - wall_work_J[0]) / (time_s[-1] - time_s[0]))


def clock_angle(places: np.ndarray) -> np.ndarray:
    """Angles (...) of places (..., 2), clockwise from 12 o'clock, 0 to 360 [deg]."""
    return np.degrees(np.arctan2(places[..., 0], places[..., 1])) % 360.0


def coverage(places: np.ndarray, diameters: np.ndarray, radius_m: float, bins: int = BINS) -> np.ndarray:
    """How much of the shell the outermost balls cover (bins,): 1 for a closed ring, 0 without a ball [-].

    places: (t, n, 2) [m] at t times; diameters: (n,) [m]; radius_m: of the shell. Outermost balls have a gap to the
    shell of less than half their diameter; each covers d / (R - d / 2) of the circle [rad].
    """
    distance = np.linalg.norm(places, axis=-1)
    outermost = radius_m - distance < diameters
    share = np.broadcast_to(diameters / (2 * math.pi * (radius_m - diameters / 2)), distance.shape)
    place = (clock_angle(places) / 360 * bins).astype(int) % bins
    total = np.bincount(place[outermost], weights=share[outermost], minlength=bins)
    return total * bins / len(places)


def toe_and_shoulder(
    places: np.ndarray, diameters: np.ndarray, radius_m: float, bins: int = BINS, covered: float = COVERED
) -> tuple[float, float]:
    """Angles of toe and shoulder [deg]: the ends of the longest arc of the shell that balls cover by `covered` or more.

    The toe is the end that the shell reaches first; at the shoulder the balls leave it. Ends are interpolated within a
    bin. (nan, nan) if balls cover the whole circle, as in a centrifuge, or none of it.
    """
    share = coverage(places, diameters, radius_m, bins)
    inside = share >= covered
    if inside.all() or not inside.any():
        return math.nan, math.nan
    # An arc begins at a covered bin after an uncovered one.
    starts = np.flatnonzero(inside & ~np.roll(inside, 1))
    lengths = [int(np.argmin(np.roll(inside, -start))) for start in starts]
    first, length = int(starts[np.argmax(lengths)]), max(lengths)
    last = first + length - 1

    def end(here: int, beyond: int) -> float:
        """The centre of the last covered bin, moved towards the next one to where the share is `covered`."""
        high, low = share[here % bins], share[beyond % bins]
        return (here + 0.5 + (beyond - here) * (high - covered) / (high - low)) * 360 / bins

    return end(first, first - 1) % 360.0, end(last, last + 1) % 360.0


def carried(places: np.ndarray, angles: np.ndarray, diameters: np.ndarray) -> np.ndarray:
    """Which balls (n,) centrifuge: they go round at a constant distance from the axis.

    places: (t, n, 2) [m] over a turn; angles: (t,) of the drum, clockwise [rad]; diameters: (n,) [m]. Over the turn the
    distance from the axis varies by less than CARRIED of the diameter, and the ball goes round by more than CARRIED of
    the angle of the drum: it may slip or roll on the shell, or on the ring outside it.
    """
    distance = np.linalg.norm(places, axis=-1)
    way = np.unwrap(np.radians(clock_angle(places)), axis=0)
    goes_round = way[-1] - way[0] > CARRIED * (angles[-1] - angles[0])
    return goes_round & (np.ptp(distance, axis=0) < CARRIED * diameters)


def complete_rings(
    places: np.ndarray, diameter_m: float, radius_m: float, lifter_height_m: float = 0.0, lifter_width_m: float = 0.0
) -> int:
    """How many complete rings these balls make, counted from the shell inwards.

    places: (n, 2) [m] of the balls that are carried round; diameter_m: of each; radius_m: of the shell. A ball's ring
    follows from its distance to the shell, in steps of RING_PITCH of the diameter. A ring is complete if it has no room
    for two more balls side by side: neighbours are less than three diameters apart, plus the width of a lifter where
    lifters are in the ring. The first incomplete ring ends the count.
    """
    distance = np.linalg.norm(places, axis=1)
    ring = np.floor((radius_m - diameter_m / 2 - distance) / (RING_PITCH * diameter_m) + 0.5).astype(int)
    angles = np.radians(clock_angle(places))
    for number in range(int(radius_m / (RING_PITCH * diameter_m))):
        own = ring == number
        if own.sum() < 2:
            return number
        middle = distance[own].mean()
        ordered = np.sort(angles[own])
        gaps = np.diff(ordered, append=ordered[0] + 2 * math.pi) * middle
        if gaps.max() >= 3 * diameter_m + lifter_width_m * (middle > radius_m - lifter_height_m):
            return number
    return number
