"""What the averaged process is worth: could chance score as well, and how many runs does it need to find the best?

Settings: yields.averaging; yields.library_trial, or yields.retrospective and the level of intervals.
Inputs: `train` and `test`.
Outputs: `permutations` and `permutation_test`, of shuffled yields; or `retrospective` and `summary`.
"""

from collections.abc import Sequence

import pandas as pd
from threadpoolctl import threadpool_limits

from millprint.config.yields import AveragingConfig, LibraryTrialConfig, RetrospectiveConfig
from millprint.run.files import write_table
from millprint.run.job import job, progress
from millprint.thesis.doe.factorial_designs import YIELD
from millprint.thesis.yields.averaging import permutation_p, permute
from millprint.thesis.yields.experiments import read_rows
from millprint.thesis.yields.proposals import (
    STRATEGIES,
    draw_starts,
    search_best,
    search_table,
    smaller_library,
    summarise_search,
    without_best,
)


def shuffle(parts: Sequence[str], output, averaging: AveragingConfig, trial: LibraryTrialConfig) -> None:
    """Write the score of every shuffle of the yields, and the p-value."""
    rows = pd.concat([read_rows(path) for path in parts], ignore_index=True)
    with threadpool_limits(1), progress(trial.permutations + 1, "permuting yields", "shuffle") as bar:
        table = permute(rows, averaging, trial, bar.update)
    write_table(table, output.permutations)
    write_table(permutation_p(table), output.permutation_test)


def search(parts: list[str], output, plan: RetrospectiveConfig, averaging: AveragingConfig, level: float) -> None:
    """Write how many runs each strategy needs to find the best one."""
    every = pd.concat([read_rows(path) for path in parts], ignore_index=True)
    library = smaller_library(averaging, plan)
    tables, paths, targets = [], [], []
    total = plan.targets * len(STRATEGIES) * plan.starts
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
    write_table(pd.concat(tables, ignore_index=True), output.retrospective)
    write_table(summarise_search(tables, paths, targets, level), output.summary)


if "snakemake" in globals():
    own, made = snakemake.params, snakemake.output
    parts, averaging = [snakemake.input.train, snakemake.input.test], AveragingConfig(**own.averaging)
    with job(snakemake.log[0], "try the averaged model"):
        if made.get("permutations"):
            shuffle(parts, made, averaging, LibraryTrialConfig(**own.trial))
        else:
            search(parts, made, RetrospectiveConfig(**own.settings), averaging, own.level)
