"""Proposals of the next experiments: repeats, a centre point, runs for a higher yield and for a better model.

A test of the proposals on the runs that were done: how soon the best of them is found.
"""

from collections.abc import Callable, Sequence

import numpy as np
import pandas as pd
from sklearn.base import RegressorMixin
from sklearn.linear_model import LinearRegression, RidgeCV
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import StandardScaler

from millprint.config.doe import ChemistryConfig
from millprint.config.errors import ConfigError
from millprint.config.yields import AveragingConfig, PredictionConfig, ProposalConfig, RetrospectiveConfig
from millprint.estimate.estimates import mean_of
from millprint.thesis.doe.factorial_designs import YIELD
from millprint.thesis.yields.averaging import LINKS, NODE_WEIGHTS, NODES, AveragedModel, fit_averaged
from millprint.thesis.yields.experiments import (
    HYDROGEN,
    POWDER,
    PRESSURE,
    PROPOSED,
    SETTINGS,
    STATUS,
    Mill,
    next_cases,
    safety_warnings,
    with_hydrogen,
)
from millprint.thesis.yields.features import CHEMICAL, CONDITIONS, TIME, describe
from millprint.thesis.yields.new_conditions import DESCRIPTORS, MillCurves, domain_warnings

# Added to a covariance before it is factorised, in units of its largest variance.
JITTER = 1e-8
# Step in the link of the central difference that gives the slope of its inverse.
SLOPE_STEP = 1e-4


def expected_improvement(model: AveragedModel, rows: pd.DataFrame, best: float) -> np.ndarray:
    """Expected improvement E[max(yield - best, 0)], (n,) [pp], of one measurement at each row.

    rows: n rows with the six conditions; best: the highest yield so far [%].
    """
    inputs, total = describe(rows).to_numpy(), np.zeros(len(rows))
    for member, weight in zip(model.members, model.weights, strict=True):
        mean, deviation = member.latent(inputs)
        yields = 100 * LINKS[member.candidate.link].inverse(mean[:, None] + deviation[:, None] * NODES)
        total += weight * (np.maximum(np.clip(yields, 0, 100) - best, 0) @ NODE_WEIGHTS)
    return total


def joint_draws(model: AveragedModel, rows: pd.DataFrame, draws: int, generator: np.random.Generator) -> np.ndarray:
    """Joint draws of the yields without noise, (s, n) [%], with s about `draws`; each member gives its share of them.

    rows: n rows with the six conditions. Raises LinAlgError for a covariance that is not positive definite.
    """
    inputs, found = describe(rows).to_numpy(), []
    for member, weight in zip(model.members, model.weights, strict=True):
        count = round(weight * draws)
        mean, covariance = member.process.posterior(member.standard(inputs))
        covariance = covariance + JITTER * covariance.diagonal().max() * np.eye(len(rows))
        latent = mean + generator.standard_normal((count, len(rows))) @ np.linalg.cholesky(covariance).T
        found.append(100 * LINKS[member.candidate.link].inverse(member.mean + member.spread * latent))
    return np.clip(np.concatenate(found), 0, 100)


def choose_for_yield(
    draws: np.ndarray, best: float, runs: int, waiting: np.ndarray | None = None, smallest: float = 0.0
) -> list[tuple[int, float]]:
    """The batch of the largest joint expected improvement, chosen one by one: (column, gain [pp]) in order.

    draws: (s, n) joint draws [%]; best: highest yield so far [%]. The improvement of a batch is that of its best run:
    the mean of max(best, y_1, ..., y_q) - best over the draws (Ginsbourger et al. 2010). A run close to one that is
    already chosen therefore adds little. The gain of a run is what it adds to the runs chosen before it, and to those
    whose yields are awaited: waiting, (s, m), has their joint draws [%]. A run that adds less than `smallest` [pp] ends
    the batch.
    """
    reached = np.full(len(draws), best)
    if waiting is not None and waiting.shape[1]:
        reached = np.maximum(reached, waiting.max(axis=1))
    chosen: list[tuple[int, float]] = []
    for _ in range(min(runs, draws.shape[1])):
        gains = np.maximum(draws - reached[:, None], 0).mean(axis=0)
        gains[[column for column, _ in chosen]] = -1.0
        column = int(gains.argmax())
        if gains[column] < smallest:
            break
        chosen.append((column, float(gains[column])))
        reached = np.maximum(reached, draws[:, column])
    return chosen


