"""Power of tumbling mills: the DEM, formulas of others, and intervals."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from millprint.config.mill import MillConfig
from millprint.config.setup_models import POWER, RINGS, SHOULDER, TOE, TURN_ENERGY, TumblingConfig, with_number
from millprint.estimate.estimates import ENDS, Estimate, Interval, mean_of
from millprint.mill.bodies import build_bodies
from millprint.mill.gravity import GRAVITY
from millprint.validation.measured import CONTACT, DEM, SCATTER, Inputs, prediction
from millprint.validation.tumbling_runs import FURTHER, PREDICTS, SAMPLE

# Lift angle of Hogg and Fuerstenau [deg], a free parameter. 35 deg is a usual choice for ball mills.
LIFT_ANGLE_DEG = 35.0


@dataclass(frozen=True)
class Mill:
    """What the formulas need.

    Radius and length inside the shell [m], share J that the charge fills, voids included [-], mass [kg]. The critical
    speed is for a point at the shell, sqrt(g / R).
    """

    radius_m: float
    length_m: float
    filling: float
    mass_kg: float

    @property
    def bulk_density(self) -> float:
        """Mass of the charge over the volume that it fills, with its voids [kg/m3]."""
        return self.mass_kg / (math.pi * self.radius_m**2 * self.length_m * self.filling)


def half_angle(filling: float) -> float:
    """Half the angle of a segment of a circle [rad], from its share of the area: J = (t - sin t cos t) / pi."""
    # Slow to import, and every set-up imports this module.
    from scipy.optimize import brentq

    return float(brentq(lambda angle: (angle - math.sin(angle) * math.cos(angle)) / math.pi - filling, 0, math.pi))


def hogg_fuerstenau(mill: Mill, turns_hz: float, lift_angle_deg: float = LIFT_ANGLE_DEG) -> float:
    """Net power of a charge in the shape of a tilted segment, 2/3 rho g L R^3 sin^3(t) sin(a) 2 pi N [W].

    turns_hz: N [1/s]; t: half the angle of the segment; a: lift_angle_deg, the tilt of its surface. The torque is the
    weight of the segment times the horizontal distance of its centre from the axis (Hogg and Fuerstenau, Trans.
    SME-AIME 252 (1972) 418). In feet, short of a factor near 1, it is 0.238 D^3.5 (L/D) N_c rho (J - 1.065 J^2) sin a.
    """
    arm_m4 = 2 / 3 * mill.radius_m**3 * math.sin(half_angle(mill.filling)) ** 3 * mill.length_m
    torque = mill.bulk_density * GRAVITY * arm_m4 * math.sin(math.radians(lift_angle_deg))
    return torque * 2 * math.pi * turns_hz


@dataclass(frozen=True)
class ChargeShape:
    """The charge of Morrell's C-model: angles counter-clockwise from 3 o'clock [rad], inner radius [m].

    The mill turns counter-clockwise. profile: z of the velocity, which equals the shell's at r = R and
    2 pi N R (r - z r_i) / (R - z r_i) further in.
    """

    toe: float
    shoulder: float
    inner_radius_m: float
    profile: float


def morrell_shape(mill: Mill, critical_share: float) -> ChargeShape:
    """Shape of a dry or grate-discharge charge in the C-model (Morrell, Trans. IMM 105 (1996) C43 and C54).

    critical_share: speed over the critical speed [-]. Raises ValueError where the whole charge centrifuges: from
    phi_c = 0.35 (3.364 - J) on, no charge moves in the model.
    """
    filling = mill.filling
    centrifuge = 0.35 * (3.364 - filling)
    if critical_share >= centrifuge:
        raise ValueError(f"critical_share = {critical_share:g}: the C-model ends at {centrifuge:.3g}")
    rise = 2.5307 * (1.2796 - filling) * (1 - math.exp(-19.42 * (centrifuge - critical_share)))
    toe = math.pi / 2 + rise
    shoulder = math.pi / 2 - rise * (0.3386 + 0.1041 * centrifuge + (1.54 - 2.5673 * centrifuge) * filling)
    # The charge fills the arc from toe over the bottom to shoulder, between the inner radius and the shell.
    inner = mill.radius_m * math.sqrt(max(0.0, 1 - 2 * math.pi * filling / (2 * math.pi + shoulder - toe)))
    return ChargeShape(toe, shoulder, inner, (1 - filling) ** 0.4532)


def morrell(mill: Mill, critical_share: float) -> float:
    """Net power of the C-model: the rate at which the charge gains potential and kinetic energy [W].

    P = rho L { pi g N R / (3 (R - z r_i)) [2 R^3 - 3 z R^2 r_i + r_i^3 (3 z - 2)] (sin s - sin t)
                + (pi N R / (R - z r_i))^3 [(R - z r_i)^4 - r_i^4 (1 - z)^4] }

    with t, s, r_i and z of `morrell_shape`: the integrals over r from r_i to R of rho L g r v (sin s - sin t) and of
    rho L v^3 / 2. No-load power and losses, by which the model makes gross power, are left out. Raises ValueError as
    `morrell_shape`.
    """
    shape, radius = morrell_shape(mill, critical_share), mill.radius_m
    inner, z = shape.inner_radius_m, shape.profile
    turns_hz = critical_share * math.sqrt(GRAVITY / radius) / (2 * math.pi)
    reach = radius - z * inner
    lift = math.pi * GRAVITY * turns_hz * radius / (3 * reach)
    lift *= 2 * radius**3 - 3 * z * radius**2 * inner + inner**3 * (3 * z - 2)
    lift *= math.sin(shape.shoulder) - math.sin(shape.toe)
    throw = (math.pi * turns_hz * radius / reach) ** 3 * (reach**4 - inner**4 * (1 - z) ** 4)
    return mill.bulk_density * mill.length_m * (lift + throw)


PROBABILITY = 0.95
BOTH = f"{SCATTER} and {CONTACT}"


def without_jump(angles_deg: np.ndarray) -> np.ndarray:
    """The same angles [deg] within half a turn of their circular mean, so that 359 and 1 are two degrees apart."""
    angles = np.asarray(angles_deg, dtype=float)
    if not angles.size:
        return angles
    # Slow to import, and every set-up imports this module.
    from scipy.stats import circmean

    return nearest_turn(angles, circmean(angles, high=360))


def nearest_turn(angles_deg: Any, reference_deg: Any) -> Any:
    """Angles [deg] plus or minus whole turns, so that each is within half a turn of a reference [deg]."""
    return reference_deg + (angles_deg - reference_deg + 180) % 360 - 180


@dataclass(frozen=True)
class Quantity:
    """A quantity with a known interval by contact parameters: a column of the runs, and how it changes.

    least: its smallest possible value; relative: whether contact parameters multiply it, or add to it, as to an angle
    [deg].
    """

    column: str
    unit: str
    least: float
    relative: bool

    @property
    def unchanged(self) -> float:
        """The change of a quantity that stays the same."""
        return 1.0 if self.relative else 0.0

    def change(self, value: pd.Series, base: pd.Series) -> pd.Series:
        """The change from the base to the value."""
        return value / base if self.relative else nearest_turn(value, base) - base

    def changed(self, base: float, change: float) -> float:
        """The base after a change."""
        return base * change if self.relative else base + change

    def mean(self, values: pd.Series) -> Estimate:
        """The mean over seeds of the values that are known, with its interval; NaN if there are none."""
        known = values.dropna().to_numpy()
        if not known.size:
            return Estimate(math.nan, self.unit)
        return mean_of(known if self.relative else without_jump(known), self.unit, PROBABILITY, self.least)

    def name(self, what: str) -> str:
        """The column of a table for one end of an interval, such as power_scatter_lower_W."""
        return f"{self.column.removesuffix(self.unit)}{what}_{self.unit}"


POWER_W = Quantity("power_W", "W", least=0.0, relative=True)
ANGLES = {name: Quantity(name, "deg", least=-math.inf, relative=False) for name in ("toe_deg", "shoulder_deg")}
QUANTITIES = (POWER_W, *ANGLES.values())


def contact_changes(runs: pd.DataFrame, quantity: Quantity) -> pd.DataFrame:
    """How contact parameters change a quantity: index speed, columns lower and upper, factors or differences.

    Each run of the sample and of the further contact sets is compared with the prediction of the same seed and speed.
    The ends are quantiles over the sample, widened to include the further sets and the prediction itself. A charge that
    covers the whole shell has no toe and no shoulder, and is left out; so is a speed without any angle.
    """
    first = runs[runs["role"] != PREDICTS]
    own = runs[(runs["role"] == PREDICTS) & (runs["number"] == runs["number"].iloc[0])]
    base = own[own["seed"] == own["seed"].iloc[0]].set_index("speed")[quantity.column]
    change = quantity.change(first[quantity.column], first["speed"].map(base))
    tail = (1 - PROBABILITY) / 2
    rows = {}
    for speed, group in first.assign(change=change).dropna(subset="change").groupby("speed"):
        sampled = group.loc[group["role"] == SAMPLE, "change"]
        named = [quantity.unchanged, *group.loc[group["role"] == FURTHER, "change"]]
        ends = sampled.quantile([tail, 1 - tail]) if len(sampled) else pd.Series([quantity.unchanged] * 2)
        rows[speed] = {"lower": min(ends.iloc[0], *named), "upper": max(ends.iloc[1], *named)}
    return pd.DataFrame.from_dict(rows, orient="index", columns=list(ENDS)).sort_index()


def _interval_columns(group: pd.DataFrame, speed: float, quantity: Quantity, changes: pd.DataFrame) -> dict[str, float]:
    """The mean over the seeds, and the ends of both of its intervals; nan where they are not known."""
    found = quantity.mean(group[quantity.column])
    change = [float(np.interp(speed, changes.index, changes[end])) if len(changes) else math.nan for end in ENDS]
    contact = [quantity.changed(found.value, each) for each in change]
    return {
        quantity.column: found.value,
        **{quantity.name(f"scatter_{end}"): value for end, value in zip(ENDS, found.ends("repeats"), strict=True)},
        **{quantity.name(f"contact_{end}"): value for end, value in zip(ENDS, contact, strict=True)},
    }


def intervals(runs: pd.DataFrame, settings: TumblingConfig) -> pd.DataFrame:
    """Power, toe and shoulder with both of their intervals; a row for each number of balls and speed.

    Columns: number, speed, speed_rpm, seeds; for power_W, toe_deg and shoulder_deg the mean over the seeds and the ends
    of the intervals, such as power_scatter_lower_W and toe_contact_upper_deg; rings; carried_share: of the balls. The
    effect of contact parameters is taken from the first number of balls, interpolated over the speed and constant
    beyond the sampled speeds.
    """
    changes = {quantity: contact_changes(runs, quantity) for quantity in QUANTITIES}
    own = runs[runs["role"] == PREDICTS]
    rows = []
    for (number, speed), group in own.groupby(["number", "speed"]):
        row = {"number": number, "speed": speed, "speed_rpm": group["speed_rpm"].iloc[0], "seeds": len(group)}
        for quantity, effect in changes.items():
            row |= _interval_columns(group, speed, quantity, effect)
        rows.append(row | {"rings": group["rings"].mean(), "carried_share": group["carried"].mean() / number})
    rank = {number: place for place, number in enumerate(settings.numbers)}
    return pd.DataFrame(sorted(rows, key=lambda row: (rank[row["number"]], row["speed"])))


def whole_interval(row: dict[str, Any], quantity: Quantity) -> tuple[float, float, str]:
    """Ends of the interval of a row of `intervals` by scatter and by contact parameters, and its origin."""
    value, scatter, contact = (
        row[quantity.column],
        *((row[quantity.name(f"{by}_lower")], row[quantity.name(f"{by}_upper")]) for by in ("scatter", "contact")),
    )
    if math.isnan(contact[0]):
        return *scatter, SCATTER
    estimate = Estimate(value, quantity.unit, repeats=Interval(*scatter), contact=Interval(*contact))
    both = estimate.together(quantity.least)
    return both.lower, both.upper, BOTH


OTHER_CONTACT = f"{DEM}, contact set"


def _rows(
    inputs: Inputs, quantity: str, unit: str, x: float, value: float, low: float, high: float, interval: str
) -> list[dict]:
    """A row for each measured row of the quantity at x, or one without an id."""
    places = inputs.places[inputs.places["quantity"] == quantity]
    same = places["x"].isna() if x != x else np.isclose(places["x"].astype(float), x)
    ids = list(places.loc[same, "id"]) or [""]
    named = interval if low == low else ""
    return [prediction(quantity, unit, value, id=id, x=x, lower=low, upper=high, interval=named) for id in ids]


def _dem_rows(inputs: Inputs, curve: pd.DataFrame, runs: pd.DataFrame, settings: TumblingConfig) -> list[dict]:
    rows = []
    for row in curve.to_dict("records"):
        x = row["speed"]
        low, high, by = whole_interval(row, POWER_W)
        if len(settings.speeds) == 1:
            power, low, high = (each * (60 / row["speed_rpm"]) for each in (row["power_W"], low, high))
            rows += _rows(inputs, TURN_ENERGY, "J/rev", math.nan, power, low, high, by)
            continue
        rows += _rows(inputs, with_number(POWER, row["number"], settings), "W", x, row["power_W"], low, high, by)
        group = runs[(runs["role"] == PREDICTS) & (runs["number"] == row["number"]) & (runs["speed"] == row["speed"])]
        rings = float(np.median(group["rings"]))
        rows += _rows(inputs, with_number(RINGS, row["number"], settings), "rings", x, rings, math.nan, math.nan, "")
        for name, quantity in ((TOE, ANGLES["toe_deg"]), (SHOULDER, ANGLES["shoulder_deg"])):
            if group[quantity.column].notna().all():
                ends = whole_interval(row, quantity)
                rows += _rows(inputs, with_number(name, row["number"], settings), "deg", x, row[quantity.column], *ends)
    return rows


def charge_of(settings: TumblingConfig, mill: MillConfig, density: float, number: int) -> Mill:
    """The charge for the power formulas, for a number of balls."""
    low, high = build_bodies(mill)[0].vessel.bounds
    across = "xyz".index(getattr(mill.geometry, "axis", "y"))
    mass = number * density * math.pi / 6 * (settings.diameter_mm / 1e3) ** 3
    filling = settings.fillings[settings.numbers.index(number)]
    return Mill(float(high[2]), float(high[across] - low[across]), filling, mass)


def formula_powers(
    settings: TumblingConfig, mill: MillConfig, density: float, number: int, speed_rpm: float
) -> dict[str, float]:
    """Net power by each formula [W], without formulas that do not hold at this speed."""
    charge = charge_of(settings, mill, density, number)
    share = speed_rpm / 60 * 2 * math.pi / math.sqrt(GRAVITY / charge.radius_m)
    powers = {}
    if share < 1:
        powers[f"Hogg and Fuerstenau, {LIFT_ANGLE_DEG:g} deg"] = hogg_fuerstenau(charge, speed_rpm / 60)
        powers["Morrell, C-model"] = morrell(charge, share)
    return powers


def _power_row(
    settings: TumblingConfig, power_W: float, number: int, speed_rpm: float, model: str, speed: float
) -> dict[str, Any]:
    """A prediction of the power; where the set-up has one speed, of the energy of a revolution."""
    if len(settings.speeds) == 1:
        return prediction(TURN_ENERGY, "J/rev", power_W * 60 / speed_rpm, model=model)
    return prediction(with_number(POWER, number, settings), "W", power_W, x=speed, model=model)


def predict_tumbling(inputs: Inputs) -> pd.DataFrame:
    """Power, toe, shoulder and rings over the speed, or the energy of a revolution at one speed; also by formulas."""
    settings: TumblingConfig = inputs.settings
    mill = inputs.mill
    assert mill is not None, "a tumbling mill is in a file of config/mills"
    runs = inputs.table("runs.tsv")
    curve = intervals(runs, settings)
    rows = _dem_rows(inputs, curve, runs, settings)
    for row in curve.to_dict("records"):
        condition = row["number"], row["speed_rpm"]
        powers = formula_powers(settings, mill, inputs.contact.density_kg_m3, *condition)
        rows += [_power_row(settings, power, *condition, model, row["speed"]) for model, power in powers.items()]
    for row in runs[runs["role"] == FURTHER].to_dict("records"):
        condition, model = (settings.numbers[0], row["speed_rpm"]), f"{OTHER_CONTACT} {row['contact']}"
        rows.append(_power_row(settings, row["power_W"], *condition, model, row["speed"]))
    return pd.DataFrame([*rows, *powers_of_other_codes(inputs)])


def powers_of_other_codes(inputs: Inputs) -> list[dict[str, Any]]:
    """Predictions by other codes for the same mill, contact set and numbers of balls."""
    settings: TumblingConfig = inputs.settings
    codes = inputs.other_codes
    if codes is None:
        return []
    same = (codes["mill"] == settings.mill) & (codes["contact"] == settings.contact)
    own = codes[same & codes["balls"].isin(settings.numbers)]
    return [
        _power_row(settings, power, int(number), rpm, str(code), settings.speed_of(rpm))
        for power, number, rpm, code in own[["power_W", "balls", "speed_rpm", "code"]].itertuples(index=False)
    ]
