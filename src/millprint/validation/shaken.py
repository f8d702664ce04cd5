"""Shaken boxes: the law of collect and collide, balls in a box on a drive or on a spring, and their predictions."""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from millprint.cases.simulate import Values
from millprint.config.contact_set import ContactConfig
from millprint.config.errors import ConfigError
from millprint.config.mill import BoxGeometry
from millprint.config.setup_models import (
    LOSS_EXPONENT,
    LOST,
    PLATE_MEAN,
    PLATE_POWER,
    SWING,
    LeafSpringConfig,
    ShakenBoxConfig,
    ShakenPlateConfig,
)
from millprint.dem.laws.registry import step_scale
from millprint.dem.ledger import check_closure, closure
from millprint.dem.packing import pack
from millprint.dem.resources import aligned_step, skin_of
from millprint.dem.simulation import FewBalls
from millprint.estimate.estimates import mean_of
from millprint.mill.gravity import GRAVITY
from millprint.mill.motion import Motion
from millprint.mill.vessel import Vessel, shape_vessel
from millprint.validation.measured import COUNT, DEM, SCATTER, Inputs, prediction

# At smaller amplitudes over the free gap, the pile never leaves the wall in time: no collect and collide.
LAW_END = 1 / math.pi
# Rounded tables give the end with four digits.
ROUNDING = 1e-3
# Time in which a pile comes to rest [s].
POURED_S = 1.0
LOSSES = ["normal_damping_J", "tangential_damping_J", "sliding_J", "rolling_J"]


def meeting_phase(gap_over_amplitude: float) -> float:
    """The phase tau between two walls [rad], tau - sin(tau) = G / A; nan for a gap of more than pi amplitudes.

    The pile leaves a wall with the speed A w when that wall stops pushing, at tau = 0, and meets the other at tau.
    """
    # Slow to import, and every set-up imports this module.
    from scipy.optimize import brentq

    if gap_over_amplitude > math.pi * (1 + ROUNDING):
        return math.nan
    gap = min(gap_over_amplitude, math.pi)
    return float(brentq(lambda tau: tau - math.sin(tau) - gap, 0, math.pi, xtol=1e-14))


def law_of_loss(amplitude_over_gap: float) -> float:
    """Energy that an inelastic pile of mass m loses a period over 4 m (A w)^2: (1 - cos tau)^2 / 4 [-].

    1 at the end of the law, A = G / pi, and nan below it.
    """
    return (1 - math.cos(meeting_phase(1 / amplitude_over_gap))) ** 2 / 4


def law_of_swing(amplitudes_over_gap: np.ndarray, mass_ratio: float) -> np.ndarray:
    """Periods (n,) that a box on a spring needs from the first amplitude over the gap down to each other (n,).

    A balance of energy over many periods: the energy of the box, M (A w)^2 / 2, falls by `law_of_loss` in each.
    mass_ratio: M over the mass of the balls. Amplitudes fall; the law has no regime below LAW_END.
    """
    middle = (amplitudes_over_gap[1:] + amplitudes_over_gap[:-1]) / 2
    fall = 4 / mass_ratio * middle * np.array([law_of_loss(each) for each in middle])
    return np.concatenate([[0.0], np.cumsum(-np.diff(amplitudes_over_gap) / fall)])


@dataclass(frozen=True)
class Pile:
    """Balls in a box with its floor at z = 0: centres (n, 3) [m]; radius, side of the box [m]."""

    centres: np.ndarray
    radius: float
    side: float

    @property
    def thickness(self) -> float:
        """Twice the height of the centre of mass above the floor [m]."""
        return 2 * float(self.centres[:, 2].mean())


def step_of(contact: ContactConfig, radius: float, fraction: float) -> float:
    """A step of this fraction of the contact law's time [s]; radius [m]."""
    return fraction * step_scale(contact, radius)


def pour(contact: ContactConfig, radius: float, side: float, balls: int, seed: int, fraction: float) -> Pile:
    """A pile of that many balls in a box of that side, packed by gravity; radius, side [m].

    Raises SimulationError if the balls do not fit.
    """
    # Room for twice the volume of loosely packed balls.
    height = 2 * balls * (2 * radius) ** 3 / side**2 + 4 * radius
    start = spread(radius, side, height, balls, seed)
    step = step_of(contact, radius, fraction)
    world = FewBalls(
        _box(side, height), contact, start.centres, radius=radius, step=step, skin=skin_of(radius, fraction),
        gravity=GRAVITY,
    )  # fmt: skip
    world.run(POURED_S, rows=0)
    return Pile(world.balls.position.copy(), radius, side)


