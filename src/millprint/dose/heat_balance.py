"""The heat balance of balls, powder and jar: temperatures over a milling programme, and pauses that keep a limit.

Three lumped bodies, each at one temperature (T above the surroundings [K]):

    C_balls  dT_balls/dt  = Q_balls  - G_bp (T_balls - T_powder) - G_bj (T_balls - T_jar)
    C_powder dT_powder/dt = Q_powder + G_bp (T_balls - T_powder) - G_pj (T_powder - T_jar)
    C_jar    dT_jar/dt    = Q_jar + G_bj (T_balls - T_jar) + G_pj (T_powder - T_jar) - H T_jar

C: heat capacities [J/K]; G: conductances between the bodies and H between jar and surroundings [W/K]; Q: sources while
the mill runs [W], zero in a pause. H in a pause may differ. Each is a lumped body with Newton's law of cooling
(Carslaw and Jaeger, Conduction of Heat in Solids, 1959). The direction of the motion does not matter.

Many samples of C, G, H and Q are solved at once: n below.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.special import exprel

BODIES = ("balls", "powder", "jar")
BALLS, POWDER, JAR = range(3)
# A state: the three temperatures, and the released heat over the total heat capacity [K].
WIDTH = 4
# Longer pauses are not practical [s].
LONGEST_PAUSE_S = 24 * 3600.0
# The bounds of the search for the time to a limit [s].
SHORTEST_S, LONGEST_S = 1e-3, 1e7
# Points in time, over the milling or the pause of a cycle, that are searched for its largest temperature.
MOMENTS = np.concatenate([[0.0], np.geomspace(1e-3, 1.0, 12)])


@dataclass(frozen=True)
class Balance:
    """Heat balances of n samples; powers while the mill runs."""

    capacity_J_K: np.ndarray
    """heat capacities of BODIES (n, 3)"""
    between_W_K: np.ndarray
    """conductances balls to powder, balls to jar, powder to jar (n, 3)"""
    running_W_K: np.ndarray
    """conductance of the jar to the surroundings while the mill runs (n,)"""
    resting_W_K: np.ndarray
    """the same in a pause (n,)"""
    source_W: np.ndarray
    """heat released in each of BODIES (n, 3)"""
    surroundings_degC: np.ndarray
    """temperature of the surroundings (n,)"""

    def __len__(self) -> int:
        """The number of samples."""
        return len(self.running_W_K)

    def conductance(self, running: bool) -> np.ndarray:
        """Matrices K (n, 3, 3) with C dT/dt = Q - K T [W/K]; symmetric."""
        matrix = np.zeros((len(self), 3, 3))
        for value, (one, other) in zip(self.between_W_K.T, ((BALLS, POWDER), (BALLS, JAR), (POWDER, JAR)), strict=True):
            matrix[:, one, other] = matrix[:, other, one] = -value
            matrix[:, one, one] += value
            matrix[:, other, other] += value
        matrix[:, JAR, JAR] += self.running_W_K if running else self.resting_W_K
        return matrix

    @cached_property
    def steady_K(self) -> np.ndarray:
        """Temperatures over the surroundings (n, 3) in the steady state of milling without pauses: K T = Q."""
        return np.linalg.solve(self.conductance(running=True), self.source_W[..., None])[..., 0]

    def steady_degC(self) -> np.ndarray:
        """Temperatures (n, 3) in the steady state of milling without pauses."""
        return self.steady_K + self.surroundings_degC[:, None]

    @cached_property
    def modes(self) -> tuple["Modes", "Modes"]:
        """The decay in a pause, and while the mill runs."""
        return Modes.of(self, running=False), Modes.of(self, running=True)


@dataclass(frozen=True)
class Modes:
    """Eigenvalues [1/s] (n, 3) and vectors of C^-1 K: exp(-C^-1 K t) = back diag(exp(-rate t)) forth."""

    rate: np.ndarray
    back: np.ndarray
    forth: np.ndarray

    @classmethod
    def of(cls, balance: Balance, running: bool) -> "Modes":
        """The modes of every sample, from the symmetric matrix C^-1/2 K C^-1/2."""
        root = np.sqrt(balance.capacity_J_K)
        rate, vectors = np.linalg.eigh(balance.conductance(running) / (root[:, :, None] * root[:, None, :]))
        return cls(rate, vectors / root[:, :, None], np.swapaxes(vectors, 1, 2) * root[:, None, :])

    def decay(self, sample: int, times_s: np.ndarray) -> np.ndarray:
        """exp(-C^-1 K t) of a sample at some times: (m, 3, 3)."""
        factors = np.exp(-np.multiply.outer(times_s, self.rate[sample]))
        return np.einsum("ij,mj,jk->mik", self.back[sample], factors, self.forth[sample])


@dataclass(frozen=True)
class Course:
    """Temperatures over time, their largest values, and the error of the balance."""

    times_s: np.ndarray
    """times (m,)"""
    temperature_degC: np.ndarray
    """temperatures of BODIES at the times (m, n, 3)"""
    peak_degC: np.ndarray
    """the largest temperatures of BODIES (n, 3), at the times and where milling or a pause ends"""
    balance_error: float
    """largest error of the balance over all samples: supplied less stored and released heat, over supplied heat [-]"""


def programme_phases(duration_s: float, milling_s: float, pause_s: float) -> list[tuple[float, float, bool]]:
    """Start, end [s], and whether the mill runs: milling and pauses in turn, cut off at the end."""
    phases, start = [], 0.0
    while start < duration_s * (1 - 1e-12):
        for length, running in ((milling_s, True), (pause_s, False)):
            end = min(start + length, duration_s)
            if end > start:
                phases.append((start, end, running))
            start = end
    return phases


def _states(balance: Balance, state: np.ndarray, phase: tuple[float, float, bool], times_s: np.ndarray) -> np.ndarray:
    """States (m, n, 4) at the times of one phase, exact for constant coefficients; the last time is the phase's end.

    With the modes of the phase and its steady temperatures S, T(t) = S + exp(-C^-1 K t) (T(0) - S). The released heat
    is the integral of H T_jar, mode by mode.
    """
    start, _, running = phase
    modes, lost_W_K = balance.modes[running], balance.running_W_K if running else balance.resting_W_K
    steady = running * balance.steady_K
    amplitude = np.einsum("nij,nj->ni", modes.forth, state[:, :3] - steady)
    elapsed = (times_s - start)[:, None, None]
    exponent = -modes.rate * elapsed
    found = np.empty((len(times_s), len(balance), WIDTH))
    found[:, :, :3] = steady + np.einsum("nij,mnj->mni", modes.back, np.exp(exponent) * amplitude)
    # exprel(x) = (exp(x) - 1) / x, and 1 at 0, where a jar releases no heat.
    summed = np.einsum("nj,mnj->mn", modes.back[:, JAR], elapsed * exprel(exponent) * amplitude)
    total = balance.capacity_J_K.sum(axis=1)
    found[:, :, 3] = state[:, 3] + lost_W_K / total * (steady[:, JAR] * elapsed[:, :, 0] + summed)
    return found


def solve(balance: Balance, phases: Sequence[tuple[float, float, bool]], times_s: np.ndarray) -> Course:
    """Temperatures at `times_s` (ascending, 0 to the end of the last phase); the start is at room temperature."""
    state = np.zeros((len(balance), WIDTH))
    over, peak, milled_s = [], np.zeros((len(balance), 3)), 0.0
    for number, phase in enumerate(phases):
        start, end, running = phase
        inside = times_s[(times_s > start) & (times_s < end)]
        states = _states(balance, state, phase, np.append(inside, end))
        if number == 0:
            over.append(state[None, :, :3])
        wanted = len(inside) + np.isin(end, times_s)
        over.append(states[:wanted, :, :3])
        peak = np.maximum(peak, states[:, :, :3].max(axis=0))
        state, milled_s = states[-1], milled_s + (end - start) * running
    supplied = balance.source_W.sum(axis=1) * milled_s
    total = balance.capacity_J_K.sum(axis=1)
    kept = (balance.capacity_J_K * state[:, :3]).sum(axis=1) + total * state[:, 3]
    warm = supplied > 0
    error = np.abs(supplied - kept)[warm] / supplied[warm]
    surroundings = balance.surroundings_degC[:, None]
    temperature = np.concatenate(over) + surroundings
    return Course(times_s, temperature, peak + surroundings, float(error.max(initial=0.0)))


def time_to_limit(balance: Balance, body: int, limit_degC: float) -> np.ndarray:
    """Time of milling without pauses until a body reaches the limit (n,) [s]; inf where it never does.

    The temperatures rise all the time, so the time is the root of a monotone function.
    """
    # Imported here: slow to import, and the check of the input imports this module.
    from scipy.optimize import brentq

    _, running = balance.modes
    steady = balance.steady_K
    found = np.full(len(balance), np.inf)
    for sample, goal in enumerate(limit_degC - balance.surroundings_degC):

        def short(log_s: float, sample: int = sample, goal: float = goal) -> float:
            left = running.decay(sample, np.array([np.exp(log_s)]))[0] @ steady[sample]
            return float(steady[sample, body] - left[body] - goal)

        if steady[sample, body] > goal and short(np.log(LONGEST_S)) > 0:
            found[sample] = np.exp(brentq(short, np.log(SHORTEST_S), np.log(LONGEST_S), xtol=1e-10))
    return found


def cycle_peak(balance: Balance, sample: int, body: int, milling_s: float, pause_s: float) -> float:
    """The largest temperature of a body in a repeating cycle [degC], for one sample.

    P and R are the decays over milling and pause, S the steady temperatures. The cycle begins at
    T = (1 - R P)^-1 R (1 - P) S.
    """
    resting, running = balance.modes
    steady = balance.steady_K[sample]
    if pause_s == 0:
        return float(steady[body] + balance.surroundings_degC[sample])
    milled, rested = running.decay(sample, milling_s * MOMENTS), resting.decay(sample, pause_s * MOMENTS)
    gained = steady - milled[-1] @ steady
    begin = np.linalg.solve(np.eye(3) - rested[-1] @ milled[-1], rested[-1] @ gained)
    warm = steady + milled @ (begin - steady)
    cooling = rested @ warm[-1]
    return float(max(warm[:, body].max(), cooling[:, body].max()) + balance.surroundings_degC[sample])


def pause_needed(balance: Balance, body: int, limit_degC: float, milling_s: float) -> np.ndarray:
    """Shortest pause after each `milling_s` of milling that always keeps a body below the limit (n,) [s].

    0 where no pause is needed; inf where even 24 h is not enough.
    """
    from scipy.optimize import brentq

    found = np.zeros(len(balance))
    for sample in range(len(balance)):

        def over(pause_s: float, sample: int = sample) -> float:
            return cycle_peak(balance, sample, body, milling_s, pause_s) - limit_degC

        if over(0.0) <= 0:
            continue
        enough = over(LONGEST_PAUSE_S) <= 0
        found[sample] = brentq(over, 0.0, LONGEST_PAUSE_S, xtol=1e-3) if enough else np.inf
    return found
