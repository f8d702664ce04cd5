"""Measures a roll-out against the simulation that it started from."""

from millprint.config.surrogate import EdgeConfig
from millprint.files import write_table
from millprint.job import job
from millprint.surrogate.checkpoint import read_weights
from millprint.surrogate.evaluation import (
    dissipation_table,
    distribution_table,
    error_table,
    evaluate,
    one_step,
)
from millprint.surrogate.scene import read_scene
from millprint.surrogate.store import read_rollout
from millprint.surrogate.tables import join_tables, tabulate
from millprint.surrogate.training import choose_device
from millprint.surrogate.trajectory import read_trajectory

ONE_STEP_GRAPHS = 2000


def main(
    inputs: dict[str, str],
    outputs: dict[str, str],
    rule: EdgeConfig,
    variant: str,
    test: str,
    ablation: bool,
    threads: int,
) -> None:
    device = choose_device(threads)
    rollout, scene = read_rollout(inputs["rollout"]), read_scene(inputs["dem"])
    first, last = float(rollout.start_s.min()), float(rollout.start_s.max() + rollout.time_s[-1])
    names = [name for name in ("dem", "other_seed", "original") if name in inputs]
    runs = {name: read_trajectory(inputs[name], first, last) for name in names}
    metrics, series = evaluate(rollout, runs, scene, test, variant, ablation)
    model, recipe = read_weights(inputs["weights"], device)
    steps = one_step(model, recipe, rule, runs["dem"], scene, ONE_STEP_GRAPHS, device)
    write_table(join_tables([metrics, tabulate(steps, {}, test, variant, ablation)]), outputs["metrics"])
    write_table(error_table(series, test), outputs["errors"])
    write_table(dissipation_table(series, test), outputs["dissipation"])
    write_table(distribution_table(series, scene, test), outputs["distributions"])


if "snakemake" in globals():
    with job(snakemake.log[0], f"evaluate the surrogate {snakemake.wildcards.variant}, {snakemake.wildcards.test}"):
        main(
            dict(snakemake.input.items()),
            dict(snakemake.output.items()),
            EdgeConfig(**snakemake.params.edges),
            snakemake.wildcards.variant,
            snakemake.wildcards.test,
            snakemake.params.ablation,
            threads=snakemake.threads,
        )
