"""Rolls a trained surrogate out in every test, from the first states of its simulation.

Settings: surrogate.tests, and the edges and roll-out of the variant.
Inputs: `weights`, and the `runs` that the roll-outs start from.
Outputs: `rollouts`, one for each test.
"""

import logging

from millprint.config.surrogate import EdgeConfig, RollOutConfig
from millprint.run.job import job
from millprint.thesis.surrogate.compiled import open_graph_surrogate
from millprint.thesis.surrogate.network import choose_device
from millprint.thesis.surrogate.rollout import Setting

logger = logging.getLogger("millprint")


def main(setting: Setting, output: str, settings: RollOutConfig, case: str, starts_s: list[float]) -> None:
    surrogate = open_graph_surrogate(setting)
    steps, per_frame = (round(time_s / surrogate.step_s) for time_s in (settings.length_s, settings.frame_interval_s))
    rollout = surrogate.roll_out(starts_s, steps, per_frame)
    rollout.write(output, case)
    logger.info("%d trajectories of %d steps; mean edges per graph: %s", len(starts_s), steps, rollout.mean_edges)


if "snakemake" in globals():
    own, variant = snakemake.params, snakemake.wildcards.variant
    with job(snakemake.log[0], f"roll out {variant}"):
        for (test, chosen), output in zip(own.tests.items(), snakemake.output.rollouts, strict=True):
            logger.info("%s, %s", variant, test)
            rules, starts_s = RollOutConfig(**chosen["settings"]), chosen["starts_s"]
            setting = Setting(
                snakemake.input.weights,
                chosen["run"],
                EdgeConfig(**own.edges),
                rules.snap_back_m,
                choose_device(snakemake.threads),
                until_s=max(starts_s) + 0.01,
            )
            main(setting, output, rules, chosen["case"], starts_s)
