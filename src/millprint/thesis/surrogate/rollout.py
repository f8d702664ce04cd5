"""A roll-out: frames of a batch of trajectories, by a surrogate or by a simulation in its place, and its file.

Snapshots of a simulation as the surrogate reads them, and the scene of a roll-out: walls, motion, balls.
"""

import json
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from millprint.config.errors import ConfigError
from millprint.config.mill import MillConfig
from millprint.mill.distance import SignedDistance
from millprint.mill.motion import motion_from_law
from millprint.mill.vessel import build_vessel
from millprint.run.hdf5 import open_hdf5, whole_hdf5

# Arrays of Trajectory with a row a snapshot, and their data sets.
OF_SNAPSHOTS = {
    "time_s": "time_s",
    "position_m": "position_m",
    "velocity_m_s": "velocity_m_s",
    "force_N": "contact_force_N",
    "wall_position_m": "body_position_m",
}


@dataclass(frozen=True)
class Trajectory:
    """Snapshots at a constant interval, from the start of motion.

    time_s (n,), position_m (n, balls, 3), velocity_m_s (n, balls, 3), force_N (n, balls, 3) net contact force,
    dissipated_J (n,) normal plus tangential since the snapshot before, wall_position_m (n, 3), and the contacts
    as ragged rows: those of snapshot k are `contact_offset[k]:contact_offset[k + 1]` of `first` (a ball) and
    `second` (a ball, or negative for a facet of the wall).
    """

    time_s: np.ndarray
    position_m: np.ndarray
    velocity_m_s: np.ndarray
    force_N: np.ndarray
    dissipated_J: np.ndarray
    wall_position_m: np.ndarray
    contact_offset: np.ndarray
    first: np.ndarray
    second: np.ndarray

    @property
    def interval_s(self) -> float:
        """Time between snapshots [s]."""
        return float(self.time_s[-1] - self.time_s[0]) / (len(self.time_s) - 1)

    @property
    def balls(self) -> int:
        """How many balls there are."""
        return self.position_m.shape[1]

    def index(self, time_s: float) -> int:
        """Row of the snapshot at `time_s`, to the nearest; raises ConfigError outside the recorded time."""
        row = round((time_s - float(self.time_s[0])) / self.interval_s)
        if not 0 <= row < len(self.time_s):
            raise ConfigError(
                f"no snapshot at {time_s:g} s: recorded are {self.time_s[0]:g} to {self.time_s[-1]:g} s of motion"
            )
        return row


def read_trajectory(path: str | Path, from_s: float = 0.0, until_s: float = np.inf) -> Trajectory:
    """Read the snapshots with from_s <= time <= until_s from a run; `check_surrogate_cases` knows that it has them."""
    with open_hdf5(path) as file:
        snapshots = file["snapshots"]
        time_s, offset = snapshots["time_s"][:], snapshots["contact_offset"][:]
        # Times are sums of steps: a tolerance of half a microsecond decides whether a snapshot at a bound belongs.
        rows = slice(*np.searchsorted(time_s, [from_s - 5e-7, until_s + 5e-7]))
        offset = offset[rows.start : rows.stop + 1]
        first, second = (
            snapshots[name][int(offset[0]) : int(offset[-1])] for name in ("contact_first", "contact_second")
        )
        arrays = {name: snapshots[dataset][rows] for name, dataset in OF_SNAPSHOTS.items()}
        dissipated_J = snapshots["normal_J"][rows] + snapshots["tangential_J"][rows]
    offset = offset - offset[0]
    return Trajectory(**arrays, dissipated_J=dissipated_J, contact_offset=offset, first=first, second=second)


def read_attributes(path: str | Path) -> dict:
    """The configuration that a run carries: `case`, `mill`, `contact` and `dem` as mappings."""
    with open_hdf5(path) as file:
        return json.loads(file.attrs["config"])


