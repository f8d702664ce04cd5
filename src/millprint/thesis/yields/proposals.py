"""Proposals of the next experiments: repeats, a centre point, runs for a higher yield and for a better model."""

import numpy as np
import pandas as pd

from millprint.config.doe import ChemistryConfig
from millprint.config.errors import ConfigError
from millprint.config.yields import PredictionConfig, ProposalConfig
from millprint.thesis.doe.factorial_designs import YIELD
from millprint.thesis.yields.averaging import LINKS, NODE_WEIGHTS, NODES, AveragedModel
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
from millprint.thesis.yields.features import CHEMICAL, CONDITIONS, describe
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
    running: pd.DataFrame,
    tolerance: float,
    taken: list[str],
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
    table.insert(0, "case", next_cases(len(table), [*known["case"].astype(str), *taken]))
    table.insert(1, STATUS, PROPOSED)
    table.insert(2, "purpose", purposes)
    table.insert(3, "rank", table.groupby("purpose", sort=False).cumcount() + 1)
    return table
