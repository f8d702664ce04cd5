"""Measures a roll-out, of whatever surrogate, against the simulation that it started from."""

from millprint.files import read_json, write_table
from millprint.job import job
from millprint.surrogate.curves import dissipation_table, distribution_table, error_table
from millprint.surrogate.evaluation import evaluate, evaluate_at_rest
from millprint.surrogate.rolled import read_rolled
from millprint.surrogate.scene import read_scene
from millprint.surrogate.tables import tabulate
from millprint.surrogate.trajectory import read_trajectory

ROLES = ("dem", "other_seed", "twin", "original", "driven")


def main(inputs: dict[str, str], outputs: dict[str, str], variant: str, test: str) -> None:
    rollout, scene = read_rolled(inputs["rollout"]), read_scene(inputs["dem"])
    first, last = float(rollout.start_s.min()), float(rollout.start_s.max() + rollout.time_s[-1])
    runs = {
        role: read_trajectory(inputs[role], *(() if role == "driven" else (first, last)))
        for role in ROLES
        if role in inputs
    }
    if "driven" in runs:
        found = evaluate_at_rest(rollout, runs, scene)
    else:
        summaries = {role: read_json(inputs[f"{role}_summary"]) for role in ("dem", "other_seed")}
        found = evaluate(rollout, runs, scene, summaries)
    write_table(tabulate(found.values, found.references, test, variant), outputs["metrics"])
    write_table(error_table(found.series, test), outputs["errors"])
    write_table(dissipation_table(found.series, rollout.member_totals_J(), test), outputs["dissipation"])
    write_table(distribution_table(found.series, scene.ball_radius_m, test), outputs["distributions"])


if "snakemake" in globals():
    with job(snakemake.log[0], f"evaluate the surrogate {snakemake.wildcards.variant}, {snakemake.wildcards.test}"):
        main(
            dict(snakemake.input.items()),
            dict(snakemake.output.items()),
            snakemake.wildcards.variant,
            snakemake.wildcards.test,
        )