def read_rows(path: str | Path, names: tuple[str, ...], rows: slice) -> list[np.ndarray]:
    """Some rows of data sets of the snapshots of a run."""
    with open_hdf5(path) as file:
        return [file["snapshots"][name][rows] for name in names]


def mean_power_W(path: str | Path, until_s: float) -> float:
    """Dissipated energy of a run over time, from its first snapshot to the one at `until_s` [s] of motion [W]."""
    time_s, normal, tangential = read_rows(path, ("time_s", "normal_J", "tangential_J"), slice(None))
    end = int(np.searchsorted(time_s, until_s + 5e-7))
    return float((normal + tangential)[1:end].sum(dtype=float) / (time_s[end - 1] - time_s[0]))


AXES = "xyz"
# Of a section through a vessel, along each of its two axes.
POINTS = 161
Distance = Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]]


@dataclass(frozen=True)
class Scene:
    """A vessel that moves without turning, and the balls in it.

    distance: points (n, 3) in the body frame to their signed distances (n,), negative inside, and gradients (n, 3);
    wall_position: times (...) to positions of the body frame (..., 3); bounds_m (2, 3): lower and upper corner of the
    vessel in its frame.
    """

    ball_radius_m: float
    ball_mass_kg: float
    speed_rpm: float
    bounds_m: np.ndarray
    distance: Distance
    wall_position: Callable[[np.ndarray], np.ndarray]

    @property
    def turn_s(self) -> float:
        """Time of a turn of the mill [s]."""
        return 60.0 / self.speed_rpm

    def signed_distance(self, position: np.ndarray, wall: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Signed distance (...) and gradient (..., 3) at `position` (..., 3) with the vessel at `wall` (..., 3).

        The vessel only translates, so the gradient is the same in the laboratory frame.
        """
        relative = np.asarray(position - wall, dtype=float)
        points = relative.reshape(-1, 3)
        # A roll-out may run away: positions that are not finite have no distance.
        finite = np.isfinite(points).all(axis=1)
        distance, gradient = np.full(len(points), np.nan), np.full(points.shape, np.nan)
        distance[finite], gradient[finite] = self.distance(points[finite])
        return distance.reshape(relative.shape[:-1]), gradient.reshape(relative.shape)

    def section(self, normal: str, at_m: float) -> dict:
        """Signed distance on the plane `normal` = at_m of the body frame, not a number outside (thesis Fig. 6.3).

        normal: x, y or z. Returns `title`, `axes` (two names), `first_m` (a,), `second_m` (b,), `distance_m` (b, a).
        """
        across = [axis for axis in range(3) if axis != AXES.index(normal)]
        low, high = self.bounds_m
        lines = [np.linspace(low[axis], high[axis], POINTS) for axis in across]
        grid = np.full((POINTS, POINTS, 3), at_m)
        grid[..., across[0]], grid[..., across[1]] = np.meshgrid(*lines)
        distance, _ = self.signed_distance(grid, np.zeros(3))
        axes = tuple(AXES[axis] for axis in across)
        return {
            "title": f"{axes[0]}{axes[1]} plane, {normal} = {1e3 * at_m:.3g} mm",
            "axes": axes,
            "first_m": lines[0],
            "second_m": lines[1],
            "distance_m": np.where(distance < 0, distance, np.nan),
        }


def read_scene(run: str | Path) -> Scene:
    """The scene of a simulation, from the configuration that its file carries.

    Raises ConfigError for a vessel that turns or has inserts, whose features this network does not have.
    """
    attributes = read_attributes(run)
    mill, case, contact = attributes["mill"], attributes["case"], attributes["contact"]
    config = MillConfig(**mill)
    motion = motion_from_law(config.motion, case["speed_hz"])
    if motion.turns:
        raise ConfigError(f"{run}: mill {config.name} turns; the surrogate knows vessels that only translate")
    if config.inserts:
        raise ConfigError(f"{run}: mill {config.name} has inserts; the surrogate knows the walls of one vessel")
    vessel = build_vessel(config)
    radius = case["ball_diameter_m"] / 2
    return Scene(
        ball_radius_m=radius,
        ball_mass_kg=contact["density_kg_m3"] * 4 / 3 * np.pi * radius**3,
        speed_rpm=60 * case["speed_hz"],
        bounds_m=vessel.bounds,
        distance=SignedDistance(vessel),
        wall_position=motion.position,
    )


# Units of the arrays that a file holds, each in the data set of its name.
UNITS = {
    "time_s": "s", "position_m": "m", "velocity_m_s": "m/s", "dissipated_J": "J", "crossed_s": "s", "start_s": "s",
}  # fmt: skip
EDGES = ("wall", "pair")
# Surfaces nearer than this share of a ball's radius touch: overlaps are smaller, and gaps are rarely that small.
TOUCH = 0.01


@dataclass(frozen=True)
class RollOut:
    """Frames of a batch of trajectories.

    Of every roll-out: time_s (frames,) since the start; position_m and velocity_m_s (frames, batch, balls, 3);
    dissipated_J (frames, batch) since the frame before; crossed_s (batch, balls): when a centre first crossed the wall
    or stopped being a finite number, infinity if never; start_s (batch,) since the mill was started. mean_edges: mean
    number of `wall` and of `pair` edges of a graph, of graph networks.

    None where it is not known: recorded_J (frames, batch): cumulative dissipation as a simulation recorded it.
    wall_distance_m (frames, batch, balls): of every centre, positive inside; see `in_scene`.
    """

    time_s: np.ndarray
    position_m: np.ndarray
    velocity_m_s: np.ndarray
    dissipated_J: np.ndarray
    crossed_s: np.ndarray
    start_s: np.ndarray
    mean_edges: dict[str, float] = field(default_factory=dict)
    recorded_J: np.ndarray | None = None
    wall_distance_m: np.ndarray | None = None

    def known(self, name: str) -> np.ndarray:
        """An optional array by its name; raises ValueError where this roll-out does not have it."""
        values = getattr(self, name)
        if values is None:
            raise ValueError(f"this roll-out has no {name}")
        return values

    @property
    def cumulative_J(self) -> np.ndarray:
        """Dissipation since the start, (frames, batch) [J]."""
        return np.cumsum(self.dissipated_J, axis=0) if self.recorded_J is None else self.recorded_J

    @property
    def length_s(self) -> float:
        """Time from the first frame to the last [s]."""
        return float(self.time_s[-1])

    def in_scene(self, scene: Scene, wall_m: np.ndarray | None = None) -> "RollOut":
        """The same with wall distances; wall_m (frames, batch, 3): as recorded, or else as the scene's wall moves."""
        wall_m = scene.wall_position(self.start_s + self.time_s[:, None]) if wall_m is None else wall_m
        with np.errstate(invalid="ignore", over="ignore"):
            distance, _ = scene.signed_distance(self.position_m, wall_m[:, :, None, :])
        return replace(self, wall_distance_m=-distance)

    def wall_of(self, scene: Scene) -> tuple[np.ndarray, np.ndarray]:
        """Position [m] and velocity [m/s] of a scene's wall at every frame, (frames, batch, 1, 3) each."""
        wall = scene.wall_position(self.start_s + self.time_s[:, None])[:, :, None, :]
        return wall, np.gradient(wall, self.time_s[1] - self.time_s[0], axis=0)

    def first_trajectory(self) -> "RollOut":
        """The same arrays for only the first trajectory: a batch of one."""
        names = ("position_m", "velocity_m_s", "dissipated_J", "recorded_J", "wall_distance_m")
        first = {name: values[:, :1] for name in names if (values := getattr(self, name)) is not None}
        return RollOut(time_s=self.time_s, crossed_s=self.crossed_s[:1], start_s=self.start_s[:1], **first)

    def speed(self) -> np.ndarray:
        """Speed of every ball, (frames, batch, balls) [m/s]."""
        return np.linalg.norm(self.velocity_m_s, axis=-1)

    def contacts(self, radius_m: float) -> np.ndarray:
        """How many balls and walls each ball touches, from positions only, (frames, batch, balls) [-]."""
        first, second = np.triu_indices(self.position_m.shape[2], 1)
        reach = (2 + TOUCH) * radius_m
        count = (self.known("wall_distance_m") <= (1 + TOUCH) * radius_m).astype(int)
        for i in np.unique(first):
            others = second[first == i]
            gap = self.position_m[:, :, others] - self.position_m[:, :, i, None]
            touching = (gap * gap).sum(axis=-1) <= reach**2
            count[:, :, i] += touching.sum(axis=-1)
            count[:, :, others] += touching
        return count

    def write(self, path: str | Path, case: str) -> None:
        """Write the arrays of UNITS; case: the simulation that gave the first states."""
        with whole_hdf5(path) as file:
            file.attrs["case"] = case
            for kind, number in self.mean_edges.items():
                file.attrs[f"mean_{kind}_edges"] = number
            for name, unit in UNITS.items():
                dataset = file.create_dataset(name, data=getattr(self, name))
                dataset.attrs["units"] = unit

    @classmethod
    def read(cls, path: str | Path) -> "RollOut":
        """Read a file, in double precision."""
        with open_hdf5(path) as file:
            arrays = {name: file[name][:].astype(float) for name in UNITS}
            edges = {kind: float(file.attrs[key]) for kind in EDGES if (key := f"mean_{kind}_edges") in file.attrs}
            return cls(**arrays, mean_edges=edges)


def simulated(run: Trajectory, scene: Scene | None, time_s: np.ndarray, start_s: np.ndarray) -> RollOut:
    """A simulation as a roll-out: at `time_s` (frames,) after each of `start_s` (batch,), with energies as recorded.

    With a scene, it has wall distances, of the walls as recorded. Raises ConfigError where its snapshots are not at
    those times.
    """
    moments_s = start_s + time_s[:, None]
    first = np.array([run.index(float(moment)) for moment in start_s])
    run.index(float(moments_s.max()))
    rows = first + np.rint(time_s / run.interval_s).astype(int)[:, None]
    # A later frame would not show the same contacts.
    late = float(np.abs(run.time_s[rows] - moments_s).max())
    if late > 1e-5:
        raise ConfigError(
            f"a simulation has snapshots every {run.interval_s:g} s, {late:.2g} s off the frames of the roll-out: its "
            "snapshot_interval_s must divide surrogate.rollout.frame_interval_s, and starts_s be among its times"
        )
    total = np.cumsum(run.dissipated_J, dtype=float)
    recorded = RollOut(
        time_s=time_s,
        position_m=run.position_m[rows].astype(float),
        velocity_m_s=run.velocity_m_s[rows].astype(float),
        dissipated_J=np.diff(total[rows], axis=0, prepend=total[rows][:1]),
        crossed_s=np.full((len(start_s), run.balls), np.inf),
        start_s=start_s,
        recorded_J=total[rows] - total[first],
    )
    return recorded.in_scene(scene, run.wall_position_m[rows].astype(float)) if scene else recorded


SLOWED_RATE = 0.9


def simulated_rollout(run: Trajectory, start_s: float, length_s: float, interval_s: float) -> RollOut:
    """A simulation in the place of a surrogate: frames every `interval_s` [s], without what a surrogate cannot record.

    Raises ConfigError outside the recorded time.
    """
    every = max(1, round(interval_s / run.interval_s))
    time_s = run.time_s[run.index(start_s) : run.index(start_s + length_s) + 1 : every]
    return replace(simulated(run, None, time_s - time_s[0], np.array([start_s])), recorded_J=None)


def blurred(rollout: RollOut) -> RollOut:
    """Every ball at the centre of mass, with the right dissipation: a low mean square error, and no motion at all."""
    centre, drift = (
        np.broadcast_to(array.mean(axis=2, keepdims=True), array.shape)
        for array in (rollout.position_m, rollout.velocity_m_s)
    )
    return replace(rollout, position_m=centre, velocity_m_s=drift)


def rms_wall_speed(scene: Scene) -> float:
    """Root mean square speed of the wall over a turn of the mill [m/s]."""
    time_s = np.linspace(0.0, scene.turn_s, 2001)
    velocity = np.gradient(scene.wall_position(time_s), time_s, axis=0)
    return float(np.sqrt((velocity[:-1] ** 2).sum(axis=-1).mean()))


def scaled_motion(rollout: RollOut, scene: Scene, known: RollOut, known_scene: Scene) -> RollOut:
    """The nearest known motion, again and again, in step with the mill and at the speed of this wall.

    Every ball has its place in the known jar, its velocity in the jar times the ratio v of both rms wall speeds, and
    what is dissipated is v^2 times the known, as a power goes with the square of a speed at the same turns a second.
    known: frames as far apart as those of the roll-out, and one trajectory.
    """
    step = rollout.time_s[1] - rollout.time_s[0]
    turn = round(scene.turn_s / step)
    # Of whole turns, if there is one, so that the motion begins again in step.
    frames = max((len(known.time_s) - 1) // turn * turn, min(turn, len(known.time_s) - 1))
    first = round((float(rollout.start_s[0] - known.start_s[0]) % scene.turn_s) / step)
    rows = 1 + (first - 1 + np.arange(len(rollout.time_s))) % frames
    there, here = known.wall_of(known_scene), rollout.wall_of(scene)
    ratio = rms_wall_speed(scene) / rms_wall_speed(known_scene)
    dissipated = ratio**2 * known.dissipated_J[rows]
    dissipated[0] = 0
    shape = rollout.position_m.shape
    return replace(
        rollout,
        position_m=np.broadcast_to((known.position_m - there[0])[rows] + here[0], shape),
        velocity_m_s=np.broadcast_to(ratio * (known.velocity_m_s - there[1])[rows] + here[1], shape),
        dissipated_J=np.broadcast_to(dissipated, rollout.dissipated_J.shape),
    )


def riding(rollout: RollOut, scene: Scene, power_W: float) -> RollOut:
    """Nothing learned: every ball keeps its place in the jar, and a constant power is dissipated.

    power_W: the mean of the training, or that times the ratio of the squares of both rms wall speeds.
    """
    wall, drift = rollout.wall_of(scene)
    dissipated = np.full_like(rollout.dissipated_J, power_W * (rollout.time_s[1] - rollout.time_s[0]))
    dissipated[0] = 0
    place = rollout.position_m[:1] + wall - wall[:1]
    velocity = np.broadcast_to(drift, rollout.velocity_m_s.shape)
    return replace(rollout, position_m=place, velocity_m_s=velocity, dissipated_J=dissipated)


def slowed(rollout: RollOut, scene: Scene, rate: float = SLOWED_RATE) -> RollOut:
    """The motion of the balls relative to the jar at another rate, in a jar that moves at the right rate."""
    moment = rollout.time_s * rate
    frame = np.searchsorted(rollout.time_s, moment, side="right") - 1
    following = np.minimum(frame + 1, len(moment) - 1)
    step = rollout.time_s[1] - rollout.time_s[0]
    share = ((moment - rollout.time_s[frame]) / step)[:, None, None, None]
    wall, drift = rollout.wall_of(scene)
    place, motion = rollout.position_m - wall, rollout.velocity_m_s - drift
    late = (1 - share[..., 0, 0]) * rollout.cumulative_J[frame] + share[..., 0, 0] * rollout.cumulative_J[following]
    return replace(
        rollout,
        position_m=wall + (1 - share) * place[frame] + share * place[following],
        velocity_m_s=drift + rate * ((1 - share) * motion[frame] + share * motion[following]),
        dissipated_J=np.diff(late, axis=0, prepend=0),
    )
