"""What the curves of a mill show: whether they collapse on one, and the zones of its operation.

A mill enlarged by geometric similarity: how to run it for the same fingerprint, and what it costs to simulate.

All lengths of vessel and motion grow by L = (V / V_0)^(1/3). With energies per collision ~ rho omega^2 A^2 d^3, a
frequency ~ omega and a power ~ rho omega^3 A^2 d^3 of one ball (Eqs 3.28, 3.29), each row keeps one of them. Unchanged
balls keep the chemistry of a collision. Enlarged balls, at omega ~ L^(-1/2), keep every scaled number, including the
share of gravity A omega^2 / g. In a charge of several sizes, all sizes grow by the same factor.
"""

from dataclasses import replace

import numpy as np
import pandas as pd
from scipy.constants import hour as HOUR

from millprint.cases.of_mill import RUN_WAY, WAYS
from millprint.config.mill_sweep import ScaleUpConfig
from millprint.estimate.estimates import Estimate
from millprint.estimate.judge import AGREES, DIFFERS, OPEN, Allowed, Verdict, judge
from millprint.fingerprint.descriptors import CHARGE, as_built
from millprint.fingerprint.model import Fingerprint
from millprint.fingerprint.predicted_values import Prediction
from millprint.observables.condition import SCALES
from millprint.observables.counted_collisions import CHANNELS
from millprint.observables.definitions import POWER, PREDICTED, SCALED_BY

# Exponents in the equations, for quantities of one ball or one collision.
SUPPOSED = {
    **dict.fromkeys(
        ("normal_power_per_ball_W", "tangential_power_per_ball_W", "power_per_ball_W"), SCALES["power"].exponents
    ),
    **{name: SCALES[PREDICTED[name].scale].exponents for name in SCALED_BY},
}
# Of all that is dissipated and supplied; the thesis has normal and tangential only.
WALL_POWER = "wall_power_per_ball_W"
# Quantities per ball or per collision -> short name in the table of all mills; empty if not in it.
COLLAPSED = {
    WALL_POWER: "power",
    "normal_power_per_ball_W": "normal",
    "tangential_power_per_ball_W": "tangential",
    **dict.fromkeys(SCALED_BY, ""),
    "weighted_normal_energy_J": "weighted_energy",
    "weighted_normal_frequency_hz": "weighted_frequency",
    "specific_frequency_hz": "frequency",
}
VARIED = {"omega": "speed_hz", "d": "ball_diameter_m"}
# Curves collapse if the scaled power spreads by no more than this, in logarithms [-].
COLLAPSE_MAX = 0.2
UNKNOWN = Verdict(OPEN, "no fill ratio has two speeds or two sizes")
NOTHING_THERE = Verdict(OPEN, "it is 0 at some conditions")
BY_LAW, BY_OWN = "collapses by the scaling law", "collapses by exponents of its own"
BY_NONE = "collapses by no powers of speed and ball size"
UNFITTED = "does not collapse by the scaling law; there are too few conditions for exponents of its own"


def with_power_per_ball(descriptors: pd.DataFrame) -> pd.DataFrame:
    """The descriptors with powers per ball [W]: normal, tangential, their sum as in the thesis, and of the walls."""
    normal, tangential = (descriptors[f"{channel}_power_W"] / descriptors["balls"] for channel in CHANNELS)
    of_walls = descriptors["wall_power_W"] / descriptors["balls"]
    return descriptors.assign(
        normal_power_per_ball_W=normal, tangential_power_per_ball_W=tangential, power_per_ball_W=normal + tangential
    ).assign(**{WALL_POWER: of_walls})


def _about_means(values: np.ndarray, constants: np.ndarray) -> np.ndarray:
    """Values (n,) less the mean of their group; constants (n, groups): 1 for the group of the row."""
    return values - constants @ np.linalg.lstsq(constants, values, rcond=None)[0]


def _spread(logs: np.ndarray, constants: np.ndarray) -> float:
    """Standard deviation of logarithms about the mean of each fill ratio; constants (n, fills): 1 for the row's.

    NaN where no fill ratio has two conditions.
    """
    if not len(logs):
        return float("nan")
    rest = _about_means(logs, constants)
    return float(np.sqrt((rest**2).sum() / (len(logs) - constants.shape[1])))


