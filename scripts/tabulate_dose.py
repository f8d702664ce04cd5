"""Doses of the screening runs and of the five cases of chapter 4, and the kinetics of their yields."""

import pandas as pd

from millprint.dose.dose import AXES, regime_doses, screening_doses
from millprint.dose.kinetics import best_of, curve_of, fit_kinetics, verdict
from millprint.dose.shear import said_of_shear
from millprint.figures.spectra import plot_doses
from millprint.figures.style import save
from millprint.files import read_table, whole_file, write_table
from millprint.fingerprint.regimes import read_regimes
from millprint.job import job

SETS = {"screening": "Screening runs", "regimes": "Five cases of chapter 4"}


def main(files, output, ball_diameter_m: float, density_kg_m3: float) -> None:
    """Write doses, kinetics, the best curve over each axis, and a verdict on each set of runs."""
    cases = read_table(files.table_4_2, text=["curves", "case"])
    cases = cases[cases["curves"] == "published"].drop(columns="curves")
    balls = (ball_diameter_m, density_kg_m3)
    tables = {
        "screening": screening_doses(files.screening, *balls),
        "regimes": regime_doses(read_regimes(files.regimes), cases, *balls),
    }
    kinetics = {name: fit_kinetics(table) for name, table in tables.items()}
    curves = []
    for name, fits in kinetics.items():
        for axis in AXES:
            if (best := best_of(fits, axis)) is not None:
                curve = curve_of(best, tables[name][axis].max())
                curves.append(curve.rename(columns={"x": "value"}).assign(set=name, x=axis, model=best["model"]))
    for path, parts in ((output.doses, tables), (output.kinetics, kinetics)):
        write_table(pd.concat([table.assign(set=name) for name, table in parts.items()], ignore_index=True), path)
    write_table(pd.concat(curves, ignore_index=True), output.curves)
    lines = [f"{verdict(own, kinetics[name], SETS[name])} {said_of_shear(own)}" for name, own in tables.items()]
    # The screening gives the law over the dose, the five cases differ in how it is divided.
    lines.append(f"Both sets together: {said_of_shear(pd.concat(tables.values(), ignore_index=True))}")
    with whole_file(output.verdict) as partial:
        partial.write_text("\n".join(lines) + "\n")


def draw(tables) -> None:
    """Draw yields against time, doses and hits, with the best kinetics over each, from the written tables."""
    save(plot_doses(read_table(tables.doses), read_table(tables.curves)), tables.svg, tables.png)


if "snakemake" in globals():
    with job(snakemake.log[0], "tabulate doses"):
        main(
            snakemake.input,
            snakemake.output,
            snakemake.params.ball_diameter_m,
            snakemake.params.density_kg_m3,
        )
        draw(snakemake.output)
