"""The heat balance of balls, powder and jar over a milling programme: its sources, and a table of conditions.

Three lumped bodies, each at one temperature (T above the surroundings [K]):

    C_balls  dT_balls/dt  = Q_balls  - G_bp (T_balls - T_powder) - G_bj (T_balls - T_jar)
    C_powder dT_powder/dt = Q_powder + G_bp (T_balls - T_powder) - G_pj (T_powder - T_jar)
    C_jar    dT_jar/dt    = Q_jar + G_bj (T_balls - T_jar) + G_pj (T_powder - T_jar) - H T_jar

C: heat capacities [J/K]; G: conductances between the bodies and H between jar and surroundings [W/K]; Q: sources while
the mill runs [W], zero in a pause. H in a pause may differ. Each is a lumped body with Newton's law of cooling
(Carslaw and Jaeger, Conduction of Heat in Solids, 1959). The direction of the motion does not matter.

Many samples of C, G, H and Q are solved at once: n below.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import h5py
import numpy as np
import pandas as pd
from scipy.constants import hour as HOUR
from scipy.special import exprel

from millprint.config.dose import COEFFICIENT, PARAMETERS, TEMPERATURE, HeatConfig, RangeSection
from millprint.config.errors import ConfigError
from millprint.estimate.estimates import latin_hypercube
from millprint.fingerprint.descriptors import condition_of
from millprint.observables.counted_collisions import PAIRS, PARTS
from millprint.run.files import read_json
from millprint.run.hdf5 import open_hdf5

BODIES = ("balls", "powder", "jar")
BALLS, POWDER, JAR = range(3)
# A state: the three temperatures, and the released heat over the total heat capacity [K].
WIDTH = 4
# Longer pauses are not practical [s].
LONGEST_PAUSE_S = 24 * HOUR
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


@dataclass(frozen=True)
class HeatSource:
    """The heat sources of one condition of a mill, the mean over its seeds."""

    condition: str
    """name of the case without its seed"""
    about: dict[str, object]
    """as `condition_of`, and the number of seeds"""
    power_W: np.ndarray
    """dissipation by PAIRS and PARTS (2, 3)"""
    balls_kg: float
    """mass of all balls"""
    balls_m2: float
    """surface of all balls"""
    inside_m2: float
    """inner surface of the jar, without inserts"""
    inside_m3: float
    """volume of the jar for the balls"""


def split_of_contacts(group: h5py.Group) -> np.ndarray | None:
    """Shares of PAIRS in each of PARTS (2, 3) from the table of collisions; None if the run has none."""
    if "second" not in group:
        return None
    between = group["second"][:] >= 0
    energies = (group["normal_J"][:], group["damping_J"][:] + group["sliding_J"][:], group["rolling_J"][:])
    return _shares(
        np.array([[energy[between].sum(dtype=float), energy[~between].sum(dtype=float)] for energy in energies]).T
    )


def _shares(energy: np.ndarray) -> np.ndarray:
    """Columns of (2, 3) over their sums; halves for a channel without energy."""
    # Single values of a ledger may be a little below zero by rounding.
    energy = np.maximum(energy, 0.0)
    total = energy.sum(axis=0)
    return np.where(total > 0, energy / np.where(total > 0, total, 1.0), 0.5)


def split_of_summary(summary: dict) -> np.ndarray:
    """As `split_of_contacts`, from the summary's counting rule without thresholds; rolling is divided like sliding."""
    for rule in summary["collisions"]:
        if not any(rule["dropped"].values()):
            split = [
                [rule["shares"][place][channel] for channel in ("normal", "tangential", "tangential")]
                for place in PAIRS
            ]
            return _shares(np.array(split))
    raise ConfigError(
        f"{summary['mill']}: the run kept no table of its collisions, and no rule of dem.counting_rules is without "
        "a threshold: heat cannot be divided between balls and wall"
    )


