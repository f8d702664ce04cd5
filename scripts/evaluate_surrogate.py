"""Compares the roll-outs of a surrogate with the simulations that they started from.

Also the errors of single steps from states of the simulation, before errors can grow. Or checks the measures in every
test: on roll-outs that are known to be right or wrong, and on those in which nothing is learned.

Settings: surrogate.tests, and the edges of the variant; for the check surrogate.rollout and
surrogate.snapshots.train_until_s.
Inputs: the simulations of each test; `rollouts`, `weights`, `stepped` (run.h5) and `claims`; or `trained` (run.h5).
Outputs: `metrics`, `errors`, `dissipation`, `distributions`, `single_steps`; or `controls`.
"""

import pandas as pd

from millprint.config.surrogate import EdgeConfig
from millprint.run.files import write_table
from millprint.run.job import job
from millprint.run.tables import read_printed
from millprint.thesis.surrogate.graph_surrogate import single_steps
from millprint.thesis.surrogate.measure_tables import is_met, join_tables, printed_measures, tabulate
from millprint.thesis.surrogate.network import choose_device, read_weights
from millprint.thesis.surrogate.rollout import RollOut, blurred, riding, simulated_rollout, slowed
from millprint.thesis.surrogate.rollout_evaluation import (
    dissipation_table,
    distribution_table,
    error_table,
    evaluate,
    evaluate_at_rest,
    of_test,
)
from millprint.thesis.surrogate.scene import mean_power_W, read_scene, read_trajectory

# Single steps that are averaged.
GRAPHS = 2000
# What roll-outs are compared with, by role; the known ones only with the first.
REFERENCES = ("dem", "other_seed", "twin")
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
    found = evaluate_at_rest(rollout, runs, scene) if "driven" in runs else evaluate(rollout, runs, scene)
    printed = printed_measures(read_printed(claims))
    return {
        "metrics": tabulate(found.values, found.references, test, variant, printed, rollout.length_s),
        "errors": error_table(found.rollouts, test),
        "dissipation": dissipation_table(found.rollouts, test),
        "distributions": distribution_table(found.rollouts, scene.ball_radius_m, test),
    }


def step_errors(
    weights: str, runs: list[str], rule: EdgeConfig, starts_s: dict[str, float], variant: str, threads: int
) -> pd.DataFrame:
    """The errors of single steps; starts_s: from where in each test, in the order of `runs`."""
    device = choose_device(threads)
    model, recipe = read_weights(weights, device)
    tables = []
    for (test, start_s), run in zip(starts_s.items(), runs, strict=True):
        values = single_steps(model, recipe, rule, read_trajectory(run, start_s), read_scene(run), GRAPHS, device)
        tables.append(tabulate(values, {}, test, variant))
    return join_tables(tables)


def known_rollouts(
    inputs: dict[str, str], test: str, start_s: float, length_s: float, interval_s: float, power_W: float
) -> pd.DataFrame:
    """The measures of known roll-outs in a test.

    `inputs` has the simulation of each role; power_W: mean dissipation in the training.
    """
    scene = read_scene(inputs["dem"])
    roles = [role for role in (*REFERENCES, "long_step") if role in inputs]
    runs = {role: read_trajectory(inputs[role], start_s, start_s + length_s) for role in roles}
    known = {role: simulated_rollout(run, scene, start_s, length_s, interval_s) for role, run in runs.items()}
    known["no_network"] = riding(known["dem"], scene, power_W)
    known |= {"blurred": blurred(known["dem"]), "slowed": slowed(known["dem"], scene)}
    against = {role: runs[role] for role in roles if role in REFERENCES}
    tables = []
    for name, rollout in known.items():
        found = evaluate(rollout, against, scene)
        tables.append(tabulate(found.values, found.references, test, name, length_s=rollout.length_s))
    return join_tables(tables)


def with_aims_met(table: pd.DataFrame) -> pd.DataFrame:
    """The same with a column `met`: whether each measure that has an aim reaches it."""
    rows = table.itertuples()
    met = ["" if pd.isna(row.aim) else "yes" if is_met(row.measure, row.value, row.aim) else "no" for row in rows]
    return table.drop(columns="thesis").rename(columns={"variant": "rollout"}).assign(met=met)


def evaluate_variant(given, made, own, variant: str, threads: int, log) -> None:
    """Write the tables of a variant."""
    parts = []
    for test, rollout in zip(own.tests, given.rollouts, strict=True):
        parts.append(main(rollout, of_test(test, given), given.claims, variant, test))
        log.info("measured: %s, %s", variant, test)
    for name in parts[0]:
        write_table(join_tables([part[name] for part in parts]), made[name])
    rule = EdgeConfig(**own.edges)
    write_table(
        step_errors(given.weights, list(given.stepped), rule, own.starts_s, variant, threads), made.single_steps
    )


def check_measures(given, made, own, log) -> None:
    """Write the measures of known roll-outs in every test."""
    powers_W = [mean_power_W(path, own.train_until_s) for path in given.trained]
    power_W = sum(powers_W) / len(powers_W)
    log.info("mean power of the training: %.4g W", power_W)
    tables = [
        known_rollouts(of_test(test, given), test, start_s, own.lengths_s[test], own.interval_s, power_W)
        for test, start_s in own.starts_s.items()
    ]
    write_table(with_aims_met(join_tables(tables)), made.controls)


if "snakemake" in globals():
    files = snakemake.input, snakemake.output, snakemake.params
    variant = snakemake.wildcards.get("variant")
    with job(snakemake.log[0], f"evaluate {variant or 'the measures'}") as log:
        if variant:
            evaluate_variant(*files, variant, snakemake.threads, log)
        else:
            check_measures(*files, log)
