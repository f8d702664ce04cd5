"""Errors of single steps of a graph network from states of the simulation, before errors can grow."""

from millprint.config.surrogate import EdgeConfig
from millprint.files import write_table
from millprint.job import job
from millprint.surrogate.checkpoint import choose_device
from millprint.surrogate.scene import read_scene
from millprint.surrogate.tables import join_tables, tabulate
from millprint.surrogate.thesis.network import read_weights
from millprint.surrogate.thesis.surrogate import single_steps
from millprint.surrogate.trajectory import read_trajectory

GRAPHS = 2000


def main(
    weights: str,
    runs: list[str],
    output: str,
    rule: EdgeConfig,
    starts_s: dict[str, float],
    variant: str,
    threads: int,
) -> None:
    device = choose_device(threads)
    model, recipe = read_weights(weights, device)
    tables = []
    for (test, start_s), run in zip(starts_s.items(), runs, strict=True):
        values = single_steps(model, recipe, rule, read_trajectory(run, start_s), read_scene(run), GRAPHS, device)
        tables.append(tabulate(values, {}, test, variant))
    write_table(join_tables(tables), output)


if "snakemake" in globals():
    with job(snakemake.log[0], f"single steps of {snakemake.wildcards.variant}"):
        main(
            snakemake.input.weights,
            list(snakemake.input.runs),
            snakemake.output.steps,
            EdgeConfig(**snakemake.params.edges),
            snakemake.params.starts_s,
            snakemake.wildcards.variant,
            threads=snakemake.threads,
        )