def spread(radius: float, side: float, length: float, balls: int, seed: int) -> Pile:
    """Balls at rest all over a box of that side and length [m]. Raises SimulationError if they do not fit."""
    return Pile(pack(_box(side, length), 2 * radius, balls, seed, side**2 * length), radius, side)


def _box(side: float, height: float) -> Vessel:
    sides = {f"{axis}_mm": 1e3 * size for axis, size in (("x", side), ("y", side), ("z", height))}
    return shape_vessel(BoxGeometry(kind="box", **sides), "shaken box", solid=False)


class ShakenBox(FewBalls):
    """A pile in a box that moves up and down as z = a cos wt + b sin wt, at first from the lowest place.

    length: inner, from floor to lid [m]; amplitude [m]; frequency [Hz]; fraction: of the contact law's time, for a step
    of which a whole number makes a period.
    """

    def __init__(
        self, pile: Pile, contact: ContactConfig, length: float, amplitude: float, frequency_hz: float,
        fraction: float, gravity: float = 0.0,
    ) -> None:  # fmt: skip
        step, self.steps = aligned_step(step_of(contact, pile.radius, fraction), 1 / frequency_hz)
        self.frequency_hz, self.side = frequency_hz, pile.side
        wave = np.array([[2 * math.pi * frequency_hz, 0.0, 0.0, -amplitude, 0.0, 0.0, 0.0]])
        super().__init__(
            _box(pile.side, length), contact, pile.centres - [0, 0, amplitude], radius=pile.radius, step=step,
            skin=skin_of(pile.radius, fraction), gravity=gravity, motion=Motion(wave, frequency_hz),
        )  # fmt: skip
        self.mass = float(self.balls.mass[self.balls.species].sum())

    def shake(self, periods: int, closure_max: float) -> pd.DataFrame:
        """The energy ledger of whole periods, a row at the end of each. Raises SimulationError for an open balance."""
        series = self.run(periods / self.frequency_hz, self.steps, rows=0)
        assert series is not None
        check_closure(series, closure_max)
        return series

    def packed(self, periods: int) -> Pile:
        """The pile as shaking packs it: after these periods and a quarter, when the floor stops pushing it."""
        self.run((periods + 0.25) / self.frequency_hz, rows=0)
        return Pile(self.balls.position.copy(), float(self.balls.radius[0]), self.side)

    @property
    def amplitude(self) -> float:
        """The amplitude of the box [m]."""
        return float(np.hypot(*self._wave))

    @property
    def _wave(self) -> np.ndarray:
        """a and b, in the motion that the kernels read [m]."""
        return self.clock.motions.harmonics[0, 3::3]

    def momentum(self) -> float:
        """Momentum of the balls upwards [kg m/s]."""
        return float(self.balls.mass[self.balls.species] @ self.balls.velocity[:, 2])

    def swing(self, box_kg: float, periods: float, chunk: int = 4) -> pd.DataFrame:
        """Let the box swing on a spring that makes it w without balls: time [s], place [m] and amplitude [m].

        box_kg: mass M of the box. After each chunk of steps the box has lost the momentum that the balls have gained:
        its speed changes by that over M, its place does not. Between, it moves as a box without balls.
        """
        w = 2 * math.pi * self.frequency_hz
        rows = []
        before = self.momentum()
        for time in self.chunks(periods / self.frequency_hz, chunk):
            after = self.momentum()
            slower = (after - before) / (box_kg * w)
            cosine, sine = math.cos(w * time), math.sin(w * time)
            self._wave[:] += np.array([sine, -cosine]) * slower
            before = after
            rows.append((time, float(self._wave @ [cosine, sine]), self.amplitude))
        return pd.DataFrame(rows, columns=["time_s", "place_m", "amplitude_m"])


def peaks(track: pd.DataFrame) -> pd.DataFrame:
    """Where the box turns: time_s and amplitude_m of a track of `ShakenBox.swing`."""
    from scipy.signal import find_peaks

    return track.iloc[find_peaks(track["place_m"].abs())[0]]


