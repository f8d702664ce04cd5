"""Proposals of the next experiments: for a higher yield and for a better model, with their predicted yields."""

import numpy as np
import pandas as pd

from millprint.config.proposals import ProposalConfig
from millprint.doe.runs import YIELD
from millprint.predict.acquisition import (
    choose_for_learning,
    choose_for_yield,
    expected_improvement,
    joint_draws,
)
from millprint.predict.averaging import AveragedModel

FOR_YIELD, FOR_LEARNING = "yield", "learning"


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


def propose(
    model: AveragedModel, known: pd.DataFrame, conditions: pd.DataFrame, settings: ProposalConfig
) -> pd.DataFrame:
    """The next runs for each purpose, proposed as one batch.

    known: the rows that the model was trained on; conditions: what region_conditions returns. Columns: purpose, rank,
    the settings, balls, powder_mass_g, descriptors, predicted_percent, lower_percent, upper_percent,
    expected_improvement_pp (of the run alone), gain and gain_unit: what the run adds to those ranked before it, in
    points of yield or as a share of the integrated variance.
    """
    generator = np.random.default_rng(settings.seed)
    best = float(known[YIELD].max())
    merit = expected_improvement(model, conditions, best)
    chosen, random_half = shortlist(merit, settings.shortlist, generator)
    rows = conditions.iloc[chosen].reset_index(drop=True)
    draws = joint_draws(model, rows, settings.draws, generator)
    batches = {
        FOR_YIELD: (choose_for_yield(draws, best, settings.runs), "pp"),
        FOR_LEARNING: (choose_for_learning(model, rows, random_half, settings.runs), "share of variance"),
    }
    tables = []
    for purpose, (batch, unit) in batches.items():
        table = rows.iloc[[position for position, _ in batch]].reset_index(drop=True)
        lower, upper = model.interval(table, settings.level)
        table = table.drop(columns="case").assign(
            predicted_percent=model.predict(table),
            lower_percent=lower,
            upper_percent=upper,
            expected_improvement_pp=expected_improvement(model, table, best),
            gain=[gain for _, gain in batch],
            gain_unit=unit,
        )
        table.insert(0, "purpose", purpose)
        table.insert(1, "rank", np.arange(1, len(table) + 1))
        tables.append(table)
    return pd.concat(tables, ignore_index=True)