def _own(logs: np.ndarray, constants: np.ndarray, varied: dict[str, np.ndarray], probability: float) -> dict:
    """Exponents by least squares over all fill ratios, with Student's intervals, and the spread that is left."""
    # A variable that changes only between charges cannot be fitted.
    names = [name for name, values in varied.items() if len(values) and np.ptp(_about_means(values, constants)) > 1e-9]
    empty = {f"{name}{end}": np.nan for name in varied for end in ("", "_lower", "_upper")}
    design = np.column_stack([constants, *(varied[name] for name in names)])
    if not names or len(logs) <= design.shape[1]:
        return empty | {"spread_own": np.nan}
    # Imported here: slow to import, and the claims import this module.
    from statsmodels.regression.linear_model import OLS

    fit = OLS(logs, design).fit()
    intervals = fit.conf_int(alpha=1 - probability)
    found = {"spread_own": float(np.sqrt(fit.mse_resid))}
    for place, name in enumerate(names, start=constants.shape[1]):
        found |= {name: fit.params[place], f"{name}_lower": intervals[place, 0], f"{name}_upper": intervals[place, 1]}
    return empty | found


def judge_collapse(thesis: float, own: float) -> Verdict:
    """Whether the thesis's scaling leaves a spread [-] of at most COLLAPSE_MAX, and else, whether its own does."""
    by_law, by_own = (judge(Estimate(spread, "-"), Allowed(upper=COLLAPSE_MAX)) for spread in (thesis, own))
    if by_law.word == OPEN:
        return UNKNOWN
    reasons = {AGREES: BY_OWN, DIFFERS: BY_NONE, OPEN: UNFITTED}
    return by_law._replace(reason=BY_LAW if by_law.agrees else reasons[by_own.word])


def tabulate_mill_collapse(descriptors: pd.DataFrame, probability: float) -> pd.DataFrame:
    """The spread between speeds and ball sizes of one mill and contact set, a row for each quantity.

    Each spread is a standard deviation of log y about the mean of a fill ratio, pooled over the fill ratios, so that
    0.1 is about 10 %: `spread_before` of the quantity itself, `spread_thesis` after division by omega^p d^q with the
    exponents of Eqs 3.28 and 3.29 (omega_supposed, d_supposed), `spread_own` after those of a regression (omega, d,
    with intervals of `probability`). `collapse` is the verdict on the thesis's scaling, which agrees at COLLAPSE_MAX or
    less, and `reason` says whether its own would do. A single condition at a fill ratio gives no spread; density and
    amplitude are the mill's. A charge of several sizes is compared only with itself, at other speeds.
    """
    whole = with_power_per_ball(as_built(descriptors))
    groups = whole.groupby(["fill_ratio", CHARGE])
    is_compared = groups["fill_ratio"].transform("size") > 1
    table = whole[is_compared]
    constants = pd.get_dummies(groups.ngroup()[is_compared]).to_numpy(dtype=float)
    varied = {name: np.log(table[column].to_numpy(dtype=float)) for name, column in VARIED.items()}
    rows = []
    for quantity in COLLAPSED:
        supposed = SCALES["power"].exponents if quantity == WALL_POWER else SUPPOSED[quantity]
        is_there = bool((whole[quantity] > 0).all())
        logs = np.log(table[quantity].to_numpy(dtype=float)) if is_there else np.full(len(table), np.nan)
        scaled = logs - sum(supposed[name] * values for name, values in varied.items())
        row = {
            "mill": whole["mill"].iloc[0],
            "contact": whole["contact"].iloc[0],
            "quantity": quantity,
            "conditions": len(table),
            "fill_ratios": table["fill_ratio"].nunique(),
            "spread_before": _spread(logs, constants),
            "spread_thesis": _spread(scaled, constants),
            **_own(logs, constants, varied if is_there else dict.fromkeys(varied, np.empty(0)), probability),
            **{f"{name}_supposed": supposed[name] for name in VARIED},
        }
        word, reason = judge_collapse(row["spread_thesis"], row["spread_own"]) if is_there else NOTHING_THERE
        rows.append(row | {"collapse": word, "reason": reason})
    return pd.DataFrame(rows)


def one_row_a_mill(tables: list[pd.DataFrame]) -> pd.DataFrame:
    """The collapse of several mills, a row for each mill; columns NAME_* for the names in COLLAPSED."""
    kept = [f"spread_{name}" for name in ("before", "thesis", "own")]
    kept += [f"{name}{end}" for name in VARIED for end in ("", "_lower", "_upper")]
    rows = []
    for table in tables:
        first = table.iloc[0]
        row = {name: first[name] for name in ("mill", "contact", "conditions")}
        for quantity, name in COLLAPSED.items():
            if not name:
                continue
            own = table[table["quantity"] == quantity].iloc[0]
            row |= {f"{name}_collapse": own["collapse"], f"{name}_reason": own["reason"]}
            row |= {f"{name}_{column}": own[column] for column in kept}
        rows.append(row)
    return pd.DataFrame(rows)


