"""What the fit leaves open of a jar's shape: other jars, weighted by their agreement with what was fitted.

The search of the fit simulated jars over the ranges `SHAPE`. Emulators of their published values stand in for the
jars between them. Every jar of the ranges is as likely as any other before the fit; after it, its weight is the
likelihood of the fitted values y_k,
    w = prod_k N(log(y_k / published_k); 0, s^2),
s the root mean square of the present jar's own deviations: a jar that agrees as well as it has as much weight.
"""

import logging
from collections.abc import Sequence

import numpy as np
import pandas as pd
from scipy.stats import qmc

from millprint.config.calibration import JarSearch
from millprint.config.errors import ConfigError
from millprint.fingerprint.bands import Ends, ShapeFactors
from millprint.observables.definitions import BASIC, THESIS_CURVES, scaled_quantities
from millprint.thesis.fit import FEWEST_JARS
from millprint.thesis.fit.jar_search import JAR_PARAMETERS, SHAPE, places_of
from millprint.uncertainty.emulator import Emulator

logger = logging.getLogger("millprint")

# Jars drawn from the ranges, and how many must carry the weight, in effect.
DRAWN, FEWEST_IN_EFFECT = 2**14, 50


def deviation_emulators(search: pd.DataFrame, names: Sequence[str], counting_rule: str) -> dict[str, Emulator]:
    """An emulator of log(ours / published) over the ranges for each of the published values `names`.

    Of the trials under `counting_rule`. Raises ConfigError for fewer than FEWEST_JARS of them.
    """
    ruled = search[search["counting_rule"] == counting_rule]
    if len(ruled) < FEWEST_JARS:
        raise ConfigError(
            f"the search of the fit has {len(ruled)} jars with the rule {counting_rule}; a shape's interval needs "
            f"{FEWEST_JARS}"
        )
    found = {}
    for name in names:
        rows = ruled[ruled[f"{name}_percent"].notna()]
        logs = np.log1p(rows[f"{name}_percent"].to_numpy(dtype=float) / 100.0)
        found[name] = Emulator.fit(places_of(rows), logs)
    return found


def agreement(residuals: np.ndarray, deviation: float) -> np.ndarray:
    """Weights (n,) of jars, which add up to 1, from residuals (n, k) and their standard deviation s."""
    exponents = -0.5 * ((residuals / deviation) ** 2).sum(axis=1)
    weights = np.exp(exponents - exponents.max())
    return weights / weights.sum()


def _ends(values: np.ndarray, weights: np.ndarray, probability: float) -> np.ndarray:
    """The central interval (2,) of weighted values (n,)."""
    levels = [0.5 - 0.5 * probability, 0.5 + 0.5 * probability]
    return np.quantile(values, levels, weights=weights, method="inverted_cdf")


def shape_factors(
    search: pd.DataFrame,
    published: dict[str, float],
    settings: JarSearch,
    present: dict[str, float],
    *,
    mill: str,
    counting_rule: str,
    probability: float,
) -> ShapeFactors:
    """What the jars of the ranges that agree with the fitted values would change of the present jar's predictions.

    search: fit_search.tsv; published: the published values by name; present: the parameters of the mill's jar. The
    fill ratios are those of which the search has both powers and the frequency. Raises ConfigError for a search of too
    few jars, or if hardly one of the ranges agrees.
    """
    values = [column.removesuffix("_percent") for column in search if column.endswith("_percent")]
    for name in settings.fitted:
        if name not in values:
            raise ConfigError(f"the search of the fit lacks {name}; run `snakemake --cores 2 fit` again")
    fills = [name.removeprefix("Pn_f") for name in values if name.startswith("Pn_f")]
    fills = sorted(fill for fill in fills if all(f"{one}_f{fill}" in values for one in BASIC))
    needed = list(dict.fromkeys([*settings.fitted, *(f"{one}_f{fill}" for fill in fills for one in BASIC)]))
    emulators = deviation_emulators(search, needed, counting_rule)
    drawn = qmc.Sobol(len(JAR_PARAMETERS), seed=0).random(DRAWN)
    own = places_of(pd.DataFrame([present]))
    residuals, here = (np.column_stack([emulators[k].predict(at) for k in settings.fitted]) for at in (drawn, own))
    deviation = float(np.sqrt((here**2).mean()))
    weights = agreement(residuals, deviation)
    effective = 1.0 / (weights**2).sum()
    logger.info("misfit of the jar %.3f; %.0f of %d jars carry the weight", deviation, effective, DRAWN)
    if effective < FEWEST_IN_EFFECT:
        raise ConfigError(f"hardly a jar of the search agrees with fit.fitted: {effective:.0f} of {DRAWN} jars")
    # The search knows nothing of the energy-weighted descriptors.
    known = list(THESIS_CURVES)
    ends: dict[str, list[np.ndarray]] = {name: [] for name in known}
    for fill in fills:
        names = {one: f"{one}_f{fill}" for one in BASIC}
        scaled, before = (
            scaled_quantities({one: published[k] * np.exp(emulators[k].predict(at)) for one, k in names.items()})
            for at in (drawn, own)
        )
        for name in known:
            ends[name].append(_ends(scaled[name] / before[name], weights, probability))
    return ShapeFactors(
        format="millprint shape uncertainty 1",
        mill=mill,
        contact=settings.contact,
        counting_rule=counting_rule,
        probability=probability,
        samples=int((search["counting_rule"] == counting_rule).sum()),
        parameters=_agreeing(drawn, weights, present, probability),
        fill_ratios=[float(fill) for fill in fills],
        factors={
            name: Ends(lower=[float(low) for low, _ in own_ends], upper=[float(high) for _, high in own_ends])
            for name, own_ends in ends.items()
        },
    )


def _agreeing(drawn: np.ndarray, weights: np.ndarray, present: dict[str, float], probability: float) -> dict[str, dict]:
    """Each parameter of the jar: its range, the present value, and the interval that agrees with the fitted values."""
    found: dict[str, dict] = {}
    for column, name in enumerate(JAR_PARAMETERS):
        allowed = SHAPE[name]
        lower, upper = allowed.low + (allowed.high - allowed.low) * _ends(drawn[:, column], weights, probability)
        found[name] = {
            "kind": "uniform", "low": allowed.low, "high": allowed.high, "present": present[name],
            "lower": float(lower), "upper": float(upper),
            "source": "ranges of the fit, weighted by agreement with fit.fitted",
        }  # fmt: skip
    return found