def read_source(summary_path: str | Path, run_path: str | Path) -> HeatSource:
    """The source of one run: powers of the ledger over its window, divided by the places where contacts dissipate.

    Raises ConfigError, in one line, for a file that cannot be read or a run that dissipates nothing.
    """
    # Imported here: slow to import, and the check of the input imports this module.
    import trimesh

    summary = read_json(summary_path)
    with open_hdf5(run_path) as file:
        split = split_of_contacts(file["collisions"])
        vertices, triangles = file["geometry/vertices_m"][:], file["geometry/triangles"][:]
        inside_m2 = float(trimesh.Trimesh(vertices, triangles, process=False).area)
    split = split_of_summary(summary) if split is None else split
    power = np.array([max(summary["power_W"][channel], 0.0) for channel in PARTS])
    if not power.sum() > 0:
        raise ConfigError(f"{summary_path}: the run dissipates nothing; a mill at rest has no heat balance")
    case = summary["case"]
    sizes = np.repeat(summary["ball_sizes_m"], summary["ball_counts"])
    return HeatSource(
        condition=Path(summary_path).parent.name.removesuffix(f"_s{case['seed']}"),
        about={**condition_of(summary), "seeds": 1},
        power_W=split * power,
        balls_kg=summary["ball_mass_kg"] * summary["balls"],
        balls_m2=float(np.pi * (sizes**2).sum()),
        inside_m2=inside_m2,
        inside_m3=summary["jar_volume_m3"],
    )


def read_sources(paths: Iterable[tuple[str, str]]) -> list[HeatSource]:
    """The conditions in pairs of summary and run.h5, each a mean over its seeds, in the order of the files."""
    grouped: dict[str, list[HeatSource]] = {}
    for summary_path, run_path in paths:
        source = read_source(summary_path, run_path)
        grouped.setdefault(source.condition, []).append(source)
    return [mean_of(group) for group in grouped.values()]


def mean_of(group: list[HeatSource]) -> HeatSource:
    """One condition from its seeds."""
    first = group[0]
    return HeatSource(
        condition=first.condition,
        about={**first.about, "seeds": len(group)},
        power_W=np.mean([each.power_W for each in group], axis=0),
        **{
            name: float(np.mean([getattr(each, name) for each in group]))
            for name in ("balls_kg", "balls_m2", "inside_m2", "inside_m3")
        },
    )


def source_table(sources: Iterable[HeatSource]) -> pd.DataFrame:
    """A row for each condition: dissipation by place and channel [W], mass of the balls, inner surface of the jar."""
    rows = []
    for source in sources:
        powers = {
            f"{place}_{channel}_W": source.power_W[i, k]
            for i, place in enumerate(PAIRS)
            for k, channel in enumerate(PARTS)
        }
        sizes = {
            "balls_g": 1e3 * source.balls_kg,
            "balls_cm2": 1e4 * source.balls_m2,
            "inside_cm2": 1e4 * source.inside_m2,
        }
        rows.append({"condition": source.condition, **source.about, **powers, "total_W": source.power_W.sum(), **sizes})
    return pd.DataFrame(rows)


RUNNING, RESTING, ROOM = "running_W_m2K", "resting_W_m2K", "surroundings_degC"
# Bounds of a band, by the columns that hold them.
BAND = ("lower", "median", "upper")
# Times in a table of temperatures, from the start to the end of the programme.
TIMES = 61
# What cools a jar while the mill stands, by what cools it while the mill runs.
AT_REST: dict[str, str] = {"still_air": "still_air", "moving_air": "still_air", "water": "water"}


def ranges_of(settings: HeatConfig, mill: str) -> dict[str, tuple[RangeSection, str, str]]:
    """Every sampled number by name, with its range, title and unit: parameters, and the surroundings of the mill."""
    cooling = getattr(settings.surroundings, settings.jar_of(mill).cooling)
    resting = getattr(settings.surroundings, AT_REST[settings.jar_of(mill).cooling])
    own = {name: (given, PARAMETERS[name].title, PARAMETERS[name].unit) for name, given in settings.parameters.items()}
    return {
        **own,
        RUNNING: (cooling.coefficient_W_m2K, f"{COEFFICIENT.title} while the mill runs", COEFFICIENT.unit),
        RESTING: (resting.coefficient_W_m2K, f"{COEFFICIENT.title} in a pause", COEFFICIENT.unit),
        ROOM: (cooling.temperature_degC, f"{TEMPERATURE.title}, and all bodies at the start", TEMPERATURE.unit),
    }


