"""How many runs the search for the next experiment needs to find the best run.

Settings: yields.retrospective, yields.averaging, yields.evaluation.level.
Inputs: `train` and `test`.
Outputs: `retrospective`, `summary`.
"""

import pandas as pd
from threadpoolctl import threadpool_limits

from millprint.config.yields import AveragingConfig, RetrospectiveConfig
from millprint.run.files import write_table
from millprint.run.job import job, progress
from millprint.thesis.doe.factorial_designs import YIELD
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


def main(parts: list[str], output, plan: RetrospectiveConfig, averaging: AveragingConfig, level: float) -> None:
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
    with job(snakemake.log[0], "search retrospectively"):
        main(
            [snakemake.input.train, snakemake.input.test],
            snakemake.output,
            RetrospectiveConfig(**snakemake.params.settings),
            AveragingConfig(**snakemake.params.averaging),
            snakemake.params.level,
        )