ZONE_CURVES = ("Pn", "Pt", "ratio")
POINTS, SAMPLES = 120, 500
COLUMNS = ["contact", "zone", "value", "lower", "upper", "found", "smallest", "largest"]


def elbow(fill_ratio: np.ndarray, ratio: np.ndarray) -> float:
    """Fill ratio at the elbow of a falling curve: farthest below the line from its top to the lowest point after it.

    A rise before the top is left out. Both arrays have one dimension and the same length; NaN if the curve does not
    fall.
    """
    top = int(np.argmax(ratio))
    bottom = top + int(np.argmin(ratio[top:]))
    if bottom - top < 2:
        return float("nan")
    fill_ratio, ratio = fill_ratio[top : bottom + 1], ratio[top : bottom + 1]
    across = (fill_ratio - fill_ratio[0]) / (fill_ratio[-1] - fill_ratio[0])
    chord = ratio[0] + across * (ratio[-1] - ratio[0])
    return float(fill_ratio[np.argmax(chord - ratio)])


def choking(fill_ratio: np.ndarray, normal: np.ndarray, tangential: np.ndarray) -> float:
    """Fill ratio beyond which neither power per ball exceeds 90 % of its largest value; NaN if one still does."""
    low = (normal < 0.9 * normal.max()) & (tangential < 0.9 * tangential.max())
    still = np.flatnonzero(~low)
    return float(fill_ratio[still[-1] + 1]) if still[-1] + 1 < fill_ratio.size else float("nan")


def zones_of(fill: np.ndarray, normal: np.ndarray, tangential: np.ndarray, ratio: np.ndarray) -> dict[str, float]:
    """Elbow, fill ratios of the largest powers, choking [-], and the ratio at the elbow and its ends [-]."""
    bend = elbow(fill, ratio)
    return {
        "elbow": bend,
        "normal_maximum": float(fill[np.argmax(normal)]),
        "tangential_maximum": float(fill[np.argmax(tangential)]),
        "choking": choking(fill, normal, tangential),
        "ratio_at_elbow": float(np.interp(bend, fill, ratio)) if np.isfinite(bend) else float("nan"),
        "ratio_largest": float(ratio.max()),
        "ratio_smallest": float(ratio.min()),
    }


