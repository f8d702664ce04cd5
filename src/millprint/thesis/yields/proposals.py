"""Proposals of the next experiments: repeats, a centre point, runs for a higher yield and for a better model."""

import numpy as np
import pandas as pd

from millprint.config.doe import ChemistryConfig
from millprint.config.errors import ConfigError
from millprint.config.next_experiments import PredictionConfig, ProposalConfig
from millprint.thesis.doe.runs import YIELD
from millprint.thesis.yields.acquisition import (
    choose_for_learning,
    choose_for_yield,
    expected_improvement,
    joint_draws,
)
from millprint.thesis.yields.averaging import AveragedModel
from millprint.thesis.yields.domain import DESCRIPTORS, MillCurves
from millprint.thesis.yields.experiments import PROPOSED, STATUS, next_cases
from millprint.thesis.yields.features import CHEMICAL, CONDITIONS, describe
from millprint.thesis.yields.new_conditions import domain_warnings
from millprint.thesis.yields.region import SETTINGS, Mill
from millprint.thesis.yields.safety import HYDROGEN, POWDER, PRESSURE, safety_warnings, with_hydrogen

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
    lower, upper = model.interval(table, settings.level)
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
