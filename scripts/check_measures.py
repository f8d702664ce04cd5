"""Checks the measures in every test: on roll-outs known to be right or wrong, and on those in which nothing is learned.

Settings: surrogate.tests, surrogate.rollout and surrogate.snapshots.train_until_s.
Inputs: the simulations of each test, and `trained` (run.h5).
Outputs: `controls`.
"""

from dataclasses import replace

import pandas as pd

from millprint.run.files import write_table
from millprint.run.job import job
from millprint.thesis.surrogate.measures import is_met, join_tables, tabulate
from millprint.thesis.surrogate.rollout import (
    RollOut,
    Scene,
    blurred,
    mean_power_W,
    read_scene,
    read_trajectory,
    riding,
    rms_wall_speed,
    scaled_motion,
    simulated,
    simulated_rollout,
    slowed,
)
from millprint.thesis.surrogate.rollout_evaluation import REFERENCES, evaluate, of_test, references_of

# Of the time of the training, in which the mill starts: not a part of its motion.
START_SHARE = 0.1


def known_rollouts(
    inputs: dict[str, str],
    test: str,
    start_s: float,
    length_s: float,
    interval_s: float,
    power_W: float,
    trained: tuple[RollOut, Scene],
) -> pd.DataFrame:
    """The measures of known roll-outs in a test.

    `inputs` has the simulation of each role; power_W: mean dissipation in the training; trained: its motion, and scene.
    """
    scene = read_scene(inputs["dem"])
    roles = [role for role in (*REFERENCES, "long_step") if role in inputs]
    runs = {role: read_trajectory(inputs[role], start_s, start_s + length_s) for role in roles}
    dem = simulated_rollout(runs["dem"], start_s, length_s, interval_s)
    # All with its frames; a run without snapshots there is refused.
    frames = dem.time_s, dem.start_s
    known = {role: replace(simulated(run, None, *frames), recorded_J=None) for role, run in runs.items()}
    faster = rms_wall_speed(scene) / rms_wall_speed(trained[1])
    known["no_network"] = riding(dem, scene, power_W)
    known["scaled_power"] = riding(dem, scene, faster**2 * power_W)
    known["scaled_motion"] = scaled_motion(dem, scene, *trained)
    known |= {"blurred": blurred(dem), "slowed": slowed(dem, scene)}
    against = {role: runs[role] for role in roles if role in REFERENCES}
    references = references_of(against, scene, *frames)
    tables = []
    for name, rollout in known.items():
        found = evaluate(rollout, references, scene)
        tables.append(tabulate(found.values, found.references, test, name, length_s=rollout.length_s))
    return join_tables(tables)


def with_aims_met(table: pd.DataFrame) -> pd.DataFrame:
    """The same with a column `met`: whether each measure that has an aim reaches it."""
    rows = table.itertuples()
    met = ["" if pd.isna(row.aim) else "yes" if is_met(row.measure, row.value, row.aim) else "no" for row in rows]
    return table.drop(columns="thesis").rename(columns={"variant": "rollout"}).assign(met=met)


def main(given, made, own, log) -> None:
    """Write the measures of known roll-outs in every test."""
    powers_W = [mean_power_W(path, own.train_until_s) for path in given.trained]
    power_W = sum(powers_W) / len(powers_W)
    log.info("mean power of the training: %.4g W", power_W)
    scene, from_s = read_scene(given.trained[0]), START_SHARE * own.train_until_s
    run = read_trajectory(given.trained[0], from_s, own.train_until_s)
    trained = simulated_rollout(run, from_s, own.train_until_s - from_s, own.interval_s), scene
    tables = [
        known_rollouts(of_test(test, given), test, start_s, own.lengths_s[test], own.interval_s, power_W, trained)
        for test, start_s in own.starts_s.items()
    ]
    write_table(with_aims_met(join_tables(tables)), made.controls)


if "snakemake" in globals():
    with job(snakemake.log[0], "evaluate the measures") as log:
        main(snakemake.input, snakemake.output, snakemake.params, log)
