"""Rigid motion of a body: its place and rotation at a time, along a curve through points too, and how fast it moves.

Place: a periodic cubic spline X(u) of the turn u = t f. Rotation: a periodic cubic spline q(u) of quaternions (w, x, y,
z), normalised when it is used, so that
    R = R(q / |q|),  omega = 2 Im(dq/dt q*) / |q|^2
is exact: a change of the length of q does not turn the body.

The body turns by an angle about a fixed unit axis a through a pivot p, and a translation is added. Both are sums of
harmonics of the mill's angular frequency w, and the angle may grow steadily too:
    theta(t) = rate t + sum_k c_k cos(m_k w t) + s_k sin(m_k w t)
    X(t) = p - R(theta) p + sum_k C_k cos(m_k w t) + S_k sin(m_k w t)
    V(t) = dX/dt,  omega(t) = (d theta / dt) a,  R(theta) = cos theta I + (1 - cos theta) a a^T + sin theta [a]x
with X the origin of the body frame; a point x of the body is at X + R x. The mill starts at t = 0 from rest at its
pose there and has its full speed at once, as in the thesis (Sec. 3.2.2). A motion given as a table of points is a
periodic curve instead (mill.motion).
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from millprint.config.motion_kinds import Drive, MotionSection
from millprint.mill.kernel_columns import Vector, number_columns, span_of, width_of
from millprint.mill.vectors import add, add_scaled, cross, put_vector, rotate, row, scale, subtract, vector
from millprint.run.kernel import inlined


class RotationColumns(NamedTuple):
    """A rotation matrix from the body's frame to the laboratory, row by row."""

    first_row: Vector
    second_row: Vector
    third_row: Vector


class PoseColumns(NamedTuple):
    """Where the body's frame is, how fast it moves, and how it is turned."""

    position: Vector  # of its origin [m]
    velocity: Vector  # of its origin [m/s]
    angular_velocity: Vector  # [rad/s]
    rotation: RotationColumns


POSE = number_columns(PoseColumns)


@inlined()
def velocity_of(motions, body):
    """Velocity of a body's origin [m/s]."""
    return vector(motions.pose, body, POSE.velocity)


@inlined()
def angular_velocity_of(motions, body):
    """Angular velocity of a body [rad/s]."""
    return vector(motions.pose, body, POSE.angular_velocity)


@inlined()
def rotation_of(motions, body):
    """Rotation of a body to the laboratory, a tuple of three rows."""
    pose, rows = motions.pose, POSE.rotation
    return vector(pose, body, rows.first_row), vector(pose, body, rows.second_row), vector(pose, body, rows.third_row)


@inlined()
def write_rotation(pose, body, rotation):
    """Write a rotation, a tuple of three rows."""
    put_vector(pose, body, POSE.rotation.first_row, rotation[0])
    put_vector(pose, body, POSE.rotation.second_row, rotation[1])
    put_vector(pose, body, POSE.rotation.third_row, rotation[2])


def path_values(breaks: np.ndarray, pieces: np.ndarray, turns: np.ndarray) -> np.ndarray:
    """The curve (..., 7), place [m] and quaternion, at turns (...) since the start."""
    # Takes long to import, and few mills need it.
    from scipy.interpolate import CubicSpline

    return CubicSpline.construct_fast(np.moveaxis(pieces, 0, 1), breaks, extrapolate="periodic")(turns)


def rotation_matrices(quaternion: np.ndarray) -> np.ndarray:
    """Rotation matrices (..., 3, 3) of quaternions (..., 4) of any length, w first."""
    from scipy.spatial.transform import Rotation

    scalar_last = np.roll(quaternion, -1, axis=-1).reshape(-1, 4)
    return Rotation.from_quat(scalar_last).as_matrix().reshape(*quaternion.shape[:-1], 3, 3)


@inlined()
def find_piece(breaks, first, last, turns):
    """The piece that contains `turns`, of those from `first` up to but not `last`; breaks has the start of each."""
    low, high = first, last - 1
    while low < high:
        middle = (low + high + 1) // 2
        if breaks[middle] <= turns:
            low = middle
        else:
            high = middle - 1
    return low


@inlined()
def _component(piece, part, c, turns):
    a, b, k = piece[part, 0, c], piece[part, 1, c], piece[part, 2, c]
    value = ((a * turns + b) * turns + k) * turns + piece[part, 3, c]
    return value, (3.0 * a * turns + 2.0 * b) * turns + k


@inlined()
def write_path(piece, part, turns, frequency, pose, body):
    """Write the pose of a body by one piece of its curve, `turns` after the piece's start; rates in 1/s."""
    for c in range(3):
        value, rate = _component(piece, part, c, turns)
        pose[body, POSE.position.x + c] = value
        pose[body, POSE.velocity.x + c] = frequency * rate


