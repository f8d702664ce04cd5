"""Rolls a trained surrogate out from the first states of a simulation."""

import logging

from millprint.config.surrogate import EdgeConfig, RollOutConfig, ScenarioConfig
from millprint.job import job, progress
from millprint.surrogate.checkpoint import read_weights
from millprint.surrogate.rollout import Simulator, first_state
from millprint.surrogate.scene import read_scene
from millprint.surrogate.store import write_rollout
from millprint.surrogate.training import choose_device
from millprint.surrogate.trajectory import read_trajectory

logger = logging.getLogger("millprint")


def main(
    weights: str, run: str, output: str, rule: EdgeConfig, settings: RollOutConfig, test: ScenarioConfig, threads: int
) -> None:
    device = choose_device(threads)
    model, recipe = read_weights(weights, device)
    scene = read_scene(run)
    trajectory = read_trajectory(run, until_s=max(test.starts_s) + 0.01)
    simulator = Simulator(model, scene, rule, settings.snap_back_m, trajectory.interval_s, device)
    state = first_state(trajectory, scene, test.starts_s, recipe.graph.window)
    steps = round(settings.length_s / trajectory.interval_s)
    with progress(steps, "roll out", "step") as bar:
        rollout = simulator.run(state, steps, round(settings.frame_interval_s / trajectory.interval_s), bar)
    write_rollout(rollout, output, test.case)
    logger.info("%d trajectories of %d steps; mean edges a graph: %s", len(test.starts_s), steps, rollout.edges)


if "snakemake" in globals():
    with job(snakemake.log[0], f"roll out the surrogate {snakemake.wildcards.variant}, {snakemake.wildcards.test}"):
        main(
            snakemake.input.weights,
            snakemake.input.run,
            snakemake.output.rollout,
            EdgeConfig(**snakemake.params.edges),
            RollOutConfig(**snakemake.params.settings),
            ScenarioConfig(**snakemake.params.test),
            threads=snakemake.threads,
        )
