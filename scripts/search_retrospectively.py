"""How many runs the search for the next experiment needs to find the best run, compared with random choice."""

import pandas as pd
from threadpoolctl import threadpool_limits

from millprint.config.averaging import AveragingConfig
from millprint.config.proposals import RetrospectiveConfig
from millprint.doe.runs import YIELD
from millprint.files import write_table
from millprint.job import job, progress
from millprint.predict.retrospective import (
    MERITS,
    draw_starts,
    search_best,
    search_table,
    smaller_library,
    summarise_search,
)
from millprint.predict.tables import read_rows


def main(parts: list[str], output, plan: RetrospectiveConfig, averaging: AveragingConfig, level: float) -> None:
    """Write the fraction of starts that have found the best run after each number of runs, and the mean number."""
    rows = pd.concat([read_rows(path) for path in parts], ignore_index=True)
    yields = rows[YIELD].to_numpy(float)
    library, starts = smaller_library(averaging, plan), draw_starts(yields, plan)
    reached: dict[str, list] = {name: [] for name in MERITS}
    with threadpool_limits(1), progress(len(MERITS) * len(starts), "searching retrospectively", "start") as bar:
        for name, merit in MERITS.items():
            for start in starts:
                reached[name].append(search_best(rows, start, merit, library))
                bar.update()
    table = search_table(reached, yields, plan.start_runs, level)
    write_table(table, output.retrospective)
    write_table(summarise_search(table, reached, level), output.summary)


if "snakemake" in globals():
    with job(snakemake.log[0], "search retrospectively"):
        main(
            [snakemake.input.train, snakemake.input.test],
            snakemake.output,
            RetrospectiveConfig(**snakemake.params.settings),
            AveragingConfig(**snakemake.params.averaging),
            snakemake.params.level,
        )