def _curves(fingerprint: Fingerprint, quantity: str, fills: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Log curves over the fills: of each setting (j, m), and the mean over the settings with SAMPLES draws of it."""
    inputs = fingerprint.at_settings(fills)
    mean, covariance = fingerprint.predictors[quantity].joint(inputs)
    settings = len(inputs) // fills.size
    average = np.kron(np.eye(fills.size), np.full(settings, 1.0 / settings))
    centre = average @ mean
    generator = np.random.default_rng(0)
    drawn = generator.multivariate_normal(centre, average @ covariance @ average.T, size=SAMPLES, method="eigh")
    return mean.reshape(fills.size, settings).T, np.vstack([centre, drawn])


def _zones_of_all(fills: np.ndarray, curves: dict[str, np.ndarray]) -> pd.DataFrame:
    lines = zip(*(np.exp(curves[name]) for name in ZONE_CURVES), strict=True)
    return pd.DataFrame([zones_of(fills, *line) for line in lines])


def find_zones(fingerprint: Fingerprint) -> pd.DataFrame:
    """The zones with intervals: columns contact, zone, value, lower, upper, found, smallest, largest.

    `value` is from the curves averaged over the simulated speeds and ball sizes. `lower` and `upper` hold the
    fingerprint's probability of such curves drawn from the processes; `found` is the share of the drawn curves that
    have the zone at all. `smallest` and `largest` are over single speeds and ball sizes. The fill ratios of a zone are
    on a grid within the simulated ones, so the true maximum may be beyond an end of the grid. Powers and ratio each
    come from a separate process. There is no row where one of the three has no curve, or all have one fill ratio.
    """
    low, high = fingerprint.fill_range
    if not set(ZONE_CURVES) <= fingerprint.predictors.keys() or low == high:
        return pd.DataFrame(columns=COLUMNS)
    fills = np.geomspace(low, high, POINTS)
    pairs = {name: _curves(fingerprint, name, fills) for name in ZONE_CURVES}
    single = _zones_of_all(fills, {name: pair[0] for name, pair in pairs.items()})
    average = _zones_of_all(fills, {name: pair[1] for name, pair in pairs.items()})
    tail = 0.5 - 0.5 * fingerprint.about["probability"]
    drawn = average.iloc[1:]
    found = drawn.notna().mean()
    is_common = found >= 0.5
    return pd.DataFrame(
        {
            "contact": fingerprint.about["contact"],
            "zone": average.columns,
            "value": average.iloc[0].to_numpy(),
            "lower": drawn.quantile(tail).where(is_common).to_numpy(),
            "upper": drawn.quantile(1.0 - tail).where(is_common).to_numpy(),
            "found": found.to_numpy(),
            "smallest": single.min().to_numpy(),
            "largest": single.max().to_numpy(),
        }
    )


def _ratio(large: Prediction, small: Prediction, name: str) -> float:
    return getattr(large, name).value / getattr(small, name).value


def tabulate_scale_up(
    fingerprint: Fingerprint, factor: float, settings: ScaleUpConfig, step_s: float, ns_per_ball_step: float
) -> pd.DataFrame:
    """Speed, balls, descriptors, their ratios to the small mill's, and the costs of each way to run the large mill.

    factor: L [-]; step_s: the step for the small mill's balls [s], which grows with them; ns_per_ball_step: measured.
    A charge of several sizes has its name and sizes in separate columns.
    `hours` is the time of one core for settings.revolutions. The fingerprint predicts the descriptors at the large
    amplitude: this is beyond what was simulated, so by the scaling of the thesis, and `outside` says so. `froude` is
    A omega^2 / g over the small mill's: where it is not 1, gravity matters more or less than in the small mill.
    """
    volume = fingerprint.about["volume_m3"]
    diameter, charge = fingerprint.balls(settings.ball_diameter_mm)
    small = fingerprint.condition(
        speed_hz=settings.speed_rpm / 60, ball_diameter_m=diameter, fill_ratio=settings.fill_ratio
    )
    small_found = fingerprint.predict(small, charge=charge)
    small_mass = small.fill_ratio * volume * small.density_kg_m3
    rows = []
    for way in WAYS:
        larger = factor if way.balls_grow else 1.0
        large = replace(
            small,
            speed_hz=small.speed_hz * factor**way.power,
            ball_diameter_m=small.ball_diameter_m * larger,
            amplitude_m=small.amplitude_m * factor,
        )
        found = fingerprint.predict(large, volume_m3=volume * factor**3, charge=charge)
        step = step_s * larger
        steps = settings.revolutions / large.speed_hz / step
        rows.append(
            {
                "way": way.name,
                "keeps": way.keeps,
                "length_factor": factor,
                "volume_L": 1e3 * volume * factor**3,
                "amplitude_mm": 1e3 * small.amplitude_m * factor,
                "ball_diameter_mm": 1e3 * large.ball_diameter_m,
                **(fingerprint.charges[charge].columns(larger) if charge else {}),
                "speed_rpm": 60 * large.speed_hz,
                "balls": found.balls,
                "froude": factor ** (1 + 2 * way.power),
                **{name: getattr(found, name).value for name in SCALED_BY},
                POWER: found.wall_power_W.value,
                "specific_power_W_kg": found.wall_power_W.value / (small_mass * factor**3),
                "weighted_normal_energy_ratio": _ratio(found, small_found, "weighted_normal_energy_J"),
                "weighted_normal_frequency_ratio": _ratio(found, small_found, "weighted_normal_frequency_hz"),
                "specific_power_ratio": found.wall_power_W.value / small_found.wall_power_W.value / factor**3,
                "outside": ", ".join(found.outside) or "nothing",
                "time_step_s": step,
                "steps": steps,
                "ns_per_ball_step": ns_per_ball_step,
                "hours": steps * found.balls * ns_per_ball_step * 1e-9 / HOUR,
            }
        )
    return pd.DataFrame(rows)


def compare_run(sheet: pd.DataFrame, large: dict, rule: dict) -> pd.DataFrame:
    """The large run compared with its prediction in the sheet; for each quantity foreseen, simulated and their ratio.

    large: summary of the run; rule: its collisions by the fingerprint's counting rule.
    """
    foreseen = sheet.set_index("way").loc[RUN_WAY.name]
    simulated = {
        "balls": large["balls"],
        **{f"weighted_{name}_energy_J": large["weighted"][name]["energy_J"] for name in CHANNELS},
        "normal_energy_J": rule["mean_normal_J"],
        "tangential_energy_J": rule["mean_tangential_J"],
        "specific_frequency_hz": rule["specific_frequency_hz"],
        POWER: large["power_W"]["wall"],
        "ns_per_ball_step": large["ns_per_ball_step"],
    }
    return pd.DataFrame(
        [
            {"quantity": name, "foreseen": foreseen[name], "simulated": value, "ratio": value / foreseen[name]}
            for name, value in simulated.items()
        ]
    )
