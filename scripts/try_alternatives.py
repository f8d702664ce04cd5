"""What the averaged process is compared with: other libraries, yields that were shuffled, other ways to search.

The search: how many runs it takes to find the best run, and what its runs teach of others.

Settings: yields.training, yields.evaluation, yields.averaging, yields.library_trial, yields.retrospective.
Inputs: `train` and `test`.
Outputs: `libraries`; or `permutations` and `permutation_test`; or `retrospective`, `summary`, `learning`.
"""

from collections.abc import Sequence

import numpy as np
import pandas as pd
from threadpoolctl import threadpool_limits

from millprint.config.averaged_process import AveragingConfig
from millprint.config.yields import HeldOutConfig, LibraryTrialConfig, RetrospectiveConfig, TrainingConfig
from millprint.run.files import write_table
from millprint.run.job import job
from millprint.run.progress import progress
from millprint.thesis.doe.runs import YIELD
from millprint.thesis.yields.evaluation import WHOLE
from millprint.thesis.yields.held_out import outer_folds
from millprint.thesis.yields.library_trials import compare_libraries, permutation_p, permute
from millprint.thesis.yields.metrics import YieldWeights
from millprint.thesis.yields.retrospective import (
    CHOICES,
    STRATEGIES,
    draw_held_out,
    draw_starts,
    learn,
    learning_table,
    search_best,
    search_table,
    smaller_library,
    summarise_search,
    without_best,
)
from millprint.thesis.yields.run_tables import read_rows


def try_libraries(
    train: str,
    test: str,
    libraries_path: str,
    training: TrainingConfig,
    budget: HeldOutConfig,
    averaging: AveragingConfig,
    trial: LibraryTrialConfig,
) -> None:
    """Write scores of the library, of the one before it and of random halves of both."""
    parts = [read_rows(train).assign(role="train"), read_rows(test).assign(role="test")]
    rows = pd.concat(parts, ignore_index=True)
    folds = [fold for fold in outer_folds(rows, budget) if fold.scheme in WHOLE]
    with threadpool_limits(1), progress(len(folds), "comparing libraries", "fold") as bar:
        table = compare_libraries(rows, folds, averaging, trial, YieldWeights.of(training), bar.update)
    write_table(table, libraries_path)


def try_shuffles(parts: Sequence[str], output, averaging: AveragingConfig, trial: LibraryTrialConfig) -> None:
    """Write the score of every shuffle of the yields, and the p-value: could chance score as well?"""
    rows = pd.concat([read_rows(path) for path in parts], ignore_index=True)
    with threadpool_limits(1), progress(trial.permutations + 1, "permuting yields", "shuffle") as bar:
        table = permute(rows, averaging, trial, bar.update)
    write_table(table, output.permutations)
    write_table(permutation_p(table), output.permutation_test)


def search(parts: list[str], output, plan: RetrospectiveConfig, averaging: AveragingConfig, level: float) -> None:
    """Write how many runs each strategy needs to find the best one, and the error of the runs held out."""
    every = pd.concat([read_rows(path) for path in parts], ignore_index=True)
    library = smaller_library(averaging, plan)
    tables, paths, targets = [], [], []
    held_out = draw_held_out(len(every), plan)
    errors: dict[str, np.ndarray] = {}
    total = (plan.targets * len(STRATEGIES) + len(CHOICES)) * plan.starts
    with threadpool_limits(1), progress(total, "searching retrospectively", "start") as bar:
        for count in range(plan.targets):
            rows = without_best(every, count)
            yields = rows[YIELD].to_numpy(float)
            reached: dict[str, list] = {name: [] for name in STRATEGIES}
            for name, strategy in STRATEGIES.items():
                for number, start in enumerate(draw_starts(yields, plan)):
                    reached[name].append(search_best(rows, start, strategy, library, plan.seed + number))
                    bar.update()
            target = str(rows["case"].iloc[int(yields.argmax())])
            table = search_table(reached, yields, plan.start_runs, level)
            table.insert(0, "target", target)
            tables.append(table)
            paths.append(reached)
            targets.append(target)
        for name, choice in CHOICES.items():
            paths_of = []
            for number, (start, held) in enumerate(held_out):
                paths_of.append(learn(every, start, held, choice, library, plan.chosen_runs, plan.seed + number))
                bar.update()
            errors[name] = np.array(paths_of)
    write_table(pd.concat(tables, ignore_index=True), output.retrospective)
    write_table(summarise_search(tables, paths, targets, level), output.summary)
    write_table(learning_table(errors, plan.start_runs, level), output.learning)


if "snakemake" in globals():
    made, own = snakemake.output, snakemake.params
    parts, averaging = (snakemake.input.train, snakemake.input.test), AveragingConfig(**own.averaging)
    with job(snakemake.log[0], "try alternatives") as log:
        if made.get("retrospective"):
            search(parts, made, RetrospectiveConfig(**own.settings), averaging, own.level)
        elif made.get("libraries"):
            training, budget = TrainingConfig(**own.training), HeldOutConfig(**own.evaluation)
            trial = LibraryTrialConfig(**own.trial)
            try_libraries(*parts, made.libraries, training, budget, averaging, trial)
        else:
            try_shuffles(parts, made, averaging, LibraryTrialConfig(**own.trial))
