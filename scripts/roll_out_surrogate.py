"""Rolls a trained surrogate out from the first states of a simulation."""

import logging

import numpy as np

from millprint.config.surrogate import EdgeConfig, RollOutConfig, ScenarioConfig
from millprint.job import job, progress
from millprint.surrogate.checkpoint import read_weights
from millprint.surrogate.contact.roller import ContactRoller
from millprint.surrogate.contact.store import is_ensemble
from millprint.surrogate.rollout import Simulator, first_state
from millprint.surrogate.scene import read_scene
from millprint.surrogate.store import write_rollout
from millprint.surrogate.training import choose_device
from millprint.surrogate.trajectory import read_trajectory

# Times at which the members of an ensemble are compared.
LOOKS = 100

logger = logging.getLogger("millprint")


def main(
    weights: str, run: str, output: str, rule: EdgeConfig, settings: RollOutConfig, test: ScenarioConfig, threads: int
) -> None:
    if is_ensemble(weights):
        roll_out_contacts(weights, run, output, settings, test)
        return
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


def roll_out_contacts(weights: str, run: str, output: str, settings: RollOutConfig, test: ScenarioConfig) -> None:
    """The contact surrogate: its first member, and the dissipation of every member from the first start."""
    roller = ContactRoller(weights, run)
    state = roller.first_state(test.starts_s)
    steps, per_frame = (round(time_s / roller.step_s) for time_s in (settings.length_s, settings.frame_interval_s))
    with progress(steps * (len(test.starts_s) + len(roller.members)), "roll out", "step") as bar:
        rollout = roller.run(state, steps, per_frame, bar)
        rollout.member_dissipated_J = roller.spread(state, steps, per_frame, bar)
    rollout.doubt = roller.doubt(state, steps, LOOKS)
    write_rollout(rollout, output, test.case)
    totals = rollout.member_dissipated_J.sum(axis=0)
    logger.info(
        "%d trajectories of %d steps; dissipation of the members %s J; their expectations part by %.3g of the forces",
        len(test.starts_s),
        steps,
        totals,
        np.nanmean(rollout.doubt) if len(roller.members) > 1 else np.nan,
    )


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