@inlined()
def write_path_rotation(piece, part, turns, frequency, pose, body):
    """Write rotation and angular velocity [rad/s] of a body by one piece of its curve of quaternions."""
    w, dw = _component(piece, part, 3, turns)
    x, dx = _component(piece, part, 4, turns)
    y, dy = _component(piece, part, 5, turns)
    z, dz = _component(piece, part, 6, turns)
    over = 1.0 / (w * w + x * x + y * y + z * z)
    product = cross((dx, dy, dz), (x, y, z))
    half = subtract(subtract(scale(w, (dx, dy, dz)), scale(dw, (x, y, z))), product)
    put_vector(pose, body, POSE.angular_velocity, scale(2.0 * frequency * over, half))
    rotation = (
        (1.0 - 2.0 * over * (y * y + z * z), 2.0 * over * (x * y - w * z), 2.0 * over * (x * z + w * y)),
        (2.0 * over * (x * y + w * z), 1.0 - 2.0 * over * (x * x + z * z), 2.0 * over * (y * z - w * x)),
        (2.0 * over * (x * z - w * y), 2.0 * over * (y * z + w * x), 1.0 - 2.0 * over * (x * x + y * y)),
    )
    write_rotation(pose, body, rotation)


# Points of a turn of a motion that is carried by another one: their curve is within 1e-9 of it at a turn of each.
CARRIED = 720


def _waves(waves: np.ndarray, time_s: np.ndarray) -> np.ndarray:
    """A sum of waves (k, 1 + 2 d) at times (...): its values (..., d)."""
    size = (waves.shape[1] - 1) // 2
    w, cosine, sine = waves[:, :1], waves[:, 1 : 1 + size], waves[:, 1 + size :]
    phase = w * time_s[..., None, None]
    return (cosine * np.cos(phase) + sine * np.sin(phase)).sum(axis=-2)


@dataclass(frozen=True)
class Motion:
    """A rigid motion, which `stack_motions` hands to the kernels; only they compute its velocities.

    harmonics: (k, 7) angular frequency [rad/s], cosine amplitudes x, y, z and sine amplitudes x, y, z [m];
    axis: (3,) unit vector; pivot: (3,) [m]; rate: steady angular velocity about the axis [rad/s];
    swing: (j, 3) angular frequency [rad/s], cosine amplitude and sine amplitude [rad];
    breaks (m + 1,) and pieces (m, 4, 7): the curve of a table of points (mill.motion), in place of all these;
    moves: false for a body that stands still.
    """

    harmonics: np.ndarray
    frequency_hz: float
    axis: np.ndarray = field(default_factory=lambda: np.array([0.0, 0.0, 1.0]))
    pivot: np.ndarray = field(default_factory=lambda: np.zeros(3))
    rate: float = 0.0
    swing: np.ndarray = field(default_factory=lambda: np.zeros((0, 3)))
    breaks: np.ndarray = field(default_factory=lambda: np.zeros(1))
    pieces: np.ndarray = field(default_factory=lambda: np.zeros((0, 4, 7)))
    moves: bool = True

    def _along(self, time_s: float | np.ndarray) -> np.ndarray:
        """Place and quaternion (..., 7) of a table of points at times (...) [s]."""
        return path_values(self.breaks, self.pieces, self.frequency_hz * self._running(time_s))

    def position(self, time_s: float | np.ndarray) -> np.ndarray:
        """Position of the body frame's origin (..., 3) [m] at times (...) [s]; for t < 0 that of t = 0."""
        if len(self.pieces):
            return self._along(time_s)[..., :3]
        time_s = self._running(time_s)
        return self.pivot - self.rotation(time_s) @ self.pivot + _waves(self.harmonics, time_s)

    def angle(self, time_s: float | np.ndarray) -> np.ndarray:
        """Angle theta about the axis (...) [rad] at times (...) [s]; for t < 0 that of t = 0."""
        time_s = self._running(time_s)
        return self.rate * time_s + _waves(self.swing, time_s)[..., 0]

    def rotation(self, time_s: float | np.ndarray) -> np.ndarray:
        """Rotation matrices (..., 3, 3) from the body frame to the laboratory at times (...) [s]."""
        if len(self.pieces):
            return rotation_matrices(self._along(time_s)[..., 3:])
        angle = self.angle(time_s)[..., None, None]
        x, y, z = self.axis
        skew = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
        turned = (1 - np.cos(angle)) * np.outer(self.axis, self.axis) + np.sin(angle) * skew
        return np.cos(angle) * np.eye(3) + turned

    def _running(self, time_s: float | np.ndarray) -> np.ndarray:
        """The time [s] since the mill has started; 0 before, and for what never moves."""
        return np.maximum(np.asarray(time_s, dtype=float), 0.0) * self.moves

    @property
    def turns(self) -> bool:
        """Whether the body's rotation is ever not the identity."""
        return bool(self.rate) or bool(self.swing.any()) or bool(self.pieces[:, :, 4:].any())

    def at_rest(self) -> "Motion":
        """The body standing still where this motion begins."""
        start = np.zeros(())
        if len(self.pieces):
            # One piece that never changes: where the table begins.
            still = np.zeros((1, 4, 7))
            still[0, 3] = self._along(start)
            return replace(self, moves=False, frequency_hz=0.0, breaks=np.array([0.0, 1.0]), pieces=still)
        harmonics, swing = np.zeros((1, 7)), np.zeros((1, 3))
        harmonics[0, 1:4] = _waves(self.harmonics, start)
        swing[0, 1] = self.angle(start)
        return replace(self, moves=False, harmonics=harmonics, frequency_hz=0.0, rate=0.0, swing=swing)


