"""Times roll-outs of a trained surrogate beside our own simulation of the same case."""

from millprint.config.surrogate import EdgeConfig, RollOutConfig, ScenarioConfig, TimingConfig
from millprint.files import read_json, write_table
from millprint.job import job
from millprint.surrogate.checkpoint import read_weights
from millprint.surrogate.rollout import Simulator
from millprint.surrogate.scene import read_scene
from millprint.surrogate.timing import simulation_seconds, time_rollouts
from millprint.surrogate.training import choose_device
from millprint.surrogate.trajectory import read_trajectory


def main(
    inputs: dict[str, str],
    output: str,
    rule: EdgeConfig,
    settings: RollOutConfig,
    timing: TimingConfig,
    test: ScenarioConfig,
    variant: str,
) -> None:
    # One thread, as the simulation has.
    device = choose_device(threads=1)
    model, recipe = read_weights(inputs["weights"], device)
    start_s = test.starts_s[0]
    run = read_trajectory(inputs["run"], until_s=start_s + 0.01)
    simulator = Simulator(model, read_scene(inputs["run"]), rule, settings.snap_back_m, run.interval_s, device)
    table = time_rollouts(simulator, run, start_s, timing.batches, recipe.graph.window, timing.steps)
    table.insert(0, "variant", variant)
    table["dem_seconds_for_15_s"] = simulation_seconds(read_json(inputs["summary"]))
    table["dem_over_surrogate"] = table["dem_seconds_for_15_s"] / table["seconds_per_trajectory"]
    write_table(table, output)


if "snakemake" in globals():
    with job(snakemake.log[0], f"time the surrogate {snakemake.wildcards.variant}"):
        main(
            dict(snakemake.input.items()),
            snakemake.output.runtime,
            EdgeConfig(**snakemake.params.edges),
            RollOutConfig(**snakemake.params.settings),
            TimingConfig(**snakemake.params.timing),
            ScenarioConfig(**snakemake.params.test),
            snakemake.wildcards.variant,
        )
