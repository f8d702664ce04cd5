"""Drums half full of beads: the flowing bed, its angles and speeds."""

import logging
import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from millprint.cases.simulate import Values
from millprint.config.contact_set import ContactConfig
from millprint.config.errors import ConfigError
from millprint.config.mill import CylinderGeometry, MillConfig
from millprint.config.setup_models import (
    FLOW_SPEED,
    REPOSE,
    STILL_PLACE,
    SURFACE_ANGLE,
    BeadDrumConfig,
    DrumOfBallsConfig,
    ReposeDrumConfig,
)
from millprint.config.sweep import Case, expand_sweep
from millprint.dem.collisions import collision_table
from millprint.dem.layout import SNAPSHOT
from millprint.dem.ledger import check_balance, ledger_series
from millprint.dem.simulation import Simulation
from millprint.estimate.estimates import half_width, latin_hypercube
from millprint.mill.kernel_columns import span_of
from millprint.run.hdf5 import open_hdf5
from millprint.validation.measured import BLOCKS, CONTACT, Inputs, prediction

# At the surface, the number density falls to this share of its value in the bed.
SURFACE_SHARE = 0.5
# Rows of the histogram of a column per width of the column.
ROWS_PER_CELL = 2
TURNS_MAX, TURN_END = 20, 1e-4
# A mean needs at least this number of balls.
FEWEST = 20


@dataclass(frozen=True)
class Surface:
    """A plane free surface, by its slope.

    slope_rad: angle to the horizontal, positive where the surface rises with x; height_m: its place along the normal.
    """

    slope_rad: float
    height_m: float

    @property
    def angle_deg(self) -> float:
        """Angle to the horizontal [deg], without its sign."""
        return math.degrees(abs(self.slope_rad))

    @property
    def down(self) -> np.ndarray:
        """Unit vector (2,) down the slope."""
        along = np.array([math.cos(self.slope_rad), math.sin(self.slope_rad)])
        return -along if self.slope_rad > 0 else along

    @property
    def normal(self) -> np.ndarray:
        """Unit vector (2,) out of the bed."""
        return np.array([-math.sin(self.slope_rad), math.cos(self.slope_rad)])


def _column_tops(along: np.ndarray, up: np.ndarray, half_width: float, cell: float) -> tuple[np.ndarray, np.ndarray]:
    """Middles (c,) of columns, and heights (c,) at which the density falls to SURFACE_SHARE of that below [m]."""
    columns = max(4, round(2 * half_width / cell))
    step = cell / ROWS_PER_CELL
    low, high = up.min() - step, up.max() + 2 * step
    rows = math.ceil((high - low) / step)
    edges = np.linspace(-half_width, half_width, columns + 1)
    counts, _, heights = np.histogram2d(along, up, [edges, np.linspace(low, low + rows * step, rows + 1)])
    middles, centres = (edges[1:] + edges[:-1]) / 2, (heights[1:] + heights[:-1]) / 2
    tops = np.full(columns, math.nan)
    for column, count in enumerate(counts):
        if not count.any():
            continue
        half = SURFACE_SHARE * np.median(count[count > 0])
        last = np.flatnonzero(count >= half)[-1]
        # The highest row is always empty.
        tops[column] = centres[last] + step * (count[last] - half) / (count[last] - count[last + 1])
    return middles, tops


def fit_surface(places: np.ndarray, half_width: float, cell: float) -> Surface:
    """The free surface by least squares, in the middle part of the drum.

    places: (n, 2) of the balls at all times [m]; half_width: of the part that is fitted, along the surface on both
    sides of the axis [m]; cell: width of a column [m], about a ball. The fit is repeated until the columns are
    perpendicular to the surface. Raises ValueError if fewer than three columns contain balls.
    """
    slope, height = 0.0, math.nan
    for _ in range(TURNS_MAX):
        along = np.array([math.cos(slope), math.sin(slope)])
        normal = np.array([-along[1], along[0]])
        middles, tops = _column_tops(places @ along, places @ normal, half_width, cell)
        known = np.isfinite(tops)
        if known.sum() < 3:
            raise ValueError("fewer than three columns of the middle part hold balls")
        gradient, height = np.polyfit(middles[known], tops[known], 1)
        turn = math.atan(gradient)
        slope += turn
        if abs(turn) < TURN_END:
            break
    return Surface(slope, float(height))