# A body that stands still at the origin.
AT_REST = Motion(np.zeros((1, 7)), 0.0, moves=False)


def motion_from_law(law: MotionSection, speed_hz: float) -> Motion:
    """The motion of a body by the keys of its law, at the mill's speed [Hz].

    Raises ConfigError for a table of points that is not one turn of the mill.
    """
    if not law.record.moves:
        return AT_REST
    motion = _driven(law.drive(), speed_hz)
    return motion if speed_hz > 0 else motion.at_rest()


def _driven(drive: Drive, frequency: float) -> Motion:
    if drive.is_curve:
        # Takes long to import, and few mills need it.
        from millprint.mill.points import curve_through, read_path

        if drive.carrier:
            drive = Drive(points=_carried(drive).tolist())
        breaks, pieces = curve_through(drive.points) if drive.table is None else read_path(drive.table)
        pieces[:, :, :3] *= drive.scale
        return Motion(np.zeros((1, 7)), frequency, breaks=breaks, pieces=pieces)
    w = 2 * math.pi * frequency
    axis = np.array(drive.axis, dtype=float)
    axis /= np.abs(axis).max()
    harmonics, swing = np.array(drive.harmonics, dtype=float), np.array(drive.swing, dtype=float).reshape(-1, 3)
    harmonics[:, 0] *= w
    swing[:, 0] *= w
    pivot = np.array(drive.pivot_mm, dtype=float) / 1e3
    return Motion(harmonics, frequency, axis / np.linalg.norm(axis), pivot, drive.turns * w, swing)


def _carried(drive: Drive) -> np.ndarray:
    """Points (CARRIED + 1, 7) of one turn of a motion that another one carries, as of Drive.points.

    With R', X' of the carrier, a point x of the body is at X' + R' (X + R x).
    """
    from scipy.spatial.transform import Rotation

    turn = np.arange(CARRIED + 1) / CARRIED
    own, carrier = (_driven(each, 1.0) for each in (replace(drive, carrier=None), drive.carrier) if each)
    place = carrier.position(turn) + (carrier.rotation(turn) @ own.position(turn)[..., None])[..., 0]
    turned = Rotation.from_matrix(carrier.rotation(turn) @ own.rotation(turn))
    return np.column_stack([turn, place, np.degrees(turned.as_rotvec())])


class Motions(NamedTuple):
    """The motions of several bodies (b) as flat arrays; see `Motion` for the quantities and their units."""

    moves: np.ndarray  # (b,) uint8, 0 for a body that stands still
    first_harmonic: np.ndarray  # (b + 1,) rows of body i are first_harmonic[i] to first_harmonic[i + 1]
    harmonics: np.ndarray  # (total, 7)
    axis: np.ndarray  # (b, 3)
    pivot: np.ndarray  # (b, 3)
    rate: np.ndarray  # (b,)
    first_swing: np.ndarray  # (b + 1,)
    swing: np.ndarray  # (total, 3)
    turns: np.ndarray  # (b,) uint8, 0 where the rotation is the identity at any time
    frequency: np.ndarray  # (b,) turns of the mill in a second [1/s]
    period: np.ndarray  # (b,) turns after which the curve of a table of points repeats
    first_piece: np.ndarray  # (b + 1,) pieces of that curve; none for a body that moves by a law
    piece_start: np.ndarray  # (total,) turns at which a piece begins
    piece: np.ndarray  # (total, 4, 7)
    pose: np.ndarray  # (b, width) pose.PoseColumns, as of the last call of write_poses


