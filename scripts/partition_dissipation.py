"""Shear against compression: Tables 4.2 to 4.5 and the two regression lines, from published and from our curves.

Also doses of these cases and of the screening runs, and the kinetics of their yields.

Settings: partition; the density of the balls.
Inputs: `regimes`, `screening`, `fingerprint`.
Outputs: `table_4_2`, `table_4_3`, `table_4_4`, `table_4_5`, `slopes`, `design`; `doses`, `kinetics`, `curves`,
`verdict`; and the figures.
"""

import pandas as pd

from millprint.config.workflow import PartitionConfig
from millprint.dose.kinetics import AXES, best_of, fit_kinetics, said_of_dose, said_of_shear
from millprint.figures.style import save
from millprint.fingerprint.model import Fingerprint
from millprint.run.files import read_table, whole_file, write_table
from millprint.run.job import job
from millprint.thesis import regimes
from millprint.thesis.figures.chapter3_and_4_figures import (
    plot_doses,
    plot_mass_per_watt,
    plot_specific_yield,
    plot_yield,
)
from millprint.thesis.regimes import (
    compare_with_prior,
    curve_of,
    energy_leverage,
    fit_slopes,
    regime_doses,
    screening_doses,
    specific_yields,
)

# The sets of runs whose yields are compared with their doses, as the verdict names them.
SETS = {"screening": "Screening runs", "regimes": "Five cases of chapter 4"}


def best_run(runs: pd.DataFrame, cases: pd.DataFrame) -> dict[str, float]:
    """The run of the highest yield, with its speed [Hz]."""
    index = runs["yield_percent"].idxmax()
    return runs.loc[index, ["yield_percent", "time_h", "bpr"]].to_dict() | {"speed_hz": cases.loc[index, "speed_hz"]}


def side_by_side(tables: dict[str, pd.DataFrame]) -> pd.DataFrame:
    """The tables, joined, with the name of each in a first column `curves`."""
    return pd.concat([table.assign(curves=name) for name, table in tables.items()], ignore_index=True)[
        ["curves", *next(iter(tables.values())).columns]
    ]


def main(regimes_path: str, fingerprint_path: str, output, settings: PartitionConfig) -> None:
    """Design the cases and evaluate the measured yields, with the published curves and with ours."""
    measured, fingerprint = regimes.read_regimes(regimes_path), Fingerprint.read(fingerprint_path)
    about = fingerprint.about
    reference = regimes.reference_condition(
        measured,
        speed_hz=settings.reference_speed_rpm / 60.0,
        ball_diameter_m=settings.ball_diameter_mm * 1e-3,
        density_kg_m3=about["density_kg_m3"],
        amplitude_m=about["amplitude_m"],
    )
    chosen = {"published": measured, "ours": regimes.with_curves(measured, fingerprint)}
    cases = {name: regimes.design_cases(table, reference) for name, table in chosen.items()}
    # The yields were measured at the speeds of the published design, so our curves give the power at these speeds.
    run_speed = cases["published"]["speed_hz"]
    for table in cases.values():
        table["power_as_run_W"] = regimes.power_as_run(table, run_speed, reference)
        table["yield_percent"] = measured["yield_percent"]
    cases["ours"]["power_as_printed_W"] = float("nan")
    powers = {"published": cases["published"]["power_as_printed_W"], "ours": cases["ours"]["power_as_run_W"]}
    runs = {name: measured.assign(power_W=power) for name, power in powers.items()}
    prior = settings.prior._asdict()
    tables = {
        "table_4_2": cases,
        "table_4_3": {name: compare_with_prior(best_run(measured, table), prior) for name, table in cases.items()},
        "table_4_4": {name: specific_yields(table) for name, table in runs.items()},
        "table_4_5": {name: energy_leverage(table, settings) for name, table in runs.items()},
    }
    for name, pair in tables.items():
        write_table(side_by_side(pair), getattr(output, name))
    write_table(fit_slopes(measured, settings.interval), output.slopes)
    free = regimes.cases_at(settings.fill_ratios, reference, about["volume_m3"])
    designs = {"published": regimes.with_published(free, measured), "ours": regimes.with_curves(free, fingerprint)}
    designs = {name: regimes.design_cases(table, reference) for name, table in designs.items()}
    write_table(side_by_side(designs).drop(columns="power_as_printed_W"), output.design)


def draw(tables) -> None:
    """Figures 4.3 to 4.5, from the written tables, and yields against doses with the best kinetics over each."""
    cases, judged = read_table(tables.table_4_2), read_table(tables.table_4_4)
    cases = cases[cases["curves"] == "published"]
    published, ours = (judged[judged["curves"] == name] for name in ("published", "ours"))
    save(plot_yield(cases, read_table(tables.slopes)), *tables.yield_figure)
    save(plot_specific_yield(published, ours), *tables.specific_figure)
    save(plot_mass_per_watt(published, ours), *tables.mass_figure)
    save(plot_doses(read_table(tables.doses), read_table(tables.curves)), *tables.dose_figure)


def tabulate_doses(inputs, output, ball_diameter_m: float, density_kg_m3: float) -> None:
    """Write doses, kinetics, the best curve over each axis, and a verdict on each set of runs."""
    cases = read_table(output.table_4_2, text=["curves", "case"])
    cases = cases[cases["curves"] == "published"].drop(columns="curves")
    balls = (ball_diameter_m, density_kg_m3)
    tables = {
        "screening": screening_doses(inputs.screening, *balls),
        "regimes": regime_doses(regimes.read_regimes(inputs.regimes), cases, *balls),
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
    lines = [f"{said_of_dose(own, kinetics[name], SETS[name])} {said_of_shear(own)}" for name, own in tables.items()]
    # The screening gives the law over the dose, the five cases differ in how it is divided.
    lines.append(f"Both sets together: {said_of_shear(pd.concat(tables.values(), ignore_index=True))}")
    with whole_file(output.verdict) as partial:
        partial.write_text("\n".join(lines) + "\n")


if "snakemake" in globals():
    given, made, own = snakemake.input, snakemake.output, snakemake.params
    with job(snakemake.log[0], "partition dissipation"):
        main(given.regimes, given.fingerprint, made, PartitionConfig(**own.settings))
        tabulate_doses(given, made, PartitionConfig.ball_diameter_mm * 1e-3, own.density_kg_m3)
        draw(made)