LAW = "collect and collide, one particle"
FITTED = f"{LAW}, thickness fitted"
POURED = "poured"
THICKNESS = "thickness of the pile over that packed by shaking"
SAME = "energy lost over that of the prediction at the same A / G"
# Places on the line of the law.
LINE = 60


def _places(inputs: Inputs, quantity: str, given: Iterable[float], what: str) -> list[float]:
    """The places of the settings and the measured ones. Raises ConfigError for a measured one that is not above 0."""
    measured = inputs.places_of(quantity)
    if (measured <= 0).any():
        raise ConfigError(f"validation.measured: quantity {quantity}: x = {measured.min():g}: {what} must be above 0")
    return sorted({*map(float, given), *measured})


def _mean_rows(table: pd.DataFrame, quantity: str, ids: dict[float, str]) -> list[dict]:
    """A row for each x of a table of runs (x, value), with the mean over the seeds and its interval."""
    rows = []
    for x, group in table.groupby("x"):
        mean, interval = mean_of(group["value"].to_numpy(), "-", least=0.0), SCATTER if len(group) > 1 else ""
        low, high = mean.ends("repeats")
        rows.append(
            prediction(quantity, "-", mean.value, id=ids.get(x, ""), x=x, lower=low, upper=high, interval=interval)
        )
    return rows


def lost_share(run: Values, settings: ShakenBoxConfig, contact: ContactConfig) -> Values:
    """What a run of set-up 21 loses a period over 4 m (A w)^2 [-], and the thickness of the pile.

    run: amplitude over the free gap `x`, `seed`, `balls`, `speed_m_s`, `restitution`, `static_friction`. The gap is the
    inner length less the thickness of the pile as shaking packs it, at A / G = x or more, in a first box that the
    poured pile fills as far.
    `layers`: that thickness over the diameter; `poured`: that of the poured pile over it [-].
    """
    own = contact.model_copy(update={key: run[key] for key in ("restitution", "static_friction")})
    radius, fraction = settings.ball_diameter_mm / 2e3, settings.rayleigh_fraction

    def box_of(pile: Pile, amplitude_over_gap: float) -> ShakenBox:
        length = pile.thickness / settings.fill_share
        amplitude = amplitude_over_gap * (length - pile.thickness)
        frequency_hz = run["speed_m_s"] / (2 * math.pi * amplitude)
        return ShakenBox(pile, own, length, amplitude, frequency_hz, fraction)

    poured = pour(own, radius, settings.side_m, run["balls"], run["seed"], fraction)
    pile = box_of(poured, max(run["x"], settings.packing_amplitude)).packed(settings.packing_periods)
    box = box_of(pile, run["x"])
    box.shake(settings.discard_periods, 1.0)
    series = box.shake(settings.window_periods, settings.closure_max)
    lost = float(series[LOSSES].iloc[-1].sum()) / settings.window_periods
    return {
        "value": lost / (4 * box.mass * run["speed_m_s"] ** 2),
        "layers": pile.thickness / (2 * radius),
        "poured": poured.thickness / pile.thickness,
        "closure": closure(series),
    }


def design_of_box(settings: ShakenBoxConfig, contact: ContactConfig, places: Iterable[float]) -> pd.DataFrame:
    """A row for each run of set-up 21: its `model`, and the values that `lost_share` takes."""
    own = {
        "balls": settings.balls, "speed_m_s": settings.speed_m_s, "restitution": contact.restitution,
        "static_friction": contact.static_friction,
    }  # fmt: skip
    rows = [{"model": DEM, "x": x, "seed": seed, **own} for seed in settings.seeds for x in places]
    words = {
        "speed_m_s": "{:g} m/s", "restitution": "restitution {:g}", "static_friction": "friction {:g}",
        "balls": "{} balls",
    }  # fmt: skip
    rows += [
        {"model": f"{DEM}, {words[key].format(value)}", "x": x, "seed": settings.seeds[0], **own, key: value}
        for key, values in settings.changes.items()
        for value in values
        for x in settings.varied_amplitudes
    ]
    return pd.DataFrame(rows)


def gap_ratio(thickness: float, fill_share: float) -> float:
    """The free gap of a pile that is thicker than packed, over that of the packed one [-].

    thickness: over the packed one; fill_share: packed thickness over the inner length [-].
    """
    return (1 - fill_share * thickness) / (1 - fill_share)