def stack_motions(motions: Sequence[Motion]) -> Motions:
    """The motions of several bodies for the kernels, their poses those of the settling (t < 0)."""
    pose = np.zeros((len(motions), width_of(POSE)))
    for row_of, motion in zip(pose, motions, strict=True):
        row_of[span_of(POSE.position)] = motion.position(-1.0)
        row_of[span_of(POSE.rotation)] = motion.rotation(-1.0).ravel()
    return Motions(
        moves=np.array([motion.moves for motion in motions], dtype=np.uint8),
        first_harmonic=np.cumsum([0, *(len(motion.harmonics) for motion in motions)]),
        harmonics=np.concatenate([motion.harmonics for motion in motions]),
        axis=np.array([motion.axis for motion in motions]),
        pivot=np.array([motion.pivot for motion in motions]),
        rate=np.array([motion.rate for motion in motions]),
        first_swing=np.cumsum([0, *(len(motion.swing) for motion in motions)]),
        swing=np.concatenate([motion.swing for motion in motions]),
        turns=np.array([motion.turns for motion in motions], dtype=np.uint8),
        frequency=np.array([motion.frequency_hz for motion in motions]),
        period=np.array([motion.breaks[-1] for motion in motions]),
        first_piece=np.cumsum([0, *(len(motion.pieces) for motion in motions)]),
        piece_start=np.concatenate([motion.breaks[:-1] for motion in motions]),
        piece=np.concatenate([motion.pieces for motion in motions]),
        pose=pose,
    )


@inlined()
def _write_translation(motions, body, time, pose):
    for c in range(3):
        pose[body, POSE.position.x + c] = 0.0
        pose[body, POSE.velocity.x + c] = 0.0
    for k in range(motions.first_harmonic[body], motions.first_harmonic[body + 1]):
        w = motions.harmonics[k, 0]
        cosine, sine = math.cos(w * time), math.sin(w * time)
        for c in range(3):
            in_phase, out_of_phase = motions.harmonics[k, 1 + c], motions.harmonics[k, 4 + c]
            pose[body, POSE.position.x + c] += in_phase * cosine + out_of_phase * sine
            pose[body, POSE.velocity.x + c] += w * (out_of_phase * cosine - in_phase * sine)


@inlined()
def _write_rotation(motions, body, time, pose):
    """Rotation and angular velocity of a body, and what they add to the position and velocity of its origin."""
    angle, turning = motions.rate[body] * time, motions.rate[body]
    for k in range(motions.first_swing[body], motions.first_swing[body + 1]):
        w, in_phase, out_of_phase = motions.swing[k, 0], motions.swing[k, 1], motions.swing[k, 2]
        cosine, sine = math.cos(w * time), math.sin(w * time)
        angle += in_phase * cosine + out_of_phase * sine
        turning += w * (out_of_phase * cosine - in_phase * sine)
    axis, pivot = row(motions.axis, body), row(motions.pivot, body)
    x, y, z = axis
    cosine, sine = math.cos(angle), math.sin(angle)
    rest = 1.0 - cosine
    rotation = (
        (cosine + rest * x * x, rest * x * y - sine * z, rest * x * z + sine * y),
        (rest * y * x + sine * z, cosine + rest * y * y, rest * y * z - sine * x),
        (rest * z * x - sine * y, rest * z * y + sine * x, cosine + rest * z * z),
    )
    put_vector(pose, body, POSE.angular_velocity, scale(turning, axis))
    write_rotation(pose, body, rotation)
    arm = scale(-1.0, rotate(rotation, pivot))
    put_vector(pose, body, POSE.position, add(row(pose, body), add(pivot, arm)))
    velocity = add_scaled(vector(pose, body, POSE.velocity), turning, cross(axis, arm))
    put_vector(pose, body, POSE.velocity, velocity)


@inlined()
def _write_curve(motions, body, time, pose):
    """The pose of a body that follows a table of points."""
    turns, frequency = motions.frequency[body] * time, motions.frequency[body]
    turns -= motions.period[body] * math.floor(turns / motions.period[body])
    part = find_piece(motions.piece_start, motions.first_piece[body], motions.first_piece[body + 1], turns)
    write_path(motions.piece, part, turns - motions.piece_start[part], frequency, pose, body)
    if motions.turns[body]:
        write_path_rotation(motions.piece, part, turns - motions.piece_start[part], frequency, pose, body)


@inlined()
def write_poses(motions, time):
    """Write the pose of every body at `time` [s] into motions.pose; for t < 0 that of t = 0, standing still."""
    pose = motions.pose
    for body in range(motions.moves.size):
        runs = time >= 0.0 and motions.moves[body] != 0
        at = time if runs else 0.0
        if motions.first_piece[body + 1] > motions.first_piece[body]:
            _write_curve(motions, body, at, pose)
        else:
            _write_translation(motions, body, at, pose)
            if motions.turns[body]:
                _write_rotation(motions, body, at, pose)
        if not runs:
            put_vector(pose, body, POSE.velocity, (0.0, 0.0, 0.0))
            put_vector(pose, body, POSE.angular_velocity, (0.0, 0.0, 0.0))