def speed_profile(
    places: np.ndarray, velocities: np.ndarray, surface: Surface, depths: np.ndarray, half_width: float,
    half_height: float,
) -> np.ndarray:  # fmt: skip
    """Mean speed down the slope (k,) [m/s] at places (k,) along the normal [m].

    places, velocities: (n, 2) of the balls at all times [m], [m/s]. The mean is over the balls in a box around the
    place with half the height half_height and half the width half_width [m]; NaN for fewer than FEWEST balls.
    """
    near = np.abs(places @ surface.down) < half_width
    height, speed = places[near] @ surface.normal, velocities[near] @ surface.down
    order = np.argsort(height)
    height, total = height[order], np.concatenate([[0.0], np.cumsum(speed[order])])
    first = np.searchsorted(height, np.asarray(depths) - half_height)
    last = np.searchsorted(height, np.asarray(depths) + half_height)
    count = last - first
    return np.where(count >= FEWEST, (total[last] - total[first]) / np.maximum(count, 1), math.nan)


def zero_place(depths: np.ndarray, speeds: np.ndarray) -> float:
    """The place [m] of the first change of sign of the speed on the way up from the wall, interpolated; nan for none.

    depths: (k,) ascending [m]; speeds: (k,) [m/s], negative where the bed turns with the drum.
    """
    known = np.isfinite(speeds)
    depth, speed = np.asarray(depths)[known], np.asarray(speeds)[known]
    changes = np.flatnonzero((speed[:-1] <= 0) & (speed[1:] > 0))
    if not len(changes):
        return math.nan
    at = changes[0]
    return float(depth[at] - speed[at] * (depth[at + 1] - depth[at]) / (speed[at + 1] - speed[at]))


logger = logging.getLogger("millprint")

# Both drums turn about y.
ACROSS = [0, 2]
TURNING, SHORT = "turning with the drum", "shorter slice"
# Places per ball diameter at which the speed is predicted, in addition to the measured ones.
PLACES_PER_DIAMETER = 1
VARIED = ("restitution", "static_friction", "rolling_friction")


@dataclass(frozen=True)
class Motion:
    """Balls of a drum at t times: places and velocities (t, n, 2) across the axis [m], [m/s], and the radius [m]."""

    places: np.ndarray
    velocities: np.ndarray
    radius: float

    def blocks(self, count: int) -> list["Motion"]:
        """The motion in consecutive parts of about equal length."""
        parts = np.array_split(np.arange(len(self.places)), count)
        return [Motion(self.places[part], self.velocities[part], self.radius) for part in parts]

    def surface(self, settings: DrumOfBallsConfig) -> Surface:
        """The free surface, of all times together."""
        half_width = settings.surface_share * self.radius
        return fit_surface(self.places.reshape(-1, 2), half_width, settings.ball_diameter_mm * 1e-3)


def read_motion(path: Path, radius: float) -> Motion:
    """The motion in the snapshots of a run. Raises ConfigError for a damaged file."""
    with open_hdf5(path) as file:
        group = file["snapshots"]
        return Motion(group["position_m"][..., ACROSS], group["velocity_m_s"][..., ACROSS], radius)


def _drum(inputs: Inputs) -> tuple[MillConfig, CylinderGeometry]:
    """The mill and its shape. Raises ConfigError for one that is not a cylinder about y."""
    mill = inputs.mill
    if mill is None or not isinstance(mill.geometry, CylinderGeometry) or mill.geometry.axis != "y":
        raise ConfigError(f"validation: mill {inputs.settings.mill}: must be a cylinder about the axis y")
    return mill, mill.geometry


def _radius(inputs: Inputs) -> float:
    return _drum(inputs)[1].radius_mm * 1e-3


@dataclass(frozen=True)
class Profile:
    """Results of a run of set-up 4: surface angle [deg], speeds (k,) [m/s] at places, and the place of speed 0 [m]."""

    angle_deg: float
    speeds: np.ndarray
    zero: float

    @property
    def values(self) -> np.ndarray:
        """All numbers in one row: angle, place of speed 0, speeds."""
        return np.array([self.angle_deg, self.zero, *self.speeds])


