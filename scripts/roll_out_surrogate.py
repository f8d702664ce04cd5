"""Rolls a trained surrogate out from the first states of a simulation."""

import logging

import numpy as np

from millprint.config.surrogate import EdgeConfig, RollOutConfig
from millprint.job import job, progress
from millprint.surrogate.contact.roller import ContactRoller
from millprint.surrogate.device import choose_device
from millprint.surrogate.roller import open_roller
from millprint.surrogate.store import write_rollout

# Times at which the members of an ensemble are compared.
LOOKS = 100

logger = logging.getLogger("millprint")


def main(
    weights: str,
    run: str,
    output: str,
    rule: EdgeConfig,
    settings: RollOutConfig,
    case: str,
    starts_s: list[float],
    threads: int,
) -> None:
    device = choose_device(threads)
    roller = open_roller(weights, run, rule, settings.snap_back_m, device, until_s=max(starts_s) + 0.01)
    state = roller.first_state(starts_s)
    steps, per_frame = (round(time_s / roller.step_s) for time_s in (settings.length_s, settings.frame_interval_s))
    members = len(roller.members) if isinstance(roller, ContactRoller) else 0
    # The members of an ensemble are rolled out from the first start.
    with progress(steps * ((len(starts_s) + members) if members else 1), "roll out", "step") as bar:
        rollout = roller.run(state, steps, per_frame, bar)
        if members:
            rollout.member_dissipated_J = roller.spread(state, steps, per_frame, bar)
            rollout.doubt = roller.doubt(state, steps, LOOKS)
            logger.info("dissipation of the members: %s J", rollout.member_dissipated_J.sum(axis=0))
            pooled = np.sqrt(np.nanmean(rollout.doubt**2))
            logger.info("their expectations part by %.3g of the forces", pooled)
    write_rollout(rollout, output, case)
    logger.info("%d trajectories of %d steps; mean edges a graph: %s", len(starts_s), steps, rollout.edges)


if "snakemake" in globals():
    with job(snakemake.log[0], f"roll out the surrogate {snakemake.wildcards.variant}, {snakemake.wildcards.test}"):
        main(
            snakemake.input.weights,
            snakemake.input.run,
            snakemake.output.rollout,
            EdgeConfig(**snakemake.params.edges),
            RollOutConfig(**snakemake.params.settings),
            snakemake.params.case,
            snakemake.params.starts_s,
            threads=snakemake.threads,
        )
