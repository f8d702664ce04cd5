"""Rolls a trained surrogate out in every test, from the first states of its simulation; or times roll-outs.

Timed are those of all variants, and our simulation of the same cases.

Settings: surrogate.tests, and the edges and roll-out of the variant; or surrogate.timing, and those of each variant.
Inputs: `weights`, and the `runs` (run.h5) that the roll-outs start from; for the timing also `trained`.
Outputs: `rollouts`, one for each test; or `runtime`.
"""

import pandas as pd

from millprint.config.surrogate import EdgeConfig, RollOutConfig, TimingConfig
from millprint.run.files import write_table
from millprint.run.job import job
from millprint.thesis.surrogate.compiled import open_graph_surrogate
from millprint.thesis.surrogate.device import choose_device
from millprint.thesis.surrogate.graph_surrogate import scaled_thresholds, simulation_seconds, time_rollouts
from millprint.thesis.surrogate.rollout import read_scene


def roll_out(weights: str, chosen: dict, rule: EdgeConfig, output: str, threads: int, log) -> None:
    """Write the roll-out in one test. chosen: settings, case with its run, and starts [s], as plain values."""
    settings, starts_s = RollOutConfig(**chosen["settings"]), chosen["starts_s"]
    device, until_s = choose_device(threads), max(starts_s) + 0.01
    surrogate = open_graph_surrogate(weights, chosen["run"], rule, settings.snap_back_m, device, until_s)
    steps, per_frame = (round(time_s / surrogate.step_s) for time_s in (settings.length_s, settings.frame_interval_s))
    rollout = surrogate.roll_out(starts_s, steps, per_frame)
    rollout.write(output, chosen["case"])
    log.info("%d trajectories of %d steps; mean edges per graph: %s", len(starts_s), steps, rollout.mean_edges)


def time_variant(
    weights: str, trained: str, runs: list[str], rule: EdgeConfig, snap_back_m: float | None, timing: TimingConfig
) -> pd.DataFrame:
    """Rows of one variant, one for each case and batch size."""
    # One thread, as for the simulation.
    device = choose_device(threads=1)
    trained_m, tables = read_scene(trained).ball_radius_m, []
    for run in runs:
        own = scaled_thresholds(rule, snap_back_m, read_scene(run).ball_radius_m, trained_m)
        surrogate = open_graph_surrogate(weights, run, *own, device, until_s=timing.start_s + 0.01)
        machine = "one thread" if device.type == "cpu" else device.type
        table = time_rollouts(surrogate, timing.start_s, timing.batches, timing.steps, machine)
        table["dem_seconds_for_15_s"] = simulation_seconds(run, timing.dem_s)
        tables.append(table)
    table = pd.concat(tables, ignore_index=True)
    table["dem_over_surrogate"] = table["dem_seconds_for_15_s"] / table["seconds_per_trajectory"]
    return table


def time_variants(given, own, log) -> pd.DataFrame:
    """Rows of every variant."""
    tables = []
    for (variant, chosen), weights in zip(own.variants.items(), given.weights, strict=True):
        rule, timing = EdgeConfig(**chosen["edges"]), TimingConfig(**own.timing)
        table = time_variant(weights, given.trained, list(given.runs), rule, chosen["snap_back_m"], timing)
        table.insert(0, "variant", variant)
        tables.append(table)
        log.info("timed: %s", variant)
    return pd.concat(tables, ignore_index=True)


if "snakemake" in globals():
    given, made, own = snakemake.input, snakemake.output, snakemake.params
    variant = snakemake.wildcards.get("variant")
    with job(snakemake.log[0], f"roll out {variant or 'every surrogate'}") as log:
        if variant:
            for (test, chosen), output in zip(own.tests.items(), made.rollouts, strict=True):
                log.info("%s, %s", variant, test)
                roll_out(given.weights, chosen, EdgeConfig(**own.edges), output, snakemake.threads, log)
        else:
            write_table(time_variants(given, own, log), made.runtime)