def measure(motion: Motion, depths: np.ndarray, settings: BeadDrumConfig, surface: Surface | None = None) -> Profile:
    """The profile at ascending places (k,) [m], in the frame of the motion's surface or of a given surface."""
    own = motion.surface(settings)
    half_width, half_height = (
        share * settings.ball_diameter_mm * 1e-3
        for share in (settings.half_width_diameters, settings.half_height_diameters)
    )
    places, velocities = (values.reshape(-1, 2) for values in (motion.places, motion.velocities))
    speeds = speed_profile(places, velocities, surface or own, depths, half_width, half_height)
    return Profile(own.angle_deg, speeds, zero_place(depths, speeds))


def _block_scatter(motion: Motion, depths: np.ndarray, settings: BeadDrumConfig, surface: Surface) -> np.ndarray:
    """Half the interval of each of `Profile.values` by the scatter of blocks of time, all in the same frame."""
    blocks = motion.blocks(settings.blocks)
    return half_width(np.array([measure(block, depths, settings, surface).values for block in blocks]))


def predict_bead_drum(inputs: Inputs) -> pd.DataFrame:
    """Set-up 4: angle of the surface, speed over depth about the axis, and where the speed is zero, from two slices.

    The long slice predicts, in the frame of its surface. Its interval is by blocks of time, plus on each side the
    change with the other contact sets in the short slice.
    """
    settings: BeadDrumConfig = inputs.settings
    radius, diameter = _radius(inputs), settings.ball_diameter_mm * 1e-3
    paths = {(case.mill, case.contact): path for path, case in inputs.cases.items()}
    long = read_motion(inputs.runs / paths[settings.mill, settings.contact] / "run.h5", radius)
    surface = long.surface(settings)
    spaced = np.arange(-radius + diameter / 2, surface.height_m, diameter / PLACES_PER_DIAMETER)
    depths = np.union1d(spaced, inputs.places_of(FLOW_SPEED))
    found = measure(long, depths, settings).values
    scatter = _block_scatter(long, depths, settings, surface)
    shorts = {
        contact: read_motion(inputs.runs / paths[settings.short_mill, contact] / "run.h5", radius)
        for contact in settings.contact_names
    }
    short = {contact: measure(motion, depths, settings).values for contact, motion in shorts.items()}
    same = shorts[settings.contact]
    short_scatter = _block_scatter(same, depths, settings, same.surface(settings))
    changes = np.array([values - short[settings.contact] for values in short.values()])
    # A place outside the bed in one of the runs gives no information on the parameters.
    lower, upper = np.fmin.reduce([*changes, 0 * found]), np.fmax.reduce([*changes, 0 * found])
    spread = np.nan_to_num(scatter)
    low, high = found + np.nan_to_num(lower) - spread, found + np.nan_to_num(upper) + spread
    for contact, values in short.items():
        logger.info("slice of %s, %s: angle %.2f deg, speed 0 at %.4f m", settings.short_mill, contact, *values[:2])
    logger.info("slice of %s: angle %.2f deg +- %.2f, speed 0 at %.4f m", settings.mill, found[0], scatter[0], found[1])

    interval = f"{BLOCKS} and {CONTACT}" if len(short) > 1 else BLOCKS

    def rows_of(place: int, quantity: str, unit: str, id: str, x: float = math.nan) -> list[dict]:
        """The rows of one number: for the long slice, the short slice, and the short slice with the other sets."""
        other = short[settings.contact][place]
        return [
            prediction(
                quantity, unit, found[place], id=id, x=x, lower=low[place], upper=high[place], interval=interval
            ),
            prediction(
                quantity, unit, other, id=id, x=x, lower=other - short_scatter[place],
                upper=other + short_scatter[place], interval=BLOCKS, model=SHORT,
            ),
            *(
                prediction(quantity, unit, short[name][place], id=id, x=x, model=f"{SHORT}, {name}")
                for name in settings.further_contacts
            ),
        ]  # fmt: skip

    ids, omega = inputs.ids_of(FLOW_SPEED), settings.speed_rpm * math.pi / 30
    rows = [
        *rows_of(0, SURFACE_ANGLE, "deg", inputs.ids_of_single(SURFACE_ANGLE)),
        *rows_of(1, STILL_PLACE, "m", inputs.ids_of_single(STILL_PLACE)),
    ]
    for place, depth in enumerate(depths.tolist(), start=2):
        if not math.isnan(found[place]):
            id = ids.get(depth, "")
            rows += rows_of(place, FLOW_SPEED, "m/s", id, depth)
            rows.append(prediction(FLOW_SPEED, "m/s", omega * depth, id=id, x=depth, model=TURNING))
    return pd.DataFrame(rows)


