"""Motion of a vessel: where it is and how fast it moves at a time t, as parameters that a kernel evaluates.

A translation is a sum of harmonics of the mill's angular frequency w,
    X(t) = sum_k C_k cos(m_k w t) + S_k sin(m_k w t),
one row (m_k w, C_k, S_k) each. The mill starts at t = 0 from rest at X(0) and has its full speed at once, as in the
thesis (Sec. 3.2.2). A pose carries a rotation and an angular velocity too, so that a turning vessel is one more kind.
"""

import math
from dataclasses import dataclass

import numpy as np

from millprint.config.mill import CircleMotion, LissajousMotion, MillConfig
from millprint.kernel import inlined

REST, HARMONIC = 0, 1

# Layout of a pose: position (3), velocity (3), angular velocity (3), rotation (9).
POSE = 18


@dataclass(frozen=True)
class Motion:
    """A rigid motion of the vessel; `kind` and `harmonics` are what the kernel reads.

    harmonics: (k, 7) angular frequency [rad/s], cosine amplitudes x, y, z and sine amplitudes x, y, z [m].
    """

    kind: int
    harmonics: np.ndarray
    frequency_hz: float

    def position(self, time_s: np.ndarray) -> np.ndarray:
        """Position of the body frame (..., 3) [m] at times (...) [s]; for t < 0 that of t = 0."""
        time_s = np.maximum(np.asarray(time_s, dtype=float), 0.0)[..., None, None]
        w, cosine, sine = self.harmonics[:, :1], self.harmonics[:, 1:4], self.harmonics[:, 4:7]
        return (cosine * np.cos(w * time_s) + sine * np.sin(w * time_s)).sum(axis=-2)

    def velocity(self, time_s: np.ndarray) -> np.ndarray:
        """Velocity of the body frame (..., 3) [m/s] at times (...) [s]; zero for t < 0."""
        time_s = np.asarray(time_s, dtype=float)[..., None, None]
        w, cosine, sine = self.harmonics[:, :1], self.harmonics[:, 1:4], self.harmonics[:, 4:7]
        moving = w * (sine * np.cos(w * time_s) - cosine * np.sin(w * time_s)) * (self.kind == HARMONIC)
        return np.where(time_s[..., 0] < 0, 0.0, moving.sum(axis=-2))

    @property
    def amplitude_m(self) -> float:
        """Largest distance from the mean position along one axis [m]: A of a circle."""
        time_s = np.linspace(0, 1 / self.frequency_hz, 3601) if self.frequency_hz else np.zeros(1)
        return float(np.abs(self.position(time_s)).max())

    def at_rest(self) -> "Motion":
        """The vessel standing still where this motion begins."""
        harmonics = np.zeros((1, 7))
        harmonics[0, 1:4] = self.position(np.zeros(()))
        return Motion(REST, harmonics, 0.0)


def build_motion(mill: MillConfig, speed_rpm: float) -> Motion:
    """The motion of a mill at a speed [rpm]."""
    frequency = speed_rpm / 60
    rows: dict[int, np.ndarray] = {1: np.zeros(7)}
    if isinstance(mill.motion, CircleMotion):
        rows[1][1] = rows[1][5] = mill.motion.amplitude_mm / 1e3
    elif isinstance(mill.motion, LissajousMotion):
        for term in mill.motion.terms:
            axis, phase = "xyz".index(term.axis), math.radians(term.phase_deg)
            harmonic = rows.setdefault(term.multiple, np.zeros(7))
            harmonic[1 + axis] += term.amplitude_mm / 1e3 * math.sin(phase)
            harmonic[4 + axis] += term.amplitude_mm / 1e3 * math.cos(phase)
    for multiple, harmonic in rows.items():
        harmonic[0] = 2 * math.pi * frequency * multiple
    moves = frequency > 0 and mill.motion.kind != "rest"
    motion = Motion(HARMONIC, np.array(list(rows.values())), frequency)
    return motion if moves else motion.at_rest()


@inlined()
def write_pose(kind, harmonics, time, pose):
    """Write the body's position and velocity at `time` into `pose`."""
    for axis in range(6):
        pose[axis] = 0.0
    for k in range(harmonics.shape[0]):
        w = harmonics[k, 0]
        cosine, sine = math.cos(w * time), math.sin(w * time)
        for axis in range(3):
            c, s = harmonics[k, 1 + axis], harmonics[k, 4 + axis]
            pose[axis] += c * cosine + s * sine
            if kind == HARMONIC:
                pose[3 + axis] += w * (s * cosine - c * sine)
