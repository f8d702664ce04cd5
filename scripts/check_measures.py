"""Checks the measures of the surrogate with roll-outs that are known to be right or wrong, in a table."""

from millprint.files import write_table
from millprint.job import job
from millprint.surrogate.controls import blurred, simulated_rollout, slowed
from millprint.surrogate.evaluation import evaluate
from millprint.surrogate.scene import read_scene
from millprint.surrogate.tables import is_met, join_tables, tabulate
from millprint.surrogate.trajectory import read_trajectory

# Long enough for converged distributions.
LENGTH_S = 3.0


def main(inputs: dict[str, str], output: str, start_s: float, interval_s: float, test: str) -> None:
    scene = read_scene(inputs["dem"])
    runs = {role: read_trajectory(inputs[role], start_s) for role in ("dem", "other_seed", "twin") if role in inputs}
    length_s = min(LENGTH_S, *(float(run.time_s[-1]) - start_s for run in runs.values()))
    known = {role: simulated_rollout(run, scene, start_s, length_s, interval_s) for role, run in runs.items()}
    known |= {"blurred": blurred(known["dem"]), "slowed": slowed(known["dem"], scene)}
    tables = []
    for name, rollout in known.items():
        found = evaluate(rollout, runs, scene)
        table = tabulate(found.values, found.references, test, name).drop(columns="thesis")
        aimed = table["aim"].notna()
        table.loc[aimed, "met"] = [
            "yes" if is_met(row.measure, row.value, row.aim) else "no" for row in table[aimed].itertuples()
        ]
        tables.append(table.rename(columns={"variant": "rollout"}))
    write_table(join_tables(tables), output)


if "snakemake" in globals():
    with job(snakemake.log[0], "check the measures on what is known"):
        main(
            dict(snakemake.input.items()),
            snakemake.output.controls,
            snakemake.params.start_s,
            snakemake.params.interval_s,
            snakemake.params.test,
        )
