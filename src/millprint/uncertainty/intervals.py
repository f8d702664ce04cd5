"""Intervals of a mill's predictions by contact parameters: emulators, indices, intervals, and the factors of a file.

An interval is for values at the condition that was sampled. Its ends are quantiles of the emulator over the
distributions and over what the design leaves uncertain. A ratio of two emulated values would double the error of the
emulator, and a factor on another value, such as a fingerprint's, would move the interval away from the samples. So an
interval is limited to the range of the samples. It is widened to include the samples next to its fill ratio, and the
emulated value for the contact set of the predictions, which is one of the possible sets. `Factors` keep the values that
they refer to, so that a fingerprint with another value gets the same ends (`Factors.onto`).
"""

from dataclasses import dataclass

import numpy as np
import pandas as pd

from millprint.config.charge import ONE_SIZE
from millprint.config.contact_set import ContactConfig
from millprint.config.errors import ConfigError
from millprint.config.fingerprint import PARAMETERS, UncertaintyConfig
from millprint.fingerprint.bands import ContactFactors, Ends, Sampled
from millprint.fingerprint.descriptors import CHARGE
from millprint.observables.condition import VARIABLES, Condition
from millprint.observables.definitions import CURVES, LATER_CURVES, PREDICTED
from millprint.run.job import progress
from millprint.uncertainty.samples import (
    FILL,
    FILLED,
    Emulator,
    Space,
    contact_values,
    draw,
    quality,
    saltelli_shares,
    sobol_indices,
)

SET_COLUMNS = [FILL, "quantity", "contact", "factor", "lower_factor", "upper_factor", "inside"]


@dataclass(frozen=True)
class Measured:
    """The results from the samples of a mill; workflow/outputs.md explains the columns."""

    emulator: pd.DataFrame
    indices: pd.DataFrame
    intervals: pd.DataFrame
    sets: pd.DataFrame
    factors: ContactFactors


def fit_emulators(samples: pd.DataFrame, space: Space, seed: int) -> dict[str, Emulator]:
    """An emulator of the logarithm of each quantity of CURVES over the space; fill ratios are of whole balls.

    Raises ConfigError for a quantity that is not positive.
    """
    places = space.places(samples.assign(**{FILL: samples[FILLED]}))
    emulators = {}
    for name in CURVES:
        # Nothing rolls, or no contacts were kept.
        if name in LATER_CURVES and not (name in samples and (samples[name] > 0).all()):
            continue
        values = samples[name].to_numpy(dtype=float)
        if not np.all(values > 0):
            raise ConfigError(f"samples: {name} = {values.min():g}: must be above 0; make the windows longer")
        error = float((samples[f"{name}_se"] / values).mean())
        # A window of less than two revolutions has no standard error.
        emulators[name] = Emulator.fit(places, np.log(values), 0.0 if np.isnan(error) else error, seed)
    return emulators


def emulator_table(emulators: dict[str, Emulator], samples: pd.DataFrame) -> pd.DataFrame:
    """How good each emulator is: q2, leave_one_out_error, scatter and run_error, all but the first of a logarithm [-].

    scatter: noise of one simulation according to the emulator; run_error: mean standard error according to the runs.
    """
    rows = []
    for name, emulator in emulators.items():
        error = (samples[f"{name}_se"] / samples[name]).mean()
        found = quality(emulator.logs, emulator.left_out)
        rows.append({"quantity": name, "samples": len(samples), **found, "scatter": emulator.noise, "run_error": error})
    return pd.DataFrame(rows)


def measure(
    samples: pd.DataFrame,
    space: Space,
    fill_ratios: list[float],
    contact: ContactConfig,
    others: list[ContactConfig],
    settings: UncertaintyConfig,
) -> Measured:
    """Emulators, indices and intervals from the samples of a mill, at each fill ratio.

    space: of the contact parameters and, last, the fill ratio; contact: the contact set of the predictions, to whose
    values the factors refer; others: sets that are compared with it. Raises ConfigError for a set outside the space.
    """
    emulators = fit_emulators(samples, space, settings.seed)
    names = list(PARAMETERS)
    shares = saltelli_shares(names, settings.base_samples, settings.seed)
    varied = Space(space.variables[:-1]).values(shares)
    indices, intervals, sets = [], [], []
    with progress(len(fill_ratios) * len(emulators), None, " quantities") as bar:
        for fill in fill_ratios:
            places = space.places(varied.assign(**{FILL: fill}))
            known = [space.places(pd.DataFrame([{**contact_values(one), FILL: fill}]))[0] for one in (contact, *others)]
            for name, emulator in emulators.items():
                drawn = draw(emulator, names, places, settings.draws, settings.seed)
                place = {"fill_ratio": fill, "quantity": name}
                value = float(np.exp(emulator.predict(known[0][None]))[0])
                known_ends = interval_ends(
                    drawn.ends(settings.probability),
                    samples_at(emulator, space, samples, fill),
                    nearest_to(fill, fill_ratios, samples[FILLED].to_numpy()),
                    settings.probability,
                )
                lower, upper = np.exp([min(known_ends[0], np.log(value)), max(known_ends[1], np.log(value))]) / value
                row = {**place, "value": value, "lower_factor": lower, "upper_factor": upper}
                intervals.append({**row, "scatter": emulator.noise})
                indices.append(sobol_indices(drawn, settings.probability, settings.seed).assign(**place))
                for one, at in zip(others, known[1:], strict=True):
                    factor = float(np.exp(emulator.predict(at[None]))[0]) / value
                    ends = {"factor": factor, "lower_factor": lower, "upper_factor": upper}
                    sets.append({**place, "contact": one.name, **ends, "inside": lower <= factor <= upper})
                bar.update()
    scaled = pd.DataFrame(intervals)
    first = ["fill_ratio", "quantity", "parameter"]
    table = pd.concat(indices, ignore_index=True)
    return Measured(
        emulator=emulator_table(emulators, samples),
        indices=table[[*first, *(column for column in table if column not in first)]],
        intervals=pd.concat([_with_ends(scaled.assign(unit="-")), _described(scaled, samples)], ignore_index=True),
        sets=pd.DataFrame(sets, columns=SET_COLUMNS),
        factors=_factors(scaled, samples, contact, settings),
    )


