"""What the fit leaves open of a jar's shape: other jars, weighted by their agreement with what was fitted.

The search of the fit simulated jars over the ranges `SHAPE`. Emulators of their published values stand in for the
jars between them. Every jar of the ranges is as likely as any other before the fit; after it, its weight is the
likelihood of the fitted values y_k,
    w = prod_k N(log(y_k / published_k); 0, s^2),
s the root mean square of the present jar's own deviations: a jar that agrees as well as it has as much weight.

Jars and counting rules that fit equally well, and what each gives at the conditions of chapter 3.

The fit has six knobs, five of the shape and the counting rule, for six printed values, so that it has no unique answer.
A jar and a rule fit equally well if they agree with every fitted value as a claim of it does, within TOLERANCE. A claim
of chapter 3 is then judged by the chosen jar and all of them: what only some of them meet is a property of the choice.
"""

import itertools
import logging
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd
from scipy.stats import qmc

from millprint.cases.simulate import simulate_each
from millprint.config.calibration import JarSearch
from millprint.config.contact_set import ContactConfig
from millprint.config.errors import ConfigError
from millprint.config.mill import MillConfig
from millprint.config.sweep import Case, DemConfig
from millprint.dem.run import simulate
from millprint.fingerprint.bands import Ends, ShapeFactors
from millprint.observables.definitions import BASIC, THESIS_CURVES, scaled_quantities
from millprint.run.tables import Number, Text, read_measured, refuse_rows
from millprint.thesis.fit import FEWEST_JARS
from millprint.thesis.fit.jar_search import (
    FITTED,
    HELD_BACK,
    JAR_PARAMETERS,
    SHAPE,
    case_of,
    misfit,
    places_of,
    shaped,
    under_rules,
)
from millprint.uncertainty.samples import Emulator

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


# Of the claims on the fitted values [-].
TOLERANCE = 0.15
# Places of one jar differ by less in the ranges of the search [-]: a mill's file has rounded lengths.
SAME = 1e-4
RULE = "counting_rule"
COLUMNS = ["jar", *JAR_PARAMETERS, RULE, "misfit", "held_back_misfit"]


def equally_good(search: pd.DataFrame, settings: JarSearch, chosen: dict[str, float]) -> pd.DataFrame:
    """The chosen jar, and the jars and rules of a search that agree with every fitted value: a row each, with COLUMNS.

    search: fit_search.tsv; chosen: the parameters of the mill's jar. A jar that was simulated in both stages counts by
    the longer one. Jar 1 is the chosen one, by its best rule where none agrees with every value, or the one with the
    smallest misfit where the search lacks it. Each next one is the farthest from those before it, in shares of the
    ranges of the search, so that the first `settings.equal_jars`, which are simulated, span the set.
    """
    jar = list(JAR_PARAMETERS)
    last = search.drop_duplicates([*jar, RULE], keep="last").sort_values("misfit", kind="stable")
    errors = last[[f"{name}_percent" for name in settings.fitted]].abs()
    agrees = (errors <= 100 * TOLERANCE).all(axis=1)
    last["chosen"] = (np.abs(places_of(last) - places_of(pd.DataFrame([chosen]))) < SAME).all(axis=1)
    best_of_chosen = last["chosen"] & (last["chosen"].cumsum() == 1)
    members = last[agrees | best_of_chosen].sort_values(["chosen", "misfit"], ascending=[False, True], kind="stable")
    shapes = members.drop_duplicates(jar)
    order = farthest(places_of(shapes)) if len(shapes) else []
    numbered = shapes.iloc[order][jar].assign(jar=range(1, len(shapes) + 1))
    return numbered.merge(members, on=jar)[COLUMNS]


def farthest(places: np.ndarray) -> list[int]:
    """Rows of places (n, k): the first, and then always the one that is farthest from all before it."""
    chosen = [0]
    while len(chosen) < len(places):
        distance = np.linalg.norm(places[:, None] - places[chosen], axis=2).min(axis=1)
        distance[chosen] = -1.0
        chosen.append(int(distance.argmax()))
    return chosen


def read_equal_jars(path: str | Path, rules: Sequence[str]) -> pd.DataFrame:
    """The rows, with COLUMNS, of the table that `equally_good` made, by the counting rules that a run has.

    Raises ConfigError for a faulty row, and where no row has one of these rules.
    """
    table = read_measured(path, [*(Number(name, 0) for name in COLUMNS if name != RULE), Text(RULE)])[COLUMNS]
    several = table.groupby("jar")[list(JAR_PARAMETERS)].transform("nunique").gt(1).any(axis=1)
    refuse_rows(table, path, "jar", several, "one number stands for one shape")
    own = table[RULE].isin(rules)
    refuse_rows(table, path, RULE, ~own & ~own.any(), f"one row must have {' or '.join(rules)}")
    return table[own].astype({"jar": int}).reset_index(drop=True)


def whole_cases(mill: str, settings: JarSearch) -> list[Case]:
    """The cases of chapter 3 at which a jar of the set is simulated."""
    whole = settings.whole
    ends = dict.fromkeys((whole.speeds_rpm[0], whole.speeds_rpm[-1]))
    places = dict.fromkeys(
        [*itertools.product(whole.fill_ratios, ends), *((whole.every_speed_at, speed) for speed in whole.speeds_rpm)]
    )
    return [
        case_of(mill, settings, diameter, *place, revolutions)
        for (diameter, revolutions), place in itertools.product(whole.revolutions, places)
    ]


def simulate_jar(
    mill: MillConfig, row: pd.Series, contact: ContactConfig, dem: DemConfig, settings: JarSearch, done: str | Path
) -> list[dict]:
    """The summaries of a jar at every condition of chapter 3; row: of the set; done: as in `simulate_each`."""
    jar = shaped(mill, {name: float(row[name]) for name in JAR_PARAMETERS})
    runs = {case.path: case.model_dump() for case in whole_cases(mill.name, settings)}
    shared = [jar, contact, dem]
    summaries = simulate_each(runs, lambda own: simulate(Case(**own), jar, contact, dem), shared, "jar", done)
    return list(summaries.values())


def measured_again(
    jars: pd.DataFrame, simulated: dict[int, list[dict]], values: pd.DataFrame, mill: str, contact: str
) -> pd.DataFrame:
    """The set with what the longer runs give of the values of the fit, which the search saw over few turns only.

    simulated: summaries by the number of a jar; values: as `with_roles`. Further columns, empty of a jar that is not
    simulated: again_misfit and again_held_back_misfit [-], and again_worst_percent: the largest of a fitted value.
    """
    rows = []
    for row in jars.itertuples():
        found: dict[str, float] = {}
        if runs := simulated.get(row.jar):
            table = under_rules(runs, values, [row.counting_rule], mill, contact)
            known = table[table["ours"].notna()]
            fitted = known.loc[known["role"] == FITTED, "error_percent"]
            found = {"again_misfit": misfit(known), "again_held_back_misfit": misfit(known, HELD_BACK)}
            found["again_worst_percent"] = float(fitted.loc[fitted.abs().idxmax()]) if len(fitted) else np.nan
        rows.append(found)
    again = ["again_misfit", "again_held_back_misfit", "again_worst_percent"]
    return jars.join(pd.DataFrame(rows, index=jars.index, columns=again))
