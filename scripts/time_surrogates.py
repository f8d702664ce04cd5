"""Times roll-outs of trained surrogates, and our simulation of the same cases.

Settings: surrogate.timing, and the edges and roll-out of each variant.
Inputs: `weights`, `trained` and `runs` (run.h5).
Outputs: `runtime`.
"""

import pandas as pd

from millprint.config.surrogate import EdgeConfig, TimingConfig
from millprint.run.files import write_table
from millprint.run.job import job
from millprint.thesis.surrogate.compiled import open_graph_surrogate
from millprint.thesis.surrogate.network import choose_device
from millprint.thesis.surrogate.rollout import Setting
from millprint.thesis.surrogate.scene import read_scene
from millprint.thesis.surrogate.timing import scaled_thresholds, simulation_seconds, time_rollouts


def main(
    weights: str, trained: str, runs: list[str], rule: EdgeConfig, snap_back_m: float | None, timing: TimingConfig
) -> pd.DataFrame:
    """Rows of one variant, one for each case and batch size."""
    # One thread, as for the simulation.
    device = choose_device(threads=1)
    trained_m, tables = read_scene(trained).ball_radius_m, []
    for run in runs:
        own = scaled_thresholds(rule, snap_back_m, read_scene(run).ball_radius_m, trained_m)
        surrogate = open_graph_surrogate(Setting(weights, run, *own, device, until_s=timing.start_s + 0.01))
        machine = "one thread" if device.type == "cpu" else device.type
        table = time_rollouts(surrogate, timing.start_s, timing.batches, timing.steps, machine)
        table["dem_seconds_for_15_s"] = simulation_seconds(run, timing.dem_s)
        tables.append(table)
    table = pd.concat(tables, ignore_index=True)
    table["dem_over_surrogate"] = table["dem_seconds_for_15_s"] / table["seconds_per_trajectory"]
    return table


if "snakemake" in globals():
    with job(snakemake.log[0], "time the surrogates") as log:
        tables = []
        for (variant, own), weights in zip(snakemake.params.variants.items(), snakemake.input.weights, strict=True):
            table = main(
                weights,
                snakemake.input.trained,
                list(snakemake.input.runs),
                EdgeConfig(**own["edges"]),
                own["snap_back_m"],
                TimingConfig(**snakemake.params.timing),
            )
            table.insert(0, "variant", variant)
            tables.append(table)
            log.info("timed: %s", variant)
        write_table(pd.concat(tables, ignore_index=True), snakemake.output.runtime)