def samples_at(emulator: Emulator, space: Space, samples: pd.DataFrame, fill: float) -> np.ndarray:
    """Logarithms (n,) of the samples, each moved by the emulator from its fill ratio to `fill`.

    They then differ only by scatter and parameters.
    """
    moved = space.places(samples.assign(**{FILL: fill}))
    return emulator.logs + emulator.predict(moved) - emulator.predict(emulator.places)


def nearest_to(fill: float, fill_ratios: list[float], filled: np.ndarray) -> np.ndarray:
    """Which of the samples, of fill ratios `filled` (n,), are nearer to `fill` than to the other fill ratios (n,)."""
    away = np.abs(np.log(filled[:, None] / np.array(fill_ratios)))
    return away.argmin(axis=1) == fill_ratios.index(fill)


def interval_ends(
    quantiles: tuple[float, float], moved: np.ndarray, near: np.ndarray, probability: float
) -> tuple[float, float]:
    """The ends of an interval of a logarithm, by the emulator and by the samples themselves.

    quantiles: of the emulator, limited to the range of the samples, which are moved to the fill ratio (n,). They are
    widened to the central part of the samples `near` the fill ratio (n,), interpolated between the order statistics
    k of m at shares k / (m + 1); with few samples, the smallest and the largest.
    """
    low, high = np.clip(quantiles, moved.min(), moved.max())
    if near.any():
        own = np.quantile(moved[near], [(1 - probability) / 2, (1 + probability) / 2], method="weibull")
        low, high = min(low, own[0]), max(high, own[1])
    return float(low), float(high)


def _with_ends(table: pd.DataFrame) -> pd.DataFrame:
    """The table with lower and upper, the value times its factors, in the order of the file."""
    ends = {end: table["value"] * table[f"{end}_factor"] for end in ("lower", "upper")}
    columns = ["fill_ratio", "quantity", "unit", "value", *ends, "lower_factor", "upper_factor", "scatter"]
    return table.assign(**ends)[columns]


def _described(scaled: pd.DataFrame, samples: pd.DataFrame) -> pd.DataFrame:
    """Energies, frequencies and powers at the simulated speed and ball size."""
    condition = Condition(np.nan, **_sampled(samples))
    ball_share = float((samples[FILLED] / samples["balls"]).mean())
    tables = []
    for name, own in PREDICTED.items():
        table = scaled[scaled["quantity"] == own.curve]
        balls = np.round(table["fill_ratio"] / ball_share)
        value = table["value"] * own.scale_of(condition, balls)
        tables.append(_with_ends(table.assign(quantity=name, unit=own.unit, value=value)))
    return pd.concat(tables, ignore_index=True)


def _sampled(samples: pd.DataFrame) -> dict[str, float]:
    """The condition of the samples, without the fill ratio."""
    return {name: float(samples[name].iloc[0]) for name in VARIABLES if name != FILL}


def _factors(
    scaled: pd.DataFrame, samples: pd.DataFrame, contact: ContactConfig, settings: UncertaintyConfig
) -> ContactFactors:
    """The content of contact.json."""
    ends = {
        name: Ends(lower=table["lower_factor"].tolist(), upper=table["upper_factor"].tolist())
        for name, table in scaled.groupby("quantity", sort=False)
    }
    sections = settings.parameters.items()
    sampled = Sampled(
        **_sampled(samples),
        charge=str(samples[CHARGE].fillna(ONE_SIZE).iloc[0]) if CHARGE in samples else ONE_SIZE,
        values={name: table["value"].tolist() for name, table in scaled.groupby("quantity", sort=False)},
    )
    return ContactFactors(
        format="millprint contact uncertainty 1",
        mill=str(samples["mill"].iloc[0]),
        contact=contact.name,
        counting_rule=str(samples["counting_rule"].iloc[0]),
        probability=settings.probability,
        samples=len(samples),
        parameters={name: section.model_dump(mode="json", exclude_none=True) for name, section in sections},
        fill_ratios=sorted(scaled["fill_ratio"].unique().tolist()),
        factors=ends,
        sampled=sampled,
    )