def sample(settings: HeatConfig, mill: str) -> pd.DataFrame:
    """Samples of the ranges, a row each: see `latin_hypercube`.

    A range that spans a factor of ten is uniform in the logarithm. If a pause is cooled like milling, both have the
    same sampled number.
    """
    ranges = {name: given for name, (given, _, _) in ranges_of(settings, mill).items()}
    wide = [name for name, given in ranges.items() if given.logarithmic]
    columns = latin_hypercube({name: (given.low, given.high) for name, given in ranges.items()}, settings.samples, wide)
    cooling = settings.jar_of(mill).cooling
    if AT_REST[cooling] == cooling:
        columns[RESTING] = columns[RUNNING]
    return pd.DataFrame(columns)


def jar_of_samples(
    settings: HeatConfig, mill: str, source: HeatSource, drawn: pd.DataFrame
) -> tuple[np.ndarray, np.ndarray]:
    """Mass [kg] and outside [m2] of the jar of each sample (n,).

    If the outside is not given, it is the inside (volume V, surface S) enlarged by the thickness t, by the factor
    1 + t S / (3 V) in length. This is exact for a sphere, a cube and a cylinder as deep as wide.
    """
    known = settings.jar_of(mill)
    factor = 1 + 1e-3 * drawn["wall_thickness_mm"].to_numpy() * source.inside_m2 / (3 * source.inside_m3)
    mass = drawn["jar_density_kg_m3"].to_numpy() * source.inside_m3 * (factor**3 - 1)
    outside = source.inside_m2 * factor**2
    if known.mass_kg is not None:
        mass = np.full(len(drawn), known.mass_kg)
    if known.surface_cm2 is not None:
        outside = np.full(len(drawn), 1e-4 * known.surface_cm2)
    return mass, outside


def heat_by_body(source: HeatSource, drawn: pd.DataFrame) -> np.ndarray:
    """Heat released in balls, powder and jar [W] (n, 3); the sum is heat_share of the dissipation.

    The powder takes its share of every contact. The rest heats the balls in contacts of ball on ball; in contacts of
    ball on wall, `wall_share` of the rest heats the jar and the remainder the balls.
    """
    shares = drawn[["powder_share_normal", "powder_share_shear", "powder_share_shear"]].to_numpy()
    power = source.power_W[None] * drawn["heat_share"].to_numpy()[:, None, None]
    powder = (power * shares[:, None, :]).sum(axis=(1, 2))
    between, wall = np.moveaxis((power * (1 - shares[:, None, :])).sum(axis=2), 1, 0)
    jar = wall * drawn["wall_share"].to_numpy()
    return np.column_stack([between + wall - jar, powder, jar])


def balance_of(settings: HeatConfig, mill: str, source: HeatSource, drawn: pd.DataFrame) -> Balance:
    """The balances of a condition, one for each sample."""
    mass, outside = jar_of_samples(settings, mill, source, drawn)
    powder = source.balls_kg / drawn["ball_to_powder_ratio"].to_numpy()
    if settings.powder_mass_g is not None:
        powder = np.full(len(drawn), 1e-3 * settings.powder_mass_g)
    masses = {"ball": source.balls_kg, "powder": powder, "jar": mass}
    areas = {"ball_powder": source.balls_m2, "ball_wall": source.inside_m2, "powder_wall": source.inside_m2}
    return Balance(
        capacity_J_K=np.column_stack([own * drawn[f"{of}_heat_capacity_J_kgK"] for of, own in masses.items()]),
        between_W_K=np.column_stack([own * drawn[f"{of}_W_m2K"] for of, own in areas.items()]),
        running_W_K=outside * drawn[RUNNING].to_numpy(),
        resting_W_K=outside * drawn[RESTING].to_numpy(),
        source_W=heat_by_body(source, drawn),
        surroundings_degC=drawn[ROOM].to_numpy(),
    )


def band(values: np.ndarray, probability: float) -> np.ndarray:
    """Lower end, median and upper end over the first axis (3, ...); an infinite value is larger than any other."""
    ends = [(1 - probability) / 2, 0.5, (1 + probability) / 2]
    # Not interpolated, because there is no value between a finite and an infinite one.
    return np.quantile(values, ends, axis=0, method="inverted_cdf")