def choose_for_learning(
    model: AveragedModel,
    rows: pd.DataFrame,
    reference: np.ndarray,
    runs: int,
    given: np.ndarray | None = None,
    candidates: np.ndarray | None = None,
) -> list[tuple[int, float]]:
    """The batch that reduces the integrated variance most, chosen one by one: (position, share of the variance).

    rows: n rows with the six conditions; reference: positions (m,) of the rows over which the variance of the yield is
    summed. A measurement at row j lowers the variance at row r by cov(r, j)^2 / (var(j) + noise), whatever its result.
    So each run is chosen as if those before it were done, and the rows at the positions `given`, whose yields are
    awaited. candidates: positions that may be chosen; None for all. A bounded link is replaced by its tangent at the
    mean. A share is of the variance before anything is done.
    """
    inputs = describe(rows).to_numpy()
    states: list[tuple[np.ndarray, float]] = []
    weights, total = [], 0.0
    for member, weight in zip(model.members, model.weights, strict=True):
        mean, covariance = member.process.posterior(member.standard(inputs))
        inverse, latent = LINKS[member.candidate.link].inverse, member.mean + member.spread * mean
        slope = (inverse(latent + SLOPE_STEP) - inverse(latent - SLOPE_STEP)) / (2 * SLOPE_STEP)
        scale = weight * (100 * member.spread * slope[reference]) ** 2
        total += float(scale @ covariance.diagonal()[reference])
        states.append((covariance, member.process.noise))
        weights.append(scale)
    for position in [] if given is None else given:
        states = [(_measured(covariance, noise, int(position)), noise) for covariance, noise in states]
    offered = np.arange(len(rows)) if candidates is None else candidates
    barred = np.ones(len(rows), dtype=bool)
    barred[offered] = False
    chosen: list[tuple[int, float]] = []
    for _ in range(min(runs, len(offered))):
        gains = np.zeros(len(rows))
        for (covariance, noise), scale in zip(states, weights, strict=True):
            gains += scale @ covariance[reference] ** 2 / (covariance.diagonal() + noise)
        gains[barred] = -1.0
        best = int(gains.argmax())
        chosen.append((best, float(gains[best] / total)))
        barred[best] = True
        states = [(_measured(covariance, noise, best), noise) for covariance, noise in states]
    return chosen


def _measured(covariance: np.ndarray, noise: float, position: int) -> np.ndarray:
    """The covariance (n, n) after a measurement at one position, whatever its result."""
    column = covariance[:, position]
    return covariance - np.outer(column, column) / (covariance[position, position] + noise)


FOR_YIELD, FOR_LEARNING, REPEAT, CENTRE = "yield", "learning", "repeat", "centre"
GAIN_UNITS = {
    FOR_YIELD: "pp",
    FOR_LEARNING: "share of variance",
    REPEAT: "degrees of freedom of pure error",
    CENTRE: "share of variance",
}
LEFT_OUT_COLUMNS = [*SETTINGS, POWDER, HYDROGEN, PRESSURE, "reason"]