def fitted_thickness(table: pd.DataFrame, fill_share: float) -> float:
    """The thickness over the packed one [-] with which the law fits runs (x, value) best, by least squares.

    Runs at less than 1.1 of the amplitude at which the law ends are left out.
    """
    # Slow to import, and every set-up imports this module.
    from scipy.optimize import minimize_scalar

    own = table[table["x"] > 1.1 * LAW_END]

    def misfit(thickness: float) -> float:
        places = own["x"] / gap_ratio(thickness, fill_share)
        return float(((places.clip(lower=LAW_END).map(law_of_loss) - own["value"]) ** 2).sum())

    return float(minimize_scalar(misfit, bounds=(0.9, 1.4), method="bounded").x)


def predict_shaken_box(inputs: Inputs) -> pd.DataFrame:
    """Set-up 21: energy lost a period over the amplitude, by the DEM, with one thing changed, and by the law."""
    settings: ShakenBoxConfig = inputs.settings
    places = _places(inputs, LOST, settings.amplitudes, "the amplitude over the free gap")
    table = design_of_box(settings, inputs.contact, places)
    runs = {f"{row['model']}, A/G {row['x']:g}, seed {row['seed']}": row for row in table.to_dict("records")}
    found = inputs.simulated(runs, lambda run: lost_share(run, settings, inputs.contact), "shaken box")
    table = table.join(pd.DataFrame(found))
    own = table[table["model"] == DEM]
    rows = _mean_rows(own, LOST, inputs.ids_of(LOST))
    means = own.groupby("x")["value"].mean()
    for row in table[table["model"] != DEM].to_dict("records"):
        about: dict[str, Any] = {"x": row["x"], "model": row["model"]}
        rows.append(prediction(LOST, "-", row["value"], **about))
        if row["x"] in means:
            rows.append(prediction(SAME, "-", row["value"] / means[row["x"]], **about))
    thickness = fitted_thickness(own, settings.fill_share)
    rows.append(prediction(THICKNESS, "-", thickness, model=FITTED))
    rows.append(prediction(THICKNESS, "-", float(own["poured"].mean()), model=POURED))
    gap = gap_ratio(thickness, settings.fill_share)
    for x in np.geomspace(LAW_END, max(*places, 2 * LAW_END), LINE).tolist():
        rows.append(prediction(LOST, "-", law_of_loss(x), x=x, model=LAW))
        rows.append(prediction(LOST, "-", law_of_loss(x / gap), x=x, model=FITTED))
    return pd.DataFrame(rows)


def swing_down(run: Values, settings: LeafSpringConfig, contact: ContactConfig, seconds: float) -> Values:
    """Times [s] at which the box of set-up 22 turns, and its amplitude there over the ball diameter [-].

    run: `seed` and `balls`; the box has `mass_ratio` times their mass.
    """
    diameter, fraction = settings.ball_diameter_mm / 1e3, settings.rayleigh_fraction
    length, amplitude = settings.length_diameters * diameter, settings.amplitude_diameters * diameter
    start = spread(diameter / 2, settings.side_m, length, run["balls"], run["seed"])
    box = ShakenBox(start, contact, length, amplitude, settings.frequency_hz, fraction)
    turns = peaks(box.swing(settings.mass_ratio * box.mass, seconds * settings.frequency_hz))
    return {
        "time_s": [0.0, *turns["time_s"]],
        "amplitude": [settings.amplitude_diameters, *turns["amplitude_m"] / diameter],
    }


def swing_by_law(settings: LeafSpringConfig, contact: ContactConfig) -> pd.DataFrame:
    """The same by the law, with the packed thickness: columns time_s and amplitude (over the ball diameter)."""
    diameter = settings.ball_diameter_mm / 1e3
    pile = pour(contact, diameter / 2, settings.side_m, settings.balls, settings.seeds[0], settings.rayleigh_fraction)
    gap = settings.length_diameters - pile.thickness / diameter
    amplitudes = np.linspace(settings.amplitude_diameters, LAW_END * gap, LINE)
    periods = law_of_swing(amplitudes / gap, settings.mass_ratio)
    return pd.DataFrame({"time_s": periods / settings.frequency_hz, "amplitude": amplitudes})


