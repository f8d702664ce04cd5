"""Compares the roll-outs of a surrogate with the simulations that they started from.

Also the errors of single steps from states of the simulation, before errors can grow.

Settings: surrogate.tests, and the edges of the variant.
Inputs: the simulations of each test; `rollouts`, `weights`, `stepped` (run.h5) and `claims`.
Outputs: `metrics`, `errors`, `dissipation`, `distributions`, `single_steps`.
"""

import pandas as pd

from millprint.config.surrogate import EdgeConfig
from millprint.run.files import write_table
from millprint.run.job import job
from millprint.run.tables import read_printed
from millprint.thesis.surrogate.device import choose_device
from millprint.thesis.surrogate.graph_surrogate import single_steps
from millprint.thesis.surrogate.measures import join_tables, printed_measures, tabulate
from millprint.thesis.surrogate.network import read_weights
from millprint.thesis.surrogate.rollout import RollOut, read_scene, read_trajectory
from millprint.thesis.surrogate.rollout_evaluation import (
    REFERENCES,
    dissipation_table,
    distribution_table,
    error_table,
    evaluate,
    evaluate_at_rest,
    of_test,
    references_of,
)

# Single steps that are averaged.
GRAPHS = 2000
# What roll-outs are compared with, by role.
ROLES = (*REFERENCES, "original", "driven")


def main(rolled_out: str, inputs: dict[str, str], claims: str, variant: str, test: str) -> dict[str, pd.DataFrame]:
    """The tables of one test. `inputs` has the simulation of each role."""
    rollout, scene = RollOut.read(rolled_out), read_scene(inputs["dem"])
    first, last = float(rollout.start_s.min()), float(rollout.start_s.max() + rollout.time_s[-1])
    runs = {
        role: read_trajectory(inputs[role], *(() if role == "driven" else (first, last)))
        for role in ROLES
        if role in inputs
    }
    if "driven" in runs:
        found = evaluate_at_rest(rollout, runs, scene)
    else:
        found = evaluate(rollout, references_of(runs, scene, rollout.time_s, rollout.start_s), scene)
    printed = printed_measures(read_printed(claims))
    return {
        "metrics": tabulate(found.values, found.references, test, variant, printed, rollout.length_s),
        "errors": error_table(found.rollouts, test),
        "dissipation": dissipation_table(found.rollouts, test),
        "distributions": distribution_table(found.rollouts, scene.ball_radius_m, test),
    }


if "snakemake" in globals():
    given, made, own, variant = snakemake.input, snakemake.output, snakemake.params, snakemake.wildcards.variant
    with job(snakemake.log[0], f"evaluate {variant}") as log:
        parts = []
        for test, rollout in zip(own.tests, given.rollouts, strict=True):
            parts.append(main(rollout, of_test(test, given), given.claims, variant, test))
            log.info("measured: %s, %s", variant, test)
        for name in parts[0]:
            write_table(join_tables([part[name] for part in parts]), made[name])
        device, rule = choose_device(snakemake.threads), EdgeConfig(**own.edges)
        model, recipe = read_weights(given.weights, device)
        tables = []
        for (test, start_s), run in zip(own.starts_s.items(), given.stepped, strict=True):
            values = single_steps(model, recipe, rule, read_trajectory(run, start_s), read_scene(run), GRAPHS, device)
            tables.append(tabulate(values, {}, test, variant))
        write_table(join_tables(tables), made.single_steps)