def shortlist(merit: np.ndarray, size: int, generator: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Positions (size,) of the conditions to compare, and the positions among them of the random half.

    merit: (n,). Half of the conditions have the largest merit. The other half is drawn at random from the rest, to
    represent the whole region. There are fewer if n is below `size`.
    """
    order = np.argsort(-merit, kind="stable")
    best = order[: (size + 1) // 2]
    rest = order[len(best) :]
    drawn = generator.choice(rest, min(size - len(best), len(rest)), replace=False)
    chosen = np.concatenate([best, drawn])
    random_half = np.arange(len(best), len(chosen))
    return chosen, random_half if len(random_half) else np.arange(len(chosen))


def split_region(
    model: AveragedModel,
    known: pd.DataFrame,
    conditions: pd.DataFrame,
    settings: ProposalConfig,
    limits: PredictionConfig,
    reaction: ChemistryConfig,
    mill: Mill,
    curves: MillCurves,
) -> tuple[pd.DataFrame, pd.DataFrame]:
    """The conditions that may be proposed, and those that may not, each with its reason.

    A condition is left out if it breaks a limit of the region (`safety_warnings`) or if `predict` would refuse it
    (`domain_warnings`). known: the rows that the model was trained on; conditions: what region_conditions returns. Both
    tables have the amount and the pressure of the hydrogen. Raises ConfigError if nothing is left.
    """
    rows = with_hydrogen(conditions, settings.region, reaction, mill.volume)
    safe = safety_warnings(rows, settings.region)
    asked = domain_warnings(model, known, rows, limits, curves)
    reasons = pd.Series(["; ".join(filter(None, texts)) for texts in zip(safe, asked, strict=True)], index=rows.index)
    kept = (reasons == "").to_numpy()
    left_out = rows[~kept].assign(reason=reasons[~kept])[LEFT_OUT_COLUMNS].reset_index(drop=True)
    if not kept.any():
        first = count_reasons(left_out, len(rows)).iloc[0]
        raise ConfigError(
            f"yields.proposals.region: none of its {len(rows)} conditions may be proposed; {first['conditions']} of "
            f"them because of {first['reason']}, for example {first['example']}"
        )
    return rows[kept].reset_index(drop=True), left_out


def count_reasons(left_out: pd.DataFrame, conditions: int) -> pd.DataFrame:
    """How many of the `conditions` of a region each reason leaves out: reason, conditions, of, example; most first."""
    parts = left_out["reason"].str.split("; ").explode()
    # The value in a reason differs between conditions, its name does not.
    names = parts.str.split(" = ").str[0].str.split(":").str[0]
    groups = parts.groupby(names, sort=False)
    table = groups.agg(conditions="size", example="first").rename_axis("reason").reset_index()
    table.insert(2, "of", conditions)
    return table.sort_values("conditions", ascending=False, kind="stable", ignore_index=True)


def same_setting(rows: pd.DataFrame, others: pd.DataFrame, tolerance: float) -> np.ndarray:
    """Position (n,) in `others` of the setting that each of n rows was run at; -1 where there is none.

    The chemical conditions must be equal, and each descriptor within a factor of 1 + tolerance, as the printed ones of
    the screening are rounded; of several settings the one with the nearest descriptors counts.
    """
    found = np.full(len(rows), -1)
    chemical, descriptors = others[list(CHEMICAL)].to_numpy(float), np.log(others[list(DESCRIPTORS)].to_numpy(float))
    for place, (_, row) in enumerate(rows.iterrows()):
        same = np.isclose(chemical, row[list(CHEMICAL)].to_numpy(float), rtol=1e-6).all(axis=1)
        off = np.abs(descriptors - np.log(row[list(DESCRIPTORS)].to_numpy(float))).max(axis=1)
        off[~same] = np.inf
        if len(off) and off.min() <= np.log1p(tolerance):
            found[place] = int(off.argmin())
    return found


def choose_repeats(
    known: pd.DataFrame, rows: pd.DataFrame, running: pd.DataFrame, count: int, tolerance: float
) -> list[tuple[int, str]]:
    """Runs to repeat, (position in `rows`, case), for the scatter of repeated runs.

    The run of the highest yield comes first, since the highest of many measured yields is more often too high than too
    low; then always the run whose yield is farthest from those already chosen, since the scatter may depend on the
    yield. Runs that were repeated, or are being repeated, are left out. rows: the conditions that may be proposed.
    """
    places = same_setting(known, rows, tolerance)
    again = same_setting(running, rows, tolerance)
    often = np.bincount(places[places >= 0], minlength=len(rows))
    free = [run for run, place in enumerate(places) if place >= 0 and often[place] == 1 and place not in set(again)]
    yields = known[YIELD].to_numpy(float)
    chosen: list[int] = []
    while free and len(chosen) < count:
        if not chosen:
            best = max(free, key=lambda run: yields[run])
        else:
            best = max(free, key=lambda run: min(abs(yields[run] - yields[other]) for other in chosen))
        chosen.append(best)
        free.remove(best)
    return [(int(places[run]), str(known["case"].iloc[run])) for run in chosen]


def choose_centre(known: pd.DataFrame, rows: pd.DataFrame) -> int:
    """Position in `rows` of the condition nearest to the mean of the runs, in standard deviations of their inputs."""
    inputs, others = describe(known), describe(rows)
    spread = inputs.std(ddof=0).where(lambda each: each > 0, 1.0)
    return int((((others - inputs.mean()) / spread) ** 2).sum(axis=1).to_numpy().argmin())


def propose(
    model: AveragedModel,
    known: pd.DataFrame,
    conditions: pd.DataFrame,
    settings: ProposalConfig,
    running: pd.DataFrame | None = None,
    tolerance: float = 0.03,
    taken: list[str] | None = None,
) -> pd.DataFrame:
    """The next runs, proposed as one batch.

    known: the rows that the model was trained on; conditions: those that may be proposed; running: experiments whose
    yields are not known yet, with the six conditions; tolerance: of `same_setting`; taken: cases of other experiments.
    First come repeats and centre points. Runs for a higher yield are chosen by their joint expected improvement over
    what is known, running and repeated, whose unknown yields are drawn from the model together with theirs; runs for a
    better model by how much variance they remove in addition to all of these. Runs that would add less than the
    smallest gain of the settings are left out; a slot that is not needed for a higher yield goes to learning.

    Columns: case, status, purpose, rank, the settings, balls, powder_mass_g, hydrogen_mmol, hydrogen_pressure_bar,
    descriptors, predicted_percent, lower_percent, upper_percent, expected_improvement_pp (of the single run), gain and
    gain_unit (what the run adds to those ranked before it), repeats (the case that is done again), yield_percent
    (empty: for your result).
    """
    generator = np.random.default_rng(settings.seed)
    columns = list(CONDITIONS)
    running = conditions.iloc[:0] if running is None else running
    best = float(known[YIELD].max())
    repeats = choose_repeats(known, conditions, running, settings.replicates, tolerance)
    picked: list[tuple[int, str, float, str]] = [(position, REPEAT, 1.0, case) for position, case in repeats]
    centre = choose_centre(known, conditions)
    merit = expected_improvement(model, conditions, best)
    chosen, random_half = shortlist(merit, settings.shortlist, generator)

    def waiting() -> pd.DataFrame:
        """The six conditions of everything whose yield is not known yet."""
        return pd.concat([running[columns], conditions.iloc[[each[0] for each in picked]][columns]], ignore_index=True)

    def learn(candidates: np.ndarray, count: int) -> list[tuple[int, float]]:
        """Positions among the conditions, and the share of the variance that each removes after what is waiting."""
        given = waiting()
        rows = pd.concat([conditions.iloc[chosen][columns], conditions.iloc[candidates][columns], given])
        first = len(chosen) + len(candidates)
        offered = np.arange(len(chosen), first)
        batch = choose_for_learning(
            model, rows, random_half, count, given=np.arange(first, len(rows)), candidates=offered
        )
        return [(int(candidates[place - len(chosen)]), gain) for place, gain in batch]

    for _ in range(settings.centre_points):
        ((position, gain),) = learn(np.array([centre]), 1)
        picked.append((position, CENTRE, gain, ""))
    given = waiting()
    draws = joint_draws(
        model, pd.concat([conditions.iloc[chosen][columns], given], ignore_index=True), settings.draws, generator
    )
    batch = choose_for_yield(
        draws[:, : len(chosen)],
        best,
        settings.runs,
        waiting=draws[:, len(chosen) :],
        smallest=settings.smallest_gain_pp,
    )
    picked += [(int(chosen[place]), FOR_YIELD, gain, "") for place, gain in batch]
    batch = learn(chosen, 2 * settings.runs - len(batch))
    picked += [(place, FOR_LEARNING, gain, "") for place, gain in batch if gain >= settings.smallest_share]

    purposes = [purpose for _, purpose, _, _ in picked]
    table = conditions.iloc[[position for position, _, _, _ in picked]].drop(columns="case").reset_index(drop=True)
    lower, upper = model.intervals(table, [settings.level])[:, 0].T
    table = table.assign(
        predicted_percent=model.predict(table),
        lower_percent=lower,
        upper_percent=upper,
        expected_improvement_pp=expected_improvement(model, table, best),
        gain=[gain for _, _, gain, _ in picked],
        gain_unit=[GAIN_UNITS[purpose] for purpose in purposes],
        repeats=[case for _, _, _, case in picked],
        yield_percent=np.nan,
    )
    table.insert(0, "case", next_cases(len(table), [*known["case"].astype(str), *(taken or [])]))
    table.insert(1, STATUS, PROPOSED)
    table.insert(2, "purpose", purposes)
    table.insert(3, "rank", table.groupby("purpose", sort=False).cumcount() + 1)
    return table


IMPROVEMENT, GREEDY, CHANCE = "expected_improvement", "highest_mean", "random"
LEAST_SQUARES, RIDGE, RULE = "least_squares", "ridge", "most_balls_longest_time"
# Penalties that ridge regression chooses from by leave-one-out, for standardised inputs.
PENALTIES = np.logspace(-2, 2, 9)
# The rows of the summary over every target.
ALL_TARGETS = "all"
# Known runs, their yields [%], the runs to choose from, the library, and random numbers for ties: the merit of each.
Strategy = Callable[[pd.DataFrame, np.ndarray, pd.DataFrame, AveragingConfig, np.random.Generator], np.ndarray]


def _averaged(merit: Callable[[AveragedModel, pd.DataFrame, float], np.ndarray]) -> Strategy:
    """By a merit of the averaged process of the known runs."""
    return lambda known, yields, left, library, _: merit(fit_averaged(known, yields, library), left, yields.max())


def _linear(make: Callable[[], RegressorMixin]) -> Strategy:
    """By the prediction of a linear model in the standardised inputs of the averaged process."""

    def merit(
        known: pd.DataFrame, yields: np.ndarray, left: pd.DataFrame, _: AveragingConfig, __: np.random.Generator
    ) -> np.ndarray:
        return make_pipeline(StandardScaler(), make()).fit(describe(known), yields).predict(describe(left))

    return merit


def rule_merit(left: pd.DataFrame, generator: np.random.Generator) -> np.ndarray:
    """The rank by ball-to-powder ratio, then by milling time; what is equal in both is in random order."""
    order = np.lexsort((generator.random(len(left)), left[TIME], left["bpr"]))
    return np.argsort(order)


STRATEGIES: dict[str, Strategy] = {
    IMPROVEMENT: _averaged(expected_improvement),
    GREEDY: _averaged(lambda model, rows, best: model.predict(rows)),
    LEAST_SQUARES: _linear(LinearRegression),
    RIDGE: _linear(lambda: RidgeCV(PENALTIES)),
    RULE: lambda known, yields, left, library, generator: rule_merit(left, generator),
}


def smaller_library(averaging: AveragingConfig, settings: RetrospectiveConfig) -> AveragingConfig:
    """The library with only the links and structures of the test, to save time: every step fits the library again."""
    return averaging.model_copy(update={"links": settings.links, "structures": [*settings.structures]})


def without_best(rows: pd.DataFrame, count: int) -> pd.DataFrame:
    """The rows without the `count` runs of the highest yields, so that the best of the others becomes the target."""
    kept = rows[YIELD].sort_values(ascending=False, kind="stable").index[count:]
    return rows.loc[rows.index.isin(kept)].reset_index(drop=True)


def draw_starts(yields: np.ndarray, settings: RetrospectiveConfig) -> list[np.ndarray]:
    """Positions (start_runs,) of the runs known at each start, never with a run of the highest yield.

    yields: (n,) [%]. Raises ValueError if there are too few other runs.
    """
    generator, others = np.random.default_rng(settings.seed), np.flatnonzero(yields < yields.max())
    return [generator.choice(others, settings.start_runs, replace=False) for _ in range(settings.starts)]


def search_best(
    rows: pd.DataFrame, start: np.ndarray, strategy: Strategy, averaging: AveragingConfig, seed: int = 0
) -> np.ndarray:
    """Best yield known after each run, (runs,) [%], from the start until the best run of all is found.

    rows: the six conditions and yield_percent. At each step the run with the largest merit among the others becomes
    known; the merit sees the yields of known runs only. start: positions of the runs known at first; seed: of ties.
    """
    yields, generator = rows[YIELD].to_numpy(float), np.random.default_rng(seed)
    known, reached = list(start), [float(yields[start].max())]
    while reached[-1] < yields.max():
        left = np.setdiff1d(np.arange(len(rows)), known)
        merit = strategy(rows.iloc[known], yields[known], rows.iloc[left], averaging, generator)
        known.append(int(left[merit.argmax()]))
        reached.append(max(reached[-1], yields[known[-1]]))
    return np.array(reached)


def chance(count: int, start_runs: int, best: int) -> np.ndarray:
    """Probability that the first n of `count` runs in random order include one of the `best` best runs.

    An array for n = start_runs .. count. None of the best is among the first `start_runs`: 1 - C(left - best, k) /
    C(left, k) for k further runs of `left`.
    """
    left = count - start_runs
    missed = [1.0]
    for done in range(left):
        missed.append(missed[-1] * max(left - best - done, 0) / (left - done))
    return 1 - np.array(missed)


def search_table(
    reached: dict[str, list[np.ndarray]], yields: np.ndarray, start_runs: int, level: float
) -> pd.DataFrame:
    """Share of starts that have found the best run after n runs: strategy, runs, found, lower, upper, best_percent.

    The interval is Clopper and Pearson's over starts; that of chance is exact and has no width. best_percent is the
    mean of the best yield known; it is NaN for chance.
    """
    from statsmodels.stats.proportion import proportion_confint

    runs = np.arange(start_runs, len(yields) + 1)
    tables = []
    for strategy, paths in reached.items():
        known = np.array([np.pad(path, (0, len(runs) - len(path)), mode="edge") for path in paths])
        hits, starts = (known >= yields.max()).sum(axis=0), len(paths)
        lower, upper = proportion_confint(hits, starts, alpha=1 - level, method="beta")
        columns = {"found": hits / starts, "lower": lower, "upper": upper, "best_percent": known.mean(axis=0)}
        tables.append(pd.DataFrame({"strategy": strategy, "runs": runs, **columns}))
    exact = chance(len(yields), start_runs, int((yields == yields.max()).sum()))
    columns = {"found": exact, "lower": exact, "upper": exact, "best_percent": np.nan}
    tables.append(pd.DataFrame({"strategy": CHANCE, "runs": runs, **columns}))
    return pd.concat(tables, ignore_index=True)


def _columns(values: np.ndarray, level: float, names: Sequence[str]) -> dict[str, float]:
    """The mean and the ends of Student's interval by column; the ends are NaN for one value."""
    found = mean_of(values, "-", level)
    return dict(zip(names, (found.value, *found.ends("repeats")), strict=True))


MEAN_RUNS, FEWER = ("mean_runs", "lower", "upper"), ("fewer_than_search", "fewer_lower", "fewer_upper")


def summarise_search(
    tables: list[pd.DataFrame], reached: list[dict[str, list[np.ndarray]]], targets: list[str], level: float
) -> pd.DataFrame:
    """Runs to the best, start included, for every target, and over all of them.

    tables, reached: of each target, as search_table returns and takes them; targets: the case of each. Columns: target,
    strategy, mean_runs, lower, upper, median_runs, starts, and fewer_than_search: the mean of the runs that expected
    improvement takes less those of the strategy, from the same starts, with fewer_lower and fewer_upper, and
    conclusion. The intervals of one target are Student's over starts: they say what another start would change, not
    what another best run would. Those of the last rows, for the target `all`, are over targets, each a mean over its
    starts: they say whether the order of the strategies would hold for other best runs.
    """
    counts: list[dict[str, np.ndarray]] = []
    rows = []
    for table, paths, target in zip(tables, reached, targets, strict=True):
        first = int(table["runs"].iloc[0])
        own = {name: np.array([first + len(path) - 1 for path in each], dtype=float) for name, each in paths.items()}
        # E[N] = sum over n of P(N > n).
        exact = first + float((1 - table.loc[table["strategy"] == CHANCE, "found"]).sum())
        counts.append(own | {CHANCE: np.full(len(own[IMPROVEMENT]), exact)})
        for strategy, found in counts[-1].items():
            part = table[table["strategy"] == strategy]
            rows.append(
                {"target": target, "strategy": strategy}
                | _columns(found, level, MEAN_RUNS)
                | {"median_runs": part.loc[part["found"] >= 0.5, "runs"].iloc[0], "starts": len(found)}
                | _against_search(counts[-1][IMPROVEMENT] - found, level, "starts")
            )
    for strategy in counts[0]:
        means = np.array([own[strategy].mean() for own in counts])
        search = np.array([own[IMPROVEMENT].mean() for own in counts])
        rows.append(
            {"target": ALL_TARGETS, "strategy": strategy}
            | _columns(means, level, MEAN_RUNS)
            | {"starts": len(means) * len(counts[0][strategy])}
            | _against_search(search - means, level, "targets")
        )
    summary = pd.DataFrame(rows)
    summary.loc[summary["strategy"] == IMPROVEMENT, list(FEWER)] = np.nan
    summary.loc[summary["strategy"] == IMPROVEMENT, "conclusion"] = ""
    return summary


def _against_search(fewer: np.ndarray, level: float, over: str) -> dict[str, float | str]:
    """The paired differences, their mean and interval, and what follows in words."""
    found = _columns(fewer, level, FEWER)
    _, lower, upper = found.values()
    if lower > 0:
        words = f"needs fewer runs than the search over these {over}"
    elif upper < 0:
        words = f"needs more runs than the search over these {over}"
    else:
        words = f"cannot be told from the search by these {over}"
    return {**found, "conclusion": words}