def slab_of_bed(path: Path, thickness: float) -> pd.DataFrame:
    """The balls of the last snapshot in the middle of a drum: x, z [m] and speed [m/s] across its axis.

    thickness: of the slab along the axis [m]. Raises ConfigError for a damaged file.
    """
    with open_hdf5(path) as file:
        position, velocity = (file["snapshots"][name][-1] for name in ("position_m", "velocity_m_s"))
    inside = np.abs(position[:, 1] - position[:, 1].mean()) < thickness / 2
    (x, z), speed = position[inside][:, ACROSS].T, np.linalg.norm(velocity[inside][:, ACROSS], axis=1)
    return pd.DataFrame({"x_m": x, "z_m": z, "speed_m_s": speed})


def sample_contacts(contact: ContactConfig, settings: ReposeDrumConfig) -> list[ContactConfig]:
    """Contact sets with parameters drawn from the intervals of the settings by a Latin hypercube."""
    ranges = {name: getattr(settings, name) for name in VARIED}
    drawn = pd.DataFrame(latin_hypercube(ranges, settings.samples, ["rolling_friction"]))
    return [contact.model_copy(update=row) for row in drawn.to_dict("records")]


def _slice_angle(inputs: Inputs, case: Case, contact: ContactConfig) -> Values:
    """Angle of the surface in a slice with smooth ends [deg], simulated here.

    Raises SimulationError where the energy balance does not close.
    """
    settings: ReposeDrumConfig = inputs.settings
    whole, shape = _drum(inputs)
    geometry = shape.model_copy(update={"height_mm": settings.slice_mm, "smooth_ends": True})
    volume_ml = whole.volume_ml * settings.slice_mm / shape.height_mm
    mill = whole.model_copy(update={"geometry": geometry, "volume_ml": volume_ml})
    simulation = Simulation(case, mill, contact, inputs.dem)
    recording = simulation.run("slice")
    check_balance(simulation, ledger_series(np.concatenate(recording.samples)), collision_table(recording.table))
    balls = np.concatenate(recording.snapshots)
    places, velocities = (
        balls[..., span_of(columns)][..., ACROSS] for columns in (SNAPSHOT.position_m, SNAPSHOT.velocity_m_s)
    )
    return {"angle_deg": float(Motion(places, velocities, _radius(inputs)).surface(settings).angle_deg)}


def predict_repose_drum(inputs: Inputs) -> pd.DataFrame:
    """Set-up 7: the angle of the surface in the whole drum, the mean of its seeds.

    Its interval is by blocks of time of all seeds, which are few, plus on each side the largest change with other
    contact parameters in a slice.
    """
    settings: ReposeDrumConfig = inputs.settings
    motions = [read_motion(inputs.runs / path / "run.h5", _radius(inputs)) for path in inputs.cases]
    angles = np.array([motion.surface(settings).angle_deg for motion in motions])
    blocks = [[part.surface(settings).angle_deg for part in motion.blocks(settings.blocks)] for motion in motions]
    scatter = float(half_width(np.concatenate(blocks)))
    case = next(iter(expand_sweep(settings.sweeps[0], inputs.dem, settings.mill)))
    contacts = [inputs.contact, *sample_contacts(inputs.contact, settings)]
    runs = {f"slice {number}": contact.model_dump(mode="json") for number, contact in enumerate(contacts)}
    slices = inputs.simulated(runs, lambda own: _slice_angle(inputs, case, ContactConfig(**own)), "slices")
    base, *others = (each["angle_deg"] for each in slices)
    changes = [0.0, *(angle - base for angle in others)]
    found, id = float(angles.mean()), inputs.ids_of_single(REPOSE)
    logger.info("whole drum: %s deg; slice with smooth ends: %.2f deg", np.round(angles, 2).tolist(), base)
    return pd.DataFrame(
        [
            prediction(
                REPOSE, "deg", found, id=id, lower=found + min(changes) - scatter, upper=found + max(changes) + scatter,
                interval=f"{BLOCKS} and {CONTACT}" if settings.samples else BLOCKS,
            ),
            prediction(REPOSE, "deg", base, id=id, model="slice without ends"),
        ]
    )  # fmt: skip