def predict_leaf_spring(inputs: Inputs) -> pd.DataFrame:
    """Set-up 22: amplitude of a box on a leaf spring over the time; the interval spans seeds and numbers of balls."""
    settings: LeafSpringConfig = inputs.settings
    times = _places(inputs, SWING, settings.times_s, "the time")
    numbers = [settings.balls] * len(settings.seeds) + settings.further_balls
    seeds = settings.seeds + [settings.seeds[0]] * len(settings.further_balls)
    runs = {
        f"{balls} balls, seed {seed}": {"balls": balls, "seed": seed}
        for balls, seed in zip(numbers, seeds, strict=True)
    }
    seconds = max(times) + 1 / settings.frequency_hz
    found = inputs.simulated(runs, lambda run: swing_down(run, settings, inputs.contact, seconds), "leaf spring")
    courses = np.array([np.interp(times, each["time_s"], each["amplitude"]) for each in found])
    own, ids, rows = courses[: len(settings.seeds)], inputs.ids_of(SWING), []
    for x, values, every in zip(times, own.T, courses.T, strict=True):
        mean = mean_of(values, "-", least=0.0)
        low, high = mean.ends("repeats")
        ends = (float(np.nanmin([low, *every])), float(np.nanmax([high, *every]))) if len(every) > 1 else (low, high)
        interval = f"{SCATTER} and {COUNT}" if len(every) > 1 else ""
        rows.append(
            prediction(SWING, "-", mean.value, id=ids.get(x, ""), x=x, lower=ends[0], upper=ends[1], interval=interval)
        )
    line = swing_by_law(settings, inputs.contact)
    rows += [prediction(SWING, "-", row.amplitude, x=row.time_s, model=LAW) for row in line.itertuples()]
    return pd.DataFrame(rows)


def plate_power(run: Values, settings: ShakenPlateConfig, contact: ContactConfig) -> Values:
    """Power over m g V of a run of set-up 23 [-], V the peak speed of the plate.

    run: acceleration `x` [g] and `seed`.
    """
    radius, fraction = settings.ball_diameter_mm / 2e3, settings.rayleigh_fraction
    pile = pour(contact, radius, settings.side_m, settings.balls, run["seed"], fraction)
    w = 2 * math.pi * settings.frequency_hz
    speed = run["x"] * GRAVITY / w
    # Twice the speed of the plate does not reach the lid.
    height = pile.thickness + (2 * speed) ** 2 / (2 * GRAVITY)
    plate = ShakenBox(pile, contact, height, speed / w, settings.frequency_hz, fraction, GRAVITY)
    plate.shake(settings.discard_periods, 1.0)
    series = plate.shake(settings.window_periods, settings.closure_max)
    power = float(series[LOSSES].iloc[-1].sum()) * settings.frequency_hz / settings.window_periods
    return {"value": power / (plate.mass * GRAVITY * speed)}


def predict_shaken_plate(inputs: Inputs) -> pd.DataFrame:
    """Set-up 23: power over m g V at each acceleration, its mean, and the exponent of the loss factor."""
    settings: ShakenPlateConfig = inputs.settings
    places = _places(inputs, PLATE_POWER, settings.accelerations, "the acceleration")
    table = pd.DataFrame([{"x": x, "seed": seed} for seed in settings.seeds for x in places])
    runs = {f"{row['x']:g} g, seed {row['seed']}": row for row in table.to_dict("records")}
    found = inputs.simulated(runs, lambda run: plate_power(run, settings, inputs.contact), "shaken plate")
    table = table.join(pd.DataFrame(found))
    own = table[table["x"].isin(settings.accelerations)]
    means, exponents = zip(
        *(
            # Energy lost a cycle over m V^2 / 2 goes with the power over m g V, over the acceleration.
            (group["value"].mean(), np.polyfit(np.log(group["x"]), np.log(group["value"] / group["x"]), 1)[0])
            for _, group in own.groupby("seed")
        ),
        strict=True,
    )
    rows = _mean_rows(table, PLATE_POWER, inputs.ids_of(PLATE_POWER))
    for quantity, values in ((PLATE_MEAN, means), (LOSS_EXPONENT, exponents)):
        mean = mean_of(values, "-")
        bounds: dict[str, Any] = {**vars(mean.repeats), "interval": SCATTER} if mean.repeats else {}
        rows.append(prediction(quantity, "-", mean.value, id=inputs.ids_of_single(quantity), **bounds))
    return pd.DataFrame(rows)
