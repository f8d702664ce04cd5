"""Jars and counting rules that fit equally well, and what each gives at the conditions of chapter 3.

The fit has six knobs, five of the shape and the counting rule, for six printed values, so that it has no unique answer.
A jar and a rule fit equally well if they agree with every fitted value as a claim of it does, within TOLERANCE. A claim
of chapter 3 is then judged by all of them: what only some of them meet is a property of the choice.
"""

import itertools
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from millprint.cases.simulate import simulate_each
from millprint.config.calibration import JarSearch
from millprint.config.contact_set import ContactConfig
from millprint.config.mill import MillConfig
from millprint.config.sweep import Case, DemConfig
from millprint.dem.run import simulate
from millprint.run.tables import Number, Text, read_measured, refuse_rows
from millprint.thesis.fit.jar_search import FITTED, HELD_BACK, JAR_PARAMETERS, misfit, places_of, shaped, under_rules

# Of the claims on the fitted values [-].
TOLERANCE = 0.15
RULE = "counting_rule"
COLUMNS = ["jar", *JAR_PARAMETERS, RULE, "misfit", "held_back_misfit"]


def equally_good(search: pd.DataFrame, settings: JarSearch) -> pd.DataFrame:
    """The jars and rules of a search that agree with every fitted value, with COLUMNS: a row for each jar and rule.

    search: fit_search.tsv. A jar that was simulated in both stages counts by the longer one. Jar 1 has the smallest
    misfit, and each next one is the farthest from those before it, in shares of the ranges of the search, so that the
    first `settings.equal_jars`, which are simulated, span the set.
    """
    jar = list(JAR_PARAMETERS)
    last = search.drop_duplicates([*jar, RULE], keep="last")
    errors = last[[f"{name}_percent" for name in settings.fitted]].abs()
    agreeing = last[(errors <= 100 * TOLERANCE).all(axis=1)].sort_values("misfit", kind="stable")
    shapes = agreeing.drop_duplicates(jar)
    order = farthest(places_of(shapes)) if len(shapes) else []
    chosen = shapes.iloc[order][jar].assign(jar=range(1, len(shapes) + 1))
    return chosen.merge(agreeing, on=jar)[COLUMNS]


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
    common = {"mill": mill, "contact": settings.contact}
    common |= {name: getattr(settings, name) for name in ("time_step_s", "closure_max", "settle_s")}
    return [
        Case(
            **common,
            ball_diameter_m=diameter / 1e3,
            fill_ratio=fill,
            speed_hz=speed / 60,
            seed=0,
            discard_s=settings.discard_revolutions * 60.0 / speed,
            window_s=revolutions * 60.0 / speed,
        )
        for (diameter, revolutions), (fill, speed) in itertools.product(whole.revolutions, places)
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