def _columns(name: str, values: np.ndarray, probability: float) -> dict[str, float]:
    return {f"{name}_{end}": value for end, value in zip(BAND, band(values, probability), strict=True)}


@dataclass(frozen=True)
class HeatTables:
    """The tables of a mill."""

    parameters: pd.DataFrame
    """a row for each sampled number, with its range and source"""
    temperatures: pd.DataFrame
    """a row for each condition, body and time"""
    limits: pd.DataFrame
    """a row for each condition: temperatures, time to the limit, pauses"""


def parameter_table(settings: HeatConfig, mill: str) -> pd.DataFrame:
    """A row for each sampled number: range, unit and source."""
    columns = ["parameter", "title", "unit", "low", "high", "source"]
    ranges = ranges_of(settings, mill).items()
    rows = [(name, title, unit, given.low, given.high, given.source) for name, (given, title, unit) in ranges]
    return pd.DataFrame(rows, columns=columns)


def limit_row(settings: HeatConfig, source: HeatSource, balance: Balance, course: Course) -> dict[str, object]:
    """The results of a condition: temperatures, time to the limit, and the pauses that keep below it.

    no_pause_share: share of samples that need no pause; interval_too_long_share: share of samples that get too hot in a
    single interval of milling, so that no pause is enough.
    """
    limit, programme, level = settings.limit, settings.programme, settings.probability
    body = BODIES.index(limit.body)
    reach = time_to_limit(balance, body, limit.temperature_degC) / HOUR
    pause = pause_needed(balance, body, limit.temperature_degC, 60 * programme.milling_min) / 60
    steady = balance.steady_degC()
    row: dict[str, object] = {"condition": source.condition, **source.about, "total_W": source.power_W.sum()}
    for index, name in enumerate(BODIES):
        row |= _columns(f"{name}_steady_degC", steady[:, index], level)
    for index, name in enumerate(BODIES):
        row |= _columns(f"{name}_peak_degC", course.peak_degC[:, index], level)
    return {
        **row,
        "limit_body": limit.body,
        "limit_degC": limit.temperature_degC,
        "over_limit_share": float(np.mean(course.peak_degC[:, body] > limit.temperature_degC)),
        **_columns("time_to_limit_h", reach, level),
        "milling_min": programme.milling_min,
        **_columns("pause_needed_min", pause, level),
        "no_pause_share": float(np.mean(pause == 0)),
        "interval_too_long_share": float(np.mean(np.isinf(pause))),
        "balance_error": course.balance_error,
    }


def temperature_rows(settings: HeatConfig, source: HeatSource, course: Course) -> pd.DataFrame:
    """Bands of the temperatures of a condition over time, a row for each body and time."""
    tables, about = [], {"condition": source.condition, "time_h": course.times_s / HOUR}
    for index, name in enumerate(BODIES):
        ends = band(np.moveaxis(course.temperature_degC[:, :, index], 1, 0), settings.probability)
        columns = {f"{end}_degC": values for end, values in zip(BAND, ends, strict=True)}
        tables.append(pd.DataFrame(about | {"body": name} | columns))
    order = ["condition", "body", "time_h", *(f"{end}_degC" for end in BAND)]
    return pd.concat(tables, ignore_index=True)[order]


def heat_tables(
    settings: HeatConfig,
    mill: str,
    sources: list[HeatSource],
    step: Callable[[], object] = lambda: None,
    times: int = TIMES,
) -> HeatTables:
    """Every table of a mill; step: called after each condition; times: number of times of the temperatures."""
    drawn = sample(settings, mill)
    programme = settings.programme
    duration = HOUR * programme.duration_h
    phases = programme_phases(duration, 60 * programme.milling_min, 60 * programme.pause_min)
    if not programme.pause_min:
        phases = programme_phases(duration, duration, 0.0)
    times_s = np.linspace(0.0, duration, times)
    limits, temperatures = [], []
    for source in sources:
        balance = balance_of(settings, mill, source, drawn)
        course = solve(balance, phases, times_s)
        limits.append(limit_row(settings, source, balance, course))
        temperatures.append(temperature_rows(settings, source, course))
        step()
    return HeatTables(parameter_table(settings, mill), pd.concat(temperatures, ignore_index=True), pd.DataFrame(limits))
