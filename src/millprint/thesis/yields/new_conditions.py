"""Yields of new conditions by a stored model, with intervals; conditions outside its domain are refused.

The domain: descriptors that a mill can have at once, trained ranges, and nearness to the runs in the model's metric.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
from threadpoolctl import threadpool_limits

from millprint.config.errors import ConfigError
from millprint.config.yields import INPUTS, PredictionConfig, TrainingConfig
from millprint.estimate.gaussian_process import LINEAR
from millprint.observables.condition import Condition, energy_scale
from millprint.observables.definitions import BASIC
from millprint.run.files import read_format, write_json, write_table
from millprint.thesis.doe.factorial_designs import YIELD
from millprint.thesis.yields.averaging import (
    BISECTIONS,
    HIGHEST,
    LOWEST,
    NODE_WEIGHTS,
    NODES,
    AveragedModel,
    Member,
)
from millprint.thesis.yields.estimators import FIT_JITTER, MEAN_VARIANCE
from millprint.thesis.yields.experiments import read_rows
from millprint.thesis.yields.features import (
    CHEMICAL,
    CONDITIONS,
    FREQUENCY,
    NORMAL,
    SHARE,
    TANGENTIAL,
    describe,
)
from millprint.thesis.yields.held_out import CV_PLUS, cross_intervals, cross_validate, own_intervals, refit
from millprint.thesis.yields.stored_models import fitted_content, load_any, load_averaged, training_rows
from millprint.thesis.yields.yield_model import YieldModel

DESCRIPTORS = (NORMAL, TANGENTIAL, FREQUENCY)
# The energies go with the square of the speed, the frequency with the speed (Eqs 3.28 and 3.29).
POWERS_OF_SPEED = np.array([2.0, 2.0, 1.0])
# Fill ratios at which the curves are compared.
FILLS = 241
FORMAT = "millprint curves of a mill 1"


@dataclass(frozen=True)
class MillCurves:
    """The master curves of a mill and what can be set on it.

    curves: fill_ratio, Pn, Pt, f, and their ends Pn_lower, Pn_upper, ... where a band is known; density: of the balls
    [kg/m3]; amplitude: of the motion [m]; diameters_mm: of the available balls; speeds_rpm: lowest and highest.
    """

    name: str
    curves: pd.DataFrame
    density: float
    amplitude: float
    diameters_mm: tuple[float, ...]
    speeds_rpm: tuple[float, float]

    def write(self, path: str | Path) -> None:
        """Write a JSON file."""
        names = ["fill_ratio", *(f"{name}{end}" for name in BASIC for end in ("", "_lower", "_upper"))]
        table = self.curves[[name for name in names if name in self.curves]].drop_duplicates("fill_ratio")
        content = {
            "format": FORMAT,
            "mill": self.name,
            "curves": table.sort_values("fill_ratio").astype(float).to_dict("list"),
            "density_kg_m3": self.density,
            "amplitude_m": self.amplitude,
            "ball_diameters_mm": list(self.diameters_mm),
            "speeds_rpm": list(self.speeds_rpm),
        }
        write_json(content, path)

    @classmethod
    def read(cls, path: str | Path) -> "MillCurves":
        """Read what `write` has written; raises ConfigError, in one line, for a file that is missing or another."""
        content = read_format(path, [FORMAT], "file of a mill's curves", f"`snakemake {path}` writes it")
        try:
            return cls(
                content["mill"],
                pd.DataFrame(content["curves"]).astype(float),
                float(content["density_kg_m3"]),
                float(content["amplitude_m"]),
                tuple(map(float, content["ball_diameters_mm"])),
                (float(content["speeds_rpm"][0]), float(content["speeds_rpm"][1])),
            )
        except (IndexError, KeyError, TypeError, ValueError) as error:
            raise ConfigError(f"{path}: damaged: {error}") from None

    def _at_one_hertz(self) -> tuple[np.ndarray, list[dict[str, np.ndarray]]]:
        """Fill ratios (k,), and for each ball size logarithms (k, 3) of the descriptors at 1 Hz, with their band."""
        table = self.curves.drop_duplicates("fill_ratio").sort_values("fill_ratio")
        known = np.log(table["fill_ratio"].to_numpy(float))
        fills = np.linspace(known[0], known[-1], FILLS)

        def curve(name: str, end: str) -> np.ndarray:
            column = f"{name}{end}" if f"{name}{end}" in table else name
            return np.interp(fills, known, np.log(table[column].to_numpy(float)))

        # The band of an energy per collision, a ratio of two curves, is that of its power.
        scaled = {}
        for key, end in (("value", ""), ("lower", "_lower"), ("upper", "_upper")):
            frequency = curve("f", end)
            scaled[key] = np.stack([curve("Pn", end) - curve("f", ""), curve("Pt", end) - curve("f", ""), frequency], 1)
        sizes = []
        for diameter in self.diameters_mm:
            energy = energy_scale(Condition(0.1, 1.0, diameter * 1e-3, self.density, self.amplitude))
            shift = np.array([np.log(1e6 * energy), np.log(1e6 * energy), 0.0])
            sizes.append({key: value + shift for key, value in scaled.items()})
        return np.exp(fills), sizes

    def warnings(self, rows: pd.DataFrame, tolerance: float) -> list[str]:
        """For each row why this mill does not have its three descriptors at once, empty where it has them.

        rows: the descriptors, energies [microjoule] and frequency [1/s]. A row is possible if, for one ball size, one
        fill ratio and one speed, each descriptor is within the band of its curve, widened by the factor 1 + tolerance
        both ways. With ln D = c(fill, size) + p ln(speed), each descriptor leaves an interval of ln(speed); all three
        and the speeds of the mill must share one.
        """
        measured = np.log(rows[list(DESCRIPTORS)].to_numpy(float))
        fills, sizes = self._at_one_hertz()
        ends = np.log(np.array(self.speeds_rpm) / 60)
        slack, widest = np.log1p(tolerance), np.full(len(rows), np.inf)
        texts = [""] * len(rows)
        for diameter, size in zip(self.diameters_mm, sizes, strict=True):
            # (rows, fills, 3): the interval of ln(speed) that each descriptor leaves.
            low = (measured[:, None, :] - size["upper"] - slack) / POWERS_OF_SPEED
            high = (measured[:, None, :] - size["lower"] + slack) / POWERS_OF_SPEED
            gap = np.maximum(low.max(axis=2), ends[0] - slack) - np.minimum(high.min(axis=2), ends[1] + slack)
            nearest = gap.argmin(axis=1)
            for row, place in enumerate(nearest):
                if gap[row, place] >= widest[row]:
                    continue
                widest[row] = gap[row, place]
                means = 60 * np.exp((measured[row] - size["value"][place]) / POWERS_OF_SPEED)
                told = ", ".join(f"{name} {rpm:.0f}" for name, rpm in zip(DESCRIPTORS, means, strict=True))
                texts[row] = (
                    f"descriptors that {self.name} does not have at once: at its nearest fill ratio, "
                    f"{fills[place]:.2f} with {diameter:g} mm balls, they mean speeds [rpm] of {told}; "
                    f"its speeds are {self.speeds_rpm[0]:.0f} to {self.speeds_rpm[1]:.0f}"
                )
        # Texts of one row are joined by semicolons.
        return [text.replace(";", ",") if gap > 0 else "" for text, gap in zip(texts, widest, strict=True)]


def nearest_correlation(model: AveragedModel, known: pd.DataFrame, rows: pd.DataFrame) -> np.ndarray:
    """Largest correlation (m,) [-] of the yield at each row with that at a training row, by the model's length scales.

    known: the training rows; rows: m rows with the six conditions. sum_k w_k exp(-1/2 sum_j (x_j - x_j')^2 / l_kj^2)
    over the members k with the weights w_k, the largest over the training rows: 1 at a training row, 0 far from all.
    """
    new, old = describe(rows).to_numpy(), describe(known).to_numpy()
    total = np.zeros((len(new), len(old)))
    for member, weight in zip(model.members, model.weights, strict=True):
        lengths = np.exp(member.process.logs[: len(INPUTS)])
        scaled = [member.standard(inputs) / lengths for inputs in (new, old)]
        total += weight * np.exp(-0.5 * ((scaled[0][:, None, :] - scaled[1][None, :, :]) ** 2).sum(axis=2))
    return total.max(axis=1)


def correlation_warnings(model: AveragedModel, known: pd.DataFrame, rows: pd.DataFrame, smallest: float) -> list[str]:
    """For each row whether its yield is correlated less than `smallest` [-] with every run; empty where it is not."""
    return [
        f"correlation = {value:.2f} with the yield of the nearest run is below {smallest:g}" if value < smallest else ""
        for value in nearest_correlation(model, known, rows)
    ]


def trained_ranges(rows: pd.DataFrame, settings: PredictionConfig) -> dict[str, tuple[float, float]]:
    """Lowest and highest value with a prediction, for each condition and for the tangential share."""
    ranges = {}
    for name in CONDITIONS:
        low, high = float(rows[name].min()), float(rows[name].max())
        slack = settings.tolerance * (high - low)
        ranges[name] = (low - slack, high + slack)
    share = describe(rows)[SHARE]
    return ranges | {SHARE: (share.min() - settings.share_tolerance, share.max() + settings.share_tolerance)}


def range_warnings(rows: pd.DataFrame, ranges: dict[str, tuple[float, float]]) -> list[str]:
    """For each row the conditions outside the ranges as text, empty if there are none.

    The share is checked as well: at another fill ratio each energy can be within its range while their ratio is not.
    """
    values = rows[list(CONDITIONS)].assign(**{SHARE: describe(rows)[SHARE]})
    return [
        "; ".join(
            f"{name} = {row[name]:.4g} is outside {low:.4g} to {high:.4g}"
            for name, (low, high) in ranges.items()
            if not low <= row[name] <= high
        )
        for _, row in values.iterrows()
    ]


def domain_warnings(
    model: YieldModel | AveragedModel,
    known: pd.DataFrame,
    rows: pd.DataFrame,
    limits: PredictionConfig,
    mill: MillCurves | None,
) -> list[str]:
    """For each row why the model should not be asked, empty if it may be.

    Each condition must be within its trained range, the three descriptors must belong to one setting of the mill (if
    there is one), and the yield must be correlated with that of a run (for the averaged process, which has length
    scales for its inputs; for a row outside a range, only the range is reported).

    known: the training rows; rows: the six conditions.
    """
    outside = range_warnings(rows, trained_ranges(known, limits))
    parts = [outside]
    if mill is not None:
        parts.append(mill.warnings(rows, limits.curve_tolerance))
    if isinstance(model, AveragedModel):
        far = correlation_warnings(model, known, rows, limits.correlation_min)
        parts.append([text if not told else "" for text, told in zip(far, outside, strict=True)])
    return ["; ".join(filter(None, texts)) for texts in zip(*parts, strict=True)]


def predict_conditions(
    path: str,
    rows: pd.DataFrame,
    limits: PredictionConfig,
    training: TrainingConfig,
    folds: int,
    level: float,
    extrapolate: bool = False,
    mill: MillCurves | None = None,
) -> pd.DataFrame:
    """Columns: case, the six conditions, predicted_percent, lower_percent, upper_percent, interval, warning.

    path: a stored model; rows: case and the six conditions; folds: of the CV+ intervals; level: of the intervals [-].
    mill: whose descriptors the rows have; None if that is not known. The interval is the model's own if it predicts a
    distribution, else CV+ from its training rows. A row that `domain_warnings` warns of has no numbers, unless
    `extrapolate` is true. Raises ConfigError as load_any.
    """
    model, known = load_any(path), training_rows(path)
    intervals = own_intervals(model, rows, [level])
    if isinstance(model, YieldModel) and not intervals:
        yields = known[YIELD].to_numpy(float)
        fit = refit(model, training)
        errors = cross_validate(fit, known, yields, rows, folds, training.seed)
        intervals = {CV_PLUS: cross_intervals(*errors, [level])}
    ((method, ends),) = intervals.items()
    warnings = domain_warnings(model, known, rows, limits, mill)
    answered = np.array([extrapolate or not text for text in warnings])
    numbers = {"predicted_percent": model.predict(rows), "lower_percent": ends[:, 0, 0], "upper_percent": ends[:, 0, 1]}
    table = rows[["case", *CONDITIONS]].assign(
        **{name: np.where(answered, value, np.nan) for name, value in numbers.items()}
    )
    return table.assign(interval=np.where(answered, method, ""), warning=warnings)


def write_predictions(
    model: str,
    conditions: str,
    out: str,
    limits: PredictionConfig,
    training: TrainingConfig,
    folds: int,
    level: float,
    extrapolate: bool,
    mill: str | None = None,
) -> int:
    """Write the predictions, and return the number of rows without one.

    mill: path of the curves of the mill that the conditions belong to; None if they are not known.
    """
    with threadpool_limits(1):
        rows, own = read_rows(conditions, yields=False), MillCurves.read(mill) if mill else None
        table = predict_conditions(model, rows, limits, training, folds, level, extrapolate, own)
    write_table(table, out)
    return int(table["predicted_percent"].isna().sum())


def explorer_yields(model: str | Path, prediction: PredictionConfig, level: float) -> dict:
    """What the explorer shows of yields: `yield`, the model, and `chemistry`, the range of each chemical condition.

    model: file of a stored averaged Gaussian process; prediction: how far beyond the trained range a yield is still
    answered; level: of the yield's interval [-].
    """
    return {"yield": yield_content(model, prediction, level), "chemistry": chemistry(model)}


def yield_content(path: str | Path, prediction: PredictionConfig, level: float) -> dict:
    """An averaged yield model with its transformed data: scaled inputs and standardised yields of every member."""
    model = load_averaged(str(path))
    ranges = trained_ranges(training_rows(str(path)), prediction)
    return {
        "inputs": list(INPUTS),
        "level": level,
        "ranges": {name: [float(end) for end in ends] for name, ends in ranges.items()},
        "nodes": NODES.tolist(),
        "node_weights": NODE_WEIGHTS.tolist(),
        "bisections": BISECTIONS,
        "search": [LOWEST, HIGHEST],
        "mean_variance": MEAN_VARIANCE,
        "jitter": FIT_JITTER,
        "members": [
            fitted_content(member, weight) | _explored(member)
            for member, weight in zip(model.members, model.weights, strict=True)
        ],
    }


def _explored(member: Member) -> dict:
    """The terms of a member's kernel, and its data."""
    own = member.process.kernel
    terms = zip((own.lengths >= 0).astype(int).tolist(), (shape == LINEAR for shape in own.shapes), strict=True)
    return {
        "terms": [{"factors": factors, "linear": linear} for factors, linear in terms],
        "known": member.process.inputs.tolist(),
        "target": member.process.target.tolist(),
    }


def chemistry(yield_model: str | Path) -> dict[str, list[float]]:
    """Smallest, middle and largest value that the yield model was trained on, of each chemical condition."""
    rows = training_rows(str(yield_model))
    return {name: np.quantile(rows[name], [0, 0.5, 1]).tolist() for name in CHEMICAL}
